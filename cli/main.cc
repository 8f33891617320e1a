#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>
#include <iostream>

#include "cli/commands.h"
#include "core/errors.h"
#include "core/version.h"

namespace {

constexpr const char* kDescription =
    "powdercal finds the contact parameters with which discrete element simulations of a powder\n"
    "reproduce its laboratory tests.\n\n"
    "  powdercal check STUDY     what would run, and what the scaling preserves\n"
    "  powdercal run STUDY       calibrate; the same command again resumes\n"
    "  powdercal report FOLDER   write the report anew";

constexpr const char* kFooter =
    "Exit status: 0 done, 1 the study failed or a check fell short, 2 bad input, 3 interrupted "
    "and\n"
    "resumable. STUDY is a file or the name of a shipped study (`powdercal list studies`).";

}  // namespace

int main(int argc, char** argv) {
  using namespace powdercal;
  std::signal(SIGPIPE, SIG_IGN);  // a closed pager is no reason to lose a study
  CLI::App program{kDescription, "powdercal"};
  program.footer(kFooter);
  program.set_version_flag("--version", kVersion);
  program.require_subcommand(1);
  int status = cli::kDone;
  cli::AddCheck(program, status);
  cli::AddList(program, status);
  cli::AddReport(program, status);
  cli::AddResume(program, status);
  cli::AddRun(program, status);
  cli::AddSimulate(program, status);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? cli::kDone : cli::kBadInput;
  } catch (const InputError& error) {
    fmt::print(stderr, "powdercal: {}\n", error.what());
    return cli::kBadInput;
  } catch (const std::exception& error) {
    fmt::print(stderr, "powdercal: {}\n", error.what());
    return cli::kFellShort;
  }
  return status;
}

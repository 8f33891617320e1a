#include <CLI/CLI.hpp>
#include <csignal>
#include <cstring>
#include <exception>
#include <vector>

#include "cli/commands.h"
#include "cli/output.h"
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

using powdercal::InputError;

// What is wrong with the command line, with the name that was probably meant.
std::string Explain(const CLI::App& program, const CLI::ParseError& error,
                    const std::vector<std::string>& arguments) {
  const auto parsed = program.get_subcommands();
  if (parsed.empty()) {
    std::vector<std::string> commands;
    for (const CLI::App* command : program.get_subcommands({})) {
      commands.push_back(command->get_name());
    }
    for (const std::string& argument : arguments) {
      if (argument.starts_with('-')) continue;
      return powdercal::UnknownName("command", argument, commands).what();
    }
    return fmt::format("no command is given (valid: {})", powdercal::JoinNames(commands));
  }
  std::vector<std::string> valid;
  for (const CLI::Option* option : parsed.front()->get_options()) {
    for (const std::string& name : option->get_lnames()) valid.push_back("--" + name);
  }
  for (const std::string& argument : parsed.front()->remaining()) {
    if (!argument.starts_with('-')) continue;
    const std::string name = argument.substr(0, argument.find('='));
    return InputError(fmt::format("unknown option '{}'", name),
                      {.suggestion = powdercal::NearestName(name, valid)})
        .what();
  }
  return error.what();
}

}  // namespace

int main(int argc, char** argv) {
  using namespace powdercal;
  cli::OpenStandardStreams();
  std::signal(SIGPIPE, SIG_IGN);  // a closed pager is no reason to lose a study
  CLI::App program{kDescription, "powdercal"};
  program.footer(kFooter);
  program.set_version_flag("--version", kVersion);
  program.require_subcommand(1);
  int status = cli::kDone;
  cli::AddCheck(program, status);
  cli::AddCompare(program, status);
  cli::AddList(program, status);
  cli::AddReport(program, status);
  cli::AddResume(program, status);
  cli::AddRun(program, status);
  cli::AddScale(program, status);
  cli::AddSimulate(program, status);
  cli::AddVerify(program, status);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help, --version
      status = program.exit(error);
    } else {
      cli::Say("powdercal: {}\nRun with --help for more information.\n",
               Explain(program, error, {argv + 1, argv + argc}));
      status = cli::kBadInput;
    }
  } catch (const InputError& error) {
    cli::Say("powdercal: {}\n", error.what());
    status = cli::kBadInput;
  } catch (const std::exception& error) {
    cli::Say("powdercal: {}\n", error.what());
    status = cli::kFellShort;
  }
  if (!cli::FlushOutput() && status == cli::kDone) {
    cli::Say("powdercal: cannot write the output: {}\n", std::strerror(errno));
    status = cli::kFellShort;
  }
  return status;
}

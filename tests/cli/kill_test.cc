#include <gmock/gmock.h>

#include "tests/cli/streams.h"

namespace powdercal {
namespace {

using nlohmann::json;

std::vector<std::string> Command(const std::vector<std::string>& mode, const std::string& out) {
  std::vector<std::string> command = {"run", "hastelloy_x_table3", "--seed", "5", "--out", out};
  command.insert(command.end(), mode.begin(), mode.end());
  return command;
}

class KilledRuns : public ::testing::TestWithParam<std::vector<std::string>> {};

// SIGKILL at many moments of a study, each time going on with the same command.
TEST_P(KilledRuns, EndAsIfNothingHadHappened) {
  const TemporaryFolder folder;
  const ProcessResult whole = Powdercal(Command(GetParam(), "whole"), folder.path());
  ASSERT_EQ(whole.exit_status, 0) << whole.output;
  const std::string expected = ReadJson(folder / "whole/results.json").at("history").dump();

  int killed = 0;
  const auto run_for = [&](double seconds, const std::string& out) {
    std::vector<std::string> command = Command(GetParam(), out);
    command.insert(command.begin(), POWDERCAL_PROGRAM);
    const ProcessResult result = RunProcess({.arguments = std::move(command),
                                             .working_directory = folder.path(),
                                             .time_limit = std::chrono::duration<double>(seconds)});
    if (result.end == ProcessResult::End::time_limit) ++killed;
  };
  // While the folder and its ledger are being made:
  for (int milliseconds = 8; milliseconds < 50; milliseconds += 3) {
    const std::string out = "early" + std::to_string(milliseconds);
    run_for(milliseconds / 1000.0, out);
    const ProcessResult check = Powdercal(
        {"check", "hastelloy_x_table3", "--seed", "5", "--out", out, "--json"}, folder.path());
    EXPECT_EQ(check.exit_status, 0) << out << ": " << check.output;
  }
  // Further and further, until it comes to the end by itself:
  for (int attempt = 1; attempt <= 6; ++attempt)
    run_for(whole.wall_seconds * attempt / 7, "killed");
  EXPECT_GT(killed, 0);
  const ProcessResult last = Powdercal(Command(GetParam(), "killed"), folder.path());
  EXPECT_EQ(last.exit_status, 0) << last.output;
  EXPECT_EQ(ReadJson(folder / "killed/results.json").at("history").dump(), expected);
}

INSTANTIATE_TEST_SUITE_P(Cli, KilledRuns,
                         ::testing::Values(std::vector<std::string>{"--parallel", "1"},
                                           std::vector<std::string>{"--parallel", "2",
                                                                    "--deterministic"}));

}  // namespace
}  // namespace powdercal

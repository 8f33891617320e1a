#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/streams.h"

// The command with real simulators.

namespace powdercal {
namespace {

using ::testing::HasSubstr;

TEST(Verify, ContactsOfEmbeddedAndLiggghtsAreEquivalent) {
  const TemporaryFolder folder;
  for (const char* law : {"hertz_mindlin_history", "linear", "paper"}) {
    const Streams streams = PowdercalStreams(
        {"verify", "--law", law, "--backends", "embedded,liggghts", "--rungs", "1", "--json"},
        folder.path());
    EXPECT_EQ(streams.exit_status, 0) << streams.error;
    const auto json = nlohmann::json::parse(streams.output);
    EXPECT_TRUE(json["passed"].get<bool>());
    EXPECT_GE(json["counts"]["equivalent"], 12);
    EXPECT_EQ(json["counts"]["unsupported"], 0);
  }
}

TEST(Verify, AFolderKeepsTheRunsAndTheVerdicts) {
  const TemporaryFolder folder;
  const std::vector<std::string> command = {
      "verify",  "--law", "linear", "--backends", "embedded,liggghts", "--rungs", "packing",
      "--seeds", "2",     "--out",  "out"};
  const ProcessResult first = Powdercal(command, folder.path());
  EXPECT_THAT(first.output, HasSubstr("rung 2, packing: 4 runs\n"));
  EXPECT_THAT(first.output, HasSubstr("void_ratio at 900 Pa"));
  const ProcessResult again = Powdercal(command, folder.path());
  EXPECT_THAT(again.output, HasSubstr("rung 2, packing: 4 runs, 4 of them in the ledger"));
  EXPECT_EQ(first.exit_status, again.exit_status);
  const auto json = ReadJson(folder / "out/verification.json");
  EXPECT_EQ(json["seeds"], 2);
  EXPECT_THAT(ReadFile(folder / "out/verification.html"), HasSubstr("void_ratio at 900 Pa"));
  // Another law has no business there.
  const ProcessResult other =
      Powdercal({"verify", "--law", "paper", "--rungs", "1", "--out", "out"}, folder.path());
  EXPECT_EQ(other.exit_status, 2);
  EXPECT_THAT(other.output, HasSubstr("belongs to another study"));
}

}  // namespace
}  // namespace powdercal

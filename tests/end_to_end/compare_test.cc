#include <gmock/gmock.h>

#include "tests/cli/streams.h"
#include "tests/support/comparison_document.h"

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

// A few simulations of the embedded engine, emulated: from a design, and from a run.
TEST(Compare, EmulatesADesignThatItSimulates) {
  const TemporaryFolder folder;
  const std::vector<std::string> command = {"compare",       "quickstart",
                                            "--design",      "6",
                                            "--seeds",       "2",
                                            "--optimizers",  "bayesian,random",
                                            "--evaluations", "7",
                                            "--out",         "x",
                                            "--set",         "backend.replicates=1",
                                            "--set",         "backend.confirm_replicates=1",
                                            "--json"};
  const Streams result = PowdercalStreams(command, folder.path());
  ASSERT_EQ(result.exit_status, 0) << result.error;
  const json document = json::parse(result.output);
  EXPECT_EQ(document.at("source").at("kind"), "emulator");
  EXPECT_EQ(document.at("source").at("points"), 6);
  EXPECT_EQ(document.at("source").at("runs"), 12);  // two seeds, for the scatter
  EXPECT_THAT(document.at("source").at("text").get<std::string>(), HasSubstr("x/design"));
  const json& response = document.at("source").at("responses").at(0);
  EXPECT_EQ(response.at("response"), "consolidation.void_ratio");
  EXPECT_EQ(response.at("sd_from_replicates"), true);
  for (const json& contest : document.at("contests")) {
    EXPECT_EQ(contest.at("hold_out").at(0).at("fidelity"), "quick");
    EXPECT_GT(contest.at("core_seconds"), 0);
  }
  // The design is not simulated again, and serves as a run.
  const Streams again = PowdercalStreams(command, folder.path());
  EXPECT_EQ(json::parse(again.output).at("contests"), document.at("contests"));
  const Streams emulated = PowdercalStreams(
      {"compare", "quickstart", "--emulate", "x/design", "--seeds", "2", "--optimizers",
       "bayesian,random", "--evaluations", "7", "--out", "y", "--set", "backend.replicates=1",
       "--set", "backend.confirm_replicates=1", "--json"},
      folder.path());
  ASSERT_EQ(emulated.exit_status, 0) << emulated.error;
  EXPECT_EQ(Reproducible(json::parse(emulated.output)).at("contests"),
            Reproducible(document).at("contests"));
}

TEST(Compare, SimulatesForRealAndResumesFromTheLedger) {
  const TemporaryFolder folder;
  const std::vector<std::string> command = {"compare",
                                            "quickstart",
                                            "--real",
                                            "--seeds",
                                            "1",
                                            "--optimizers",
                                            "sobol,random",
                                            "--evaluations",
                                            "3",
                                            "--out",
                                            "x",
                                            "--hold-out-seeds",
                                            "0",
                                            "--set",
                                            "backend.replicates=1",
                                            "--json"};
  const Streams result = PowdercalStreams(command, folder.path());
  ASSERT_EQ(result.exit_status, 0) << result.error;
  const json document = json::parse(result.output);
  EXPECT_EQ(document.at("source").at("kind"), "simulator");
  EXPECT_EQ(document.at("judged_by"), "observation");
  ASSERT_EQ(document.at("contests").size(), 2U);
  // Without its record of contests the comparison is the same from the ledger alone.
  std::filesystem::remove(folder / "x/comparison.json");
  const Streams again = PowdercalStreams(command, folder.path());
  ASSERT_EQ(again.exit_status, 0) << again.error;
  EXPECT_EQ(Reproducible(json::parse(again.output)).at("contests"),
            Reproducible(document).at("contests"));
}

}  // namespace
}  // namespace powdercal

#include <gmock/gmock.h>

#include "tests/support/program.h"

// The best point of a study on the embedded engine, confirmed with the real LIGGGHTS.

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

std::string ConfirmedStudy() {
  const std::string text = StudyText("quickstart", "          tolerance: 0.01\n");
  return text.substr(0, text.find("optimizer:")) +
         "optimizer:\n"
         "  name: list\n"
         "  points:\n"
         "    - {cohesion_energy_density: 7e3 J/m3, rolling_friction: 0.4}\n"
         "backend: {replicates: 2, confirm_replicates: 2, confirm_with: [liggghts]}\n"
         "budget: {parallel: 2}\n";
}

TEST(Confirmation, WithLiggghtsThroughKills) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "study.yaml", ConfirmedStudy());
  const ProcessResult whole = Powdercal({"run", "study.yaml", "--out", "whole"}, folder.path());
  ASSERT_EQ(whole.exit_status, 0) << whole.output;
  const json results = ReadJson(folder / "whole/results.json");
  ASSERT_EQ(results.at("confirmations").size(), 1u);
  const json& confirmation = results.at("confirmations")[0];
  EXPECT_EQ(confirmation.at("backend"), "liggghts");
  EXPECT_EQ(confirmation.at("outcome"), "ok") << confirmation.at("message");
  EXPECT_THAT(confirmation.at("contact_law_as_run").get<std::string>(), HasSubstr("sjkr2"));
  const json& ratio = confirmation.at("responses").at("consolidation.void_ratio");
  EXPECT_EQ(ratio.at("replicates"), 2);
  // From the same particles the two engines differ by little beside the scatter of the seeds.
  EXPECT_LT(std::abs(ratio.at("difference").get<double>()), 0.03);
  EXPECT_THAT(ReadFile(folder / "whole/report.html"), HasSubstr("card wide confirmations"));

  // Killed in the study and in its confirmation.
  for (const double share : {0.1, 0.7}) {
    RunProcess({.arguments = {POWDERCAL_PROGRAM, "run", "study.yaml", "--out", "killed"},
                .working_directory = folder.path(),
                .time_limit = std::chrono::duration<double>(share * whole.wall_seconds)});
  }
  const ProcessResult last = Powdercal({"resume", "killed"}, folder.path());
  ASSERT_EQ(last.exit_status, 0) << last.output;
  const json resumed = ReadJson(folder / "killed/results.json");
  EXPECT_EQ(resumed.at("history").dump(), results.at("history").dump());
  EXPECT_EQ(resumed.at("confirmations").dump(), results.at("confirmations").dump());
  EXPECT_EQ(resumed.at("runs").size(), results.at("runs").size());
}

}  // namespace
}  // namespace powdercal

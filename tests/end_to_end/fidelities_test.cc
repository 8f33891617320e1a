#include <gmock/gmock.h>

#include "tests/support/program.h"

// Beds of 1000 and of 3000 particles in one study, on the embedded engine.

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

TEST(Fidelities, LearnsFromSmallerSimulationsThroughAKill) {
  const TemporaryFolder folder;
  const auto command = [](const std::string& out) -> std::vector<std::string> {
    return {"run",
            "quickstart",
            "--fidelity",
            "standard",
            "--deterministic",
            "--evaluations",
            "3",
            "--set",
            "backend.lower_fidelities=[quick]",
            "--set",
            "backend.replicates=1",
            "--set",
            "backend.confirm_replicates=1",
            "--out",
            out};
  };
  const ProcessResult whole = Powdercal(command("whole"), folder.path());
  ASSERT_EQ(whole.exit_status, 0) << whole.output;
  EXPECT_THAT(whole.output, HasSubstr(" at quick -> consolidation.void_ratio"));
  EXPECT_THAT(whole.output, HasSubstr("at a lower fidelity (quick): learnt from, not ranked"));
  const json results = ReadJson(folder / "whole/results.json");
  const json& lower = results.at("lower_fidelity");
  ASSERT_GE(lower.size(), 5u) << "the initial design";
  ASSERT_GE(results.at("history").size(), 1u);
  EXPECT_EQ(results.at("evaluations").at("total"), lower.size() + results.at("history").size());
  for (const json& evaluation : lower) EXPECT_EQ(evaluation.at("fidelity"), "quick");
  for (const json& evaluation : results.at("history")) {
    EXPECT_EQ(evaluation.at("fidelity"), "standard");
  }
  // More particles pack alike: what is learnt from `quick` is worth something.
  const auto void_ratio = [](const json& evaluation) {
    return evaluation.at("responses").at("consolidation.void_ratio").at("simulated").get<double>();
  };
  EXPECT_GT(void_ratio(lower[3]), void_ratio(lower[0]) + 0.3) << "sticky against nearly free";
  EXPECT_THAT(ReadFile(folder / "whole/report.html"), HasSubstr("id=\"lower_fidelity\""));

  std::vector<std::string> arguments = command("killed");
  arguments.insert(arguments.begin(), POWDERCAL_PROGRAM);
  RunProcess({.arguments = arguments,
              .working_directory = folder.path(),
              .time_limit = std::chrono::duration<double>(0.5 * whole.wall_seconds)});
  const ProcessResult last = Powdercal({"resume", "killed"}, folder.path());
  ASSERT_EQ(last.exit_status, 0) << last.output;
  const json resumed = ReadJson(folder / "killed/results.json");
  EXPECT_EQ(resumed.at("history").dump(), results.at("history").dump());
  EXPECT_EQ(resumed.at("lower_fidelity").dump(), lower.dump());
}

TEST(Fidelities, CheckSaysWhatTheyCost) {
  const ProcessResult result =
      Powdercal({"check", "quickstart", "--fidelity", "standard", "--set",
                 "backend.lower_fidelities=[quick]", "--json"});
  ASSERT_EQ(result.exit_status, 0) << result.output;
  const json lower = json::parse(result.output).at("lower_fidelities");
  ASSERT_EQ(lower.size(), 1u);
  EXPECT_EQ(lower[0].at("fidelity"), "quick");
  EXPECT_LT(lower[0].at("cost"), 0.34);
}

}  // namespace
}  // namespace powdercal

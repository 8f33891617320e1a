#include <gmock/gmock.h>

#include "tests/support/program.h"

// Consolidation and spreading calibrated together, then shear, on the embedded engine.

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

// At the second point the bed is too cohesive to come to rest in the four windows that it is
// given: there consolidation fails, and spreading does not.
std::string JointStudy() {
  std::string text = StudyText("quickstart", "          tolerance: 0.01\n");
  const std::string stress = "      stress: 9 kPa\n";
  text.replace(text.find(stress), stress.size(), stress + "      max_hold_windows: 4\n");
  return text.substr(0, text.find("objective:")) +
         "  - spreading:\n"
         "      sweep: 0.7 mm\n"
         "      observed: {coverage: {value: 0.9, sd: 0.05}}\n"
         "  - shear:\n"
         "      preshear: 9 kPa\n"
         "      repeats: 1\n"
         "      calibrate: false\n"
         "      observed: {yield_locus: locus.csv}\n"
         "optimizer:\n"
         "  name: list\n"
         "  points:\n"
         "    - {cohesion_energy_density: 1e2 J/m3, rolling_friction: 0.05}\n"
         "    - {cohesion_energy_density: 1e5 J/m3, rolling_friction: 0.7}\n"
         "backend: {replicates: 1, confirm_replicates: 1}\n";
}

TEST(SeveralExperiments, PartialFailureAndTransferThroughKills) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "study.yaml", JointStudy());
  WriteFileAtomically(folder / "locus.csv",
                      "normal_stress [kPa],shear_stress [kPa],shear_stress_sd [kPa]\n"
                      "3,1.8,0.15\n5,2.9,0.2\n7,3.9,0.2\n");
  const auto command = [](const std::string& out) -> std::vector<std::string> {
    return {"run", "study.yaml", "--out", out, "--evaluate-also", "shear"};
  };
  const ProcessResult whole = Powdercal(command("whole"), folder.path());
  ASSERT_EQ(whole.exit_status, 0) << whole.output;
  const json results = ReadJson(folder / "whole/results.json");
  EXPECT_EQ(results.at("evaluations").at("ok"), 1);
  EXPECT_EQ(results.at("evaluations").at("partial"), 1);
  const json& failure = results.at("failures").at(0).at("experiments").at(0);
  EXPECT_EQ(failure.at("experiment"), "consolidation");
  EXPECT_EQ(failure.at("outcome"), "not_quasi_static");
  const json& history = results.at("history");
  EXPECT_TRUE(history[1].at("responses").at("spreading.coverage").at("simulated").is_number());
  EXPECT_EQ(results.at("best").at("evaluation"), 0);
  // Against a made-up locus of a cohesive powder: friction of hardly rolling spheres is too low.
  const json& transfer = results.at("best").at("transfer");
  for (const char* point : {"shear_stress_1", "shear_stress_2", "shear_stress_3"}) {
    EXPECT_LT(transfer.at(std::string("shear.") + point).at("standard_deviations_off"), -2);
  }
  EXPECT_TRUE(transfer.at("shear.tan_phi").at("observed").is_null());

  // Killed on the way; the file of observations is no longer there, nor needed.
  for (const double share : {0.4, 0.8}) {
    std::vector<std::string> arguments = command("killed");
    arguments.insert(arguments.begin(), POWDERCAL_PROGRAM);
    RunProcess({.arguments = arguments,
                .working_directory = folder.path(),
                .time_limit = std::chrono::duration<double>(share * whole.wall_seconds)});
  }
  std::filesystem::remove(folder / "locus.csv");
  const ProcessResult last =
      Powdercal({"resume", "killed", "--evaluate-also", "shear"}, folder.path());
  ASSERT_EQ(last.exit_status, 0) << last.output;
  const json resumed = ReadJson(folder / "killed/results.json");
  EXPECT_EQ(resumed.at("history").dump(), history.dump());
  EXPECT_EQ(resumed.at("best").at("transfer").dump(), transfer.dump());
  EXPECT_EQ(resumed.at("runs").size(), results.at("runs").size());
}

}  // namespace
}  // namespace powdercal

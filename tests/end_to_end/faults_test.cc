#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "tests/support/program.h"
#include "tests/support/simulators.h"

// Faults in the middle of studies on the real LIGGGHTS: recorded with the right reason, and the
// study goes on.

namespace powdercal {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

// Four points on LIGGGHTS, each simulated once, all of them: no tolerance ends the study early.
std::string FourPoints() {
  std::string text = StudyText("quickstart", "          tolerance: 0.01\n");
  const std::size_t begin = text.find("optimizer:");
  text.replace(begin, text.find('\n', begin) - begin,
               "optimizer:\n"
               "  name: list\n"
               "  points:\n"
               "    - {cohesion_energy_density: 7 kJ/m3, rolling_friction: 0.4}\n"
               "    - {cohesion_energy_density: 30 kJ/m3, rolling_friction: 0.3}\n"
               "    - {cohesion_energy_density: 40 kJ/m3, rolling_friction: 0.3}\n"
               "    - {cohesion_energy_density: 1 kJ/m3, rolling_friction: 0.1}");
  const std::string replicates = "replicates: 3, confirm_replicates: 6";
  text.replace(text.find(replicates), replicates.size(), "replicates: 1, confirm_replicates: 1");
  const std::string backend = "name: embedded";
  text.replace(text.find(backend), backend.size(), "name: liggghts");
  return text;
}

class Faults : public ::testing::Test {
 protected:
  Faults() { WriteFileAtomically(folder_ / "study.yaml", FourPoints()); }

  ProcessResult Run(const std::string& name, std::vector<std::string> extra = {}) {
    std::vector<std::string> arguments = {"run", (folder_ / "study.yaml").string(), "--out",
                                          (folder_ / name).string()};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    return Powdercal(arguments, folder_.path());
  }

  nlohmann::json Results(const std::string& name) {
    return ReadJson(folder_ / name / "results.json");
  }

  TemporaryFolder folder_;
};

// Signals the simulator of one point as soon as it is there.
class Saboteur {
 public:
  Saboteur(fs::path work_folder, int signal)
      : thread_([folder = std::move(work_folder), signal](std::stop_token done) {
          while (!done.stop_requested()) {
            for (const pid_t pid : SimulatorsIn(folder)) {
              kill(pid, signal);
              return;
            }
            std::this_thread::sleep_for(20ms);
          }
        }) {}

 private:
  std::jthread thread_;
};

TEST_F(Faults, HangingAndKilledSimulatorsCostTheirOwnPointOnly) {
  ASSERT_EQ(Run("undisturbed").exit_status, 0);
  ProcessResult result;
  {
    const Saboteur hang(folder_ / "disturbed/runs/0001-consolidation-0", SIGSTOP);
    const Saboteur murder(folder_ / "disturbed/runs/0002-consolidation-0", SIGKILL);
    result = Run("disturbed", {"--run-timeout", "60 s"});
  }
  ASSERT_EQ(result.exit_status, 0) << result.output;
  const nlohmann::json disturbed = Results("disturbed");
  const nlohmann::json& history = disturbed["history"];
  ASSERT_EQ(history.size(), 4u);
  const auto outcome = [&](std::size_t id) {
    for (const nlohmann::json& entry : history) {
      if (entry["evaluation"] == id) return entry["outcome"].get<std::string>();
    }
    return std::string("missing");
  };
  EXPECT_EQ(outcome(0), "ok");
  EXPECT_EQ(outcome(1), "timeout");
  EXPECT_EQ(outcome(2), "crashed");
  EXPECT_EQ(outcome(3), "ok");
  EXPECT_EQ(disturbed["evaluations"]["failed"], 2);
  EXPECT_EQ(disturbed["best"], Results("undisturbed")["best"]);
  EXPECT_TRUE(fs::exists(folder_ / "disturbed/runs/0001-consolidation-0/in.deck"))
      << "a failed run keeps its files";
  EXPECT_TRUE(SimulatorsIn(folder_ / "disturbed").empty());
}

TEST_F(Faults, TimeStepThatBlowsUpFailsEveryPointAndTheStudySaysSo) {
  const ProcessResult result = Run("x", {"--set", "numerics.time_step=6 us"});
  EXPECT_EQ(result.exit_status, 1) << result.output;
  const nlohmann::json results = Results("x");
  EXPECT_EQ(results["evaluations"]["failed"], 4);
  EXPECT_TRUE(results["best"].is_null());
  for (const nlohmann::json& entry : results["history"]) EXPECT_EQ(entry["outcome"], "unstable");
  EXPECT_TRUE(fs::exists(folder_ / "x/report.html"));
}

TEST_F(Faults, StressOutOfReachIsNotQuasiStatic) {
  const ProcessResult result =
      Run("x", {"--set", "experiments[0].consolidation.max_load_time=0.01", "--set",
                "experiments[0].consolidation.max_hold_windows=1"});
  EXPECT_EQ(result.exit_status, 1) << result.output;
  for (const nlohmann::json& entry : Results("x")["history"]) {
    EXPECT_EQ(entry["outcome"], "not_quasi_static");
  }
}

TEST_F(Faults, CohesionBeyondAllBoundsFailsItsOwnPointOnly) {
  std::string text = FourPoints();
  const std::string range = "range: [1e2, 1e5]";
  text.replace(text.find(range), range.size(), "range: [1e2, 1e9]");
  const std::string point = "30 kJ/m3";
  text.replace(text.find(point), point.size(), "500 MJ/m3");
  WriteFileAtomically(folder_ / "study.yaml", text);
  const ProcessResult result = Run("x", {"--run-timeout", "60 s"});
  EXPECT_EQ(result.exit_status, 0) << result.output;
  const nlohmann::json results = Results("x");
  EXPECT_EQ(results["evaluations"]["ok"], 3);
  EXPECT_EQ(results["evaluations"]["failed"], 1);
}

}  // namespace
}  // namespace powdercal

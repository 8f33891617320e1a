#include <gmock/gmock.h>

#include "tests/cli/streams.h"

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Streams Simulate(const std::vector<std::string>& more) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments = {"simulate", "hastelloy_x_table3"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  Streams result = PowdercalStreams(arguments, folder.path());
  EXPECT_THAT(Listing(folder.path()), IsEmpty());
  return result;
}

TEST(Simulate, AnswersAtOnePoint) {
  const Streams result = Simulate({"-p", "k=47500", "-p", "mu_r=0.5"});
  EXPECT_EQ(result.exit_status, 0);
  EXPECT_THAT(result.output, HasSubstr("void_ratio  0.77"));
  EXPECT_THAT(result.error, HasSubstr("no simulation was run"));
}

TEST(Simulate, JsonByNameAndUnit) {
  const Streams result =
      Simulate({"-p", "cohesion_energy_density=47.5 kJ/m3", "-p", "rolling_friction=0.5", "--json",
                "--replicates", "2", "--particle-seed", "7"});
  EXPECT_EQ(result.exit_status, 0);
  const json document = json::parse(result.output);
  EXPECT_EQ(document.at("simulated"), false);
  EXPECT_EQ(document.at("parameters").at("cohesion_energy_density"), 47500);
  ASSERT_EQ(document.at("runs").size(), 2u);
  EXPECT_EQ(document.at("runs").at(0).at("seed"), 7);
  EXPECT_EQ(document.at("runs").at(1).at("seed"), 8);
  for (const json& run : document.at("runs")) {
    EXPECT_EQ(run.at("outcome"), "ok");
    EXPECT_NEAR(run.at("responses").at("void_ratio"), 0.78, 0.02);
  }
}

TEST(Simulate, WritesSnapshotsOfTheQuickstart) {
  const TemporaryFolder folder;
  const Streams result =
      PowdercalStreams({"simulate", "quickstart", "-p", "k=7000", "-p", "mu_r=0.4", "--snapshots",
                        "1 ms", "--out", "x", "--json"},
                       folder.path());
  ASSERT_EQ(result.exit_status, 0) << result.error;
  const json run = json::parse(result.output).at("runs").at(0);
  EXPECT_EQ(run.at("outcome"), "ok");
  EXPECT_EQ(run.at("backend"), "embedded");
  EXPECT_GT(run.at("figures").at("particle_steps_per_second"), 0);
  const std::filesystem::path snapshots = run.at("snapshots").get<std::string>();
  EXPECT_THAT(result.error, HasSubstr("snapshots: " + snapshots.string()));
  for (const char* list : {"particles.pvd", "walls.pvd"}) {
    const std::string text = ReadFile(folder.path() / snapshots / list);
    EXPECT_THAT(text, HasSubstr("timestep=\"0\"")) << list;
    EXPECT_THAT(text, HasSubstr("timestep=\"0.00")) << list;
  }
}

class SimulateMistakes : public ::testing::TestWithParam<Mistake> {};

TEST_P(SimulateMistakes, AreExplained) {
  const Streams result = Simulate(GetParam().arguments);
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_EQ(result.output, "");
  for (const std::string& piece : GetParam().message) EXPECT_THAT(result.error, HasSubstr(piece));
}

INSTANTIATE_TEST_SUITE_P(
    Cli, SimulateMistakes,
    ::testing::Values(
        Mistake{{"-p", "k=1"}, {"missing parameter 'rolling_friction'", "-p mu_r=VALUE"}},
        Mistake{{"-p", "k=1", "-p", "rolling_frction=1"},
                {"unknown parameter 'rolling_frction'", "did you mean 'rolling_friction'?"}},
        Mistake{{"-p", "k=1", "-p", "mu_r=0.1", "-p", "cohesion_energy_density=2"},
                {"command line: cohesion_energy_density: given twice"}},
        Mistake{{"-p", "k", "-p", "mu_r=0.1"}, {"expected -p NAME=VALUE (found 'k')"}},
        Mistake{{"-p", "k=stiff", "-p", "mu_r=0.1"},
                {"command line: cohesion_energy_density: 'stiff' is not a number"}},
        Mistake{{"-p", "k=3 m", "-p", "mu_r=0.1"},
                {"command line: cohesion_energy_density: expected a pressure", "got a length"}},
        Mistake{{"-p", "k=nan", "-p", "mu_r=0.1"}, {"'nan' is not a number"}},
        Mistake{{"-p", "k=-1", "-p", "mu_r=0.1"},
                {"command line: cohesion_energy_density: must be at least 0 (found '-1')"}},
        Mistake{{"-p", "k=1", "-p", "mu_r=0.1", "--replicates", "0"},
                {"--replicates: Value 0 not in range 1 to 1000"}},
        Mistake{{"-p", "k=1", "-p", "mu_r=0.1", "--particle-seed", "-1"},
                {"--particle-seed: Value -1 not in range"}},
        Mistake{{"-p", "k=1", "-p", "mu_r=0.1", "--out", "/proc/powdercal"},
                {"/proc/powdercal: cannot write the folder"}},
        Mistake{{"-p", "k=1", "-p", "mu_r=0.1", "--snapshots", "0.1 ms"},
                {"command line: --snapshots: backend 'table' writes no snapshots; use --backend "
                 "embedded"}},
        Mistake{{"-p", "k=1", "-p", "mu_r=0.1", "--snapshots", "often"},
                {"command line: --snapshots: 'often' is not a number"}},
        Mistake{{"-p", "k=1", "-p", "mu_r=0.1", "--snapshots", "0.1"},
                {"command line: --snapshots: ", "expected a time (such as s)"}},
        Mistake{{"-p", "k=1", "-p", "mu_r=0.1", "--snapshots", "3 um"},
                {"command line: --snapshots: expected a time", "got a length"}},
        Mistake{{"-p", "k=1", "-p", "mu_r=0.1", "--snapshots", "0 s"},
                {"command line: --snapshots: must be above 0 s (found '0 s')"}},
        Mistake{{"-p", "k=1", "-p", "mu_r=0.1", "--snapshots=-1 ms"},
                {"command line: --snapshots: must be above 0 s (found '-1 ms')"}},
        Mistake{{"-p", "k=1", "-p", "mu_r=0.1", "--snapshots", ""},
                {"--snapshots: a value is missing"}}));

}  // namespace
}  // namespace powdercal

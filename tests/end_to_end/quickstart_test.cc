#include <gmock/gmock.h>

#include <cmath>

#include "tests/support/program.h"

// The shipped quickstart study on the real LIGGGHTS, as ./run starts it.

namespace powdercal {
namespace {

using ::testing::HasSubstr;

TEST(Quickstart, CalibratesRealSimulationsToTheObservedVoidRatio) {
  const TemporaryFolder folder;
  const ProcessResult result =
      Powdercal({"run", "quickstart", "--out", (folder / "x").string()}, folder.path());
  ASSERT_EQ(result.exit_status, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("report.html"));

  const nlohmann::json results = ReadJson(folder / "x/results.json");
  EXPECT_EQ(results["schema"], 1);
  EXPECT_LE(results["evaluations"]["total"].get<int>(), 20);
  const nlohmann::json& response = results["best"]["responses"]["consolidation.void_ratio"];
  EXPECT_LE(std::abs(response["simulated"].get<double>() - 0.783), 0.02);
  EXPECT_EQ(response["observed"], 0.783);
  EXPECT_GE(response["replicates"].get<int>(), 3);
  EXPECT_EQ(results["backend"]["name"], "liggghts");
  EXPECT_EQ(results["backend"]["version"], "3.8.0");
  // Framework overhead, all that is not inside a simulator, as a share of the wall clock.
  EXPECT_LT(results["overhead_s"].get<double>(), 0.02 * results["wall_s"].get<double>());

  EXPECT_GT(std::filesystem::file_size(folder / "x/report.html"), 100'000u);
  EXPECT_THAT(ReadFile(folder / "x/material_card.yaml"), HasSubstr("cohesion_energy_density"));
  EXPECT_TRUE(!std::filesystem::exists(folder / "x/runs") ||
              std::filesystem::is_empty(folder / "x/runs"))
      << "the files of successful runs are not kept";
}

}  // namespace
}  // namespace powdercal

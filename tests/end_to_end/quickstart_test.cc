#include <gmock/gmock.h>

#include <cmath>

#include "tests/support/program.h"

// The shipped quickstart study, as ./run starts it.

namespace powdercal {
namespace {

using ::testing::HasSubstr;

class Quickstart : public ::testing::Test {
 protected:
  // What results.json says after a run, and what must hold for it on every backend.
  nlohmann::json Calibrate(const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"run", "quickstart", "--out", (folder_ / "x").string()};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProcessResult result = Powdercal(arguments, folder_.path());
    EXPECT_EQ(result.exit_status, 0) << result.output;
    EXPECT_THAT(result.output, HasSubstr("report.html"));

    nlohmann::json results = ReadJson(folder_ / "x/results.json");
    EXPECT_EQ(results["schema"], 1);
    EXPECT_LE(results["evaluations"]["total"].get<int>(), 20);
    EXPECT_EQ(results["evaluations"]["failed"], 0);
    const nlohmann::json& response = results["best"]["responses"]["consolidation.void_ratio"];
    EXPECT_LE(std::abs(response["simulated"].get<double>() - 0.783), 0.02);
    EXPECT_EQ(response["observed"], 0.783);
    EXPECT_GE(response["replicates"].get<int>(), 3);

    EXPECT_GT(std::filesystem::file_size(folder_ / "x/report.html"), 100'000u);
    EXPECT_THAT(ReadFile(folder_ / "x/material_card.yaml"), HasSubstr("cohesion_energy_density"));
    EXPECT_TRUE(!std::filesystem::exists(folder_ / "x/runs") ||
                std::filesystem::is_empty(folder_ / "x/runs"))
        << "the files of successful runs are not kept";
    return results;
  }

  TemporaryFolder folder_;
};

TEST_F(Quickstart, FindsTheObservedVoidRatio) {
  const nlohmann::json results = Calibrate({});
  EXPECT_EQ(results["backend"]["name"], "embedded");
}

TEST_F(Quickstart, FindsItOnLiggghtsToo) {
  const nlohmann::json results = Calibrate({"--backend", "liggghts"});
  EXPECT_EQ(results["backend"]["name"], "liggghts");
  EXPECT_EQ(results["backend"]["version"], "3.8.0");
}

}  // namespace
}  // namespace powdercal

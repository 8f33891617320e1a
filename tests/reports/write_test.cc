#include "reports/write.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "tests/reports/sample_studies.h"

namespace powdercal {
namespace {

TEST(WriteReportsTest, WritesThreeFilesAndNothingElse) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "write_reports";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  WriteReports(QuickstartSample(), folder);
  WriteReports(QuickstartSample(), folder);
  std::ifstream json(folder / "results.json");
  EXPECT_EQ(nlohmann::json::parse(json).at("schema"), 1);
  EXPECT_EQ(YAML::LoadFile(folder / "material_card.yaml")["powder"].as<std::string>(),
            "Hastelloy X");
  EXPECT_GT(std::filesystem::file_size(folder / "report.html"), 500000u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 3);
  std::filesystem::remove_all(folder);
}

TEST(WriteReportsTest, UnwritableFolderIsAnInputError) {
  EXPECT_THROW(WriteReports(LineSample(), "/proc/no/such/folder"), InputError);
}

}  // namespace
}  // namespace powdercal

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "tests/cli/streams.h"

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// 12 rows: e is linear in ln k and mu_r, w in the column without a unit is constant, and a response
// of an experiment stands before the last column.
std::string LogLinearCsv() {
  std::string text = "k [kJ/m3],mu_r,w,shear.cohesion [Pa],e\n";
  for (int i = 0; i < 12; ++i) {
    const double k = 0.1 * std::pow(1000.0, i / 11.0);
    const double mu = 0.05 + 0.06 * ((5 * i) % 12);
    text += std::to_string(k) + "," + std::to_string(mu) + ",3," + std::to_string(i) + "," +
            std::to_string(0.5 + 0.1 * std::log(k) + 0.2 * mu) + "\n";
  }
  return text;
}

Streams Compare(const TemporaryFolder& folder, const std::string& csv,
                std::vector<std::string> more = {}) {
  WriteFileAtomically(folder / "t.csv", csv);
  std::vector<std::string> arguments = {"compare", "--surrogates", "t.csv", "--repeats", "1"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return PowdercalStreams(arguments, folder.path());
}

TEST(CompareSurrogates, PrintsAndPlotsATable) {
  const TemporaryFolder folder;
  const Streams result = Compare(folder, LogLinearCsv(), {"--log", "k"});
  EXPECT_EQ(result.exit_status, 0) << result.error;
  for (const char* piece : {"# e over k [kJ/m3] (log), mu_r, 12 points", "R2 leave-one-out",
                            "gaussian_process", "gradient_boosting", "nearest_neighbours",
                            "random_forest", "ridge", "support_vector", "best: ridge"}) {
    EXPECT_THAT(result.output, HasSubstr(piece));
  }
  EXPECT_THAT(result.error, AllOf(HasSubstr("column 'w' is 3 in every row, and left out"),
                                  HasSubstr("column 'shear.cohesion' is a response")));
  const std::filesystem::path pages = folder / "runs/t-surrogates";
  EXPECT_THAT(Listing(pages), ElementsAre("surrogates.html", "surrogates.json"));
  const std::string page = ReadFile(pages / "surrogates.html");
  EXPECT_THAT(page, AllOf(HasSubstr("<h1>Surrogates compared on t.csv</h1>"),
                          HasSubstr("vegaEmbed('#f1'")));
  EXPECT_THAT(page, ::testing::Not(HasSubstr("https://cdn")));
}

TEST(CompareSurrogates, JsonHasEveryFigure) {
  const TemporaryFolder folder;
  const Streams result = Compare(folder, LogLinearCsv(), {"--log", "k", "--json", "--out", "o"});
  ASSERT_EQ(result.exit_status, 0) << result.error;
  const json document = json::parse(result.output);
  EXPECT_EQ(document, ReadJson(folder / "o/surrogates.json"));
  ASSERT_EQ(document["inputs"].size(), 2u);
  EXPECT_EQ(document["inputs"][0]["name"], "k");
  EXPECT_EQ(document["inputs"][0]["unit"], "kJ/m3");
  EXPECT_NEAR(document["inputs"][0]["upper"].get<double>(), 100, 1e-6);
  EXPECT_EQ(document["inputs"][0]["logarithmic"], true);
  ASSERT_EQ(document["responses"].size(), 1u);
  const json& response = document["responses"][0];
  EXPECT_EQ(response["best"], "ridge");
  ASSERT_EQ(response["surrogates"].size(), 6u);
  for (const json& one : response["surrogates"]) {
    EXPECT_EQ(one["problem"], "");
    // R² from the predictions once more.
    const auto values = response["values"].get<std::vector<double>>();
    const auto predicted = one["leave_one_out"]["predicted"].get<std::vector<double>>();
    ASSERT_EQ(values.size(), 12u);
    ASSERT_EQ(predicted.size(), 12u);
    double mean = 0;
    for (const double value : values) mean += value / 12;
    double total = 0;
    double squares = 0;
    for (std::size_t i = 0; i < 12; ++i) {
      total += std::pow(values[i] - mean, 2);
      squares += std::pow(values[i] - predicted[i], 2);
    }
    EXPECT_NEAR(one["leave_one_out"]["r2"].get<double>(), 1 - squares / total, 1e-9);
    EXPECT_NEAR(one["leave_one_out"]["rmse"].get<double>(), std::sqrt(squares / 12), 1e-9);
    EXPECT_EQ(one["k_fold"]["r2_each"].size(), 1u);
    EXPECT_EQ(one["hold_out"]["r2"], one["hold_out"]["r2_each"][0]);
  }
}

TEST(CompareSurrogates, ComparesOnARun) {
  const TemporaryFolder folder;
  const auto run = PowdercalStreams(
      {"run", "hastelloy_x_table3", "--evaluations", "6", "--out", "r"}, folder.path());
  ASSERT_EQ(run.exit_status, 0) << run.error;
  const Streams result = PowdercalStreams(
      {"compare", "--surrogates", "r", "--repeats", "1", "--folds", "3"}, folder.path());
  EXPECT_EQ(result.exit_status, 0) << result.error;
  EXPECT_THAT(result.output, HasSubstr("# consolidation.void_ratio over cohesion_energy_density "
                                       "[J/m3], rolling_friction, 6 points"));
  EXPECT_TRUE(std::filesystem::exists(folder / "r/surrogates.html"));
  const Streams wrong = PowdercalStreams(
      {"compare", "--surrogates", "r", "--response", "consolidation.void_ration"}, folder.path());
  EXPECT_EQ(wrong.exit_status, 2);
  EXPECT_THAT(wrong.error, HasSubstr("did you mean 'consolidation.void_ratio'?"));
}

TEST(CompareSurrogates, BadInputIsRefusedWithItsPlace) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& csv, std::vector<std::string> more = {}) {
    const Streams result = Compare(folder, csv, std::move(more));
    EXPECT_EQ(result.exit_status, 2);
    EXPECT_EQ(result.output, "");
    return result.error;
  };
  EXPECT_THAT(error("k,e\n1,2\n2,three\n3,4\n"), AllOf(HasSubstr("t.csv:3:3"), HasSubstr("three")));
  EXPECT_THAT(error("k [J/m3x],e\n1,2\n2,3\n3,4\n"), HasSubstr("t.csv:1"));
  EXPECT_THAT(error("k,e\n1,2\n2,3\n"), HasSubstr("2 rows"));
  EXPECT_THAT(error("k,e\n1,2\n1,3\n1,4\n"), HasSubstr("no column is left"));
  EXPECT_THAT(error("k,e\n1,2\n2,3\n3,4\n", {"--response", "ee"}), HasSubstr("did you mean 'e'?"));
  EXPECT_THAT(error("mu,e\n0,2\n2,3\n3,4\n", {"--log", "mu"}), HasSubstr("the lowest is 0"));
  EXPECT_THAT(error("mu_r,e\n1,2\n2,3\n3,4\n", {"--log", "mu_rr"}),
              HasSubstr("did you mean 'mu_r'?"));
  EXPECT_TRUE(!std::filesystem::exists(folder / "runs"));
  const Streams absent = PowdercalStreams({"compare", "--surrogates", "absent.csv"}, folder.path());
  EXPECT_EQ(absent.exit_status, 2);
  EXPECT_THAT(absent.error, HasSubstr("absent.csv"));
}

TEST(CompareSurrogates, EqualValuesHaveNoBest) {
  const TemporaryFolder folder;
  const Streams result = Compare(folder, "k,e\n1,2\n2,2\n3,2\n4,2\n5,2\n");
  EXPECT_EQ(result.exit_status, 1);
  EXPECT_THAT(result.output, HasSubstr("all values are equal"));
  EXPECT_THAT(result.output, ::testing::Not(HasSubstr("best:")));
}

}  // namespace
}  // namespace powdercal

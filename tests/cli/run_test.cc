#include <gmock/gmock.h>

#include <regex>

#include "tests/cli/streams.h"

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<std::string> kRun = {"run", "hastelloy_x_table3", "--out", "x"};

TEST(Run, JsonIsTheResultsFileAndNothingElse) {
  const TemporaryFolder folder;
  const Streams result = PowdercalStreams(With(kRun, {"--json"}), folder.path());
  ASSERT_EQ(result.exit_status, 0) << result.error;
  const json results = json::parse(result.output);
  EXPECT_EQ(results, ReadJson(folder / "x/results.json"));
  EXPECT_EQ(results.at("schema"), 1);
  EXPECT_EQ(results.at("backend").at("name"), "table");
  EXPECT_EQ(results.at("history").size(), results.at("evaluations").at("total"));
  const json& response = results.at("best").at("responses").at("consolidation.void_ratio");
  EXPECT_NEAR(response.at("simulated"), 0.783, 0.007);
  EXPECT_EQ(response.at("observed"), 0.783);
  EXPECT_THAT(result.error, HasSubstr("no simulation was run"));
}

TEST(Run, LeavesStudyLedgerAndReports) {
  const TemporaryFolder folder;
  const Streams result = PowdercalStreams(kRun, folder.path());
  ASSERT_EQ(result.exit_status, 0) << result.error;
  EXPECT_THAT(Listing(folder / "x"), ElementsAre("ledger.sqlite", "lock", "material_card.yaml",
                                                 "report.html", "results.json", "study.yaml"));
  EXPECT_THAT(ReadFile(folder / "x/report.html"),
              AllOf(HasSubstr("<!doctype html>"), HasSubstr("Hastelloy X"),
                    HasSubstr("No simulation was run"), HasSubstr("vega")));
  EXPECT_THAT(ReadFile(folder / "x/material_card.yaml"),
              AllOf(HasSubstr("cohesion_energy_density"), HasSubstr("rolling_friction"),
                    HasSubstr("hertz"), HasSubstr("table")));
  EXPECT_THAT(result.output,
              AllOf(HasSubstr("every tolerance reached"), HasSubstr("cohesion_energy_density (k)"),
                    HasSubstr("within the tolerance"), HasSubstr("No simulation was run"),
                    HasSubstr("report: x/report.html")));
}

TEST(Run, WritesPlainLinesWhereThereIsNoTerminal) {
  const TemporaryFolder folder;
  const Streams result = PowdercalStreams(kRun, folder.path());
  ASSERT_EQ(result.exit_status, 0) << result.error;
  for (const std::string& text : {result.output, result.error}) {
    for (const char c : text) {
      EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= ' ')
          << "control character " << int{c};
    }
  }
  const int evaluations = ReadJson(folder / "x/results.json").at("evaluations").at("total");
  const std::regex line(R"( +\d+/100 #\d+ k = \S+ J/m3, mu_r = \S+ -> consolidation.void_ratio)");
  EXPECT_EQ(std::distance(std::sregex_iterator(result.error.begin(), result.error.end(), line),
                          std::sregex_iterator()),
            evaluations)
      << result.error;
}

TEST(Run, GoesOnWithoutReadersAndWithClosedStreams) {
  for (const char* redirections :
       {"2>&1 | true", ">&- 2>&- <&-", ">\"$output\" 2>&-", ">/dev/null 2>/dev/full"}) {
    const TemporaryFolder folder;
    const Streams result =
        PowdercalStreams(With(kRun, {"--evaluations", "5"}), folder.path(), redirections);
    EXPECT_EQ(result.exit_status, 0) << redirections;
    EXPECT_EQ(ReadJson(folder / "x/results.json").at("evaluations").at("total"), 5) << redirections;
    EXPECT_THAT(ReadFile(folder / "x/lock"), Not(HasSubstr("powdercal"))) << redirections;
  }
}

TEST(Run, OutputThatCannotBeWrittenIsAFailure) {
  const TemporaryFolder folder;
  const Streams result =
      PowdercalStreams(With(kRun, {"--json"}), folder.path(), ">/dev/full 2>\"$error\"");
  EXPECT_EQ(result.exit_status, 1);
  EXPECT_THAT(result.error, HasSubstr("cannot write the output: No space left on device"));
  EXPECT_TRUE(std::filesystem::exists(folder / "x/report.html"));
}

TEST(Run, SameCommandAgainRepeatsNothing) {
  const TemporaryFolder folder;
  ASSERT_EQ(PowdercalStreams(kRun, folder.path()).exit_status, 0);
  const json first = ReadJson(folder / "x/results.json").at("history");
  for (const std::vector<std::string>& again :
       {kRun, std::vector<std::string>{"resume", "x"}, With(kRun, {"--evaluations", "3"})}) {
    const Streams result = PowdercalStreams(again, folder.path());
    EXPECT_EQ(result.exit_status, 0) << result.error;
    EXPECT_THAT(result.error, HasSubstr("resuming after"));
    EXPECT_THAT(result.error, Not(HasSubstr("->"))) << "nothing was evaluated";
    EXPECT_EQ(ReadJson(folder / "x/results.json").at("history"), first);
  }
}

TEST(Run, WithoutAnyResultHasFailed) {
  const TemporaryFolder folder;
  const Streams result = PowdercalStreams(With(kRun, {"--wall-time", "1 ns"}), folder.path());
  EXPECT_EQ(result.exit_status, 1);
  EXPECT_THAT(result.output, HasSubstr("no evaluation succeeded"));
}

TEST(Report, IsWrittenAnewFromTheLedger) {
  const TemporaryFolder folder;
  ASSERT_EQ(PowdercalStreams(kRun, folder.path()).exit_status, 0);
  const std::string html = ReadFile(folder / "x/report.html");
  const json results = ReadJson(folder / "x/results.json");
  for (const char* file : {"report.html", "results.json", "material_card.yaml"}) {
    std::filesystem::remove(folder.path() / "x" / file);
  }
  const Streams report = PowdercalStreams({"report", "x", "--json"}, folder.path());
  EXPECT_EQ(report.exit_status, 0) << report.error;
  EXPECT_EQ(report.error, "");
  EXPECT_EQ(json::parse(report.output), results);
  EXPECT_EQ(ReadJson(folder / "x/results.json"), results);
  EXPECT_EQ(ReadFile(folder / "x/report.html").size(), html.size());
  EXPECT_TRUE(std::filesystem::exists(folder / "x/material_card.yaml"));
}

}  // namespace
}  // namespace powdercal

#include "reports/comparison_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "reports/comparison_json.h"
#include "tests/support/program.h"

namespace powdercal {
namespace {

using namespace comparison;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

ContestRecord MakeRecord(const std::string& label, int seed, double value) {
  ContestRecord record{.label = label, .seed = seed, .key = label + std::to_string(seed)};
  record.steps = {
      {.judged = {kNone}, .reported = -1, .core_seconds = 2, .told_at = 2, .failed = true},
      {.judged = {10}, .reported = 1, .core_seconds = 4, .told_at = 4},
      {.judged = {value}, .reported = 2, .core_seconds = 6, .told_at = 6}};
  record.end = "budget of 3 evaluations used";
  record.parameters = {1000, 0.5};
  record.fit = value;
  record.hold_out = {{"quick", 3, value + 0.5}, {"standard", 3, kNone}};
  record.core_seconds = record.busy_seconds = 6;
  record.makespan = 4;
  return record;
}

struct Sample {
  Study study = Study::Load(LibraryStudy("quickstart").string());
  Field field{study, {"bayesian", "random"}, 3};

  Comparison Make(int seeds = 8) {
    Setting setting{.study = "a <study>",
                    .description = "of a powder",
                    .program_version = "0.1.0",
                    .source = Source::emulator,
                    .source_text = "runs/a",
                    .backend = "embedded",
                    .seeds = 8,
                    .rules = {.experiments = {0}, .slots = 2, .evaluations = 3},
                    .hold_out_seeds = 3,
                    .initial_design = "corners_and_centre",
                    .targets = 1,
                    .command = {"powdercal compare 'a <study>'"}};
    setting.emulator = {{.response = "consolidation.void_ratio",
                         .unit = "1",
                         .points = 20,
                         .leave_one_out_r2 = 0.42,
                         .seed_sd = 0.01,
                         .from_replicates = true,
                         .share_of_sd = 0.8}};
    std::vector<ContestRecord> records;
    for (int seed = 1; seed <= seeds; ++seed) {
      records.push_back(MakeRecord("bayesian", seed, 0.1));
      records.push_back(MakeRecord("random", seed, 3.0 + seed));
    }
    Comparison comparison = Evaluate(setting, field, records, false);
    comparison.refused = {{"nsga2", "needs several objectives; use `bayesian`"}};
    return comparison;
  }
};

// What people read: plotting libraries have all kinds of words in them.
std::string WithoutScripts(std::string page) {
  for (std::size_t begin = page.find("<script"); begin != std::string::npos;
       begin = page.find("<script", begin)) {
    page.erase(begin, page.find("</script>", begin) - begin);
    begin = page.find("</script>", begin);
  }
  return page;
}

TEST(ComparisonPage, ShowsRecommendationFiguresAndLimits) {
  const std::string page = ComparisonPage(Sample().Make());
  for (const char* text :
       {"a &lt;study&gt;", "Use bayesian", "an emulator of runs/a answered", "favoured", "nsga2",
        "<code>bayesian</code>", "consolidation.void_ratio", "0.42", "corners_and_centre",
        "powdercal compare &#39;a &lt;study&gt;&#39;", "χ² held out (quick)",
        "χ² held out (standard)", "data-figure=\"ranks\"", "data-figure=\"by-evaluations\""}) {
    EXPECT_THAT(page, HasSubstr(text));
  }
  EXPECT_THAT(WithoutScripts(page), AllOf(Not(HasSubstr("{{")), Not(HasSubstr("<study>")),
                                          Not(HasSubstr(">nan")), Not(HasSubstr("http-equiv"))));
}

TEST(ComparisonPage, WithoutAWholeSeedSaysSo) {
  const std::string page = ComparisonPage(Sample().Make(0));
  EXPECT_THAT(page, HasSubstr("Nothing can be said yet"));
  EXPECT_TRUE(ComparisonFigures(Sample().Make(0)).empty());
}

TEST(ComparisonPage, FiguresHaveDataWithinTheirScales) {
  for (const Figure& figure : ComparisonFigures(Sample().Make())) {
    ASSERT_FALSE(figure.spec.is_null()) << figure.key;
    EXPECT_FALSE(figure.caption.empty());
    EXPECT_FALSE(figure.spec.at("data").at("values").empty()) << figure.key;
    EXPECT_THAT(figure.spec.dump(), Not(HasSubstr("null,\"type\":\"quantitative\"")));
  }
}

TEST(ComparisonPage, ASingleSeedHasNoRanks) {
  for (const Figure& figure : ComparisonFigures(Sample().Make(1))) {
    EXPECT_EQ(figure.spec.is_null(), figure.key == "ranks") << figure.key;
  }
}

TEST(ComparisonJson, ContestsAreReadBackAsTheyWere) {
  const Comparison comparison = Sample().Make();
  const json document = ComparisonToJson(comparison);
  EXPECT_EQ(document.at("schema"), 1);
  EXPECT_EQ(document.at("measure"), "chi2");
  EXPECT_TRUE(document.at("contests").at(0).at("judged").at(0).at(0).is_null());
  EXPECT_EQ(document.at("optimizers").at(0).at("hold_out").at(0).at("chi2").at("median"), 0.6);
  EXPECT_TRUE(
      document.at("optimizers").at(0).at("hold_out").at(1).at("chi2").at("median").is_null());
  Comparison again = comparison;
  again.contests = ContestsFromJson(json::parse(document.dump()));
  EXPECT_EQ(ComparisonToJson(again), document);
}

TEST(ComparisonJson, OtherDocumentsAreRefused) {
  for (const char* text : {"{}", "{\"contests\": [{\"seed\": 1}]}", "[]"}) {
    EXPECT_THROW(ContestsFromJson(json::parse(text)), InputError) << text;
  }
  json damaged = ComparisonToJson(Sample().Make());
  damaged["contests"][0]["reported"][0] = 7;
  EXPECT_THROW(ContestsFromJson(damaged), InputError);
}

TEST(WriteComparison, WritesBothFiles) {
  const TemporaryFolder folder;
  WriteComparison(Sample().Make(), folder.path());
  EXPECT_EQ(ReadJson(folder / "comparison.json").at("study"), "a <study>");
  EXPECT_THAT(ReadFile(folder / "comparison.html"), HasSubstr("<!doctype html>"));
}

}  // namespace
}  // namespace powdercal

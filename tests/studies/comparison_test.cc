#include "studies/comparison/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "studies/comparison/contest_runner.h"
#include "tests/support/program.h"

namespace powdercal::comparison {
namespace {

using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Falls to `values` one after the other, at a core-second each.
ContestRecord MakeRecord(const std::string& label, int seed, const std::vector<double>& values) {
  ContestRecord record{.label = label, .seed = seed, .end = "done", .fit = values.back()};
  for (std::size_t i = 0; i < values.size(); ++i) {
    record.steps.push_back({.judged = {values[i]},
                            .reported = static_cast<int>(i),
                            .core_seconds = static_cast<double>(i + 1)});
  }
  record.core_seconds = record.busy_seconds = static_cast<double>(values.size());
  record.makespan = record.core_seconds;
  record.hold_out = {{.fidelity = "quick", .seeds = 2, .chi2 = 2 * values.back()}};
  return record;
}

Setting MakeSetting(int seeds, int evaluations) {
  return {.study = "s",
          .source_text = "a run",
          .seeds = seeds,
          .rules = {.experiments = {0}, .slots = 1, .evaluations = evaluations},
          .hold_out_seeds = 2,
          .targets = 1};
}

struct Case {
  Study study = Study::Load(LibraryStudy("quickstart").string());
  Field field{study, {"bayesian", "random", "sobol"}, 3};
};

TEST(Evaluate, RanksTheContestantsOverTheSeeds) {
  Case c;
  std::vector<ContestRecord> records;
  for (int seed = 1; seed <= 12; ++seed) {
    records.push_back(MakeRecord("bayesian", seed, {9, 2, 0.1}));
    records.push_back(MakeRecord("random", seed, {8, 8, 5.0 + seed}));
    records.push_back(MakeRecord("sobol", seed, {9, 3, 2}));
  }
  const Comparison comparison = Evaluate(MakeSetting(12, 3), c.field, records, false);
  ASSERT_EQ(comparison.standings.size(), 3U);
  EXPECT_EQ(comparison.standings[0].contestant.label, "bayesian");
  EXPECT_EQ(comparison.standings[0].mean_rank, 1);
  EXPECT_EQ(comparison.standings[1].mean_rank, 2);
  EXPECT_EQ(comparison.standings[0].final_value.median, 0.1);
  EXPECT_EQ(comparison.standings[0].to_level.median, 3);
  EXPECT_EQ(comparison.standings[0].reached, 12);
  EXPECT_EQ(comparison.standings[2].reached, 0);
  EXPECT_TRUE(std::isinf(comparison.standings[2].to_level.median));
  EXPECT_EQ(comparison.standings[0].parallel_efficiency.median, 1);
  EXPECT_THAT(comparison.hold_out_fidelities, ElementsAre("quick"));
  EXPECT_DOUBLE_EQ(comparison.standings[0].hold_out[0].median, 0.2);
  EXPECT_NEAR(comparison.friedman.chi_squared, 24, 1e-9);  // N (k − 1)
  // √(3·4/(6·12))·2.343
  EXPECT_NEAR(comparison.critical_difference, 0.9565, 1e-3);
  const Recommendation words = Recommend(comparison);
  EXPECT_THAT(words.headline, HasSubstr("Use bayesian: it is shown to be better than all others"));
  EXPECT_THAT(words.statements, Contains(HasSubstr("With random: chi² 11.5")));
  EXPECT_THAT(words.limits, Contains(HasSubstr("emulator of a run")));
  EXPECT_THAT(words.limits, Contains(HasSubstr("below the critical difference are not findings")));
}

TEST(Evaluate, CountsOnlySeedsThatAllHaveEnded) {
  Case c;
  const std::vector<ContestRecord> records = {
      MakeRecord("bayesian", 1, {1}), MakeRecord("random", 1, {2}), MakeRecord("sobol", 1, {3}),
      MakeRecord("bayesian", 2, {1}), MakeRecord("stranger", 1, {0})};
  const Comparison comparison = Evaluate(MakeSetting(4, 3), c.field, records, true);
  EXPECT_THAT(comparison.seeds, ElementsAre(1));
  EXPECT_TRUE(std::isnan(comparison.critical_difference));
  EXPECT_THAT(Recommend(comparison).headline, HasSubstr("in a single seed, which shows nothing"));
  const Comparison none = Evaluate(MakeSetting(4, 3), c.field, {records[0]}, true);
  EXPECT_TRUE(none.standings.empty());
  EXPECT_THAT(Recommend(none).headline, HasSubstr("Nothing can be said yet"));
}

TEST(Evaluate, DoesNotFindDifferencesThatAreNot) {
  Case c;
  std::vector<ContestRecord> records;
  for (int seed = 1; seed <= 6; ++seed) {  // every order once
    const double values[] = {1, 2, 3};
    const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    const int* order = orders[seed - 1];
    records.push_back(MakeRecord("bayesian", seed, {values[order[0]]}));
    records.push_back(MakeRecord("random", seed, {values[order[1]]}));
    records.push_back(MakeRecord("sobol", seed, {values[order[2]]}));
  }
  const Comparison comparison = Evaluate(MakeSetting(6, 3), c.field, records, false);
  EXPECT_NEAR(comparison.friedman.chi_squared, 0, 1e-12);
  EXPECT_THAT(Recommend(comparison).headline,
              HasSubstr("No optimizer is shown to be better than another"));
}

TEST(Evaluate, NegligibleValuesAreEqual) {
  Case c;
  std::vector<ContestRecord> records;
  for (int seed = 1; seed <= 3; ++seed) {
    records.push_back(MakeRecord("bayesian", seed, {1e-9}));
    records.push_back(MakeRecord("random", seed, {1e-5}));
    records.push_back(MakeRecord("sobol", seed, {1}));
  }
  const Comparison comparison = Evaluate(MakeSetting(3, 3), c.field, records, false);
  EXPECT_EQ(comparison.standings[0].mean_rank, 1.5);
  EXPECT_EQ(comparison.standings[1].mean_rank, 1.5);
}

TEST(Evaluate, LevelIsTwiceTheBestWhereNobodyFits) {
  Case c;
  std::vector<ContestRecord> records;
  for (const char* label : {"bayesian", "random", "sobol"}) {
    records.push_back(MakeRecord(label, 1, {20, 7}));
  }
  const Comparison comparison = Evaluate(MakeSetting(1, 3), c.field, records, false);
  EXPECT_FALSE(comparison.level_is_fit);
  EXPECT_EQ(comparison.level, 14);
  EXPECT_EQ(comparison.standings[0].to_level.median, 2);
}

TEST(HoldOnOracle, IsTheSameWithAnyNumberOfThreads) {
  Study study = Study::Load(LibraryStudy("hastelloy_x_table3").string());
  const Planner planner(study);
  const auto oracle = MakeTableOracle(planner);
  const Field field(study, {"bayesian", "random"}, 11);
  std::vector<Task> tasks;
  for (int seed = 1; seed <= 2; ++seed) {
    for (const Contestant& contestant : field.contestants())
      tasks.push_back({&contestant, seed, ""});
  }
  const ContestOptions options{.rules = {.experiments = {0}, .slots = 2, .evaluations = 11}};
  const auto one = HoldOnOracle(study, field, tasks, *oracle, options, 1);
  const auto two = HoldOnOracle(study, field, tasks, *oracle, options, 2);
  ASSERT_EQ(one.size(), 4U);
  ASSERT_EQ(two.size(), 4U);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].label, two[i].label);
    EXPECT_EQ(one[i].parameters, two[i].parameters);
    EXPECT_EQ(one[i].steps.size(), 11U);
    EXPECT_EQ(one[i].makespan, 6);  // 11 seconds in two slots
    EXPECT_EQ(one[i].fit, two[i].fit);
    EXPECT_TRUE(one[i].error.empty());
  }
  EXPECT_LT(one[0].fit, one[1].fit);
}

TEST(HoldOnOracle, StopsOnRequest) {
  Study study = Study::Load(LibraryStudy("hastelloy_x_table3").string());
  const Planner planner(study);
  const auto oracle = MakeTableOracle(planner);
  const Field field(study, {"random"}, 7);
  std::stop_source stop;
  stop.request_stop();
  const ContestOptions options{.rules = {.experiments = {0}, .evaluations = 7},
                               .stop = stop.get_token()};
  EXPECT_TRUE(
      HoldOnOracle(study, field, {{&field.contestants()[0], 1, ""}}, *oracle, options, 2).empty());
}

}  // namespace
}  // namespace powdercal::comparison

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "studies/comparison/measures.h"

namespace powdercal::comparison {
namespace {

using ::testing::DoubleEq;
using ::testing::DoubleNear;
using ::testing::ElementsAre;

const double kInfinity = std::numeric_limits<double>::infinity();

Step MakeStep(std::vector<double> judged, int reported, double core_seconds) {
  return {.judged = std::move(judged), .reported = reported, .core_seconds = core_seconds};
}

// Found at the second evaluation; the third looks better, but is not.
ContestRecord Sample() {
  return {.label = "a",
          .seed = 1,
          .steps = {MakeStep({kNone}, -1, 1), MakeStep({4}, 1, 3), MakeStep({9}, 2, 5),
                    MakeStep({0.25}, 3, 9)}};
}

TEST(Trajectory, FollowsTheReportedPoint) {
  const Trajectory trajectory = ReportedChi2(Sample());
  EXPECT_THAT(trajectory.values, ElementsAre(kInfinity, 4, 9, 0.25));
  EXPECT_THAT(trajectory.core_seconds, ElementsAre(1, 3, 5, 9));
  EXPECT_EQ(ValueAfter(trajectory, 0), kInfinity);
  EXPECT_EQ(ValueAfter(trajectory, 2), 4);
  EXPECT_EQ(ValueAfter(trajectory, 100), 0.25);  // it stays where it ended
  EXPECT_EQ(ValueWithin(trajectory, 0.5), kInfinity);
  EXPECT_EQ(ValueWithin(trajectory, 5), 9);
  EXPECT_EQ(ValueWithin(trajectory, 8.9), 9);
  EXPECT_EQ(EvaluationsTo(trajectory, 4), 2);
  EXPECT_EQ(EvaluationsTo(trajectory, 1), 4);
  EXPECT_EQ(EvaluationsTo(trajectory, 0.1), 0);
}

TEST(Quartiles, AreLinearBetweenOrderStatistics) {
  // R: quantile(c(1, 2, 4, 8), c(0.25, 0.5, 0.75)) is 1.75, 3, 5.
  const Quartiles q = QuartilesOf({8, 1, 4, 2});
  EXPECT_EQ(q.lower, 1.75);
  EXPECT_EQ(q.median, 3);
  EXPECT_EQ(q.upper, 5);
}

TEST(Quartiles, KnowWhatWasNotReached) {
  const Quartiles q = QuartilesOf({3, 5, kInfinity, kInfinity});
  EXPECT_EQ(q.lower, 4.5);
  EXPECT_EQ(q.median, kInfinity);
}

TEST(Band, HasQuartilesAlongBothAxes) {
  const std::vector<Trajectory> trajectories = {{{8, 4}, {1, 2}}, {{6}, {4}}, {{2, 1}, {3, 4}}};
  const Band evaluations = BandByEvaluations(trajectories, 3);
  EXPECT_THAT(evaluations.x, ElementsAre(1, 2, 3));
  EXPECT_EQ(evaluations.y[0].median, 6);
  EXPECT_EQ(evaluations.y[2].median, 4);  // the second stays at 6
  const Band seconds = BandByCoreSeconds(trajectories, 4);
  EXPECT_EQ(seconds.x.back(), 4);
  EXPECT_EQ(seconds.y.back().median, 4);
  EXPECT_EQ(seconds.y.front().median, kInfinity);
}

TEST(Targets, AreSpacedInTheLogarithm) {
  const std::vector<Trajectory> trajectories = {{{kInfinity, 100, 1}, {}}, {{100, 0.01}, {}}};
  EXPECT_THAT(TargetLevels(trajectories, 1e-9, 5),
              ElementsAre(DoubleEq(100), DoubleNear(10, 1e-9), DoubleNear(1, 1e-9),
                          DoubleNear(0.1, 1e-9), DoubleEq(0.01)));
  EXPECT_EQ(TargetLevels(trajectories, 1, 3).back(), 1);  // what lies below does not matter
  EXPECT_TRUE(TargetLevels(std::vector<Trajectory>{{{kInfinity}, {1}}}, 1, 3).empty());
}

TEST(ShareOfTargets, CountsPairsOfContestAndLevel) {
  const std::vector<Trajectory> trajectories = {{{50, 50, 5}, {}}, {{500, 0.5}, {}}};
  // Level 100: after 1 and 2 evaluations; 10: 3 and 2; 1: never and 2.
  EXPECT_THAT(ShareOfTargets(trajectories, {100, 10, 1}, 4),
              ElementsAre(DoubleNear(1.0 / 6, 1e-12), DoubleNear(4.0 / 6, 1e-12),
                          DoubleNear(5.0 / 6, 1e-12), DoubleNear(5.0 / 6, 1e-12)));
}

// In decades, d = log10 chi²: front (0, 2), (1, 1), (2, 0), the median of each objective is 2, and
// the front reaches up to there: the reference lies a tenth of ln chi² beyond.
TEST(LostHypervolume, IsMeasuredAgainstTheFrontOfAll) {
  ContestRecord a{.label = "a", .seed = 1};
  a.steps = {MakeStep({1, 100}, 0, 1), MakeStep({kNone, kNone}, 0, 2),
             MakeStep({1000, 1000}, 0, 3)};
  ContestRecord b{.label = "b", .seed = 1};
  b.steps = {MakeStep({100, 1}, 0, 1), MakeStep({10, 10}, 1, 2), MakeStep({1000, 1000}, 1, 3)};
  const std::vector<ContestRecord> records = {a, b};
  const FrontScale scale = ScaleOfFront(records);
  EXPECT_EQ(scale.ideal[0], 0);
  EXPECT_DOUBLE_EQ(scale.reference[1], std::log(100) + 0.1);
  const double beyond = 0.1 / std::log(10);  // decades
  const double side = 2 + beyond;
  const double all = side * beyond + (1 + beyond) * 1 + beyond * 1;
  EXPECT_NEAR(scale.hypervolume, all / (side * side), 1e-12);
  const Trajectory lost_a = LostHypervolume(a, scale);
  EXPECT_NEAR(lost_a.values[0], 1 - side * beyond / all, 1e-12);
  EXPECT_EQ(lost_a.values[2], lost_a.values[0]);  // a failure and a dominated point add nothing
  const Trajectory lost_b = LostHypervolume(b, scale);
  EXPECT_NEAR(lost_b.values[1], 1 - (beyond * side + 1 * (1 + beyond)) / all, 1e-12);
}

TEST(LostHypervolume, DoesNotLoseSightOfWhatIsFarFromTheFront) {
  ContestRecord good{.label = "a", .seed = 1};
  good.steps = {MakeStep({0.02, 0.3}, 0, 1), MakeStep({0.3, 0.02}, 0, 2)};
  ContestRecord poor{.label = "b", .seed = 1};
  poor.steps = {MakeStep({40, 500}, 0, 1), MakeStep({70, 60}, 0, 2), MakeStep({900, 30}, 0, 3)};
  ContestRecord worse{.label = "c", .seed = 1};
  worse.steps = {MakeStep({900, 900}, 0, 1), MakeStep({500, 1e4}, 0, 2), MakeStep({1e4, 70}, 0, 3)};
  const std::vector<ContestRecord> records = {good, poor, worse};
  const FrontScale scale = ScaleOfFront(records);
  EXPECT_NEAR(LostHypervolume(good, scale).values.back(), 0, 1e-12);
  EXPECT_LT(LostHypervolume(poor, scale).values.back(), 1);
  EXPECT_LT(LostHypervolume(poor, scale).values.back(),
            LostHypervolume(worse, scale).values.back());
}

TEST(LostHypervolume, IsDefinedForASinglePoint) {
  const std::vector<ContestRecord> records = {{.label = "a", .steps = {MakeStep({5, 7}, 0, 1)}}};
  const FrontScale scale = ScaleOfFront(records);
  EXPECT_NEAR(scale.hypervolume, 1, 1e-12);
  EXPECT_EQ(LostHypervolume(records[0], scale).values[0], 0);
}

TEST(LostHypervolume, OfNothingIsEmpty) {
  const std::vector<ContestRecord> records = {
      {.label = "a", .steps = {MakeStep({kNone, 1}, -1, 1)}}};
  EXPECT_TRUE(ScaleOfFront(records).empty());
}

}  // namespace
}  // namespace powdercal::comparison

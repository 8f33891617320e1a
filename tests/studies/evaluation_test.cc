#include "studies/evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace powdercal {
namespace {

Objectives TwoTargets() {
  return {.targets = {{.response = "consolidation.void_ratio", .value = 0.8, .sd = 0.01},
                      {.response = "shear.cohesion", .value = 100, .sd = 5}}};
}

LedgerRun RunOf(const std::string& experiment, const std::string& response, double value,
                Reason reason = Reason::ok) {
  LedgerRun run{.experiment = experiment, .outcome = {reason, ""}};
  if (reason == Reason::ok) run.measurement.responses[response] = {value, 0};
  return run;
}

TEST(Reduce, MeansOverTheReplicatesThatSucceeded) {
  const LedgerRun a = RunOf("consolidation", "void_ratio", 0.8);
  const LedgerRun b = RunOf("consolidation", "void_ratio", 0.9);
  const LedgerRun c = RunOf("consolidation", "void_ratio", 0, Reason::timeout);
  const LedgerRun d = RunOf("shear", "cohesion", 0, Reason::crashed);
  const ReducedResponses reduced = Reduce(TwoTargets(), {&a, &b, &c, &d});
  EXPECT_NEAR(reduced.means[0], 0.85, 1e-15);
  EXPECT_NEAR(reduced.sample_variances[0], 0.005, 1e-15);
  EXPECT_EQ(reduced.counts[0], 2);
  EXPECT_TRUE(std::isnan(reduced.means[1])) << "a failure is never a number";
  EXPECT_FALSE(reduced.failed());
  EXPECT_FALSE(reduced.complete());
  EXPECT_TRUE(reduced.partial());
}

TEST(FailuresOf, NamesTheExperimentsWithoutAValueAndWhy) {
  const LedgerRun a = RunOf("consolidation", "void_ratio", 0.8);
  LedgerRun b = RunOf("shear", "cohesion", 0, Reason::not_quasi_static);
  b.outcome.message = "no steady state";
  const LedgerRun c = RunOf("shear", "cohesion", 0, Reason::timeout);
  const LedgerRun d = RunOf("shear", "ffc", 2);
  const auto failures = [](const std::vector<const LedgerRun*>& runs) {
    return FailuresOf(TwoTargets(), Reduce(TwoTargets(), runs), runs);
  };
  ASSERT_EQ(failures({&a, &b, &c}).size(), 1u);
  const ExperimentFailure shear = failures({&a, &b, &c})[0];
  EXPECT_EQ(shear.experiment, "shear");
  EXPECT_EQ(shear.reason, "not_quasi_static");
  EXPECT_EQ(shear.message, "no steady state");
  EXPECT_EQ(shear.failed_runs, 2);
  EXPECT_EQ(shear.runs, 2);
  EXPECT_EQ(failures({&b}).size(), 2u) << "an experiment without any run has no value either";
  ASSERT_EQ(failures({&a, &d}).size(), 1u);
  EXPECT_EQ(failures({&a, &d})[0].reason, kNoValue);
  EXPECT_EQ(failures({&a, &d})[0].message, "the simulations gave no cohesion");
  const LedgerRun e = RunOf("shear", "cohesion", 80);
  EXPECT_TRUE(failures({&a, &b, &e}).empty()) << "another seed gave a value";
}

TEST(PooledSeedVariance, WeighsByDegreesOfFreedom) {
  ReducedResponses three{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Constant(1, 4.0),
                         Eigen::VectorXi::Constant(1, 3)};
  ReducedResponses two{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Constant(1, 1.0),
                       Eigen::VectorXi::Constant(1, 2)};
  ReducedResponses one{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Constant(1, std::nan("")),
                       Eigen::VectorXi::Constant(1, 1)};
  EXPECT_DOUBLE_EQ(PooledSeedVariance({three, two, one}, 1)[0], (2 * 4.0 + 1 * 1.0) / 3);
  EXPECT_EQ(PooledSeedVariance({one}, 1)[0], 0) << "nothing known";
}

TEST(ExpectedMisfit, DoesNotRewardPoorlyKnownPoints) {
  const Objectives objectives{.targets = {{.response = "a.b", .value = 0, .sd = 1}}};
  const Eigen::VectorXd pooled = Eigen::VectorXd::Constant(1, 6.0);
  const ReducedResponses rough{Eigen::VectorXd::Constant(1, 2.0), Eigen::VectorXd::Zero(1),
                               Eigen::VectorXi::Constant(1, 1)};
  ReducedResponses sure = rough;
  sure.counts[0] = 6;
  EXPECT_GT(ExpectedMisfit(objectives, rough, pooled), ExpectedMisfit(objectives, sure, pooled));
  EXPECT_LT(ChiSquared(objectives, rough.means, VarianceOfMeans(rough, pooled)),
            ChiSquared(objectives, sure.means, VarianceOfMeans(sure, pooled)));
  EXPECT_DOUBLE_EQ(ExpectedMisfit(objectives, sure, pooled), 4 + 1);
}

TEST(ExpectedMisfit, IncompletePointsAreNeverBest) {
  const ReducedResponses partial{Eigen::Vector2d(0.8, std::nan("")), Eigen::Vector2d::Zero(),
                                 Eigen::Vector2i(3, 0)};
  EXPECT_TRUE(std::isinf(ExpectedMisfit(TwoTargets(), partial, Eigen::Vector2d::Zero())));
}

// One target for each of two objectives, in units of their standard deviations.
Objectives TwoObjectives() {
  return {.kind = Objectives::Kind::pareto,
          .targets = {{.response = "consolidation.void_ratio", .sd = 1, .objective = 0},
                      {.response = "shear.cohesion", .sd = 1, .objective = 1}}};
}

ReducedResponses PointAt(double first, double second, int first_count = 1, int second_count = 1) {
  return {Eigen::Vector2d(first, second), Eigen::Vector2d::Zero(),
          Eigen::Vector2i(first_count, second_count)};
}

TEST(ExpectedMisfit, OfOneObjectiveNeedsItsOwnTargetsOnly) {
  const Objectives objectives = TwoObjectives();
  const Eigen::Vector2d pooled(2, 0);
  const ReducedResponses partial = PointAt(3, std::nan(""), 4, 0);
  EXPECT_DOUBLE_EQ(ExpectedMisfit(objectives, partial, pooled, 0), 9 + 2.0 / 4);
  EXPECT_TRUE(std::isinf(ExpectedMisfit(objectives, partial, pooled, 1)));
  EXPECT_TRUE(std::isinf(ExpectedMisfit(objectives, partial, pooled)));
  const ReducedResponses whole = PointAt(3, -2);
  EXPECT_DOUBLE_EQ(
      ExpectedMisfit(objectives, whole, pooled),
      ExpectedMisfit(objectives, whole, pooled, 0) + ExpectedMisfit(objectives, whole, pooled, 1));
}

TEST(ParetoFront, TiesStayAndIncompletePointsDoNot) {
  const std::vector<ReducedResponses> points = {
      PointAt(2, 1),
      PointAt(0, std::nan(""), 1, 0),  // unbeaten in what it has
      PointAt(1, 2),
      PointAt(2, 2),   // beaten by both
      PointAt(-1, 2),  // as good as (1, 2)
      PointAt(1, 3),   // beaten in one objective, equal in the other
      PointAt(std::nan(""), std::nan(""), 0, 0)};
  EXPECT_THAT(ParetoFront(TwoObjectives(), points, Eigen::Vector2d::Zero()),
              testing::ElementsAre(0, 2, 4));
  EXPECT_THAT(ParetoFront(TwoObjectives(), {}, Eigen::Vector2d::Zero()), testing::IsEmpty());
}

TEST(ParetoFront, AWellKnownPointDominatesAsGoodAOnePoorlyKnown) {
  const std::vector<ReducedResponses> points = {PointAt(1, 1, 2, 2), PointAt(1, 1, 4, 2)};
  EXPECT_THAT(ParetoFront(TwoObjectives(), points, Eigen::Vector2d(0.5, 0)),
              testing::ElementsAre(1));
}

TEST(ParetoFront, OfAJointObjectiveIsItsBest) {
  Objectives objectives = TwoObjectives();
  objectives.kind = Objectives::Kind::joint;
  EXPECT_THAT(ParetoFront(objectives, {PointAt(2, 1), PointAt(1, 1.5)}, Eigen::Vector2d::Zero()),
              testing::ElementsAre(1));
}

}  // namespace
}  // namespace powdercal

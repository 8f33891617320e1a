#include "optimizers/feasibility.h"

#include <gtest/gtest.h>

#include <cmath>

#include "optimizers/designs/design.h"

namespace powdercal {
namespace {

TEST(FeasibilityTest, IsCertainWithoutFailures) {
  const Feasibility feasibility(SobolPoints(8, 2, 1), Eigen::VectorXd::Ones(8));
  EXPECT_EQ(feasibility.LogProbability(Eigen::Vector2d(0.3, 0.3), nullptr), 0);
  const Feasibility nothing(Eigen::MatrixXd(0, 2), Eigen::VectorXd(0));
  EXPECT_EQ(nothing.LogProbability(Eigen::Vector2d(0.3, 0.3), nullptr), 0);
}

TEST(FeasibilityTest, LearnsTheRegionThatFailsAndNeverForbidsIt) {
  const Eigen::MatrixXd points = SobolPoints(64, 2, 1);
  const Eigen::VectorXd successes = (points.col(0).array() < 0.6).cast<double>();
  const Feasibility feasibility(points, successes);
  const double inside = std::exp(feasibility.LogProbability(Eigen::Vector2d(0.85, 0.5), nullptr));
  const double outside = std::exp(feasibility.LogProbability(Eigen::Vector2d(0.2, 0.5), nullptr));
  EXPECT_LT(inside, 0.2);
  EXPECT_GT(inside, 0.005);
  EXPECT_GT(outside, 0.97);
}

TEST(FeasibilityTest, ALoneFailureHasOneThird) {
  Eigen::MatrixXd points(1, 2);
  points << 0.5, 0.5;
  const Feasibility feasibility(points, Eigen::VectorXd::Zero(1));
  EXPECT_NEAR(std::exp(feasibility.LogProbability(Eigen::Vector2d(0.5, 0.5), nullptr)), 1.0 / 3,
              1e-12);
  // Partial failures weigh less.
  const Feasibility partial(points, Eigen::VectorXd::Constant(1, 0.5));
  EXPECT_NEAR(std::exp(partial.LogProbability(Eigen::Vector2d(0.5, 0.5), nullptr)), 2.0 / 3, 1e-12);
}

TEST(FeasibilityTest, GradientAgreesWithCentralDifferences) {
  const Eigen::MatrixXd points = SobolPoints(16, 2, 1);
  const Feasibility feasibility(points, (points.col(1).array() < 0.5).cast<double>());
  const Eigen::Vector2d at(0.4, 0.6);
  Eigen::VectorXd gradient = Eigen::Vector2d(10, 20);  // is added to
  feasibility.LogProbability(at, &gradient);
  for (int k = 0; k < 2; ++k) {
    Eigen::Vector2d above = at;
    Eigen::Vector2d below = at;
    above[k] += 1e-6;
    below[k] -= 1e-6;
    EXPECT_NEAR(
        gradient[k] - (k == 0 ? 10 : 20),
        (feasibility.LogProbability(above, nullptr) - feasibility.LogProbability(below, nullptr)) /
            2e-6,
        1e-6);
  }
}

}  // namespace
}  // namespace powdercal

#include "surrogates/gradient_boosting.h"

#include <thread>
#include <vector>

#include "tests/surrogates/regression_checks.h"

namespace powdercal {
namespace {

TEST(GradientBoostingTest, HasGoodManners) {
  ExpectGoodManners([] { return std::make_unique<GradientBoosting>(); });
}

TEST(GradientBoostingTest, RecoversASmoothFunction) {
  const Observations data = Observe(Wavy, 200);
  GradientBoosting boosting;
  boosting.Fit(data.points, data.values, {});
  const double error = ErrorOn(boosting, Wavy);
  EXPECT_LT(error, 0.15);  // of a standard deviation of about 1
  const double claimed = std::sqrt(boosting.Predict(Eigen::Vector2d(0.5, 0.5)).variance);
  EXPECT_GT(claimed, 0.3 * error);
  EXPECT_LT(claimed, 3 * error);
}

TEST(GradientBoostingTest, TwoPointsByHand) {
  // A leaf of one observation takes r/(1 + λ) of its residual r, and a half of that at this
  // learning rate: after three rounds (3/4)³ of the residuals ±1 are left.
  GradientBoosting::Options options;
  options.depths = {1};
  options.rounds = {3};
  options.learning_rate = 0.5;
  options.leaf_penalty = 1;
  GradientBoosting boosting(options);
  boosting.Fit(Eigen::Vector2d(0, 1), Eigen::Vector2d(0, 2), {});
  const double left = std::pow(0.75, 3);
  EXPECT_NEAR(boosting.Predict(Eigen::VectorXd::Ones(1)).mean, 2 - left, 1e-6);
  EXPECT_NEAR(boosting.Predict(Eigen::VectorXd::Zero(1)).mean, left, 1e-6);
  // Each from the other alone: off by 2.
  EXPECT_NEAR(boosting.Predict(Eigen::VectorXd::Zero(1)).variance, 4, 1e-5);
}

TEST(GradientBoostingTest, ASumOfSingleCoordinatesTakesStumps) {
  const Observations data =
      Observe([](double u, double v) { return (u > 0.5 ? 1.0 : 0.0) + (v > 0.3 ? 1.0 : 0.0); }, 80);
  GradientBoosting boosting;
  boosting.Fit(data.points, data.values, {});
  EXPECT_EQ(boosting.depth(), 1);
  EXPECT_NEAR(boosting.Predict(Eigen::Vector2d(0.8, 0.1)).mean, 1, 0.1);
}

TEST(GradientBoostingTest, ManyThreadsGetTheSameAnswer) {
  const Observations data = Observe(Wavy, 20);
  GradientBoosting boosting;
  boosting.Fit(data.points, data.values, {});
  const Eigen::Vector2d at(0.4, 0.7);
  const double expected = boosting.Predict(at).mean;
  std::vector<double> answers(4, 0);
  {
    std::vector<std::jthread> threads;
    for (double& answer : answers) {
      threads.emplace_back([&boosting, &answer, &at] {
        for (int i = 0; i < 50; ++i) answer = boosting.Predict(at).mean;
      });
    }
  }
  for (const double answer : answers) EXPECT_EQ(answer, expected);
}

}  // namespace
}  // namespace powdercal

#include "surrogates/random_forest.h"

#include "tests/surrogates/regression_checks.h"

namespace powdercal {
namespace {

double Step(double u, double) { return u > 0.5 ? 1 : 0; }

TEST(RandomForestTest, HasGoodManners) {
  ExpectGoodManners([] { return std::make_unique<RandomForest>(); });
}

TEST(RandomForestTest, FindsAStepAndItsCoordinate) {
  const Observations data = Observe(Step, 60);
  RandomForest forest;
  forest.Fit(data.points, data.values, {});
  for (const double v : {0.1, 0.5, 0.9}) {
    EXPECT_LT(forest.Predict(Eigen::Vector2d(0.35, v)).mean, 0.02);
    EXPECT_GT(forest.Predict(Eigen::Vector2d(0.65, v)).mean, 0.98);
  }
  EXPECT_LT(forest.Predict(Eigen::Vector2d(0.1, 0.5)).variance, 0.02);
}

TEST(RandomForestTest, RecoversASmoothFunction) {
  const Observations data = Observe(Wavy, 300);
  RandomForest forest;
  forest.Fit(data.points, data.values, {});
  EXPECT_LT(ErrorOn(forest, Wavy), 0.15);  // of a standard deviation of about 1
}

TEST(RandomForestTest, TwoPointsByHand) {
  // A sample of two has both with probability 1/2, else one of them alone: at the first point the
  // trees say 0 with probability 3/4 and 1 with 1/4. Four standard errors of 500 trees: 0.077.
  RandomForest forest;
  forest.Fit(Eigen::Vector2d(0, 1), Eigen::Vector2d(0, 1), {});
  const Prediction low = forest.Predict(Eigen::VectorXd::Zero(1));
  EXPECT_NEAR(low.mean, 0.25, 0.077);
  EXPECT_NEAR(low.variance, 500.0 / 499 * low.mean * (1 - low.mean), 1e-9);
  // Split in the middle, and flat on either side and beyond.
  EXPECT_EQ(forest.Predict(Eigen::VectorXd::Constant(1, 0.5)).mean, low.mean);
  EXPECT_EQ(forest.Predict(Eigen::VectorXd::Constant(1, -3)).mean, low.mean);
  const double high = forest.Predict(Eigen::VectorXd::Ones(1)).mean;
  EXPECT_EQ(forest.Predict(Eigen::VectorXd::Constant(1, 0.501)).mean, high);
  EXPECT_NEAR(high, 0.75, 0.077);
}

TEST(RandomForestTest, StaysWithinTheValues) {
  const Observations data = Observe(Wavy, 40);
  RandomForest forest;
  forest.Fit(data.points, data.values, {});
  RandomStream random(9);
  for (int i = 0; i < 50; ++i) {
    const double mean =
        forest.Predict(Eigen::Vector2d(random.Uniform(-1, 2), random.Uniform(-1, 2))).mean;
    EXPECT_GE(mean, data.values.minCoeff());
    EXPECT_LE(mean, data.values.maxCoeff());
  }
}

TEST(RandomForestTest, LargerLeavesForNoise) {
  RandomStream random(4);
  Observations data = Observe([](double, double) { return 0.0; }, 80);
  for (double& value : data.values) value = random.Normal();
  RandomForest forest;
  forest.Fit(data.points, data.values, {});
  EXPECT_GT(forest.smallest_leaf(), 1);
  const Observations clean = Observe(Step, 80);
  forest.Fit(clean.points, clean.values, {});
  EXPECT_EQ(forest.coordinates_drawn(), 2);
}

TEST(RandomForestTest, AnotherSeedIsAnotherForest) {
  const Observations data = Observe(Wavy, 30);
  RandomForest::Options options;
  options.seed = 2;
  RandomForest first;
  RandomForest second(options);
  first.Fit(data.points, data.values, {});
  second.Fit(data.points, data.values, {});
  const Eigen::Vector2d at(0.4, 0.4);
  EXPECT_NE(first.Predict(at).mean, second.Predict(at).mean);
  EXPECT_NEAR(first.Predict(at).mean, second.Predict(at).mean, 0.2);
}

}  // namespace
}  // namespace powdercal

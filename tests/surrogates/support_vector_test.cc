#include "surrogates/support_vector.h"

#include "tests/surrogates/regression_checks.h"

namespace powdercal {
namespace {

double StandardDeviationOf(const Eigen::VectorXd& values) {
  return std::sqrt((values.array() - values.mean()).square().sum() /
                   static_cast<double>(values.size() - 1));
}

TEST(SupportVectorTest, HasGoodManners) {
  ExpectGoodManners([] { return std::make_unique<SupportVector>(); });
}

TEST(SupportVectorTest, RecoversASmoothFunction) {
  const Observations data = Observe(Wavy, 40);
  SupportVector machine;
  machine.Fit(data.points, data.values, {});
  const double error = ErrorOn(machine, Wavy);
  EXPECT_LT(error, 0.1);  // of a standard deviation of about 1
  const double claimed = std::sqrt(machine.Predict(Eigen::Vector2d(0.5, 0.5)).variance);
  EXPECT_GT(claimed, 0.3 * error);
  EXPECT_LT(claimed, 5 * error);
}

TEST(SupportVectorTest, WithoutABoundOnTheCoefficientsEveryPointIsInTheTube) {
  const Observations data = Observe(Wavy, 20);
  SupportVector::Options options;
  options.gammas = {10};
  options.costs = {1e5};
  options.tubes = {0.1};
  SupportVector machine(options);
  machine.Fit(data.points, data.values, {});
  const double tube = 0.1 * StandardDeviationOf(data.values);
  for (int i = 0; i < 20; ++i) {
    EXPECT_NEAR(machine.Predict(data.points.row(i).transpose()).mean, data.values[i], tube * 1.01);
  }
}

TEST(SupportVectorTest, ATubeThatHoldsAllValuesGivesAConstant) {
  // Standardised, the values are ±0.707: within 0.8 of their mean.
  SupportVector::Options options;
  options.tubes = {0.8};
  SupportVector machine(options);
  machine.Fit(Eigen::Vector2d(0, 1), Eigen::Vector2d(0, 2), {});
  const double at_0 = machine.Predict(Eigen::VectorXd::Zero(1)).mean;
  EXPECT_EQ(machine.Predict(Eigen::VectorXd::Ones(1)).mean, at_0);
  EXPECT_NEAR(at_0, 1, 1e-12);
}

TEST(SupportVectorTest, ChoosesAmongWhatItIsGiven) {
  const Observations data = Observe(Wavy, 25);
  SupportVector machine;
  machine.Fit(data.points, data.values, {});
  EXPECT_EQ(machine.tube(), 0.01);  // no noise to ignore
  EXPECT_GT(machine.cost(), 1);
  EXPECT_NE(machine.Describe().find("25 points"), std::string::npos);
}

}  // namespace
}  // namespace powdercal

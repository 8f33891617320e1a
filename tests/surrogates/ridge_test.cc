#include "surrogates/ridge.h"

#include "tests/surrogates/regression_checks.h"

namespace powdercal {
namespace {

double Cubic(double u, double v) { return 2 + 3 * u - v * v + u * v + 4 * u * u * u; }

TEST(RidgeTest, HasGoodManners) {
  ExpectGoodManners([] { return std::make_unique<Ridge>(); });
}

TEST(RidgeTest, RecoversAPolynomialAndItsDegree) {
  const Observations data = Observe(Cubic, 30);
  Ridge ridge;
  ridge.Fit(data.points, data.values, {});
  EXPECT_EQ(ridge.degree(), 3);
  EXPECT_LT(ErrorOn(ridge, Cubic), 1e-3);
  const auto plane = [](double u, double v) { return 1 + u - 2 * v; };
  Ridge linear;
  const Observations flat = Observe(plane, 30);
  linear.Fit(flat.points, flat.values, {});
  EXPECT_LT(ErrorOn(linear, plane), 1e-4);
}

TEST(RidgeTest, TwoPointsByHand) {
  // x = ±1, y = 0 and 2: ΦᵀΦ = 2, Φᵀy = 2, λ = 2 · 0.5, so that the slope is 2/3. Residuals ∓1/3;
  // of each, 1 − 1/2 − 1/3 is free, hence σ² = (1/9)/(1/6).
  Ridge::Options options;
  options.max_degree = 1;
  options.penalties = {0.5};
  Ridge ridge(options);
  ridge.Fit(Eigen::Vector2d(0, 1), Eigen::Vector2d(0, 2), {});
  const Prediction end = ridge.Predict(Eigen::VectorXd::Ones(1));
  EXPECT_NEAR(end.mean, 1 + 2.0 / 3, 1e-12);
  EXPECT_NEAR(end.variance, 2.0 / 3 * (1.0 / 2 + 1.0 / 3), 1e-12);
  const Prediction middle = ridge.Predict(Eigen::VectorXd::Constant(1, 0.5));
  EXPECT_NEAR(middle.mean, 1, 1e-12);
  EXPECT_NEAR(middle.variance, 1.0 / 3, 1e-12);
  EXPECT_NEAR(ridge.leave_one_out_error(), 4, 1e-12);  // each from the other alone: off by 2
}

TEST(RidgeTest, TheClosedFormIsLeaveOneOut) {
  // One term, x = 2u − 1; leaving a point out keeps λ, and moves mean and centre.
  const Observations data = Observe(Wavy, 8);
  Ridge::Options options;
  options.max_degree = 1;
  options.penalties = {0.1};
  Ridge ridge(options);
  ridge.Fit(data.points.leftCols(1), data.values, {});
  double sum = 0;
  for (int out = 0; out < 8; ++out) {
    double x_mean = 0;
    double y_mean = 0;
    for (int i = 0; i < 8; ++i) {
      if (i == out) continue;
      x_mean += (2 * data.points(i, 0) - 1) / 7;
      y_mean += data.values[i] / 7;
    }
    double xx = 0.1 * 8;
    double xy = 0;
    for (int i = 0; i < 8; ++i) {
      if (i == out) continue;
      const double x = 2 * data.points(i, 0) - 1 - x_mean;
      xx += x * x;
      xy += x * (data.values[i] - y_mean);
    }
    const double predicted = y_mean + xy / xx * (2 * data.points(out, 0) - 1 - x_mean);
    sum += std::pow(predicted - data.values[out], 2) / 8;
  }
  EXPECT_NEAR(ridge.leave_one_out_error(), sum, 1e-10);
}

TEST(RidgeTest, VarianceGrowsBeyondTheData) {
  Observations data = Observe(Wavy, 30);
  data.points *= 0.5;
  Ridge ridge;
  ridge.Fit(data.points, data.values, {});
  EXPECT_GT(ridge.Predict(Eigen::Vector2d(1, 1)).variance,
            10 * ridge.Predict(Eigen::Vector2d(0.25, 0.25)).variance);
}

TEST(RidgeTest, DegreesWithTooManyTermsAreLeftOut) {
  Ridge::Options options;
  options.max_terms = 8;  // degree 2 has 5 terms in two dimensions, degree 3 has 9
  Ridge ridge(options);
  const Observations data = Observe(Cubic, 30);
  ridge.Fit(data.points, data.values, {});
  EXPECT_EQ(ridge.degree(), 2);
  EXPECT_NE(ridge.Describe().find("degree 2 (5 terms)"), std::string::npos);
}

}  // namespace
}  // namespace powdercal

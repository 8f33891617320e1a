#include "surrogates/marginal_posterior.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "surrogates/linear_algebra.h"

namespace powdercal {
namespace {

struct Data {
  Eigen::MatrixXd points;
  Eigen::VectorXd values;
  Eigen::VectorXd variances;
};

Data MakeData(int count, int dimension) {
  RandomStream random(3);
  Data data{Eigen::MatrixXd(count, dimension), Eigen::VectorXd(count), Eigen::VectorXd(count)};
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < dimension; ++k) data.points(i, k) = random.Uniform();
    data.values[i] = random.Normal();
    data.variances[i] = 0.02 * random.Uniform();
  }
  return data;
}

class GradientTest : public testing::TestWithParam<std::tuple<Kernel, bool, bool>> {};

TEST_P(GradientTest, AgreesWithCentralDifferences) {
  const auto [kernel, ard, learn_all] = GetParam();
  const Data data = MakeData(45, 3);  // above the block size of the inverse
  HyperparameterModel model;
  model.kernel = kernel;
  model.ard = ard;
  if (!learn_all) {
    model.signal_variance = 1.3;
    model.noise_variance = 0.01;
  }
  const MarginalPosterior posterior(model, data.points, data.values, data.variances);
  ASSERT_EQ(posterior.size(), (ard ? 3 : 1) + (learn_all ? 2 : 0));
  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(posterior.size(), -0.8, -2.5);
  double value = 0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(posterior.Evaluate(t, &value, &gradient));
  double same = 0;
  ASSERT_TRUE(posterior.Evaluate(t, &same, nullptr));
  EXPECT_EQ(value, same);
  for (int i = 0; i < posterior.size(); ++i) {
    const double step = 1e-5;
    Eigen::VectorXd moved = t;
    double above = 0;
    double below = 0;
    moved[i] = t[i] + step;
    ASSERT_TRUE(posterior.Evaluate(moved, &above, nullptr));
    moved[i] = t[i] - step;
    ASSERT_TRUE(posterior.Evaluate(moved, &below, nullptr));
    EXPECT_NEAR(gradient[i], (above - below) / (2 * step), 1e-6 * (1 + std::abs(gradient[i])))
        << "variable " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, GradientTest,
                         testing::Combine(testing::Values(Kernel::matern52, Kernel::rbf),
                                          testing::Bool(), testing::Bool()));

TEST(MarginalPosteriorTest, IsTheDensityItSays) {
  // Two points, everything written out.
  HyperparameterModel model;
  model.kernel = Kernel::rbf;
  model.lengthscale_spread = 0.5;
  Eigen::MatrixXd points(2, 2);
  points << 0, 0, 0.3, 0.4;
  const Eigen::Vector2d values(0.5, -0.7);
  const Eigen::Vector2d variances(0.1, 0.2);
  const MarginalPosterior posterior(model, points, values, variances);
  const Hyperparameters at{Eigen::Vector2d(0.5, 0.8), 2, 0.05};
  double value = 0;
  ASSERT_TRUE(posterior.Evaluate(posterior.ToUnconstrained(at), &value, nullptr));

  const double correlation = std::exp(-0.5 * (0.09 / 0.25 + 0.16 / 0.64));
  Eigen::Matrix2d k;
  k << 2 + 0.05 + 0.1, 2 * correlation, 2 * correlation, 2 + 0.05 + 0.2;
  const double pi = std::numbers::pi;
  double expected =
      -0.5 * values.dot(k.inverse() * values) - 0.5 * std::log(k.determinant()) - std::log(2 * pi);
  const auto log_normal = [&](double x, double location, double scale) {
    const double z = (std::log(x) - location) / scale;
    return -0.5 * z * z - std::log(x * scale * std::sqrt(2 * pi));
  };
  const double location = std::sqrt(2) + 0.5 * std::log(2);
  expected += log_normal(0.5, location, std::sqrt(3)) + log_normal(0.8, location, std::sqrt(3)) +
              log_normal(0.05, -4, 1);
  const double deviation = 0.5 * std::log(0.8 / 0.5);
  expected -= 2 * deviation * deviation / (2 * 0.25);
  expected -= 0.5 * std::pow(std::log(2) / 2, 2);
  EXPECT_NEAR(value, expected, 1e-8);
}

TEST(MarginalPosteriorTest, ConvertsThereAndBack) {
  const Data data = MakeData(5, 3);
  const MarginalPosterior posterior(HyperparameterModel{}, data.points, data.values,
                                    data.variances);
  const Hyperparameters hyperparameters{Eigen::Vector3d(0.1, 0.5, 3), 1.7, 2e-3};
  const Hyperparameters back =
      posterior.FromUnconstrained(posterior.ToUnconstrained(hyperparameters));
  EXPECT_TRUE(back.lengthscales.isApprox(hyperparameters.lengthscales, 1e-12));
  EXPECT_NEAR(back.signal_variance, 1.7, 1e-12);
  EXPECT_NEAR(back.noise_variance, 2e-3, 1e-14);
}

TEST(LinearAlgebraTest, InvertsTrianglesAndSquaresThem) {
  RandomStream random(1);
  for (const int n : {1, 2, 31, 33, 70, 133}) {
    Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(n, n);
    for (int j = 0; j < n; ++j) {
      for (int i = j; i < n; ++i) lower(i, j) = random.Uniform(-0.2, 0.2) + (i == j ? 2 : 0);
    }
    Eigen::MatrixXd inverse = lower;
    InvertLowerTriangle(inverse);
    EXPECT_TRUE((lower * inverse).isIdentity(1e-10)) << n;
    Eigen::MatrixXd gram(n, n);
    LowerTriangleGram(inverse, gram);
    const Eigen::MatrixXd expected = (lower * lower.transpose()).inverse();
    const Eigen::MatrixXd got = gram.triangularView<Eigen::Lower>();
    EXPECT_TRUE(got.isApprox(Eigen::MatrixXd(expected.triangularView<Eigen::Lower>()), 1e-9)) << n;
  }
}

}  // namespace
}  // namespace powdercal

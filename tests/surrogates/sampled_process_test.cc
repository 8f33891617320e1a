#include "surrogates/sampled_process.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"

namespace powdercal {
namespace {

double Wave(const Eigen::VectorXd& x) { return std::sin(5 * x[0]) + x[1] * x[1]; }

GaussianProcess NoisyProcess(double noise_sd, int points, GaussianProcess::Options options = {}) {
  RandomStream random(4);
  Eigen::MatrixXd x(points, 2);
  Eigen::VectorXd y(points);
  for (Eigen::Index i = 0; i < points; ++i) {
    x.row(i) = Eigen::RowVector2d(random.Uniform(), random.Uniform());
    y[i] = Wave(x.row(i).transpose()) + noise_sd * random.Normal();
  }
  GaussianProcess process(options);
  process.Fit(x, y, Eigen::VectorXd::Constant(points, noise_sd * noise_sd));
  return process;
}

Eigen::MatrixXd Normals(Eigen::Index rows, Eigen::Index samples) {
  RandomStream random(9);
  Eigen::MatrixXd normals(rows, samples);
  for (double& z : normals.reshaped()) z = random.Normal();
  return normals;
}

// Averaged over its samples it is the process it was drawn from.
TEST(SampledProcessTest, AveragesToTheProcess) {
  const GaussianProcess process = NoisyProcess(0.3, 15);
  constexpr int kSamples = 4000;
  const Eigen::MatrixXd extra = Eigen::RowVector2d(0.4, 0.6);
  const SampledProcess sampled(process, extra, Normals(16, kSamples));
  for (const Eigen::Vector2d& point : {Eigen::Vector2d(0.3, 0.7), Eigen::Vector2d(0.9, 0.1)}) {
    const SampledProcess::Point posterior = sampled.PosteriorAt(point, false);
    const Prediction expected = process.Predict(point);
    const double mean = posterior.means.mean();
    const double spread = (posterior.means - mean).square().mean();
    EXPECT_NEAR(mean, expected.mean, 4 * std::sqrt(expected.variance / kSamples));
    // Law of total variance.
    EXPECT_NEAR(spread + posterior.variance, expected.variance, 0.1 * expected.variance);
  }
  // At a point of the set nothing is left but what differs between samples.
  EXPECT_LT(sampled.PosteriorAt(extra.row(0).transpose(), false).variance,
            1e-3 * process.Predict(extra.row(0).transpose()).variance);
}

TEST(SampledProcessTest, GradientsAndManyPointsAgree) {
  GaussianProcess::Options options;
  options.inputs = InputMap({{.a = 0.6, .b = 1.8}, {}});
  const GaussianProcess process = NoisyProcess(0.1, 12, options);
  const SampledProcess sampled(process, Eigen::MatrixXd(0, 2), Normals(12, 3));
  const Eigen::Vector2d point(0.35, 0.55);
  const SampledProcess::Point posterior = sampled.PosteriorAt(point, true);
  constexpr double kStep = 1e-6;
  for (Eigen::Index k = 0; k < 2; ++k) {
    Eigen::MatrixXd pair(2, 2);
    pair.row(0) = point.transpose();
    pair.row(1) = point.transpose();
    pair(0, k) -= kStep;
    pair(1, k) += kStep;
    Eigen::MatrixXd means;
    Eigen::VectorXd variances;
    sampled.PredictMany(pair, &means, &variances);
    for (Eigen::Index s = 0; s < 3; ++s) {
      EXPECT_NEAR(posterior.mean_gradients(s, k), (means(1, s) - means(0, s)) / (2 * kStep), 1e-4);
    }
    EXPECT_NEAR(posterior.variance_gradient[k], (variances[1] - variances[0]) / (2 * kStep), 1e-4);
  }
}

TEST(InputMapTest, CategoriesBecomeInputsOfTheirOwn) {
  const InputMap map({{}, {.categories = 3}});
  EXPECT_EQ(map.InputCount(2), 4);
  const Eigen::MatrixXd inputs = map.Map(Eigen::RowVector2d(0.25, 0.5));
  EXPECT_EQ(inputs, Eigen::RowVector4d(0.25, 0, 1, 0));
  const Eigen::MatrixXd gradient =
      map.PullBack(Eigen::Vector2d(0.25, 0.5), Eigen::RowVector4d(7, 1, 2, 3));
  EXPECT_EQ(gradient, Eigen::RowVector2d(7, 0));
  EXPECT_TRUE(InputMap().identity());
}

TEST(InputMapTest, WarpsKeepEndsAndOrder) {
  const InputMap map({{.a = 0.4, .b = 1.7}});
  Eigen::VectorXd points = Eigen::VectorXd::LinSpaced(11, 0, 1);
  const Eigen::MatrixXd inputs = map.Map(points);
  EXPECT_NEAR(inputs(0), 0, 1e-2);
  EXPECT_NEAR(inputs(10), 1, 1e-2);
  for (Eigen::Index i = 1; i < 11; ++i) EXPECT_GT(inputs(i), inputs(i - 1));
}

// A response that changes in one corner only: what it is warped by makes predictions better.
TEST(InputMapTest, WarpingIsLearned) {
  const auto response = [](double x) { return std::log(x + 0.01); };
  Eigen::MatrixXd x(14, 1);
  Eigen::VectorXd y(14);
  for (Eigen::Index i = 0; i < 14; ++i) {
    x(i, 0) = (static_cast<double>(i) + 0.5) / 14;
    y[i] = response(x(i, 0));
  }
  double errors[2] = {0, 0};
  for (const bool warp : {false, true}) {
    GaussianProcess::Options options;
    options.warp = warp;
    GaussianProcess process(options);
    process.Fit(x, y, {});
    EXPECT_EQ(process.inputs().identity(), !warp);
    for (double u = 0.02; u < 1; u += 0.01) {
      const double error = process.Predict(Eigen::VectorXd::Constant(1, u)).mean - response(u);
      errors[warp ? 1 : 0] += error * error;
    }
  }
  EXPECT_LT(errors[1], 0.5 * errors[0]);
}

}  // namespace
}  // namespace powdercal

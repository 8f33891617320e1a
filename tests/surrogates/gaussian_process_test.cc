#include "surrogates/gaussian_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "core/random.h"
#include "tests/surrogates/table3_data.h"

namespace powdercal {
namespace {

struct Data {
  Eigen::MatrixXd points;
  Eigen::VectorXd values;
};

double Smooth(const Eigen::VectorXd& x) { return 7 + 3 * std::sin(3 * x[0]) + x[0] * x[1] - x[2]; }

Data MakeData(int count, double noise, std::uint64_t seed = 5) {
  RandomStream random(seed);
  Data data{Eigen::MatrixXd(count, 3), Eigen::VectorXd(count)};
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) data.points(i, k) = random.Uniform();
    data.values[i] = Smooth(data.points.row(i).transpose()) + noise * random.Normal();
  }
  return data;
}

GaussianProcess::Options WithKernel(Kernel kernel) {
  GaussianProcess::Options options;
  options.model.kernel = kernel;
  return options;
}

class KernelTest : public testing::TestWithParam<Kernel> {};
INSTANTIATE_TEST_SUITE_P(All, KernelTest, testing::Values(Kernel::matern52, Kernel::rbf));

TEST_P(KernelTest, GradientsOfMeanVarianceAndTailAgreeWithCentralDifferences) {
  const Data data = MakeData(25, 0.01);
  GaussianProcess fitted(WithKernel(GetParam()));
  fitted.Fit(data.points, data.values, {});
  Eigen::MatrixXd pending(2, 3);
  pending << 0.2, 0.3, 0.4, 0.7, 0.6, 0.1;
  const GaussianProcess process = fitted.ConditionedOn(pending);
  const Eigen::Vector3d at(0.31, 0.52, 0.73);
  const GaussianProcess::PointPosterior posterior = process.PosteriorAt(at, 2, true);
  for (int i = 0; i < 3; ++i) {
    const double step = 1e-5;
    Eigen::Vector3d moved = at;
    moved[i] += step;
    const auto above = process.PosteriorAt(moved, 2, false);
    moved[i] = at[i] - step;
    const auto below = process.PosteriorAt(moved, 2, false);
    EXPECT_NEAR(posterior.mean_gradient[i],
                (above.prediction.mean - below.prediction.mean) / (2 * step), 1e-6);
    EXPECT_NEAR(posterior.variance_gradient[i],
                (above.prediction.variance - below.prediction.variance) / (2 * step), 1e-6);
    const Eigen::VectorXd tail = (above.tail - below.tail) / (2 * step);
    EXPECT_TRUE(posterior.tail_gradient.col(i).isApprox(tail, 1e-4));
  }
}

TEST_P(KernelTest, InterpolatesDataWithoutNoise) {
  const Data data = MakeData(30, 0);
  GaussianProcess::Options options = WithKernel(GetParam());
  options.model.noise_variance = 1e-9;
  GaussianProcess process(options);
  process.Fit(data.points, data.values, {});
  for (int i = 0; i < 30; ++i) {
    const Prediction prediction = process.Predict(data.points.row(i).transpose());
    EXPECT_NEAR(prediction.mean, data.values[i], 1e-4);
    EXPECT_LT(std::sqrt(prediction.variance), 1e-3);
  }
}

TEST_P(KernelTest, LearnsASmoothFunctionAndIsHonestAboutItsErrors) {
  const Data data = MakeData(60, 0);
  GaussianProcess process(WithKernel(GetParam()));
  process.Fit(data.points, data.values, {});
  const Data test = MakeData(200, 0, 6);
  Eigen::VectorXd means;
  Eigen::VectorXd variances;
  process.PredictMany(test.points, &means, &variances);
  const Eigen::ArrayXd errors = (means - test.values).array();
  EXPECT_LT(std::sqrt(errors.square().mean()), 0.05);  // the values' standard deviation is about 1
  EXPECT_LT((errors.square() / variances.array()).mean(), 3);
}

TEST(GaussianProcessTest, FindsTheNoise) {
  const Data data = MakeData(200, 0.3);
  GaussianProcess process;
  process.Fit(data.points, data.values, {});
  EXPECT_NEAR(process.noise_sd(), 0.3, 0.06);
}

TEST(GaussianProcessTest, KnownVariancesWeighTheObservations) {
  Eigen::MatrixXd points(3, 1);
  points << 0, 0.5, 1;
  const Eigen::Vector3d values(0, 1, 0);
  GaussianProcess::Options options;
  options.standardise = false;
  options.hyperparameters = Hyperparameters{Eigen::VectorXd::Constant(1, 0.3), 1, 1e-6};
  GaussianProcess exact(options);
  exact.Fit(points, values, {});
  GaussianProcess noisy(options);
  noisy.Fit(points, values, Eigen::Vector3d(0, 4, 0));
  const Eigen::VectorXd middle = Eigen::VectorXd::Constant(1, 0.5);
  EXPECT_NEAR(exact.Predict(middle).mean, 1, 1e-4);
  EXPECT_LT(noisy.Predict(middle).mean, 0.3);
  EXPECT_GT(noisy.Predict(middle).variance, 0.5);
  // One observation, by hand: mean = y s²/(s² + v), variance = s² v/(s² + v).
  GaussianProcess single(options);
  single.Fit(points.topRows(1), Eigen::VectorXd::Constant(1, 2.0),
             Eigen::VectorXd::Constant(1, 0.5));
  const Prediction prediction = single.Predict(Eigen::VectorXd::Zero(1));
  EXPECT_NEAR(prediction.mean, 2 / 1.5, 1e-5);
  EXPECT_NEAR(prediction.variance, 0.5 / 1.5, 1e-5);
}

TEST(GaussianProcessTest, FastLeaveOneOutEqualsRefittingWithTheSameHyperparameters) {
  const Data data = MakeData(20, 0.1);
  GaussianProcess::Options options;
  options.standardise = false;
  options.hyperparameters = Hyperparameters{Eigen::Vector3d(0.5, 1, 2), 30, 0.05};
  GaussianProcess process(options);
  process.Fit(data.points, data.values, {});
  Eigen::VectorXd means;
  Eigen::VectorXd variances;
  process.LeaveOneOut(&means, &variances);
  for (int left_out = 0; left_out < 20; ++left_out) {
    std::vector<int> kept;
    for (int i = 0; i < 20; ++i) {
      if (i != left_out) kept.push_back(i);
    }
    GaussianProcess others(options);
    others.Fit(data.points(kept, Eigen::all), data.values(kept), {});
    const Prediction prediction = others.Predict(data.points.row(left_out).transpose());
    EXPECT_NEAR(means[left_out], prediction.mean, 1e-6);
    EXPECT_NEAR(variances[left_out], prediction.variance + 0.05, 1e-6);
  }
}

TEST(GaussianProcessTest, ConditioningEqualsAFitWithTheMeansAdded) {
  const Data data = MakeData(20, 0);
  GaussianProcess::Options options;
  options.standardise = false;
  options.hyperparameters = Hyperparameters{Eigen::Vector3d(0.5, 1, 2), 30, 1e-3};
  GaussianProcess process(options);
  process.Fit(data.points, data.values, {});
  Eigen::MatrixXd pending(2, 3);
  pending << 0.1, 0.2, 0.3, 0.9, 0.8, 0.5;
  const GaussianProcess conditioned = process.ConditionedOn(pending);

  Eigen::MatrixXd points(22, 3);
  points << data.points, pending;
  Eigen::VectorXd values(22);
  values << data.values, process.Predict(pending.row(0).transpose()).mean,
      process.Predict(pending.row(1).transpose()).mean;
  GaussianProcess refitted(options);
  refitted.Fit(points, values, {});
  const Eigen::Vector3d at(0.2, 0.4, 0.3);
  EXPECT_NEAR(conditioned.Predict(at).mean, process.Predict(at).mean, 1e-9);
  EXPECT_NEAR(conditioned.Predict(at).mean, refitted.Predict(at).mean, 1e-6);
  EXPECT_NEAR(conditioned.Predict(at).variance, refitted.Predict(at).variance, 1e-6);
  EXPECT_LT(conditioned.Predict(at).variance, process.Predict(at).variance);

  // The tail: the second pending evaluation comes out two standard deviations above its mean.
  const double sd = std::sqrt(
      process.ConditionedOn(pending.topRows(1)).Predict(pending.row(1).transpose()).variance +
      1e-3);
  values[21] += 2 * sd;
  refitted.Fit(points, values, {});
  const GaussianProcess::PointPosterior posterior = conditioned.PosteriorAt(at, 2, false);
  EXPECT_NEAR(posterior.prediction.mean + 2 * posterior.tail[1], refitted.Predict(at).mean, 1e-6);
}

TEST(GaussianProcessTest, JointPosteriorAgreesWithSinglePredictions) {
  const Data data = MakeData(15, 0.05);
  GaussianProcess process;
  process.Fit(data.points, data.values, {});
  Eigen::MatrixXd points(3, 3);
  points << 0.1, 0.5, 0.9, 0.1, 0.5, 0.91, 0.8, 0.1, 0.2;
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  process.PredictJoint(points, &mean, &covariance);
  for (int i = 0; i < 3; ++i) {
    const Prediction prediction = process.Predict(points.row(i).transpose());
    EXPECT_NEAR(mean[i], prediction.mean, 1e-9);
    EXPECT_NEAR(covariance(i, i), prediction.variance, 1e-9);
  }
  EXPECT_TRUE(covariance.isApprox(covariance.transpose(), 1e-9));
  EXPECT_GT(covariance(0, 1), 0.99 * std::sqrt(covariance(0, 0) * covariance(1, 1)));
}

TEST(GaussianProcessTest, ScreeningOnASubsetEndsAtTheSameOptimum) {
  const Data data = MakeData(80, 0.05);
  GaussianProcess screened;
  screened.Fit(data.points, data.values, {});
  GaussianProcess::Options options;
  options.screening_points = 1000;
  GaussianProcess full(options);
  full.Fit(data.points, data.values, {});
  EXPECT_NEAR(screened.log_posterior_density(), full.log_posterior_density(), 0.05);
}

TEST(GaussianProcessTest, IsDeterministic) {
  const Data data = MakeData(70, 0.1);
  GaussianProcess first;
  first.Fit(data.points, data.values, {});
  GaussianProcess second;
  second.Fit(MakeData(10, 0).points, MakeData(10, 0).values, {});
  second.Fit(data.points, data.values, {});  // no memory of an earlier fit
  const Eigen::Vector3d at(0.5, 0.5, 0.5);
  EXPECT_EQ(first.Predict(at).mean, second.Predict(at).mean);
  EXPECT_EQ(first.Predict(at).variance, second.Predict(at).variance);
}

TEST(GaussianProcessTest, SurvivesDegenerateData) {
  GaussianProcess::Options options;
  options.fallback_scale = 2;
  GaussianProcess process(options);
  // All values equal; all points equal; one observation.
  process.Fit(MakeData(6, 0).points, Eigen::VectorXd::Constant(6, 3.0), {});
  EXPECT_NEAR(process.Predict(Eigen::Vector3d(0.5, 0.5, 0.5)).mean, 3, 1e-9);
  EXPECT_GT(process.Predict(Eigen::Vector3d(0.5, 0.5, 0.5)).variance, 0);
  process.Fit(Eigen::MatrixXd::Constant(4, 2, 0.3), Eigen::Vector4d(1, 2, 3, 4), {});
  EXPECT_NEAR(process.Predict(Eigen::Vector2d(0.3, 0.3)).mean, 2.5, 0.2);
  process.Fit(Eigen::MatrixXd::Constant(1, 2, 0.3), Eigen::VectorXd::Constant(1, 5.0), {});
  EXPECT_NEAR(process.Predict(Eigen::Vector2d(0.3, 0.3)).mean, 5, 1e-9);
}

TEST(GaussianProcessTest, RefusesBadData) {
  GaussianProcess process;
  const Data data = MakeData(4, 0);
  EXPECT_THROW(process.Fit(Eigen::MatrixXd(0, 2), Eigen::VectorXd(0), {}), std::invalid_argument);
  EXPECT_THROW(process.Fit(data.points, data.values.head(3), {}), std::invalid_argument);
  EXPECT_THROW(process.Fit(data.points, data.values, Eigen::VectorXd::Zero(2)),
               std::invalid_argument);
  EXPECT_THROW(process.Fit(data.points, data.values, Eigen::VectorXd::Constant(4, -1)),
               std::invalid_argument);
  Eigen::VectorXd values = data.values;
  values[2] = std::nan("");
  EXPECT_THROW(process.Fit(data.points, values, {}), std::invalid_argument);
  GaussianProcess::Options options;
  options.hyperparameters = Hyperparameters{Eigen::Vector3d(1, 1, 1), -1, 0};
  GaussianProcess impossible(options);
  EXPECT_THROW(impossible.Fit(data.points, data.values, {}), std::runtime_error);
}

TEST(GaussianProcessTest, DescribesItself) {
  GaussianProcess process;
  EXPECT_THAT(process.Describe(), testing::HasSubstr("not fitted"));
  const Table3 table = ReadTable3();
  process.Fit(table.points, table.void_ratios, {});
  EXPECT_THAT(process.Describe(), testing::HasSubstr("Matérn 5/2, 18 points, lengthscales ["));
}

}  // namespace
}  // namespace powdercal

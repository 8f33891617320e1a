#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/random.h"
#include "surrogates/validation.h"

namespace powdercal {

struct Observations {
  Eigen::MatrixXd points;
  Eigen::VectorXd values;
};

/// Random points of the unit square.
template <typename Function>
Observations Observe(const Function& function, int count, std::uint64_t seed = 3) {
  RandomStream random(seed);
  Observations data{Eigen::MatrixXd(count, 2), Eigen::VectorXd(count)};
  for (int i = 0; i < count; ++i) {
    data.points.row(i) << random.Uniform(), random.Uniform();
    data.values[i] = function(data.points(i, 0), data.points(i, 1));
  }
  return data;
}

inline double Wavy(double u, double v) { return 7 + 3 * std::sin(3 * u) + u * v; }

/// What every regression has to do with data that are not what it hopes for.
inline void ExpectGoodManners(const SurrogateMaker& make) {
  const Observations data = Observe(Wavy, 12);
  const Eigen::Vector2d at(0.3, 0.6);
  const auto surrogate = make();
  const double infinity = std::numeric_limits<double>::infinity();

  // Sizes that disagree, nothing at all, values that are not finite, negative variances.
  EXPECT_THROW(surrogate->Fit(Eigen::MatrixXd(0, 2), Eigen::VectorXd(0), {}),
               std::invalid_argument);
  EXPECT_THROW(surrogate->Fit(Eigen::MatrixXd(3, 0), Eigen::Vector3d(1, 2, 3), {}),
               std::invalid_argument);
  EXPECT_THROW(surrogate->Fit(data.points, data.values.head(3), {}), std::invalid_argument);
  EXPECT_THROW(surrogate->Fit(data.points, data.values, Eigen::VectorXd::Zero(2)),
               std::invalid_argument);
  EXPECT_THROW(surrogate->Fit(data.points, data.values, Eigen::VectorXd::Constant(12, -1)),
               std::invalid_argument);
  for (const double bad : {std::nan(""), infinity}) {
    Observations spoilt = data;
    spoilt.values[4] = bad;
    EXPECT_THROW(surrogate->Fit(spoilt.points, spoilt.values, {}), std::invalid_argument);
    spoilt = data;
    spoilt.points(4, 1) = bad;
    EXPECT_THROW(surrogate->Fit(spoilt.points, spoilt.values, {}), std::invalid_argument);
  }
  EXPECT_NE(surrogate->Describe().find("not fitted"), std::string::npos);

  // The same bits again, also from an object that was fitted to something else before.
  surrogate->Fit(data.points, data.values, {});
  const Prediction first = surrogate->Predict(at);
  EXPECT_TRUE(std::isfinite(first.mean));
  EXPECT_GE(first.variance, 0);
  surrogate->Fit(data.points.topRows(5), data.values.head(5), {});
  surrogate->Fit(data.points, data.values, Eigen::VectorXd::Zero(12));
  EXPECT_EQ(surrogate->Predict(at).mean, first.mean);
  EXPECT_EQ(surrogate->Predict(at).variance, first.variance);
  EXPECT_NE(surrogate->Describe().find("12 points"), std::string::npos);

  // A constant.
  surrogate->Fit(data.points, Eigen::VectorXd::Constant(12, 4.5), {});
  EXPECT_NEAR(surrogate->Predict(at).mean, 4.5, 1e-6);
  EXPECT_GE(surrogate->Predict(at).variance, 0);

  // One point, of which nothing can be learned about errors.
  surrogate->Fit(data.points.topRows(1), data.values.head(1), {});
  EXPECT_NEAR(surrogate->Predict(at).mean, data.values[0], 1e-6);
  EXPECT_EQ(surrogate->Predict(at).variance, infinity);

  // Every point twice, with values ±0.1 about the function.
  Observations twice{data.points.replicate(2, 1), data.values.replicate(2, 1)};
  twice.values.head(12).array() += 0.1;
  twice.values.tail(12).array() -= 0.1;
  surrogate->Fit(twice.points, twice.values, {});
  const Prediction there = surrogate->Predict(data.points.row(0).transpose());
  EXPECT_NEAR(there.mean, data.values[0], 1.0);
  EXPECT_GE(there.variance, 0);

  // Values of any size, in two dimensions or one.
  surrogate->Fit(data.points.leftCols(1), 1e9 * data.values, {});
  const double large = surrogate->Predict(at.head(1)).mean;
  surrogate->Fit(data.points.leftCols(1), 1e-9 * data.values, {});
  EXPECT_NEAR(surrogate->Predict(at.head(1)).mean, 1e-18 * large, 1e-6 * std::abs(1e-18 * large));
}

/// Root of the mean squared error at points that were not observed.
template <typename Function>
double ErrorOn(const Surrogate& surrogate, const Function& function) {
  double sum = 0;
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j < 10; ++j) {
      const Eigen::Vector2d at(0.05 + 0.1 * i, 0.05 + 0.1 * j);
      sum += std::pow(surrogate.Predict(at).mean - function(at[0], at[1]), 2);
    }
  }
  return std::sqrt(sum / 100);
}

}  // namespace powdercal

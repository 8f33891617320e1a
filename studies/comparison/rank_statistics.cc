#include "studies/comparison/rank_statistics.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "core/portable_math.h"

namespace powdercal::comparison {
namespace {

// blocks × treatments
Eigen::MatrixXd Ranks(const Eigen::MatrixXd& values) {
  Eigen::MatrixXd ranks(values.rows(), values.cols());
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.cols()));
  for (Eigen::Index row = 0; row < values.rows(); ++row) {
    const auto value = [&](Eigen::Index column) {
      const double v = values(row, column);
      return std::isfinite(v) ? v : std::numeric_limits<double>::infinity();
    };
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](Eigen::Index a, Eigen::Index b) { return value(a) < value(b); });
    for (std::size_t first = 0; first < order.size();) {
      std::size_t end = first + 1;
      while (end < order.size() && value(order[end]) == value(order[first])) ++end;
      const double shared = 0.5 * static_cast<double>(first + 1 + end);
      for (; first < end; ++first) ranks(row, order[first]) = shared;
    }
  }
  return ranks;
}

FriedmanTest WithProbabilities(FriedmanTest test) {
  const double k = test.treatments;
  const double n = test.blocks;
  test.chi_squared_p =
      boost::math::cdf(boost::math::complement(boost::math::chi_squared(k - 1), test.chi_squared));
  const double left = n * (k - 1) - test.chi_squared;
  if (left <= 1e-12 * n * (k - 1)) {
    test.f = std::numeric_limits<double>::infinity();
    test.f_p = std::exp((1 - n) * std::lgamma(k + 1));
    return test;
  }
  test.f = (n - 1) * test.chi_squared / left;
  const boost::math::fisher_f distribution(k - 1, (k - 1) * (n - 1));
  test.f_p = boost::math::cdf(boost::math::complement(distribution, test.f));
  return test;
}

}  // namespace

Eigen::VectorXd MeanRanks(const Eigen::MatrixXd& values) {
  assert(values.rows() > 0);
  return Ranks(values).colwise().mean();
}

FriedmanTest TestFriedman(const Eigen::MatrixXd& values) {
  FriedmanTest test{.blocks = static_cast<int>(values.rows()),
                    .treatments = static_cast<int>(values.cols())};
  if (test.blocks < 2 || test.treatments < 2) return test;
  const Eigen::MatrixXd ranks = Ranks(values);
  const double n = test.blocks;
  const double k = test.treatments;
  const double spread = ranks.squaredNorm() - n * k * (k + 1) * (k + 1) / 4;
  if (spread <= 0) return test;  // nothing but ties
  const Eigen::ArrayXd sums = ranks.colwise().sum();
  test.chi_squared = (k - 1) * (sums - n * (k + 1) / 2).square().sum() / spread;
  return WithProbabilities(test);
}

FriedmanTest TestMeanRanks(const Eigen::VectorXd& mean_ranks, int blocks) {
  FriedmanTest test{.blocks = blocks, .treatments = static_cast<int>(mean_ranks.size())};
  if (test.blocks < 2 || test.treatments < 2) return test;
  const double k = test.treatments;
  test.chi_squared =
      12 * blocks / (k * (k + 1)) * (mean_ranks.squaredNorm() - k * (k + 1) * (k + 1) / 4);
  return WithProbabilities(test);
}

double NormalRangeCdf(double q, int groups) {
  assert(groups >= 2);
  if (q <= 0) return 0;
  // The integrand is analytic and all but zero beyond the limits: the trapezoidal rule converges
  // exponentially.
  constexpr double kLimit = 8.5;
  constexpr double kStep = 0.05;
  double sum = 0;
  for (double z = -kLimit; z <= kLimit; z += kStep) {
    const double inside = PortableNormalCdf(z) - PortableNormalCdf(z - q);
    sum += PortableNormalDensity(z) * std::pow(inside, groups - 1);
  }
  return std::min(1.0, groups * kStep * sum);
}

double NormalRangeQuantile(double p, int groups) {
  assert(p > 0 && p < 1);
  double low = 0;
  double high = 20;  // of thousands of groups still beyond any quantile of use
  while (high - low > 1e-10) {
    const double middle = 0.5 * (low + high);
    (NormalRangeCdf(middle, groups) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double NemenyiDifference(int treatments, int blocks, double alpha) {
  const double k = treatments;
  return NormalRangeQuantile(1 - alpha, treatments) / std::sqrt(2.0) *
         std::sqrt(k * (k + 1) / (6.0 * blocks));
}

}  // namespace powdercal::comparison

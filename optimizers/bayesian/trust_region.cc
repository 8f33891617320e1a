#include "optimizers/bayesian/trust_region.h"

#include <algorithm>
#include <cmath>

namespace powdercal {
namespace {

constexpr double kFirst = 0.8;
constexpr double kLargest = 1.6;
constexpr double kSmallest = 0x1p-7;
constexpr int kSuccesses = 3;
constexpr double kImprovement = 1e-3;

}  // namespace

TrustRegion FindTrustRegion(const Eigen::VectorXd& best_point, double best_before,
                            const std::vector<double>& values,
                            const Eigen::VectorXd& lengthscales) {
  const auto patience = std::max<int>(4, static_cast<int>(best_point.size()));
  double length = kFirst;
  double best = best_before;
  int successes = 0;
  int failures = 0;
  for (const double value : values) {
    const bool improved = value < best - kImprovement * std::abs(best);
    successes = improved ? successes + 1 : 0;
    failures = improved ? 0 : failures + 1;
    best = std::min(best, value);
    if (successes == kSuccesses) {
      length = std::min(2 * length, kLargest);
      successes = 0;
    } else if (failures == patience) {
      length /= 2;
      failures = 0;
      if (length < kSmallest) length = kFirst;
    }
  }
  const Eigen::ArrayXd stretch = lengthscales.array() / std::exp(lengthscales.array().log().mean());
  const Eigen::VectorXd half = 0.5 * length * stretch.matrix();
  return {.lower = (best_point - half).cwiseMax(0),
          .upper = (best_point + half).cwiseMin(1),
          .length = length};
}

}  // namespace powdercal

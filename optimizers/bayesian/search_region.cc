#include "optimizers/bayesian/search_region.h"

#include <algorithm>
#include <cmath>

namespace powdercal {
namespace {

const SearchStep* BestOf(const std::vector<SearchStep>& steps) {
  const auto best =
      std::min_element(steps.begin(), steps.end(),
                       [](const SearchStep& a, const SearchStep& b) { return a.value < b.value; });
  return best == steps.end() || best->value == HUGE_VAL ? nullptr : &*best;
}

double TrustedLength(const std::vector<SearchStep>& steps, int patience) {
  constexpr double kFirst = 0.8;
  constexpr double kLargest = 1.6;
  constexpr double kSmallest = 0x1p-7;
  constexpr int kSuccesses = 3;
  constexpr double kImprovement = 1e-3;
  double length = kFirst;
  double best = HUGE_VAL;
  int successes = 0;
  int failures = 0;
  for (const SearchStep& step : steps) {
    if (step.proposed) {
      const bool improved = step.value < best - kImprovement * std::abs(best);
      successes = improved ? successes + 1 : 0;
      failures = improved ? 0 : failures + 1;
    }
    best = std::min(best, step.value);
    if (successes == kSuccesses) {
      length = std::min(2 * length, kLargest);
      successes = 0;
    } else if (failures == patience) {
      length /= 2;
      failures = 0;
      if (length < kSmallest) length = kFirst;
    }
  }
  return length;
}

}  // namespace

TrustRegion FindTrustRegion(const std::vector<SearchStep>& steps,
                            const Eigen::VectorXd& lengthscales) {
  const Eigen::VectorXd& centre = BestOf(steps)->point;
  const double length = TrustedLength(steps, std::max<int>(4, static_cast<int>(centre.size())));
  const Eigen::ArrayXd stretch = lengthscales.array() / std::exp(lengthscales.array().log().mean());
  const Eigen::VectorXd half = 0.5 * length * stretch.matrix();
  return {
      .lower = (centre - half).cwiseMax(0), .upper = (centre + half).cwiseMin(1), .length = length};
}

std::optional<Eigen::VectorXd> FindCreep(const std::vector<SearchStep>& steps) {
  constexpr std::size_t kSteps = 5;
  constexpr double kCreeping = 0.005;
  const SearchStep* best = BestOf(steps);
  if (best == nullptr || steps.size() < kSteps) return std::nullopt;
  const double radius = kCreeping * std::sqrt(static_cast<double>(best->point.size()));
  const bool creeps = std::all_of(steps.end() - kSteps, steps.end(), [&](const SearchStep& step) {
    return step.proposed && (step.point - best->point).norm() <= radius;
  });
  return creeps ? std::optional(best->point) : std::nullopt;
}

}  // namespace powdercal

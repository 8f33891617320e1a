#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace powdercal {

/// An evaluation as a search for one objective sees it.
struct SearchStep {
  Eigen::VectorXd point;  ///< in the unit box
  double value = 0;       ///< of the objective; +∞ where it has none
  bool proposed = false;  ///< by the optimizer, not by its initial design or the user
};

/// The part of the unit box in which a search of many parameters looks for its next point: around
/// the best one, with sides that grow after successes and shrink after failures (TuRBO: Eriksson,
/// Pearce, Gardner, Turner & Poloczek 2019, with one region). Side L ∈ [2⁻⁷, 1.6], first 0.8: three
/// successive improvements (by more than a thousandth of the best) double it, d successive
/// evaluations (at least 4) without one halve it; below 2⁻⁷ it starts anew at 0.8. Sides are
/// stretched by the lengthscales over their geometric mean.
struct TrustRegion {
  Eigen::VectorXd lower;  ///< d
  Eigen::VectorXd upper;
  double length = 0.8;
};

/// steps: in order, one of them with a finite value. lengthscales: d, of the unit box.
TrustRegion FindTrustRegion(const std::vector<SearchStep>& steps,
                            const Eigen::VectorXd& lengthscales);

/// A process that is too sure of itself creeps: proposal after proposal lies beside the best point,
/// for gains that do not matter, while the rest of the box counts as hopeless. The best point,
/// where the last five steps were proposals within 0.005 √d of it; then the next one has to go
/// elsewhere.
std::optional<Eigen::VectorXd> FindCreep(const std::vector<SearchStep>& steps);
/// How far, in units of √d.
inline constexpr double kElsewhere = 0.1;

}  // namespace powdercal

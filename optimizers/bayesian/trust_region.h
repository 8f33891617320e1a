#pragma once

#include <Eigen/Core>
#include <vector>

namespace powdercal {

/// The part of the unit box in which a search of many parameters looks for its next point: around
/// the best one, with sides that grow after successes and shrink after failures (TuRBO: Eriksson,
/// Pearce, Gardner, Turner & Poloczek 2019, with one region). Side L ∈ [2⁻⁷, 1.6], first 0.8: three
/// successive improvements (by more than a thousandth of the best) double it, d successive
/// evaluations without one halve it; below 2⁻⁷ it starts anew at 0.8. Sides are stretched by the
/// lengthscales over their geometric mean.
struct TrustRegion {
  Eigen::VectorXd lower;  ///< d
  Eigen::VectorXd upper;
  double length = 0.8;
};

/// values: objective of the evaluations that followed the initial design, in order, +∞ for failed
/// ones; `best_before`: lowest of the initial design. lengthscales: d, of the unit box.
TrustRegion FindTrustRegion(const Eigen::VectorXd& best_point, double best_before,
                            const std::vector<double>& values, const Eigen::VectorXd& lengthscales);

}  // namespace powdercal

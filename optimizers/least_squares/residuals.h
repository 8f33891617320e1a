#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "optimizers/observations.h"
#include "optimizers/optimizer.h"

namespace powdercal {

/// Why a sum of squares over a continuous box cannot treat this problem, with alternatives; "" if
/// it can.
std::string ExplainNoLeastSquares(std::string_view optimizer, const SearchSpace& space,
                                  const Objectives& objectives);

/// Residuals ρ_j = (response_j − target_j)/s_j with s_j² = sd_j² + the median variance of
/// response j, so that χ² = Σ ρ_j². One weight for all points, as least squares needs. Only
/// responses that are `active` count.
struct Residuals {
  std::vector<Eigen::Index> active;  ///< indices of targets
  Eigen::VectorXd targets;           ///< of the active responses
  Eigen::VectorXd scales;            ///< s_j > 0, of the active responses
  Eigen::VectorXd noise;             ///< sd of ρ_j by the known variances; 0: none is known

  /// All responses active.
  Residuals(const Objectives& objectives, const ObservationsById& observations);

  /// Leaves those active that the observation has.
  void Restrict(const Observation& observation);
  /// Whether every active response is there.
  bool Complete(const Observation& observation) const;
  /// Requires Complete.
  Eigen::VectorXd Of(const Observation& observation) const;
  Eigen::Index size() const { return targets.size(); }
};

}  // namespace powdercal

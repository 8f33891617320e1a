#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace powdercal {

/// What a Jacobian says of the parameters at the end of a search.
struct Identifiability {
  std::vector<Eigen::Index> dead;   ///< no response changes with them
  std::vector<Eigen::Index> lower;  ///< at their lower bound
  std::vector<Eigen::Index> upper;  ///< at their upper bound
  /// Unit vectors of the unit box, without dead parameters, along which χ² does not change.
  std::vector<Eigen::VectorXd> flat;

  /// Whether every parameter is determined, inside the box.
  bool clear() const { return dead.empty() && lower.empty() && upper.empty() && flat.empty(); }
};

/// point: in the unit box. jacobian: m × d, derivatives of residuals in units of their standard
/// deviation. noise: d, standard deviation of the entries of each column.
///
/// Along a unit vector v, χ² changes by |Jv|² over the length of the box, to first order. Singular
/// vectors v of J whose singular value is below 0.1 (0.01 of χ²), or below what noise alone would
/// give, √(m Σ v_k² noise_k²), are flat; a parameter whose column is that short is dead and left
/// out of them.
Identifiability Identify(const Eigen::VectorXd& point, const Eigen::MatrixXd& jacobian,
                         const Eigen::ArrayXd& noise);

/// "dead parameter: no response changes with mu_r; flat valley: direction (k:+0.90, e:-0.44)
/// leaves chi² unchanged; k is at its upper bound"; "" if clear.
std::string Describe(const Identifiability& identifiability,
                     const std::vector<std::string>& symbols);

}  // namespace powdercal

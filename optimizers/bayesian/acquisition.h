#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "optimizers/optimizer.h"

namespace powdercal {

/// What a new evaluation at a point promises, as a logarithm, ln [p(x) · promise(x)], with p the
/// probability that the evaluation succeeds.
class Acquisition {
 public:
  virtual ~Acquisition() = default;

  /// The gradient by the point is 0 in categorical coordinates.
  virtual double Evaluate(const Eigen::VectorXd& point, Eigen::VectorXd* gradient) const = 0;
  /// At each row of points.
  virtual Eigen::VectorXd EvaluateMany(const Eigen::MatrixXd& points) const = 0;
  /// ln p.
  virtual double LogFeasibility(const Eigen::VectorXd& point) const = 0;
  /// The evaluated point that the models hold for the best.
  virtual const Eigen::VectorXd& best_point() const = 0;
};

/// chi² below which there is nothing left to improve; only keeps logarithms finite.
inline constexpr double kSmallestObjective = 1e-16;

/// ln mean exp of the values, −∞ where all are; shares: how much each contributes, sum 1 (or 0).
double LogMeanExp(const Eigen::ArrayXd& values, Eigen::ArrayXd* shares);

/// Where a maximum of the acquisition may lie.
struct MaximisationLimits {
  const SearchSpace* space = nullptr;  ///< only its points (see SearchSpace::Snap) are proposed
  Eigen::VectorXd lower;               ///< d, corners of the part of the box that is searched
  Eigen::VectorXd upper;
  Eigen::MatrixXd taken;       ///< m × d: points that must not be proposed again
  double radius = 1e-6;        ///< around them; < 0: they may
  Eigen::VectorXd avoided;     ///< centre of a ball that is left out; empty: none
  double avoided_radius = 0;   ///< in the unit box
  double min_feasibility = 0;  ///< probability of success
};

/// A maximum of the acquisition: Sobol' points of the box, normal steps of several lengths from
/// `anchors` (m × d, good points known so far) and, of discrete parameters, the anchors' other
/// levels are tried; the best of them climb in the continuous coordinates by L-BFGS (Ceres, in
/// variables without bounds), and the highest end within the limits wins. Deterministic for a given
/// seed. Empty if none is within the limits or nothing is finite.
Eigen::VectorXd MaximiseAcquisition(const Acquisition& acquisition, const Eigen::MatrixXd& anchors,
                                    const MaximisationLimits& limits, std::uint64_t seed);

}  // namespace powdercal

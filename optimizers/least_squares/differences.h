#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "optimizers/least_squares/residuals.h"

namespace powdercal {

/// Evaluates a batch of points; answers in their order. Empty: the search is to end.
using EvaluateBatch = std::function<std::optional<std::vector<Observation>>(
    const std::vector<Eigen::VectorXd>& points, const std::vector<std::string>& origins)>;

/// What the step of a finite difference is chosen by, in units of residuals and of the unit box.
struct StepRule {
  double noise = 0;  ///< √Σ_j σ_j², σ_j the sd of residual j
  /// Whether `noise` is scatter that was told or found; else it is the digits of the responses.
  bool noisy = false;
  Eigen::ArrayXd curvature;     ///< > 0; for parameter k: √Σ_j (∂²ρ_j/∂x_k²)²
  double spread = 0;            ///< > 0; √Σ_j var ρ_j over the box
  std::optional<double> fixed;  ///< the user's step

  /// Before anything else is known: σ_j as told, or `precision` times the size of the responses;
  /// curvature such that the residuals vary by `spread` over a few tenths of the box.
  StepRule(const Residuals& residuals, const ObservationsById& observations, int dimension,
           double precision);

  /// Step of a one-sided difference with the least expected error,
  ///   h = 8^¼ (σ/|f''|)^½   (Moré & Wild 2012, eq. 1.2), within [1e-8, 0.2] of the box.
  double OneSided(Eigen::Index parameter) const;
  /// Step of a central difference, h = (3σ/|f'''|)^⅓ (balancing h²|f'''|/6 and σ/h), with |f'''|
  /// from curvature and spread as for a sine; within [1e-7, 0.2].
  double Central(Eigen::Index parameter) const;
};

enum class Scheme {
  one_sided,  ///< d evaluations
  central,    ///< 2 d evaluations; second order also at bounds
};

/// A matrix of finite differences.
struct DifferenceJacobian {
  Eigen::MatrixXd values;  ///< m × d, ∂ρ/∂x; zero columns where dropped
  Eigen::ArrayXd steps;    ///< d, in the unit box
  Scheme scheme = Scheme::one_sided;
  std::vector<Eigen::Index> dropped;  ///< parameters without a column: both sides failed
  Eigen::ArrayXd curvature;           ///< central: d, as StepRule's (0: unknown); else empty

  /// Standard deviation of an entry in column k where the residual has noise of sd 1.
  double Noise(Eigen::Index parameter) const;
};

/// Asks for the whole stencil around x as one batch. Steps go to the inside of the box. Where a
/// point of the stencil fails, or lacks an active response, the other side is asked for, in a
/// second batch; where that fails as well, the column is dropped. Empty: the search is to end.
std::optional<DifferenceJacobian> Differences(const Eigen::VectorXd& x,
                                              const Eigen::VectorXd& residuals_at_x, Scheme scheme,
                                              const Eigen::ArrayXd& steps,
                                              const Residuals& residuals,
                                              const std::vector<std::string>& symbols,
                                              const EvaluateBatch& evaluate);

}  // namespace powdercal

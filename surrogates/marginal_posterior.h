#pragma once

#include <Eigen/Core>
#include <optional>

#include "surrogates/kernel.h"

namespace powdercal {

/// Hyperparameters of a Gaussian process, in units of the unit box and of the standardised outputs.
struct Hyperparameters {
  Eigen::VectorXd lengthscales;  ///< d
  double signal_variance = 1;
  double noise_variance = 0;  ///< common to all observations, added to their known variances
};

/// What is fixed, what is learned and the priors of what is learned.
struct HyperparameterModel {
  Kernel kernel = Kernel::matern52;
  bool ard = true;                   ///< one lengthscale per input, else a common one
  double lengthscale_floor = 0.025;  ///< > 0
  /// τ > 0: prior standard deviation of ln l_i about the mean of all ln l_i. It keeps a handful of
  /// observations from declaring an input dead; ∞: no such tie.
  double lengthscale_spread = 0.5;
  double noise_location = -4;             ///< of the prior of the noise variance
  double noise_scale = 1;                 ///< > 0
  double noise_floor = 1e-6;              ///< ≥ 0, of the learned noise variance
  std::optional<double> noise_variance;   ///< fixed when set
  std::optional<double> signal_variance;  ///< fixed when set
};

/// Log posterior density of the hyperparameters of a Gaussian process, up to a constant, the
/// process itself integrated out (Rasmussen & Williams 2006, eq. 5.8 and 5.9):
///   −½ yᵀK⁻¹y − ½ ln|K| − (n/2) ln 2π + ln p(l) + ln p(σ²) + ln p(s²),
///   K = s² C(l) + diag(σ² + v),
/// with the priors
///   l_i ~ LogNormal(√2 + ½ ln d, √3) (Hvarfner, Hellsten & Nardi 2024), tied together by a factor
///         exp(−Σ (ln l_i − mean ln l)² / 2τ²);
///   σ²  ~ LogNormal(−4, 1), or as the model says;
///   s²  : ln s² ~ Normal(0, 2).
/// The first two are densities of the quantity itself, so that the mode of all l_i is at
/// exp(√2 − 3) √d ≈ 0.2 √d and that of σ² at exp(−5); the last is a density of its logarithm.
/// The density is evaluated at unconstrained variables t: l = floor + exp(t), s² = exp(t),
/// σ² = floor + exp(t), in this order.
class MarginalPosterior {
 public:
  /// points: n × d; values: standardised; variances: n, known, in the units of values².
  MarginalPosterior(HyperparameterModel model, const Eigen::MatrixXd& points,
                    const Eigen::VectorXd& values, const Eigen::VectorXd& variances);

  /// Number of unconstrained variables.
  int size() const;
  Hyperparameters FromUnconstrained(const Eigen::VectorXd& t) const;
  Eigen::VectorXd ToUnconstrained(const Hyperparameters& hyperparameters) const;

  /// The log density and, unless null, its gradient. False where K is not positive definite in
  /// floating-point arithmetic or the density is not finite.
  bool Evaluate(const Eigen::VectorXd& t, double* value, Eigen::VectorXd* gradient) const;

 private:
  double AddPriors(const Eigen::VectorXd& t, const Hyperparameters& hyperparameters,
                   Eigen::VectorXd* gradient) const;

  HyperparameterModel model_;
  Eigen::Index dimension_;
  Eigen::VectorXd values_;
  Eigen::VectorXd variances_;
  /// Squared differences of all pairs i > j, column by column of K: pairs × d, or pairs × 1 (their
  /// sum) with a common lengthscale.
  Eigen::MatrixXd squared_differences_;
};

/// Relative to the signal variance, always added to the diagonal of K.
inline constexpr double kBaseJitter = 1e-10;

}  // namespace powdercal

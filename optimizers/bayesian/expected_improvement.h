#pragma once

#include <Eigen/Core>

namespace powdercal {

/// ln E[max(0, best − f)] for f ~ Normal(mean, variance): the logarithm of Mockus' expected
/// improvement, accurate where the improvement itself underflows (Ament, Daulton, Eriksson,
/// Balandat & Bakshy 2023). Requires variance > 0.
struct LogImprovement {
  double value = 0;
  double by_mean = 0;      ///< derivative by the mean
  double by_variance = 0;  ///< derivative by the variance
};
LogImprovement LogExpectedImprovement(double best, double mean, double variance);

/// ln E[max(0, best − c)] of the composite objective
///   c = Σ_j w_j (δ_j + ε_j)²,  ε_j ~ Normal(0, v_j) independent,
/// with δ_j the residual of the predicted mean of response j and v_j its variance: the expected
/// improvement of a chi² whose responses, not its own value, are modelled (Astudillo & Frazier
/// 2019).
///
/// c is a weighted sum of noncentral chi² variables with the cumulant function
///   K(θ) = Σ_j [ θ w_j δ_j² / D_j − ½ ln D_j ],  D_j = 1 − 2 θ w_j v_j,
/// and the expectation is the inverse Laplace integral
///   E = (1/2πi) ∫ exp(K(θ) − θ best) / θ² dθ,  Re θ < 0 where it crosses the real axis,
/// taken by the trapezoidal rule along a parabola through the saddle point of the integrand that
/// follows the path of steepest descent to second order. The rule converges geometrically there,
/// any number of responses costs the same per response, tails do not underflow, there is no
/// sampling noise, and the derivatives (the same integral of other integrands) are exact. Relative
/// error about 1e-6 or better.
///
/// Requires best > 0, weights > 0, variances > 0. by_residual and by_variance (derivatives of the
/// logarithm) may be null.
double CompositeLogExpectedImprovement(double best, const Eigen::ArrayXd& residuals,
                                       const Eigen::ArrayXd& variances,
                                       const Eigen::ArrayXd& weights, Eigen::ArrayXd* by_residual,
                                       Eigen::ArrayXd* by_variance);

}  // namespace powdercal

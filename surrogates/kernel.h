#pragma once

#include <Eigen/Core>

namespace powdercal {

/// Stationary correlation functions of the scaled distance r, r² = Σ_i (x_i − x'_i)² / l_i²
/// (Rasmussen & Williams 2006, section 4.2):
///   matern52: (1 + √5 r + 5 r²/3) exp(−√5 r);
///   rbf:      exp(−r²/2).
enum class Kernel { matern52, rbf };

/// For each squared scaled distance q = r²: correlation(q), and slope(q) = −2 d correlation / dq,
/// with which d correlation / d ln l_i = slope · (x_i − x'_i)² / l_i² and d correlation / d x_i =
/// −slope · (x_i − x'_i) / l_i². `slope` may be null.
void Correlation(Kernel kernel, const Eigen::Ref<const Eigen::ArrayXd>& squared_distances,
                 Eigen::ArrayXd* correlation, Eigen::ArrayXd* slope);

}  // namespace powdercal

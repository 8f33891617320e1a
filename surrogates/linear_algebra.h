#pragma once

#include <Eigen/Core>

namespace powdercal {

/// Replaces the lower triangle L of a matrix by that of L⁻¹, by halves, in n³/3 operations (a
/// triangular solve with the identity takes three times as many). The upper triangle is untouched.
void InvertLowerTriangle(Eigen::Ref<Eigen::MatrixXd> matrix);

/// Lower triangle of AᵀA, for the lower triangle A of `matrix` (with A = L⁻¹: of the inverse of
/// LLᵀ), by halves, in n³/3 operations. The upper triangle of `gram` is not defined. No aliasing.
void LowerTriangleGram(const Eigen::Ref<const Eigen::MatrixXd>& matrix,
                       Eigen::Ref<Eigen::MatrixXd> gram);

}  // namespace powdercal

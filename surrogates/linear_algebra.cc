#include "surrogates/linear_algebra.h"

#include <Eigen/Dense>

namespace powdercal {
namespace {

constexpr Eigen::Index kBlock = 32;  // below it Eigen's own kernels are faster than more halving

}  // namespace

void InvertLowerTriangle(Eigen::Ref<Eigen::MatrixXd> matrix) {
  const Eigen::Index n = matrix.rows();
  if (n <= kBlock) {
    Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(n, n);
    matrix.triangularView<Eigen::Lower>().solveInPlace(inverse);
    matrix.triangularView<Eigen::Lower>() = inverse;
    return;
  }
  // [A 0; B C]⁻¹ = [A⁻¹ 0; −C⁻¹ B A⁻¹ C⁻¹]
  const Eigen::Index half = n / 2;
  auto a = matrix.topLeftCorner(half, half);
  auto b = matrix.bottomLeftCorner(n - half, half);
  auto c = matrix.bottomRightCorner(n - half, n - half);
  InvertLowerTriangle(a);
  InvertLowerTriangle(c);
  const Eigen::MatrixXd product = b * a.triangularView<Eigen::Lower>();
  b.noalias() = -(c.triangularView<Eigen::Lower>() * product);
}

void LowerTriangleGram(const Eigen::Ref<const Eigen::MatrixXd>& matrix,
                       Eigen::Ref<Eigen::MatrixXd> gram) {
  const Eigen::Index n = matrix.rows();
  if (n <= kBlock) {
    const Eigen::MatrixXd lower = matrix.triangularView<Eigen::Lower>();
    gram.noalias() = lower.transpose() * lower;
    return;
  }
  // [A 0; B C]ᵀ [A 0; B C] = [AᵀA + BᵀB, BᵀC; CᵀB, CᵀC]
  const Eigen::Index half = n / 2;
  const auto a = matrix.topLeftCorner(half, half);
  const auto b = matrix.bottomLeftCorner(n - half, half);
  const auto c = matrix.bottomRightCorner(n - half, n - half);
  LowerTriangleGram(a, gram.topLeftCorner(half, half));
  LowerTriangleGram(c, gram.bottomRightCorner(n - half, n - half));
  gram.topLeftCorner(half, half).selfadjointView<Eigen::Lower>().rankUpdate(b.transpose());
  gram.bottomLeftCorner(n - half, half).noalias() =
      c.transpose().triangularView<Eigen::Upper>() * b;
}

}  // namespace powdercal

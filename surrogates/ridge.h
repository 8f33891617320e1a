#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "surrogates/surrogate.h"

namespace powdercal {

/// Ridge regression (Hoerl & Kennard 1970, doi:10.1080/00401706.1970.10488634) on a polynomial:
/// all products of Legendre polynomials of 2u − 1, u being a coordinate of the unit box, up to a
/// total degree. The constant is not penalised. Degree and penalty are those of the least error by
/// leave-one-out, which has a closed form (Allen 1974, doi:10.1080/00401706.1974.10489157); of
/// equal ones the lower degree and the larger penalty. Noise variances are checked and not used.
///
/// The variance is that of the posterior of a linear model whose coefficients have the prior that
/// the penalty stands for (Bishop 2006, eq. 3.53–3.59), less the noise:
/// σ² (1/n + φᵀ(ΦᵀΦ + λI)⁻¹φ), with centred terms φ and σ² from the residuals. It grows beyond the
/// data; it does not know of structure that the polynomial lacks.
class Ridge final : public Surrogate {
 public:
  struct Options {
    int max_degree = 3;   ///< 1 … 6
    int max_terms = 500;  ///< ≥ 1; degrees above the first with more terms are not tried
    /// λ/n, > 0, to choose from.
    std::vector<double> penalties = {10,   3,    1,    0.3,  0.1,  0.03, 0.01,
                                     3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6};
  };

  Ridge() : Ridge(Options{}) {}
  explicit Ridge(Options options);

  const std::string& name() const override;
  void Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
           const Eigen::VectorXd& noise_variances) override;
  Prediction Predict(const Eigen::VectorXd& point) const override;
  std::string Describe() const override;

  int degree() const { return degree_; }
  double penalty() const { return penalty_; }  ///< λ/n
  /// Mean squared error by leave-one-out, λ and centre of the terms kept.
  double leave_one_out_error() const { return least_error_; }

 private:
  /// Everything below for the terms of one degree, with the best of the penalties.
  void Solve(const Eigen::MatrixXd& points, const Eigen::VectorXd& values);
  Eigen::RowVectorXd Terms(const Eigen::RowVectorXd& point) const;

  Options options_;
  int degree_ = 0;
  std::vector<std::vector<int>> terms_;  // degree of each coordinate's polynomial
  double penalty_ = 0;
  double least_error_ = 0;  // mean square by leave-one-out
  double noise_variance_ = 0;
  Eigen::Index count_ = 0;
  double mean_ = 0;
  Eigen::RowVectorXd centre_;     // mean of each term
  Eigen::MatrixXd directions_;    // eigenvectors of ΦᵀΦ, in columns
  Eigen::VectorXd squares_;       // its eigenvalues s²
  Eigen::VectorXd shrunk_;        // 1/(s² + λ)
  Eigen::VectorXd coefficients_;  // of the terms
};

}  // namespace powdercal

#pragma once

#include <Eigen/Core>

#include "surrogates/gaussian_process.h"

namespace powdercal {

/// A Gaussian process of which K outcomes at a set of points have been drawn from its posterior,
/// and which is, in each sample, the process that goes through them without noise. What is
/// uncertain at points that were evaluated, through noise, is thus averaged over instead of being
/// taken for known (Letham, Karrer, Ottoni & Bakshy 2019; Balandat et al. 2020).
///
/// The set is the process's own observations followed by `extra` (m × d): points under way, or that
/// failed, of which nothing is known but that they will have been evaluated. Hyperparameters are
/// the process's own. The variance is the same in all samples.
class SampledProcess {
 public:
  /// normals: K columns of n + m independent standard normals. Throws std::runtime_error where the
  /// covariance cannot be factorised.
  SampledProcess(const GaussianProcess& process, const Eigen::MatrixXd& extra,
                 const Eigen::MatrixXd& normals);

  /// Observations of the process, n.
  static Eigen::Index ObservationCount(const GaussianProcess& process);

  Eigen::Index sample_count() const { return weights_.cols(); }

  struct Point {
    Eigen::ArrayXd means;  ///< K
    double variance = 0;
    Eigen::MatrixXd mean_gradients;     ///< K × d
    Eigen::VectorXd variance_gradient;  ///< d
  };
  Point PosteriorAt(const Eigen::VectorXd& point, bool gradients) const;

  /// points: q × d; means: q × K; variances: q.
  void PredictMany(const Eigen::MatrixXd& points, Eigen::MatrixXd* means,
                   Eigen::VectorXd* variances) const;

 private:
  GaussianProcess process_;         // for its kernel, scales and inputs
  Eigen::MatrixXd inputs_;          // of the set
  Eigen::MatrixXd inverse_factor_;  // L⁻¹, LLᵀ the prior covariance of the set
  Eigen::MatrixXd weights_;         // its inverse times the samples, (n + m) × K
};

}  // namespace powdercal

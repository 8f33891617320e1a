#include "surrogates/sampled_process.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <stdexcept>

#include "surrogates/linear_algebra.h"

namespace powdercal {
namespace {

constexpr double kJitter = 1e-7;  // of the signal variance: points may all but coincide
constexpr double kLargestJitter = 1e-3;

// Cholesky factor of a covariance that may be singular to rounding.
Eigen::MatrixXd Factor(Eigen::MatrixXd covariance, double signal) {
  for (double jitter = kJitter; jitter <= kLargestJitter; jitter *= 10) {
    Eigen::MatrixXd shifted = covariance;
    shifted.diagonal().array() += jitter * signal;
    const Eigen::LLT<Eigen::MatrixXd> cholesky(shifted);
    if (cholesky.info() == Eigen::Success) return cholesky.matrixL();
  }
  throw std::runtime_error("sampled process: the covariance is not positive definite");
}

}  // namespace

Eigen::Index SampledProcess::ObservationCount(const GaussianProcess& process) {
  return process.points_.rows();
}

SampledProcess::SampledProcess(const GaussianProcess& process, const Eigen::MatrixXd& extra,
                               const Eigen::MatrixXd& normals)
    : process_(process) {
  const Eigen::Index known = process.points_.rows();
  const Eigen::Index size = known + extra.rows();
  if (normals.rows() != size) throw std::invalid_argument("SampledProcess: wrong sizes");
  inputs_.resize(size, process.points_.cols());
  inputs_.topRows(known) = process.points_;
  if (extra.rows() > 0) inputs_.bottomRows(extra.rows()) = process.options_.inputs.Map(extra);

  const double signal = process.hyperparameters_.signal_variance;
  const Eigen::MatrixXd prior = process.Covariance(inputs_, inputs_);
  const Eigen::MatrixXd whitened =
      process.inverse_factor_.triangularView<Eigen::Lower>() * prior.topRows(known);
  const Eigen::VectorXd mean = prior.topRows(known).transpose() * process.alpha_;
  const Eigen::MatrixXd posterior = prior - whitened.transpose() * whitened;
  const Eigen::MatrixXd samples = (Factor(posterior, signal) * normals).colwise() + mean;

  inverse_factor_ = Factor(prior, signal);
  InvertLowerTriangle(inverse_factor_);
  inverse_factor_.triangularView<Eigen::StrictlyUpper>().setZero();
  const Eigen::MatrixXd whitened_samples =
      inverse_factor_.triangularView<Eigen::Lower>() * samples;
  weights_ = inverse_factor_.transpose().triangularView<Eigen::Upper>() * whitened_samples;
}

SampledProcess::Point SampledProcess::PosteriorAt(const Eigen::VectorXd& point,
                                                  bool gradients) const {
  const double signal = process_.hyperparameters_.signal_variance;
  const double scale = process_.scale_;
  Eigen::MatrixXd jacobian;
  const Eigen::VectorXd covariance =
      process_.CovarianceAt(inputs_, point, gradients ? &jacobian : nullptr);
  const auto factor = inverse_factor_.triangularView<Eigen::Lower>();
  const Eigen::VectorXd whitened = factor * covariance;

  Point result;
  result.means = process_.offset_ + scale * (weights_.transpose() * covariance).array();
  result.variance = scale * scale * std::max(signal - whitened.squaredNorm(), kJitter * signal);
  if (!gradients) return result;
  const Eigen::VectorXd solved = factor.transpose() * whitened;
  const InputMap& inputs = process_.options_.inputs;
  result.mean_gradients = inputs.PullBack(point, scale * (weights_.transpose() * jacobian));
  result.variance_gradient =
      inputs.PullBack(point, (-2 * scale * scale) * (solved.transpose() * jacobian)).transpose();
  return result;
}

void SampledProcess::PredictMany(const Eigen::MatrixXd& points, Eigen::MatrixXd* means,
                                 Eigen::VectorXd* variances) const {
  const double signal = process_.hyperparameters_.signal_variance;
  const double scale = process_.scale_;
  const Eigen::MatrixXd covariance =
      process_.Covariance(inputs_, process_.options_.inputs.Map(points));
  const Eigen::MatrixXd whitened = inverse_factor_.triangularView<Eigen::Lower>() * covariance;
  *means = (scale * (covariance.transpose() * weights_)).array() + process_.offset_;
  *variances =
      (signal - whitened.colwise().squaredNorm().transpose().array()).max(kJitter * signal) *
      (scale * scale);
}

}  // namespace powdercal

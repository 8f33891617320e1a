#include "optimizers/least_squares/response_models.h"

#include <utility>

#include "optimizers/models.h"

namespace powdercal {
namespace {

constexpr double kOptimism = 2;  // standard deviations

// What docs/validation/optimizers.md was measured with; `bayesian` has a lower prior of noise.
ModelOptions OptionsOf(Kernel kernel) {
  return {.kernel = kernel, .noise_location = -6, .noise_scale = 2, .noise_floor = 1e-6};
}

}  // namespace

ResponseModels::ResponseModels(const SearchSpace& space, const Objectives& objectives,
                               const ObservationsById& observations, Kernel kernel) {
  const Residuals residuals(objectives, observations);
  Models models = FitResponses(space, Numbered(objectives), observations, OptionsOf(kernel));
  processes_ = std::move(models.processes);
  const std::vector<Eigen::Index> kept(models.targets.begin(), models.targets.end());
  targets_ = residuals.targets(kept);
  scales_ = residuals.scales(kept);
}

void ResponseModels::Evaluate(const Eigen::VectorXd& point, Eigen::VectorXd* residuals,
                              Eigen::MatrixXd* jacobian) const {
  residuals->resize(size());
  if (jacobian != nullptr) jacobian->resize(size(), point.size());
  Eigen::VectorXd gradient;
  for (Eigen::Index j = 0; j < size(); ++j) {
    const GaussianProcess& process = processes_[static_cast<std::size_t>(j)];
    const Prediction prediction = jacobian != nullptr
                                      ? process.PredictWithGradient(point, &gradient, nullptr)
                                      : process.Predict(point);
    (*residuals)[j] = (prediction.mean - targets_[j]) / scales_[j];
    if (jacobian != nullptr) jacobian->row(j) = gradient.transpose() / scales_[j];
  }
}

ResponseModels::Outlook ResponseModels::Predict(const Eigen::MatrixXd& points) const {
  const Eigen::ArrayXd zero = Eigen::ArrayXd::Zero(points.rows());
  Outlook outlook{zero, zero, zero};
  Eigen::VectorXd means;
  Eigen::VectorXd variances;
  for (Eigen::Index j = 0; j < size(); ++j) {
    processes_[static_cast<std::size_t>(j)].PredictMany(points, &means, &variances);
    const Eigen::ArrayXd distance = (means.array() - targets_[j]).abs() / scales_[j];
    const Eigen::ArrayXd variance = variances.array() / (scales_[j] * scales_[j]);
    outlook.chi2 += distance.square();
    outlook.optimistic += (distance - kOptimism * variance.sqrt()).max(0).square();
    outlook.variance += variance;
  }
  return outlook;
}

ResponseModels ResponseModels::ConditionedOn(const Eigen::MatrixXd& points) const {
  ResponseModels conditioned = *this;
  if (points.rows() == 0) return conditioned;
  for (GaussianProcess& process : conditioned.processes_) process = process.ConditionedOn(points);
  return conditioned;
}

}  // namespace powdercal

#include "optimizers/least_squares/response_models.h"

#include <algorithm>
#include <cmath>

namespace powdercal {
namespace {

constexpr Eigen::Index kMinObservations = 2;
constexpr double kOptimism = 2;  // standard deviations

struct Data {
  Eigen::MatrixXd points;
  Eigen::VectorXd values;
  Eigen::VectorXd variances;
};

Data DataOf(const ObservationsById& observations, Eigen::Index response, int dimension) {
  std::vector<const Observation*> known;
  for (const auto& [id, observation] : observations) {
    if (!observation.failed && !std::isnan(observation.responses[response])) {
      known.push_back(&observation);
    }
  }
  const auto n = static_cast<Eigen::Index>(known.size());
  Data data{Eigen::MatrixXd(n, dimension), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const Observation& observation = *known[static_cast<std::size_t>(i)];
    data.points.row(i) = observation.point.transpose();
    data.values[i] = observation.responses[response];
    data.variances[i] = observation.variances[response];
  }
  return data;
}

// As `bayesian` fits them.
GaussianProcess::Options ProcessOptions(Kernel kernel, const Data& data, double fallback_scale) {
  GaussianProcess::Options options;
  options.model.kernel = kernel;
  options.model.noise_location = -6;
  options.model.noise_scale = 2;
  options.model.lengthscale_spread = 1;
  options.fallback_scale = fallback_scale;
  if (data.values.maxCoeff() == data.values.minCoeff()) options.model.signal_variance = 1;
  return options;
}

}  // namespace

ResponseModels::ResponseModels(const Objectives& objectives, const ObservationsById& observations,
                               int dimension, Kernel kernel) {
  const Residuals residuals(objectives, observations);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index j = 0; j < residuals.size(); ++j) {
    const Data data = DataOf(observations, j, dimension);
    if (data.values.size() < kMinObservations) continue;
    const double sd = objectives.targets[static_cast<std::size_t>(j)].sd;
    const double scale = std::max(std::abs(data.values[0] - residuals.targets[j]), sd);
    GaussianProcess process(ProcessOptions(kernel, data, scale));
    process.Fit(data.points, data.values, data.variances);
    processes_.push_back(std::move(process));
    kept.push_back(j);
  }
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

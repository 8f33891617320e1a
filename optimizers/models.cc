#include "optimizers/models.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/statistics.h"

namespace powdercal {
namespace {

constexpr int kMinObservations = 2;  // for a process

// Observations of one scalar.
struct Series {
  std::vector<Eigen::VectorXd> points;
  std::vector<double> values;
  std::vector<double> variances;

  void Add(const Eigen::VectorXd& point, double value, double variance) {
    points.push_back(point);
    values.push_back(value);
    variances.push_back(std::isfinite(variance) && variance > 0 ? variance : 0);
  }
};

Eigen::VectorXd Vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

GaussianProcess FitProcess(const SearchSpace& space, const ModelOptions& models,
                           const Series& series, double fallback_scale) {
  GaussianProcess::Options options;
  options.model.kernel = models.kernel;
  options.model.noise_location = models.noise_location;
  options.model.noise_scale = models.noise_scale;
  options.model.noise_floor = models.noise_floor;
  // A weaker tie of the lengthscales finds inputs that do nothing sooner.
  options.model.lengthscale_spread = 1;
  options.fallback_scale = fallback_scale;
  options.inputs = InputsOf(space);
  options.warp = models.warp;
  // Without any spread in the data the learned scale of the function would shrink to nothing.
  const auto [low, high] = std::minmax_element(series.values.begin(), series.values.end());
  if (*low == *high) options.model.signal_variance = 1;
  GaussianProcess process(options);
  process.Fit(Rows(series.points, space.dimension()), Vector(series.values),
              Vector(series.variances));
  return process;
}

// Of chi² from those of the responses: w (f − t)², f normal.
double VarianceOfObjective(const Objectives& objectives, const Observation& observation) {
  double variance = 0;
  for (std::size_t j = 0; j < objectives.targets.size(); ++j) {
    const Target& target = objectives.targets[j];
    const auto index = static_cast<Eigen::Index>(j);
    const double v = observation.variances[index];
    if (!(v > 0)) continue;
    if (target.minimise) {
      variance += v / (target.sd * target.sd);
      continue;
    }
    const double w = 1 / (target.sd * target.sd + v);
    const double residual = observation.responses[index] - target.value;
    variance += w * w * (4 * residual * residual * v + 2 * v * v);
  }
  return variance;
}

}  // namespace

InputMap InputsOf(const SearchSpace& space) {
  std::vector<InputMap::Coordinate> coordinates;
  for (const Parameter& parameter : space.parameters) {
    const bool categorical = parameter.kind == Parameter::Kind::categorical;
    coordinates.push_back({.categories = categorical ? parameter.levels() : 0});
  }
  return InputMap(std::move(coordinates));
}

Models FitResponses(const SearchSpace& space, const Objectives& objectives,
                    const ObservationsById& observations, const ModelOptions& options) {
  Models models;
  std::vector<double> noise;
  std::set<int> known;  // objectives
  for (std::size_t j = 0; j < objectives.targets.size(); ++j) {
    const Target& target = objectives.targets[j];
    const auto index = static_cast<Eigen::Index>(j);
    Series series;
    for (const auto& [id, observation] : observations) {
      if (observation.failed || std::isnan(observation.responses[index])) continue;
      series.Add(observation.point, observation.responses[index], observation.variances[index]);
    }
    // A response that has not been seen yet waits; the others go on.
    if (series.values.size() < kMinObservations) continue;
    // If all values are equal they differ from the target by the scale that matters.
    const double scale = std::max(std::abs(series.values.front() - target.value), target.sd);
    models.processes.push_back(FitProcess(space, options, series, scale));
    models.targets.push_back(j);
    noise.push_back(UpperMedian(series.variances));
    known.insert(target.objective);
  }
  if (static_cast<int>(known.size()) < ObjectiveCount(objectives)) return {};
  models.noise_variances = Vector(noise);
  return models;
}

Models FitObjective(const SearchSpace& space, const Objectives& objectives,
                    const ObservationsById& observations, const ModelOptions& options) {
  Series series;
  for (const auto& [id, observation] : observations) {
    if (!Complete(observation)) continue;
    series.Add(observation.point,
               ChiSquared(objectives, observation.responses, observation.variances),
               VarianceOfObjective(objectives, observation));
  }
  if (series.values.size() < kMinObservations) return {};
  Models models;
  models.processes.push_back(
      FitProcess(space, options, series, std::max(1.0, std::abs(series.values.front()))));
  models.noise_variances = Eigen::ArrayXd::Constant(1, UpperMedian(series.variances));
  return models;
}

}  // namespace powdercal

#include "reports/response_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <vector>

#include "optimizers/models.h"
#include "surrogates/gaussian_process.h"

namespace powdercal {
namespace {

// A fit costs the cube of the number of points; a plot gains nothing from more than these.
constexpr std::size_t kMostPoints = 300;
constexpr std::size_t kFewestPoints = 3;

struct Sample {
  Eigen::VectorXd point;
  double value = 0;
  double variance = 0;
};

std::vector<Sample> Samples(const StudyResults& results, std::size_t target) {
  const SearchSpace space{results.parameters};
  std::vector<Sample> samples;
  for (const EvaluationResult& evaluation : results.history) {
    if (target >= evaluation.responses.size()) continue;
    const ResponseResult& response = evaluation.responses[target];
    if (!response.simulated || !std::isfinite(*response.simulated)) continue;
    Eigen::VectorXd values(space.dimension());
    for (int d = 0; d < space.dimension(); ++d) {
      const auto found = evaluation.parameters.find(space.parameters[d].name);
      values[d] = found == evaluation.parameters.end() ? NAN : found->second;
    }
    if (!values.allFinite()) continue;
    const double variance =
        response.replicates > 1 ? response.seed_sd * response.seed_sd / response.replicates : 0;
    samples.push_back({space.ToUnit(values), *response.simulated, variance});
  }
  if (samples.size() <= kMostPoints) return samples;
  std::vector<Sample> thinned;
  for (std::size_t i = 0; i < kMostPoints; ++i) {
    thinned.push_back(samples[i * (samples.size() - 1) / (kMostPoints - 1)]);
  }
  return thinned;
}

}  // namespace

ResponseSurface::ResponseSurface(const StudyResults& results, std::size_t target) {
  const std::vector<Sample> samples = Samples(results, target);
  const auto n = static_cast<Eigen::Index>(samples.size());
  point_count_ = static_cast<int>(n);
  if (samples.size() < kFewestPoints) {
    why_not_ =
        fmt::format("A response surface needs at least {} successful evaluations, there {} {}",
                    kFewestPoints, n == 1 ? "is" : "are", n);
    return;
  }
  Eigen::MatrixXd points(n, static_cast<Eigen::Index>(results.parameters.size()));
  Eigen::VectorXd values(n);
  Eigen::VectorXd variances(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    points.row(i) = samples[i].point.transpose();
    values[i] = samples[i].value;
    variances[i] = samples[i].variance;
  }
  try {
    GaussianProcess::Options options;
    options.inputs = InputsOf(SearchSpace{results.parameters});
    surrogate_ = std::make_unique<GaussianProcess>(std::move(options));
    surrogate_->Fit(points, values, variances);
  } catch (const std::exception& error) {
    // A report without this figure is better than none.
    why_not_ = fmt::format("No response surface could be fitted: {}", error.what());
  }
}

Prediction ResponseSurface::Predict(const Eigen::VectorXd& unit_point) const {
  return surrogate_->Predict(unit_point);
}

SurfaceGrid EvaluateGrid(const ResponseSurface& surface, const Eigen::VectorXd& base, int first,
                         int second, int nodes) {
  SurfaceGrid grid{Eigen::MatrixXd(nodes, nodes), Eigen::MatrixXd(nodes, nodes)};
  Eigen::VectorXd point = base;
  for (int i = 0; i < nodes; ++i) {
    for (int j = 0; j < nodes; ++j) {
      point[first] = static_cast<double>(i) / (nodes - 1);
      point[second] = static_cast<double>(j) / (nodes - 1);
      const Prediction prediction = surface.Predict(point);
      grid.mean(i, j) = prediction.mean;
      grid.sd(i, j) = std::sqrt(std::max(0.0, prediction.variance));
    }
  }
  return grid;
}

}  // namespace powdercal

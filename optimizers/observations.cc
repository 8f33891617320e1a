#include "optimizers/observations.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "optimizers/designs/design.h"

namespace powdercal {

void CheckSizes(std::string_view optimizer, const Observation& observation, int dimension,
                const Objectives& objectives) {
  const auto count = static_cast<Eigen::Index>(objectives.targets.size());
  const Eigen::Index responses = observation.responses.size();
  const Eigen::Index variances = observation.variances.size();
  const bool sizes_agree =
      observation.failed || (responses == count && (variances == 0 || variances == count));
  if (observation.point.size() == dimension && sizes_agree) return;
  throw std::invalid_argument(
      fmt::format("{}: observation {} has {} parameters, {} responses and {} variances, expected "
                  "{}, {} and {}",
                  optimizer, observation.id, observation.point.size(), responses, variances,
                  dimension, count, count));
}

Observation CheckedObservation(std::string_view optimizer, const Observation& observation,
                               int dimension, const Objectives& objectives) {
  CheckSizes(optimizer, observation, dimension, objectives);
  Observation checked = observation;
  if (checked.failed) return checked;
  if (checked.variances.size() == 0) {
    checked.variances = Eigen::VectorXd::Zero(checked.responses.size());
  }
  for (double& variance : checked.variances) {
    if (!std::isfinite(variance) || variance < 0) variance = 0;
  }
  // Infinite responses are as absent as NaN ones; without any response it is a failure.
  for (double& response : checked.responses) {
    if (!std::isfinite(response)) response = std::numeric_limits<double>::quiet_NaN();
  }
  checked.failed = checked.responses.array().isNaN().all();
  return checked;
}

bool Complete(const Observation& observation) {
  return !observation.failed && observation.responses.allFinite();
}

Eigen::MatrixXd Rows(const std::vector<Eigen::VectorXd>& points, Eigen::Index dimension) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(points.size()), dimension);
  for (std::size_t i = 0; i < points.size(); ++i) {
    rows.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
  }
  return rows;
}

Feasibility LearnFeasibility(const ObservationsById& observations, int dimension) {
  std::vector<Eigen::VectorXd> points;
  Eigen::VectorXd successes(static_cast<Eigen::Index>(observations.size()));
  for (const auto& [id, observation] : observations) {
    successes[static_cast<Eigen::Index>(points.size())] =
        observation.failed ? 0 : observation.responses.array().isFinite().cast<double>().mean();
    points.push_back(observation.point);
  }
  return Feasibility(Rows(points, dimension), successes);
}

Eigen::MatrixXd TakenPoints(const ObservationsById& observations, const PointsById& pending,
                            int dimension) {
  std::vector<Eigen::VectorXd> points;
  for (const auto& [id, observation] : observations) points.push_back(observation.point);
  for (const auto& [id, point] : pending) points.push_back(point);
  return Rows(points, dimension);
}

bool IsTaken(const Eigen::MatrixXd& taken, const Eigen::VectorXd& point) {
  return taken.rows() > 0 &&
         (taken.rowwise() - point.transpose()).rowwise().norm().minCoeff() <= kDuplicateRadius;
}

Eigen::VectorXd FarthestPoint(const Eigen::MatrixXd& taken, int dimension, int trials,
                              std::uint64_t seed) {
  const Eigen::MatrixXd points = SobolPoints(trials, dimension, seed);
  Eigen::Index farthest = 0;
  double distance = -1;
  for (Eigen::Index i = 0; i < points.rows() && taken.rows() > 0; ++i) {
    const double nearest = (taken.rowwise() - points.row(i)).rowwise().squaredNorm().minCoeff();
    if (nearest > distance) {
      distance = nearest;
      farthest = i;
    }
  }
  return points.row(farthest).transpose();
}

}  // namespace powdercal

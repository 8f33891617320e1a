#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string_view>
#include <vector>

#include "optimizers/feasibility.h"
#include "optimizers/optimizer.h"

namespace powdercal {

/// By id, each as last told, so that the order of telling makes no difference, not even of
/// rounding.
using ObservationsById = std::map<std::int64_t, Observation>;
/// Points that were asked for and not told of, by id.
using PointsById = std::map<std::int64_t, Eigen::VectorXd>;

/// Throws std::invalid_argument, naming the optimizer, unless the observation has `dimension`
/// parameters and, if it has not failed, a response for every target and as many variances or none.
void CheckSizes(std::string_view optimizer, const Observation& observation, int dimension,
                const Objectives& objectives);
/// The observation with all variances (0 where unknown) and with NaN for any response that is not
/// finite; failed where no response is left. Throws as CheckSizes.
Observation CheckedObservation(std::string_view optimizer, const Observation& observation,
                               int dimension, const Objectives& objectives);

/// Succeeded, with all of its responses.
bool Complete(const Observation& observation);

/// Points as the rows of a matrix.
Eigen::MatrixXd Rows(const std::vector<Eigen::VectorXd>& points, Eigen::Index dimension);

/// Where evaluations succeed, in the unit box of `dimension` parameters.
Feasibility LearnFeasibility(const ObservationsById& observations, int dimension);

/// Points as rows that are evaluated or under way.
Eigen::MatrixXd TakenPoints(const ObservationsById& observations, const PointsById& pending,
                            int dimension);
/// Closer together, in the unit box, points count as the same.
inline constexpr double kDuplicateRadius = 1e-6;
/// Whether the point is one of the rows of `taken`.
bool IsTaken(const Eigen::MatrixXd& taken, const Eigen::VectorXd& point);
/// Of the first `trials` points of a Sobol' sequence the one farthest from all rows of `taken`; the
/// first where there are none.
Eigen::VectorXd FarthestPoint(const Eigen::MatrixXd& taken, int dimension, int trials,
                              std::uint64_t seed);

}  // namespace powdercal

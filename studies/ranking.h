#pragma once

#include <Eigen/Core>
#include <vector>

#include "optimizers/optimizer.h"
#include "studies/evaluation.h"

namespace powdercal {

/// What the points of a study are ranked by, the lower the better, ∞ where a response is missing.
///
/// The lowest of many noisy misfits is a lucky one. Once replicates have shown how much particle
/// seeds scatter and there are enough points (8, and 2(d + 1)), a point is therefore judged by all
/// of them together: the expected squared misfit Σ ((m − target)² + v)/sd² with m and v the mean
/// and variance at the point of Gaussian processes fitted to the responses of all points, each with
/// its seed variance. Before that, and where no process can be fitted, by its own mean
/// (ExpectedMisfit).
///
/// points: in the unit box; reduced: as long. A function of its arguments alone.
std::vector<double> RankingMisfits(const SearchSpace& space, const Objectives& objectives,
                                   const std::vector<Eigen::VectorXd>& points,
                                   const std::vector<ReducedResponses>& reduced);

}  // namespace powdercal

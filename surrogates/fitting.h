#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <string_view>
#include <vector>

#include "core/random.h"

namespace powdercal {

// What the regressions share: checks, scales, folds.

/// Throws std::invalid_argument, naming the surrogate, unless there is at least one point of at
/// least one entry, one value for each, none or one noise variance for each, all of them finite and
/// no variance negative.
void CheckObservations(std::string_view surrogate, const Eigen::MatrixXd& points,
                       const Eigen::VectorXd& values, const Eigen::VectorXd& noise_variances);

/// Variance of predictions where a single observation says nothing about errors.
inline constexpr double kUnknownVariance = std::numeric_limits<double>::infinity();

/// Mean and standard deviation of values (divisor n − 1).
struct Standardisation {
  double offset = 0;
  double scale = 1;  ///< > 0; 1 where the values are equal but for rounding

  Eigen::VectorXd Apply(const Eigen::VectorXd& values) const {
    return (values.array() - offset) / scale;
  }
};
Standardisation Standardise(const Eigen::VectorXd& values);

/// The fold, 0 … count − 1, of each of n observations: sizes differ by one at most. Requires
/// 1 ≤ count ≤ n.
std::vector<int> RandomFolds(Eigen::Index n, int count, RandomStream& random);

/// Rows outside and inside of a fold, ascending.
struct Split {
  std::vector<Eigen::Index> fitted;
  std::vector<Eigen::Index> predicted;
};
Split SplitAt(const std::vector<int>& folds, int fold);

/// Folds that a surrogate may choose its hyperparameters by, the same at every call: each
/// observation for itself up to `max_folds` of them, else `max_folds` random folds.
std::vector<int> SelectionFolds(Eigen::Index n, int max_folds);

/// Predictions at `targets` (m × d) by fits to points and values: m × c, a column for each of c
/// candidates.
using CandidateFits = std::function<Eigen::MatrixXd(
    const Eigen::MatrixXd& points, const Eigen::VectorXd& values, const Eigen::MatrixXd& targets)>;
/// Mean squared error of each candidate, every fold being predicted from all the others. Requires
/// two folds at least.
Eigen::VectorXd CrossValidatedErrors(const std::vector<int>& folds, const Eigen::MatrixXd& points,
                                     const Eigen::VectorXd& values, const CandidateFits& fits);

}  // namespace powdercal

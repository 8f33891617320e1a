#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "surrogates/surrogate.h"

namespace powdercal {

// How well a surrogate predicts what it was not fitted to. Every fit chooses its hyperparameters
// anew from the observations that it is given, so that none of them has seen what is predicted.
// R² is the coefficient of determination, 1 − Σ (yᵢ − ŷᵢ)² / Σ (yᵢ − ȳ)² over what was predicted:
// 1 at best, 0 for its mean, negative for worse.
//
// All throw std::invalid_argument for fewer than 3 points, or where points and values differ in
// number or a value is not finite, and pass on what the fits throw. points: n × d; values: n.

using SurrogateMaker = std::function<std::unique_ptr<Surrogate>()>;
/// Makes the surrogate of that name with its defaults.
SurrogateMaker MakerOf(const std::string& name);

struct CrossPrediction {
  Eigen::VectorXd predicted;  ///< n, each by a fit to all the others
  double r2 = 0;              ///< NaN where all values are equal
  double rmse = 0;            ///< root of the mean squared error, in the units of the values
};
CrossPrediction LeaveOneOut(const SurrogateMaker& make, const Eigen::MatrixXd& points,
                            const Eigen::VectorXd& values);

/// Of several random partitions. R² of few points scatters widely: a single partition says little.
struct RepeatedAccuracy {
  std::vector<double>
      r2;           ///< of each partition; those whose predicted values are all equal are left out
  double rmse = 0;  ///< over all of them
  double median_r2() const;  ///< NaN without any
};
/// Every point is predicted once in each repeat, by a fit to all folds but its own.
/// 2 ≤ folds ≤ n, repeats ≥ 1.
RepeatedAccuracy KFold(const SurrogateMaker& make, const Eigen::MatrixXd& points,
                       const Eigen::VectorXd& values, int folds, int repeats, std::uint64_t seed);
/// In each repeat ⌈share n⌉ random points, two at least and all but two at most, are predicted by a
/// fit to the others. R² is taken about their own mean. 0 < share < 1, repeats ≥ 1.
RepeatedAccuracy HoldOut(const SurrogateMaker& make, const Eigen::MatrixXd& points,
                         const Eigen::VectorXd& values, double share, int repeats,
                         std::uint64_t seed);

/// One surrogate in a comparison.
struct SurrogateScore {
  std::string name;
  double r2 = 0;        ///< by leave-one-out; NaN where there is none
  std::string why_not;  ///< why there is none; "" otherwise
};
/// R² that differ by less count as equal.
inline constexpr double kEqualR2 = 0.01;
/// The highest R² by leave-one-out; of those within kEqualR2 of it the simplest, in the order
/// ridge, nearest_neighbours, gaussian_process, support_vector, random_forest, gradient_boosting.
/// The simplest of all where none has an R². `scores` must not be empty.
const SurrogateScore& BestOf(std::span<const SurrogateScore> scores);
/// BestOf() of all surrogates on these observations; a surrogate that cannot be fitted has a score
/// without R².
SurrogateScore SelectBest(const Eigen::MatrixXd& points, const Eigen::VectorXd& values);

}  // namespace powdercal

#include "surrogates/fitting.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace powdercal {

void CheckObservations(std::string_view surrogate, const Eigen::MatrixXd& points,
                       const Eigen::VectorXd& values, const Eigen::VectorXd& noise_variances) {
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(fmt::format("{}: {}", surrogate, why));
  };
  const Eigen::Index n = points.rows();
  if (n == 0 || points.cols() == 0) refuse("no observations");
  if (values.size() != n || (noise_variances.size() != 0 && noise_variances.size() != n)) {
    refuse(fmt::format("{} points, {} values, {} noise variances", n, values.size(),
                       noise_variances.size()));
  }
  if (!points.allFinite() || !values.allFinite() || !noise_variances.allFinite()) {
    refuse("an observation is not finite");
  }
  if ((noise_variances.array() < 0).any()) refuse("a noise variance is negative");
}

Standardisation Standardise(const Eigen::VectorXd& values) {
  Standardisation result{.offset = values.mean()};
  if (values.size() < 2) return result;
  const double sum = (values.array() - result.offset).square().sum();
  const double sd = std::sqrt(sum / static_cast<double>(values.size() - 1));
  if (sd > 1e-12 * std::max(std::abs(result.offset), 1e-290)) result.scale = sd;
  return result;
}

std::vector<int> RandomFolds(Eigen::Index n, int count, RandomStream& random) {
  assert(count >= 1 && count <= n);
  std::vector<int> folds(static_cast<std::size_t>(n));
  for (std::size_t i = 0; i < folds.size(); ++i) {
    folds[i] = static_cast<int>(i % static_cast<std::size_t>(count));
  }
  random.Shuffle(std::span(folds));
  return folds;
}

Split SplitAt(const std::vector<int>& folds, int fold) {
  Split split;
  for (std::size_t i = 0; i < folds.size(); ++i) {
    auto& side = folds[i] == fold ? split.predicted : split.fitted;
    side.push_back(static_cast<Eigen::Index>(i));
  }
  return split;
}

std::vector<int> SelectionFolds(Eigen::Index n, int max_folds) {
  if (n <= max_folds) {
    std::vector<int> folds(static_cast<std::size_t>(n));
    std::iota(folds.begin(), folds.end(), 0);
    return folds;
  }
  RandomStream random(1);
  return RandomFolds(n, max_folds, random);
}

Eigen::VectorXd CrossValidatedErrors(const std::vector<int>& folds, const Eigen::MatrixXd& points,
                                     const Eigen::VectorXd& values, const CandidateFits& fits) {
  const int count = 1 + *std::max_element(folds.begin(), folds.end());
  assert(count >= 2);
  Eigen::VectorXd errors;
  for (int fold = 0; fold < count; ++fold) {
    const Split split = SplitAt(folds, fold);
    const Eigen::MatrixXd predictions = fits(points(split.fitted, Eigen::all), values(split.fitted),
                                             points(split.predicted, Eigen::all));
    const Eigen::VectorXd observed = values(split.predicted);
    if (errors.size() == 0) errors = Eigen::VectorXd::Zero(predictions.cols());
    errors += (predictions.colwise() - observed).colwise().squaredNorm().transpose();
  }
  return errors / static_cast<double>(values.size());
}

}  // namespace powdercal

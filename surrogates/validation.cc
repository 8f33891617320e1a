#include "surrogates/validation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/random.h"
#include "core/statistics.h"
#include "surrogates/fitting.h"

namespace powdercal {
namespace {

constexpr Eigen::Index kFewestPoints = 3;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

const std::array<std::string, 6> kFromTheSimplest = {
    "ridge",          "nearest_neighbours", "gaussian_process",
    "support_vector", "random_forest",      "gradient_boosting"};

void Check(const Eigen::MatrixXd& points, const Eigen::VectorXd& values) {
  CheckObservations("validation", points, values, {});
  if (points.rows() < kFewestPoints) {
    throw std::invalid_argument(
        fmt::format("validation: {} points; at least {} are needed", points.rows(), kFewestPoints));
  }
}

void PredictSplit(const SurrogateMaker& make, const Eigen::MatrixXd& points,
                  const Eigen::VectorXd& values, const Split& split, Eigen::VectorXd* predicted) {
  const std::unique_ptr<Surrogate> surrogate = make();
  surrogate->Fit(points(split.fitted, Eigen::all), values(split.fitted), {});
  for (const Eigen::Index i : split.predicted) {
    (*predicted)[i] = surrogate->Predict(points.row(i).transpose()).mean;
  }
}

Eigen::VectorXd PredictFolds(const SurrogateMaker& make, const Eigen::MatrixXd& points,
                             const Eigen::VectorXd& values, const std::vector<int>& folds,
                             int count) {
  Eigen::VectorXd predicted(values.size());
  for (int fold = 0; fold < count; ++fold) {
    PredictSplit(make, points, values, SplitAt(folds, fold), &predicted);
  }
  return predicted;
}

double R2(const Eigen::VectorXd& values, const Eigen::VectorXd& predicted) {
  if (values.minCoeff() == values.maxCoeff()) return kNone;
  return 1 - (predicted - values).squaredNorm() / (values.array() - values.mean()).square().sum();
}

// Collects partitions of one kind.
class Tally {
 public:
  void Add(const Eigen::VectorXd& values, const Eigen::VectorXd& predicted) {
    squares_ += (predicted - values).squaredNorm();
    count_ += static_cast<double>(values.size());
    const double r2 = R2(values, predicted);
    if (!std::isnan(r2)) accuracy_.r2.push_back(r2);
  }
  RepeatedAccuracy Finish() {
    accuracy_.rmse = std::sqrt(squares_ / count_);
    return std::move(accuracy_);
  }

 private:
  RepeatedAccuracy accuracy_;
  double squares_ = 0;
  double count_ = 0;
};

std::size_t Complexity(const std::string& name) {
  return static_cast<std::size_t>(
      std::find(kFromTheSimplest.begin(), kFromTheSimplest.end(), name) - kFromTheSimplest.begin());
}

}  // namespace

SurrogateMaker MakerOf(const std::string& name) {
  return [name] { return MakeSurrogate(name); };
}

CrossPrediction LeaveOneOut(const SurrogateMaker& make, const Eigen::MatrixXd& points,
                            const Eigen::VectorXd& values) {
  Check(points, values);
  const auto n = static_cast<int>(values.size());
  CrossPrediction result;
  result.predicted = PredictFolds(make, points, values, SelectionFolds(n, n), n);
  result.r2 = R2(values, result.predicted);
  result.rmse = std::sqrt((result.predicted - values).squaredNorm() / n);
  return result;
}

double RepeatedAccuracy::median_r2() const { return Median(r2); }

RepeatedAccuracy KFold(const SurrogateMaker& make, const Eigen::MatrixXd& points,
                       const Eigen::VectorXd& values, int folds, int repeats, std::uint64_t seed) {
  Check(points, values);
  if (folds < 2 || folds > values.size() || repeats < 1) {
    throw std::invalid_argument(
        fmt::format("validation: {} folds of {} points, {} times", folds, values.size(), repeats));
  }
  const RandomStream random = RandomStream(seed).Split("k-fold");
  Tally tally;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    RandomStream own = random.Split(static_cast<std::uint64_t>(repeat));
    tally.Add(values,
              PredictFolds(make, points, values, RandomFolds(values.size(), folds, own), folds));
  }
  return tally.Finish();
}

RepeatedAccuracy HoldOut(const SurrogateMaker& make, const Eigen::MatrixXd& points,
                         const Eigen::VectorXd& values, double share, int repeats,
                         std::uint64_t seed) {
  Check(points, values);
  if (!(share > 0 && share < 1) || repeats < 1) {
    throw std::invalid_argument(
        fmt::format("validation: a share of {} held out, {} times", share, repeats));
  }
  const RandomStream random = RandomStream(seed).Split("hold-out");
  const auto n = static_cast<double>(values.size());
  // Three points leave one for the fit.
  const auto held =
      static_cast<Eigen::Index>(std::clamp(std::ceil(share * n), 2.0, std::max(2.0, n - 2)));
  Tally tally;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    RandomStream own = random.Split(static_cast<std::uint64_t>(repeat));
    std::vector<int> order = SelectionFolds(values.size(), static_cast<int>(values.size()));
    own.Shuffle(std::span(order));
    std::vector<int> sides(order.size(), 0);
    for (Eigen::Index i = 0; i < held; ++i) {
      sides[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])] = 1;
    }
    const Split split = SplitAt(sides, 1);
    Eigen::VectorXd predicted(values.size());
    PredictSplit(make, points, values, split, &predicted);
    tally.Add(values(split.predicted), predicted(split.predicted));
  }
  return tally.Finish();
}

const SurrogateScore& BestOf(std::span<const SurrogateScore> scores) {
  assert(!scores.empty());
  double highest = -std::numeric_limits<double>::infinity();
  for (const SurrogateScore& score : scores) {
    if (score.r2 > highest) highest = score.r2;
  }
  const SurrogateScore* best = nullptr;
  for (const SurrogateScore& score : scores) {
    const bool eligible =
        std::isinf(highest) || score.r2 > highest - kEqualR2 || score.r2 == highest;
    if (!eligible) continue;
    if (best == nullptr || Complexity(score.name) < Complexity(best->name)) best = &score;
  }
  return *best;
}

SurrogateScore SelectBest(const Eigen::MatrixXd& points, const Eigen::VectorXd& values) {
  Check(points, values);
  std::vector<SurrogateScore> scores;
  for (const std::string& name : SurrogateNames()) {
    SurrogateScore score{.name = name};
    try {
      score.r2 = LeaveOneOut(MakerOf(name), points, values).r2;
      if (std::isnan(score.r2)) score.why_not = "all values are equal";
    } catch (const std::exception& error) {
      score.r2 = kNone;
      score.why_not = error.what();
    }
    scores.push_back(std::move(score));
  }
  return BestOf(scores);
}

}  // namespace powdercal

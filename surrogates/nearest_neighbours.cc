#include "surrogates/nearest_neighbours.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <nanoflann.hpp>
#include <vector>

#include "surrogates/fitting.h"

namespace powdercal {
namespace {

constexpr int kLeafSize = 10;

struct Neighbour {
  Eigen::Index index = 0;
  double squared_distance = 0;
};

// Of the first k neighbours; those at no distance take all where distances count.
Eigen::VectorXd Weights(const std::vector<Neighbour>& neighbours, int k, int power) {
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(k);
  if (power == 0) return weights;
  const bool hit = neighbours.front().squared_distance == 0;
  for (int i = 0; i < k; ++i) {
    const double square = neighbours[static_cast<std::size_t>(i)].squared_distance;
    // Relative to the nearest, so that nothing overflows.
    weights[i] = hit ? (square == 0 ? 1.0 : 0.0)
                     : std::pow(neighbours.front().squared_distance / square, 0.5 * power);
  }
  return weights;
}

Eigen::VectorXd ValuesOf(const std::vector<Neighbour>& neighbours, int k,
                         const Eigen::VectorXd& values) {
  Eigen::VectorXd theirs(k);
  for (int i = 0; i < k; ++i) theirs[i] = values[neighbours[static_cast<std::size_t>(i)].index];
  return theirs;
}

}  // namespace

class NearestNeighbours::Tree {
 public:
  explicit Tree(const Eigen::MatrixXd& points)
      : points_(points), index_(points_.cols(), std::cref(points_), kLeafSize) {}

  // By ascending distance, of equal ones by index; at most as many as there are points.
  std::vector<Neighbour> Nearest(const Eigen::VectorXd& point, int count) const {
    const auto wanted = static_cast<std::size_t>(std::min<Eigen::Index>(count, points_.rows()));
    std::vector<Eigen::Index> indices(wanted);
    std::vector<double> squares(wanted);
    nanoflann::KNNResultSet<double, Eigen::Index> found(wanted);
    found.init(indices.data(), squares.data());
    index_.index->findNeighbors(found, point.data(), nanoflann::SearchParams());
    std::vector<Neighbour> neighbours(wanted);
    for (std::size_t i = 0; i < wanted; ++i) neighbours[i] = {indices[i], squares[i]};
    std::sort(neighbours.begin(), neighbours.end(), [](const Neighbour& a, const Neighbour& b) {
      return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance
                                                      : a.index < b.index;
    });
    return neighbours;
  }
  Eigen::Index dimension() const { return points_.cols(); }

 private:
  Eigen::MatrixXd points_;  // the index refers to it
  nanoflann::KDTreeEigenMatrixAdaptor<Eigen::MatrixXd> index_;
};

NearestNeighbours::NearestNeighbours(Options options) : options_(options) {
  assert(options_.max_neighbours >= 1 && options_.max_power >= 0);
}
NearestNeighbours::~NearestNeighbours() = default;

const std::string& NearestNeighbours::name() const {
  static const std::string kName = "nearest_neighbours";
  return kName;
}

void NearestNeighbours::Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
                            const Eigen::VectorXd& noise_variances) {
  CheckObservations(name(), points, values, noise_variances);
  tree_ = std::make_unique<const Tree>(points);
  values_ = values;
  neighbours_ = 1;
  power_ = 0;
  leave_one_out_error_ = kUnknownVariance;
  if (values.size() > 1) Select(points);
}

void NearestNeighbours::Select(const Eigen::MatrixXd& points) {
  const auto n = static_cast<int>(values_.size());
  const int largest = std::min(options_.max_neighbours, n - 1);
  Eigen::MatrixXd errors = Eigen::MatrixXd::Zero(largest, options_.max_power + 1);
  for (int i = 0; i < n; ++i) {
    std::vector<Neighbour> others = tree_->Nearest(points.row(i).transpose(), largest + 1);
    const auto self = std::find_if(others.begin(), others.end(),
                                   [&](const Neighbour& one) { return one.index == i; });
    // Among more duplicates than were asked for the point itself may be missing.
    others.erase(self == others.end() ? others.end() - 1 : self);
    for (int k = 1; k <= largest; ++k) {
      const Eigen::VectorXd theirs = ValuesOf(others, k, values_);
      for (int power = 0; power <= options_.max_power; ++power) {
        const Eigen::VectorXd weights = Weights(others, k, power);
        const double error = weights.dot(theirs) / weights.sum() - values_[i];
        errors(k - 1, power) += error * error / n;
      }
    }
  }
  for (int k = 1; k <= largest; ++k) {
    for (int power = 0; power <= options_.max_power; ++power) {
      if (errors(k - 1, power) >= leave_one_out_error_) continue;
      leave_one_out_error_ = errors(k - 1, power);
      neighbours_ = k;
      power_ = power;
    }
  }
}

Prediction NearestNeighbours::Predict(const Eigen::VectorXd& point) const {
  assert(tree_ && tree_->dimension() == point.size());
  const std::vector<Neighbour> nearest = tree_->Nearest(point, neighbours_);
  const Eigen::VectorXd theirs = ValuesOf(nearest, neighbours_, values_);
  const Eigen::VectorXd weights = Weights(nearest, neighbours_, power_);
  const Eigen::VectorXd shares = weights / weights.sum();
  const double mean = shares.dot(theirs);
  const double freedom = 1 - shares.squaredNorm();
  if (freedom < 1e-9) return {.mean = mean, .variance = leave_one_out_error_};
  return {.mean = mean,
          .variance = shares.dot((theirs.array() - mean).square().matrix()) / freedom};
}

std::string NearestNeighbours::Describe() const {
  if (!tree_) return "nearest neighbours, not fitted";
  return fmt::format("nearest neighbours, {} points, k = {}, {}", values_.size(), neighbours_,
                     power_ == 0 ? "equal weights" : fmt::format("weights 1/d^{}", power_));
}

}  // namespace powdercal

#include "surrogates/input_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace powdercal {
namespace {

// Off the ends, where the slope of a warp may be infinite.
constexpr double kEnd = 1e-6;

bool Warped(const InputMap::Coordinate& coordinate) {
  return coordinate.a != 1 || coordinate.b != 1;
}

double Warp(const InputMap::Coordinate& c, double x) {
  return 1 - std::pow(1 - std::pow(std::clamp(x, kEnd, 1 - kEnd), c.a), c.b);
}

double WarpSlope(const InputMap::Coordinate& c, double x) {
  const double u = std::clamp(x, kEnd, 1 - kEnd);
  return c.a * c.b * std::pow(u, c.a - 1) * std::pow(1 - std::pow(u, c.a), c.b - 1);
}

}  // namespace

InputMap::InputMap(std::vector<Coordinate> coordinates) : coordinates_(std::move(coordinates)) {}

bool InputMap::identity() const {
  return std::none_of(coordinates_.begin(), coordinates_.end(), [](const Coordinate& coordinate) {
    return coordinate.categories > 0 || Warped(coordinate);
  });
}

Eigen::Index InputMap::InputCount(Eigen::Index dimension) const {
  Eigen::Index count = dimension;
  for (const Coordinate& coordinate : coordinates_) {
    if (coordinate.categories > 0) count += coordinate.categories - 1;
  }
  return count;
}

Eigen::MatrixXd InputMap::Map(const Eigen::MatrixXd& points) const {
  if (identity()) return points;
  assert(points.cols() == static_cast<Eigen::Index>(coordinates_.size()));
  Eigen::MatrixXd inputs = Eigen::MatrixXd::Zero(points.rows(), InputCount(points.cols()));
  Eigen::Index input = 0;
  for (std::size_t k = 0; k < coordinates_.size(); ++k) {
    const Coordinate& coordinate = coordinates_[k];
    const auto column = static_cast<Eigen::Index>(k);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const double x = points(i, column);
      if (coordinate.categories > 0) {
        const double level = std::floor(std::clamp(x, 0.0, 1.0) * coordinate.categories);
        inputs(i, input + static_cast<Eigen::Index>(std::min(level, coordinate.categories - 1.0))) =
            1;
      } else {
        inputs(i, input) = Warped(coordinate) ? Warp(coordinate, x) : x;
      }
    }
    input += std::max(1, coordinate.categories);
  }
  return inputs;
}

Eigen::MatrixXd InputMap::PullBack(const Eigen::VectorXd& point,
                                   const Eigen::MatrixXd& gradients) const {
  if (identity()) return gradients;
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(gradients.rows(), point.size());
  Eigen::Index input = 0;
  for (std::size_t k = 0; k < coordinates_.size(); ++k) {
    const Coordinate& coordinate = coordinates_[k];
    const auto column = static_cast<Eigen::Index>(k);
    if (coordinate.categories == 0) {
      const double slope = Warped(coordinate) ? WarpSlope(coordinate, point[column]) : 1;
      result.col(column) = slope * gradients.col(input);
    }
    input += std::max(1, coordinate.categories);
  }
  return result;
}

}  // namespace powdercal

#pragma once

#include <Eigen/Core>
#include <vector>

namespace powdercal {

/// From points of the unit box to the inputs of a regression: a continuous coordinate goes through
/// a warp w(x) = 1 − (1 − xᵃ)ᵇ (the distribution function of Kumaraswamy 1980, used for this by
/// Snoek, Swersky, Zemel & Adams 2014 in its beta form), which stretches where the response changes
/// fast; a = b = 1 is none. A categorical one with n levels, which have no order, becomes n inputs
/// that are 0 or 1 (Garrido-Merchán & Hernández-Lobato 2020).
class InputMap {
 public:
  struct Coordinate {
    int categories = 0;  ///< 0: a number
    double a = 1;        ///< > 0
    double b = 1;        ///< > 0
  };

  InputMap() = default;  ///< identity
  explicit InputMap(std::vector<Coordinate> coordinates);

  /// Neither warps nor categories.
  bool identity() const;
  const std::vector<Coordinate>& coordinates() const { return coordinates_; }
  /// Number of inputs for points of the given dimension.
  Eigen::Index InputCount(Eigen::Index dimension) const;

  /// points: n × d; result: n × InputCount(d).
  Eigen::MatrixXd Map(const Eigen::MatrixXd& points) const;
  /// Gradients by the point from gradients by the inputs, one per row of `gradients` (m × inputs);
  /// 0 for categories. Result: m × d.
  Eigen::MatrixXd PullBack(const Eigen::VectorXd& point, const Eigen::MatrixXd& gradients) const;

 private:
  std::vector<Coordinate> coordinates_;
};

}  // namespace powdercal

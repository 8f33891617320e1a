#pragma once

#include <Eigen/Core>

namespace powdercal {

/// How likely an evaluation is to succeed, learned from where evaluations succeeded and failed:
///   p(x) = (a + Σ_i s_i k(x, x_i)) / (a + Σ_i k(x, x_i)),  k = exp(−|x − x_i|² / 2 l²),  a = ½,
/// with s_i in [0, 1] the fraction of the responses of point i that came out. Far from all
/// failures, and everywhere while there are none, p = 1; at a lone failure 1/3; where evaluations
/// keep failing it falls as 1/n but never to 0: failures discourage, they do not forbid. The width
/// l is the one of {0.05, 0.1, 0.2, 0.4} √d with which the points predict each other's success best
/// (largest likelihood of each from all the others).
class Feasibility {
 public:
  /// points: n × d; successes: n, in [0, 1].
  Feasibility(const Eigen::MatrixXd& points, const Eigen::VectorXd& successes);

  /// ln p(point); adds its gradient to `gradient` unless null.
  double LogProbability(const Eigen::VectorXd& point, Eigen::VectorXd* gradient) const;
  double width() const { return width_; }

 private:
  double LeaveOneOutLikelihood(double width) const;

  Eigen::MatrixXd points_;
  Eigen::VectorXd successes_;
  bool any_failure_ = false;
  double width_ = 0;
};

}  // namespace powdercal

#include "optimizers/feasibility.h"

#include <cmath>
#include <limits>

namespace powdercal {
namespace {

constexpr double kPrior = 0.5;

}  // namespace

Feasibility::Feasibility(const Eigen::MatrixXd& points, const Eigen::VectorXd& successes)
    : points_(points), successes_(successes) {
  any_failure_ = successes.size() > 0 && successes.minCoeff() < 1;
  if (!any_failure_) return;
  const double root = std::sqrt(static_cast<double>(points.cols()));
  double best = -std::numeric_limits<double>::infinity();
  for (const double factor : {0.2, 0.1, 0.4, 0.05}) {  // the first wins ties
    const double likelihood = LeaveOneOutLikelihood(factor * root);
    if (likelihood > best) {
      best = likelihood;
      width_ = factor * root;
    }
  }
}

double Feasibility::LeaveOneOutLikelihood(double width) const {
  double sum = 0;
  for (Eigen::Index i = 0; i < points_.rows(); ++i) {
    Eigen::ArrayXd weights = ((points_.rowwise() - points_.row(i)).rowwise().squaredNorm().array() /
                              (-2 * width * width))
                                 .exp();
    weights[i] = 0;
    // Success without evidence is not certain here, or the narrowest width would always win.
    const double p =
        (0.9 * kPrior + (weights * successes_.array()).sum()) / (kPrior + weights.sum());
    sum += successes_[i] * std::log(p) + (1 - successes_[i]) * std::log(std::max(1 - p, 1e-3));
  }
  return sum;
}

double Feasibility::LogProbability(const Eigen::VectorXd& point, Eigen::VectorXd* gradient) const {
  if (!any_failure_) return 0;
  const Eigen::MatrixXd differences = points_.rowwise() - point.transpose();
  const double inverse = 1 / (width_ * width_);
  const Eigen::ArrayXd weights =
      (-0.5 * inverse * differences.rowwise().squaredNorm().array()).exp();
  const double above = kPrior + (weights * successes_.array()).sum();
  const double below = kPrior + weights.sum();
  if (gradient != nullptr) {
    // d k_i / dx = k_i (x_i − x) / l²
    *gradient += inverse * (differences.transpose() *
                            (weights * (successes_.array() / above - 1 / below)).matrix());
  }
  return std::log(above / below);
}

}  // namespace powdercal

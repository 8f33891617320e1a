#pragma once

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <functional>

namespace powdercal {

/// Residuals at a point of the unit box and, unless null, their Jacobian (resized by the callee).
/// False: no values at this point; only allowed without a Jacobian.
using ResidualFunction = std::function<bool(const Eigen::VectorXd& x, Eigen::VectorXd* residuals,
                                            Eigen::MatrixXd* jacobian)>;

struct BoundedLmOptions {
  /// Of the trust region, in Ceres' meaning: 1/radius is Marquardt's λ on normalised columns.
  double initial_radius = 1e2;
  double tolerance = 1e-8;  ///< relative decrease of the sum of squares that ends it
  int max_iterations = 100;
  std::function<ceres::CallbackReturnType(const ceres::IterationSummary&)> after_iteration;
};

/// Minimises the sum of squares of `count` residuals from *x, in the unit box, by Ceres'
/// Levenberg–Marquardt method. The Jacobian is asked for at accepted points only. Its columns of
/// parameters at a bound that the gradient pushes outwards are set to zero, so that the step is
/// that of the others (Ceres alone would project the step on the box).
void LevenbergMarquardt(const ResidualFunction& function, int count,
                        const BoundedLmOptions& options, Eigen::VectorXd* x);

}  // namespace powdercal

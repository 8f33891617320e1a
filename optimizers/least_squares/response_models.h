#pragma once

#include <Eigen/Core>
#include <vector>

#include "optimizers/least_squares/residuals.h"
#include "surrogates/gaussian_process.h"

namespace powdercal {

/// A Gaussian process for each response that has at least two values, seen as residuals
/// ρ_j = (mean_j − target_j)/s_j with the weights of Residuals.
class ResponseModels {
 public:
  /// Throws what GaussianProcess::Fit throws.
  ResponseModels(const SearchSpace& space, const Objectives& objectives,
                 const ObservationsById& observations, Kernel kernel);

  int size() const { return static_cast<int>(processes_.size()); }
  /// Residuals of the means and, unless null, their exact Jacobian, m × d.
  void Evaluate(const Eigen::VectorXd& point, Eigen::VectorXd* residuals,
                Eigen::MatrixXd* jacobian) const;

  /// At rows of points: χ² of the means; χ² with each mean moved towards its target by up to two
  /// posterior standard deviations; and Σ_j v_j/s_j².
  struct Outlook {
    Eigen::ArrayXd chi2;
    Eigen::ArrayXd optimistic;
    Eigen::ArrayXd variance;
  };
  Outlook Predict(const Eigen::MatrixXd& points) const;

  /// The models after evaluations at the rows of points that come out as predicted.
  ResponseModels ConditionedOn(const Eigen::MatrixXd& points) const;

 private:
  std::vector<GaussianProcess> processes_;
  Eigen::VectorXd targets_;
  Eigen::VectorXd scales_;
};

}  // namespace powdercal

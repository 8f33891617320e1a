#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "surrogates/surrogate.h"

namespace powdercal {

/// Gradient boosting of regression trees (Friedman 2001, doi:10.1214/aos/1013203451) by XGBoost
/// (Chen & Guestrin 2016, doi:10.1145/2939672.2939785): each tree is fitted to what the sum of
/// those before it leaves of the standardised values, and shrunk by the learning rate. Exact
/// splits, one thread, nothing drawn at random. Depth of the trees and their number are those of
/// the least error by cross-validation; of equal ones the shallower and fewer. Single precision,
/// and piecewise constant. Noise variances are checked and not used.
///
/// The variance is the mean squared error of that cross-validation, the same everywhere: the method
/// itself knows of none.
class GradientBoosting final : public Surrogate {
 public:
  struct Options {
    std::vector<int> depths = {1, 2, 3};                       ///< ≥ 1, ascending
    std::vector<int> rounds = {10, 20, 30, 50, 75, 100, 150};  ///< trees, ≥ 1, ascending
    double learning_rate = 0.1;                                ///< in (0, 1]
    double leaf_penalty = 1;  ///< λ of XGBoost, ≥ 0: shrinks leaves of few observations
    int folds = 10;           ///< ≥ 2
  };

  GradientBoosting() : GradientBoosting(Options{}) {}
  explicit GradientBoosting(Options options);
  ~GradientBoosting() override;

  const std::string& name() const override;
  /// Throws also std::runtime_error for what XGBoost reports.
  void Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
           const Eigen::VectorXd& noise_variances) override;
  Prediction Predict(const Eigen::VectorXd& point) const override;
  std::string Describe() const override;

  int depth() const { return depth_; }
  int rounds() const { return rounds_; }

 private:
  class Booster;

  Options options_;
  int depth_ = 0;
  int rounds_ = 0;
  std::unique_ptr<const Booster> booster_;
  Eigen::Index count_ = 0;
  double offset_ = 0;
  double scale_ = 1;
  double variance_ = 0;
};

}  // namespace powdercal

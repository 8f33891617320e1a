#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "surrogates/surrogate.h"

namespace powdercal {

/// Support vector regression with a loss that does not see errors below ε (Vapnik 1995; Smola &
/// Schölkopf 2004, doi:10.1023/B:STCO.0000035301.49549.88) and the kernel exp(−γ |u − v|²), on
/// standardised values; the quadratic program is dlib's. γ, C and ε are those of the least error by
/// cross-validation; of equal ones the earlier. Noise variances are checked and not used.
///
/// The variance is the mean squared error of that cross-validation, the same everywhere: the method
/// itself knows of none.
class SupportVector final : public Surrogate {
 public:
  struct Options {
    std::vector<double> gammas = {0.3, 1, 3, 10};  ///< > 0, of the unit box
    std::vector<double> costs = {1, 10, 100};      ///< C, > 0
    std::vector<double> tubes = {0.1, 0.01};       ///< ε, > 0, of the standardised values
    int folds = 10;                                ///< ≥ 2
  };

  SupportVector() : SupportVector(Options{}) {}
  explicit SupportVector(Options options);
  ~SupportVector() override;

  const std::string& name() const override;
  void Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
           const Eigen::VectorXd& noise_variances) override;
  Prediction Predict(const Eigen::VectorXd& point) const override;
  std::string Describe() const override;

  double gamma() const { return gamma_; }
  double cost() const { return cost_; }
  double tube() const { return tube_; }

 private:
  struct Machine;

  Options options_;
  double gamma_ = 0;
  double cost_ = 0;
  double tube_ = 0;
  std::unique_ptr<const Machine> machine_;
  Eigen::Index count_ = 0;
  double offset_ = 0;
  double scale_ = 1;
  double variance_ = 0;
};

}  // namespace powdercal

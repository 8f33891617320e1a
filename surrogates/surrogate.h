#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace powdercal {

/// Value and variance of a regression at a point.
struct Prediction {
  double mean = 0;
  double variance = 0;  ///< of the regression function itself, without observation noise
};

/// A regression of one response on points of the unit box.
class Surrogate {
 public:
  virtual ~Surrogate() = default;

  virtual const std::string& name() const = 0;

  /// Fits n observations. points: n × d, entries in [0, 1]; values: n; noise_variances: n, known
  /// variances of the values (0: unknown; the surrogate may learn a common noise), or empty.
  /// Deterministic. Throws std::invalid_argument when sizes disagree or a value is not finite.
  virtual void Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
                   const Eigen::VectorXd& noise_variances) = 0;

  /// Requires a fit. point: d.
  virtual Prediction Predict(const Eigen::VectorXd& point) const = 0;

  /// One line on the fitted model for logs and reports (kernel, lengthscales, noise).
  virtual std::string Describe() const = 0;
};

/// Names of all surrogates, sorted: gaussian_process.
std::span<const std::string> SurrogateNames();
/// Throws InputError for an unknown name.
std::unique_ptr<Surrogate> MakeSurrogate(const std::string& name);

/// Coefficient of determination of the predictions of each point by a fit to all the others
/// (hyperparameters refitted for each): 1 − Σ (yᵢ − ŷᵢ)² / Σ (yᵢ − ȳ)². Throws
/// std::invalid_argument for fewer than 3 points and where all values are equal.
double LeaveOneOutR2(const std::string& surrogate, const Eigen::MatrixXd& points,
                     const Eigen::VectorXd& values);
/// The same for a surrogate with options of its own.
using SurrogateMaker = std::function<std::unique_ptr<Surrogate>()>;
double LeaveOneOutR2(const SurrogateMaker& make, const Eigen::MatrixXd& points,
                     const Eigen::VectorXd& values);

}  // namespace powdercal

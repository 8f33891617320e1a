#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>

namespace powdercal {

/// Value and variance of a regression at a point.
struct Prediction {
  double mean = 0;
  double variance = 0;  ///< of the regression function itself, without observation noise
};

/// A regression of one response on points of the unit box. Hyperparameters are chosen inside Fit;
/// surrogates/validation.h compares what comes of it.
class Surrogate {
 public:
  virtual ~Surrogate() = default;

  virtual const std::string& name() const = 0;

  /// Fits n observations. points: n × d, entries in [0, 1]; values: n; noise_variances: n, known
  /// variances of the values (0: unknown; the surrogate may learn a common noise), or empty; a
  /// surrogate that has no use for them says so.
  /// Deterministic. Throws std::invalid_argument when sizes disagree or a value is not finite.
  virtual void Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
                   const Eigen::VectorXd& noise_variances) = 0;

  /// Requires a fit. point: d.
  virtual Prediction Predict(const Eigen::VectorXd& point) const = 0;

  /// One line on the fitted model for logs and reports (kernel, lengthscales, noise).
  virtual std::string Describe() const = 0;
};

/// Names of all surrogates, sorted: gaussian_process, gradient_boosting, nearest_neighbours,
/// random_forest, ridge, support_vector.
std::span<const std::string> SurrogateNames();
/// Throws InputError for an unknown name.
std::unique_ptr<Surrogate> MakeSurrogate(const std::string& name);

}  // namespace powdercal

#include "surrogates/marginal_posterior.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "surrogates/linear_algebra.h"

namespace powdercal {
namespace {

constexpr double kSignalLocation = 0;
constexpr double kSignalScale = 2;

// Log density of LogNormal(location, scale) at x, and its derivative by ln x.
double LogNormalDensity(double x, double location, double scale, double* by_log) {
  const double z = (std::log(x) - location) / scale;
  *by_log = -1 - z / scale;
  return -std::log(x) - 0.5 * z * z - std::log(scale * std::sqrt(2 * std::numbers::pi));
}

}  // namespace

MarginalPosterior::MarginalPosterior(HyperparameterModel model, const Eigen::MatrixXd& points,
                                     const Eigen::VectorXd& values,
                                     const Eigen::VectorXd& variances)
    : model_(model), dimension_(points.cols()), values_(values), variances_(variances) {
  const Eigen::Index n = points.rows();
  squared_differences_.resize(n * (n - 1) / 2, model_.ard ? dimension_ : 1);
  for (Eigen::Index j = 0, first = 0; j < n; ++j) {
    const Eigen::Index below = n - 1 - j;
    const Eigen::MatrixXd squares =
        (points.bottomRows(below).rowwise() - points.row(j)).array().square();
    if (model_.ard) {
      squared_differences_.middleRows(first, below) = squares;
    } else {
      squared_differences_.middleRows(first, below) = squares.rowwise().sum();
    }
    first += below;
  }
}

int MarginalPosterior::size() const {
  return static_cast<int>(squared_differences_.cols()) + (model_.signal_variance ? 0 : 1) +
         (model_.noise_variance ? 0 : 1);
}

Hyperparameters MarginalPosterior::FromUnconstrained(const Eigen::VectorXd& t) const {
  Hyperparameters result;
  const Eigen::Index scales = squared_differences_.cols();
  const Eigen::VectorXd lengthscales = model_.lengthscale_floor + t.head(scales).array().exp();
  result.lengthscales =
      model_.ard ? lengthscales : Eigen::VectorXd::Constant(dimension_, lengthscales[0]);
  Eigen::Index next = scales;
  result.signal_variance = model_.signal_variance ? *model_.signal_variance : std::exp(t[next++]);
  result.noise_variance =
      model_.noise_variance ? *model_.noise_variance : model_.noise_floor + std::exp(t[next]);
  return result;
}

Eigen::VectorXd MarginalPosterior::ToUnconstrained(const Hyperparameters& hyperparameters) const {
  // A value on its floor is moved just above it.
  const auto log_above = [](double value, double floor) {
    return std::log(std::max(value - floor, 1e-3 * floor + 1e-300));
  };
  Eigen::VectorXd t(size());
  const Eigen::Index scales = squared_differences_.cols();
  for (Eigen::Index i = 0; i < scales; ++i) {
    t[i] = log_above(hyperparameters.lengthscales[i], model_.lengthscale_floor);
  }
  Eigen::Index next = scales;
  if (!model_.signal_variance) t[next++] = std::log(hyperparameters.signal_variance);
  if (!model_.noise_variance)
    t[next] = log_above(hyperparameters.noise_variance, model_.noise_floor);
  return t;
}

double MarginalPosterior::AddPriors(const Eigen::VectorXd& t,
                                    const Hyperparameters& hyperparameters,
                                    Eigen::VectorXd* gradient) const {
  const double location = std::numbers::sqrt2 + 0.5 * std::log(static_cast<double>(dimension_));
  const Eigen::Index scales = squared_differences_.cols();
  const Eigen::ArrayXd logs = hyperparameters.lengthscales.head(scales).array().log();
  const Eigen::ArrayXd deviations =
      (logs - logs.mean()) / (model_.lengthscale_spread * model_.lengthscale_spread);
  double sum = -0.5 * (logs * deviations).sum();
  for (Eigen::Index i = 0; i < scales; ++i) {
    double by_log = 0;
    sum +=
        LogNormalDensity(hyperparameters.lengthscales[i], location, std::numbers::sqrt3, &by_log);
    if (gradient == nullptr) continue;
    // d ln l / dt = exp(t) / l
    (*gradient)[i] += (by_log - deviations[i]) * std::exp(t[i]) / hyperparameters.lengthscales[i];
  }
  Eigen::Index next = scales;
  if (!model_.signal_variance) {
    const double z = (t[next] - kSignalLocation) / kSignalScale;
    sum -= 0.5 * z * z;
    if (gradient != nullptr) (*gradient)[next] -= z / kSignalScale;
    ++next;
  }
  if (!model_.noise_variance) {
    double by_log = 0;
    const double noise = hyperparameters.noise_variance;
    sum += LogNormalDensity(noise, model_.noise_location, model_.noise_scale, &by_log);
    if (gradient != nullptr) (*gradient)[next] += by_log * std::exp(t[next]) / noise;
  }
  return sum;
}

bool MarginalPosterior::Evaluate(const Eigen::VectorXd& t, double* value,
                                 Eigen::VectorXd* gradient) const {
  const Hyperparameters hyperparameters = FromUnconstrained(t);
  const Eigen::Index n = values_.size();
  const Eigen::Index scales = squared_differences_.cols();
  const double signal = hyperparameters.signal_variance;
  const Eigen::VectorXd inverse_squares =
      hyperparameters.lengthscales.head(scales).array().square().inverse();
  const Eigen::ArrayXd squared_distances = (squared_differences_ * inverse_squares).array();
  Eigen::ArrayXd correlation;
  Eigen::ArrayXd slope;
  Correlation(model_.kernel, squared_distances, &correlation,
              gradient != nullptr ? &slope : nullptr);

  Eigen::MatrixXd matrix(n, n);
  for (Eigen::Index j = 0, first = 0; j < n; ++j) {
    const Eigen::Index below = n - 1 - j;
    matrix(j, j) = signal * (1 + kBaseJitter) + hyperparameters.noise_variance + variances_[j];
    matrix.col(j).tail(below) = signal * correlation.segment(first, below);
    first += below;
  }
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(matrix);  // in place
  if (cholesky.info() != Eigen::Success) return false;
  const double half_log_determinant = matrix.diagonal().array().log().sum();
  const Eigen::VectorXd alpha = cholesky.solve(values_);
  *value = -0.5 * values_.dot(alpha) - half_log_determinant -
           0.5 * static_cast<double>(n) * std::log(2 * std::numbers::pi);

  if (gradient != nullptr) {
    // dL/dp = ½ tr((ααᵀ − K⁻¹) dK/dp), one inverse for all p.
    InvertLowerTriangle(matrix);
    Eigen::MatrixXd inverse(n, n);
    LowerTriangleGram(matrix, inverse);
    Eigen::VectorXd weights(squared_differences_.rows());  // (ααᵀ − K⁻¹)_ij, pairs i > j
    for (Eigen::Index j = 0, first = 0; j < n; ++j) {
      const Eigen::Index below = n - 1 - j;
      weights.segment(first, below) = alpha[j] * alpha.tail(below) - inverse.col(j).tail(below);
      first += below;
    }
    const double trace = alpha.squaredNorm() - inverse.diagonal().sum();
    gradient->resize(size());
    Eigen::Index next = scales;
    if (!model_.signal_variance) {
      (*gradient)[next++] =
          signal * (weights.dot(correlation.matrix()) + 0.5 * (1 + kBaseJitter) * trace);
    }
    if (!model_.noise_variance) (*gradient)[next] = 0.5 * trace * std::exp(t[next]);
    weights.array() *= slope;
    gradient->head(scales) = signal * (squared_differences_.transpose() * weights).array() *
                             inverse_squares.array() * t.head(scales).array().exp() /
                             hyperparameters.lengthscales.head(scales).array();
  }
  *value += AddPriors(t, hyperparameters, gradient);
  return std::isfinite(*value) && (gradient == nullptr || gradient->allFinite());
}

}  // namespace powdercal

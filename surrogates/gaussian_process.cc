#include "surrogates/gaussian_process.h"

#include <ceres/ceres.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "surrogates/fitting.h"
#include "surrogates/linear_algebra.h"

namespace powdercal {
namespace {

constexpr double kLargestJitter = 1e-4;
// Differences of log density below it do not matter to predictions.
constexpr double kDensityTolerance = 1e-3;

class NegativeLogDensity final : public ceres::FirstOrderFunction {
 public:
  NegativeLogDensity(const MarginalPosterior& posterior, int* evaluations)
      : posterior_(posterior), evaluations_(evaluations) {}

  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    ++*evaluations_;
    const Eigen::VectorXd t = Eigen::Map<const Eigen::VectorXd>(parameters, posterior_.size());
    // Far out the density is as good as zero, and exp(t) may overflow.
    if (t.cwiseAbs().maxCoeff() > 100) return false;
    Eigen::VectorXd slope;
    if (!posterior_.Evaluate(t, cost, gradient != nullptr ? &slope : nullptr)) return false;
    *cost = -*cost;
    if (gradient != nullptr) Eigen::Map<Eigen::VectorXd>(gradient, posterior_.size()) = -slope;
    return true;
  }
  int NumParameters() const override { return posterior_.size(); }

 private:
  const MarginalPosterior& posterior_;
  int* evaluations_;
};

// Ends the search after two successive steps without a gain that matters.
class StopWhenFlat final : public ceres::IterationCallback {
 public:
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    flat_steps_ = summary.iteration > 0 && std::abs(summary.cost_change) < kDensityTolerance
                      ? flat_steps_ + 1
                      : 0;
    return flat_steps_ >= 2 ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  int flat_steps_ = 0;
};

// Improves t; returns the log density there, −∞ where it cannot be evaluated.
double Climb(const MarginalPosterior& posterior, int max_iterations, Eigen::VectorXd* t,
             int* evaluations) {
  double start = 0;
  if (!posterior.Evaluate(*t, &start, nullptr)) return -std::numeric_limits<double>::infinity();
  if (posterior.size() == 0) return start;
  const ceres::GradientProblem problem(new NegativeLogDensity(posterior, evaluations));
  StopWhenFlat stop;
  ceres::GradientProblemSolver::Options options;
  options.logging_type = ceres::SILENT;
  options.minimizer_progress_to_stdout = false;
  options.max_num_iterations = max_iterations;
  options.gradient_tolerance = 1e-3;
  options.function_tolerance = 1e-12;  // the callback decides
  options.callbacks.push_back(&stop);
  ceres::GradientProblemSolver::Summary summary;
  Eigen::VectorXd climbed = *t;
  ceres::Solve(options, problem, climbed.data(), &summary);
  double end = 0;
  if (!climbed.allFinite() || !posterior.Evaluate(climbed, &end, nullptr) || end < start) {
    return start;
  }
  *t = climbed;
  return end;
}

// Starts: the prior's mode; long and short scales; a noisy and a nearly noise-free view of the
// data.
std::vector<Hyperparameters> Starts(const HyperparameterModel& model, Eigen::Index dimension,
                                    int count) {
  const double root = std::sqrt(static_cast<double>(dimension));
  const double mode = std::exp(std::sqrt(2.0) - 3) * root;
  const double lengthscales[] = {mode, 2 * root, mode, 0.3 * mode};
  const double noises[] = {1e-3, 1e-3, 0.2, 1e-2};
  std::vector<Hyperparameters> starts;
  for (int i = 0; i < std::clamp(count, 1, 4); ++i) {
    starts.push_back({Eigen::VectorXd::Constant(dimension, lengthscales[i]),
                      model.signal_variance.value_or(1), model.noise_variance.value_or(noises[i])});
  }
  return starts;
}

// Indices of `count` rows, each the farthest from those before it.
std::vector<Eigen::Index> SpreadSubset(const Eigen::MatrixXd& points, Eigen::Index count) {
  std::vector<Eigen::Index> chosen = {0};
  Eigen::VectorXd distances = (points.rowwise() - points.row(0)).rowwise().squaredNorm();
  while (static_cast<Eigen::Index>(chosen.size()) < count) {
    Eigen::Index farthest = 0;
    distances.maxCoeff(&farthest);
    chosen.push_back(farthest);
    distances =
        distances.cwiseMin((points.rowwise() - points.row(farthest)).rowwise().squaredNorm());
    distances[farthest] = -1;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

std::vector<Eigen::Index> AllRows(Eigen::Index count) {
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(count));
  std::iota(rows.begin(), rows.end(), Eigen::Index{0});
  return rows;
}

}  // namespace

GaussianProcess::GaussianProcess(Options options) : options_(std::move(options)) {}

const std::string& GaussianProcess::name() const {
  static const std::string name = "gaussian_process";
  return name;
}

double GaussianProcess::noise_sd() const {
  return scale_ * std::sqrt(hyperparameters_.noise_variance);
}

void GaussianProcess::Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
                          const Eigen::VectorXd& noise_variances) {
  CheckObservations(name(), points, values, noise_variances);
  const auto n = static_cast<double>(values.size());
  offset_ = 0;
  scale_ = 1;
  if (options_.standardise) {
    offset_ = values.mean();
    const double sum = (values.array() - offset_).square().sum();
    scale_ = values.size() > 1 ? std::sqrt(sum / (n - 1)) : 0;
    // Also where the values differ in their last digits only.
    if (scale_ <= 1e-12 * std::max(std::abs(offset_), options_.fallback_scale)) {
      scale_ = options_.fallback_scale;
    }
  }
  values_ = (values.array() - offset_) / scale_;
  Eigen::VectorXd noise = Eigen::VectorXd::Zero(values.size());
  if (noise_variances.size() != 0) noise = noise_variances / (scale_ * scale_);
  evaluations_ = 0;
  points_ = options_.inputs.Map(points);
  Optimise(noise);
  if (options_.warp && !options_.hyperparameters) LearnWarps(points, noise);
  Factorise(noise);
}

// By coordinates: each in turn tries a few shapes, refitted from where it stands, and keeps the one
// of the largest posterior density. Two rounds, on a well-spread subset if there are many points.
void GaussianProcess::LearnWarps(const Eigen::MatrixXd& points, const Eigen::VectorXd& noise) {
  constexpr double kSpread = 0.75;  // of ln a and ln b
  constexpr double kShapes[][2] = {{1, 1}, {0.35, 1}, {0.6, 1}, {1.8, 1},
                                   {3, 1}, {1, 0.6},  {1, 1.8}, {1, 3}};
  constexpr int kRounds = 2;
  constexpr double kWorthwhile = 2;  // gain of log density for which a coordinate is warped at all
  const std::vector<Eigen::Index> rows = points.rows() <= options_.screening_points
                                             ? AllRows(points.rows())
                                             : SpreadSubset(points_, options_.screening_points);
  const Eigen::MatrixXd subset = points(rows, Eigen::all);
  const auto density_of = [&](const InputMap& map, Eigen::VectorXd* t) {
    const MarginalPosterior posterior(options_.model, map.Map(subset), values_(rows), noise(rows));
    double value = Climb(posterior, options_.max_iterations, t, &evaluations_);
    for (const InputMap::Coordinate& c : map.coordinates()) {
      const double squares = std::log(c.a) * std::log(c.a) + std::log(c.b) * std::log(c.b);
      value -= squares / (2 * kSpread * kSpread);
    }
    return value;
  };
  std::vector<InputMap::Coordinate> best = options_.inputs.coordinates();
  best.resize(static_cast<std::size_t>(points.cols()));
  const MarginalPosterior start(options_.model, points_, values_, noise);
  Eigen::VectorXd best_t = start.ToUnconstrained(hyperparameters_);
  double best_value = density_of(InputMap(best), &best_t);
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t k = 0; k < best.size(); ++k) {
      if (best[k].categories > 0) continue;
      for (const auto& [a, b] : kShapes) {
        if (a == best[k].a && b == best[k].b) continue;
        std::vector<InputMap::Coordinate> trial = best;
        trial[k].a = a;
        trial[k].b = b;
        Eigen::VectorXd t = best_t;
        const double value = density_of(InputMap(trial), &t);
        if (value <= best_value + (best[k].a == 1 && best[k].b == 1 ? kWorthwhile : 0)) continue;
        best_value = value;
        best_t = t;
        best = trial;
      }
    }
  }
  options_.inputs = InputMap(best);
  if (options_.inputs.identity()) return;
  points_ = options_.inputs.Map(points);
  const MarginalPosterior posterior(options_.model, points_, values_, noise);
  log_posterior_density_ = Climb(posterior, options_.max_iterations, &best_t, &evaluations_);
  hyperparameters_ = posterior.FromUnconstrained(best_t);
}

void GaussianProcess::Optimise(const Eigen::VectorXd& noise) {
  const MarginalPosterior posterior(options_.model, points_, values_, noise);
  if (options_.hyperparameters) {
    hyperparameters_ = *options_.hyperparameters;
    if (hyperparameters_.lengthscales.size() != points_.cols()) {
      throw std::invalid_argument(fmt::format("Gaussian process: {} lengthscales for {} inputs",
                                              hyperparameters_.lengthscales.size(),
                                              points_.cols()));
    }
    return;
  }
  const std::vector<Hyperparameters> starts =
      Starts(options_.model, points_.cols(), options_.restarts);
  const auto best_of = [&](const MarginalPosterior& density) {
    Eigen::VectorXd best = density.ToUnconstrained(starts.front());
    double best_value = -std::numeric_limits<double>::infinity();
    for (const Hyperparameters& start : starts) {
      Eigen::VectorXd t = density.ToUnconstrained(start);
      const double value = Climb(density, options_.max_iterations, &t, &evaluations_);
      if (value > best_value) {
        best_value = value;
        best = t;
      }
    }
    log_posterior_density_ = best_value;
    return best;
  };
  Eigen::VectorXd best;
  if (values_.size() <= options_.screening_points) {
    best = best_of(posterior);
  } else {
    const auto density_on = [&](Eigen::Index count) {
      const std::vector<Eigen::Index> rows = SpreadSubset(points_, count);
      return MarginalPosterior(options_.model, points_(rows, Eigen::all), values_(rows),
                               noise(rows));
    };
    best = best_of(density_on(options_.screening_points));
    const bool many = values_.size() > options_.learning_points;
    log_posterior_density_ = Climb(many ? density_on(options_.learning_points) : posterior,
                                   options_.max_iterations, &best, &evaluations_);
  }
  hyperparameters_ = posterior.FromUnconstrained(best);
}

void GaussianProcess::Factorise(const Eigen::VectorXd& noise) {
  const Eigen::Index n = points_.rows();
  const Eigen::MatrixXd covariance = Covariance(points_, points_);
  const double signal = hyperparameters_.signal_variance;
  for (double jitter = kBaseJitter; jitter <= kLargestJitter; jitter *= 10) {
    inverse_factor_ = covariance;
    inverse_factor_.diagonal().array() += hyperparameters_.noise_variance + jitter * signal;
    inverse_factor_.diagonal() += noise;
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(inverse_factor_);
    if (cholesky.info() != Eigen::Success) continue;
    alpha_ = cholesky.solve(values_);
    if (!alpha_.allFinite()) continue;
    InvertLowerTriangle(inverse_factor_);
    inverse_factor_.triangularView<Eigen::StrictlyUpper>().setZero();
    return;
  }
  throw std::runtime_error(fmt::format(
      "Gaussian process: the covariance matrix of {} points is not positive definite even with "
      "{:g} of the signal variance on its diagonal",
      n, kLargestJitter));
}

Eigen::MatrixXd GaussianProcess::Covariance(const Eigen::MatrixXd& a,
                                            const Eigen::MatrixXd& b) const {
  const Eigen::RowVectorXd inverse = hyperparameters_.lengthscales.cwiseInverse().transpose();
  const Eigen::MatrixXd scaled = a.array().rowwise() * inverse.array();
  Eigen::MatrixXd covariance(a.rows(), b.rows());
  Eigen::ArrayXd correlation;
  for (Eigen::Index j = 0; j < b.rows(); ++j) {
    const Eigen::RowVectorXd other = b.row(j).cwiseProduct(inverse);
    Correlation(options_.model.kernel, (scaled.rowwise() - other).rowwise().squaredNorm().array(),
                &correlation, nullptr);
    covariance.col(j) = hyperparameters_.signal_variance * correlation;
  }
  return covariance;
}

Prediction GaussianProcess::Predict(const Eigen::VectorXd& point) const {
  return PosteriorAt(point, 0, false).prediction;
}

Prediction GaussianProcess::PredictWithGradient(const Eigen::VectorXd& point,
                                                Eigen::VectorXd* mean_gradient,
                                                Eigen::VectorXd* variance_gradient) const {
  PointPosterior posterior = PosteriorAt(point, 0, true);
  if (mean_gradient != nullptr) *mean_gradient = std::move(posterior.mean_gradient);
  if (variance_gradient != nullptr) *variance_gradient = std::move(posterior.variance_gradient);
  return posterior.prediction;
}

Eigen::VectorXd GaussianProcess::CovarianceAt(const Eigen::MatrixXd& inputs,
                                              const Eigen::VectorXd& point,
                                              Eigen::MatrixXd* jacobian) const {
  const Eigen::ArrayXd inverse_squares = hyperparameters_.lengthscales.array().square().inverse();
  const Eigen::MatrixXd differences =
      inputs.rowwise() - options_.inputs.Map(point.transpose()).row(0);
  const Eigen::ArrayXd distances =
      (differences.array().square().matrix() * inverse_squares.matrix()).array();
  Eigen::ArrayXd correlation;
  Eigen::ArrayXd slope;
  Correlation(options_.model.kernel, distances, &correlation,
              jacobian != nullptr ? &slope : nullptr);
  const double signal = hyperparameters_.signal_variance;
  if (jacobian != nullptr) {
    // d covariance_a / dx_i = signal · slope_a · (inputs_ai − x_i) / l_i²
    *jacobian =
        signal * ((differences.array().rowwise() * inverse_squares.transpose()).colwise() * slope);
  }
  return signal * correlation;
}

GaussianProcess::PointPosterior GaussianProcess::PosteriorAt(const Eigen::VectorXd& point,
                                                             int tail_size, bool gradients) const {
  assert(alpha_.size() > 0 && tail_size <= alpha_.size());
  assert(options_.inputs.InputCount(point.size()) == points_.cols());
  Eigen::MatrixXd jacobian;
  const Eigen::VectorXd covariance = CovarianceAt(points_, point, gradients ? &jacobian : nullptr);
  const double signal = hyperparameters_.signal_variance;
  const auto factor = inverse_factor_.triangularView<Eigen::Lower>();
  const Eigen::VectorXd whitened = factor * covariance;

  PointPosterior result;
  result.prediction.mean = offset_ + scale_ * covariance.dot(alpha_);
  result.prediction.variance =
      scale_ * scale_ * std::max(signal - whitened.squaredNorm(), kBaseJitter * signal);
  result.tail = scale_ * whitened.tail(tail_size);
  if (!gradients) return result;

  const Eigen::VectorXd solved = factor.transpose() * whitened;  // K⁻¹ covariance
  const auto pull_back = [&](const Eigen::MatrixXd& rows) {
    return options_.inputs.PullBack(point, rows);
  };
  result.mean_gradient =
      pull_back(scale_ * (jacobian.transpose() * alpha_).transpose()).transpose();
  result.variance_gradient =
      pull_back((-2 * scale_ * scale_) * (jacobian.transpose() * solved).transpose()).transpose();
  if (tail_size > 0) {
    result.tail_gradient = pull_back(scale_ * (inverse_factor_.bottomRows(tail_size) * jacobian));
  }
  return result;
}

void GaussianProcess::PredictMany(const Eigen::MatrixXd& points, Eigen::VectorXd* means,
                                  Eigen::VectorXd* variances, Eigen::MatrixXd* tail) const {
  const Eigen::MatrixXd covariance = Covariance(points_, options_.inputs.Map(points));
  const Eigen::MatrixXd whitened = inverse_factor_.triangularView<Eigen::Lower>() * covariance;
  const double signal = hyperparameters_.signal_variance;
  *means = (scale_ * (covariance.transpose() * alpha_)).array() + offset_;
  *variances =
      (signal - whitened.colwise().squaredNorm().transpose().array()).max(kBaseJitter * signal) *
      (scale_ * scale_);
  if (tail != nullptr) *tail = scale_ * whitened.bottomRows(tail->cols()).transpose();
}

void GaussianProcess::PredictJoint(const Eigen::MatrixXd& points, Eigen::VectorXd* mean,
                                   Eigen::MatrixXd* covariance) const {
  const Eigen::MatrixXd inputs = options_.inputs.Map(points);
  const Eigen::MatrixXd cross = Covariance(points_, inputs);
  const Eigen::MatrixXd whitened = inverse_factor_.triangularView<Eigen::Lower>() * cross;
  *mean = (scale_ * (cross.transpose() * alpha_)).array() + offset_;
  *covariance = (scale_ * scale_) * (Covariance(inputs, inputs) - whitened.transpose() * whitened);
}

GaussianProcess GaussianProcess::ConditionedOn(const Eigen::MatrixXd& points) const {
  const Eigen::Index n = points_.rows();
  const Eigen::Index m = points.rows();
  GaussianProcess result = *this;
  if (m == 0) return result;
  // [L 0; B M], B = cross L⁻ᵀ, MMᵀ = new − BBᵀ; the inverse is [L⁻¹ 0; −M⁻¹ B L⁻¹ M⁻¹].
  const Eigen::MatrixXd inputs = options_.inputs.Map(points);
  const Eigen::MatrixXd whitened =
      inverse_factor_.triangularView<Eigen::Lower>() * Covariance(points_, inputs);
  Eigen::MatrixXd schur = Covariance(inputs, inputs) - whitened.transpose() * whitened;
  const double signal = hyperparameters_.signal_variance;
  schur.diagonal().array() += std::max(hyperparameters_.noise_variance, 1e-8 * signal);
  Eigen::LLT<Eigen::MatrixXd> cholesky(schur);
  for (double jitter = 1e-8; cholesky.info() != Eigen::Success; jitter *= 10) {
    schur.diagonal().array() += jitter * signal;
    cholesky.compute(schur);
  }
  Eigen::MatrixXd corner = cholesky.matrixL();
  InvertLowerTriangle(corner);
  result.points_.conservativeResize(n + m, Eigen::NoChange);
  result.points_.bottomRows(m) = inputs;
  result.inverse_factor_.setZero(n + m, n + m);
  result.inverse_factor_.topLeftCorner(n, n) = inverse_factor_;
  result.inverse_factor_.bottomRightCorner(m, m) = corner;
  result.inverse_factor_.bottomLeftCorner(m, n) =
      -corner * (whitened.transpose() * inverse_factor_.triangularView<Eigen::Lower>());
  // The new observations lie on the mean: their weights are zero and the others keep theirs.
  Eigen::VectorXd means;
  Eigen::VectorXd variances;
  PredictMany(points, &means, &variances);
  result.alpha_.conservativeResize(n + m);
  result.alpha_.tail(m).setZero();
  result.values_.conservativeResize(n + m);
  result.values_.tail(m) = (means.array() - offset_) / scale_;
  return result;
}

void GaussianProcess::LeaveOneOut(Eigen::VectorXd* means, Eigen::VectorXd* variances) const {
  const Eigen::ArrayXd diagonal = inverse_factor_.colwise().squaredNorm().transpose();  // of K⁻¹
  *means = (values_.array() - alpha_.array() / diagonal) * scale_ + offset_;
  *variances = scale_ * scale_ / diagonal;
}

std::string GaussianProcess::Describe() const {
  const char* kernel = options_.model.kernel == Kernel::rbf ? "RBF" : "Matérn 5/2";
  if (alpha_.size() == 0) return fmt::format("Gaussian process, {}, not fitted", kernel);
  const std::vector<double> lengthscales(hyperparameters_.lengthscales.begin(),
                                         hyperparameters_.lengthscales.end());
  return fmt::format(
      "Gaussian process, {}, {} points, lengthscales [{:.3g}] of the box, signal sd {:.3g}, "
      "noise sd {:.3g}",
      kernel, points_.rows(), fmt::join(lengthscales, ", "),
      scale_ * std::sqrt(hyperparameters_.signal_variance), noise_sd());
}

}  // namespace powdercal

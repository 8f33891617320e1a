#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "surrogates/input_map.h"
#include "surrogates/marginal_posterior.h"
#include "surrogates/surrogate.h"

namespace powdercal {

/// Gaussian process regression (Rasmussen & Williams 2006, chapters 2 and 5): zero prior mean on
/// standardised outputs, stationary kernel with one lengthscale per input, hyperparameters at the
/// maximum of their posterior density (see MarginalPosterior), found by L-BFGS from a few fixed
/// starts. With more observations than `screening_points` the starts are tried on a well-spread
/// subset of them and only the best is refined on all. Deterministic.
///
/// All arguments and results are in the units of the observations; hyperparameters are in units of
/// the unit box and of the standardised outputs.
class GaussianProcess final : public Surrogate {
 public:
  struct Options {
    HyperparameterModel model;
    bool standardise = true;  ///< subtract the mean, divide by the standard deviation of the values
    double fallback_scale =
        1;             ///< > 0; stands for the standard deviation where all values are equal
    int restarts = 4;  ///< starts of the search, 1 … 4
    int screening_points = 50;
    /// Hyperparameters are learned from at most so many well-spread observations; predictions use
    /// all of them.
    int learning_points = 300;
    int max_iterations = 60;                         ///< of L-BFGS, for each start
    std::optional<Hyperparameters> hyperparameters;  ///< not learned when set
    InputMap inputs;    ///< from points to what the kernel sees; lengthscales belong to its inputs
    bool warp = false;  ///< learn the warps of `inputs` (prior: ln a, ln b ~ Normal(0, 0.75))
  };

  GaussianProcess() : GaussianProcess(Options{}) {}
  explicit GaussianProcess(Options options);

  const std::string& name() const override;

  /// Throws std::invalid_argument when sizes disagree, there are no observations, a value is not
  /// finite or a variance is negative; std::runtime_error when the covariance matrix is not
  /// positive definite even with 1e-4 of the signal variance added to its diagonal.
  void Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
           const Eigen::VectorXd& noise_variances) override;

  Prediction Predict(const Eigen::VectorXd& point) const override;
  std::string Describe() const override;

  /// Predict, with the gradients of mean and variance by the point; either may be null.
  Prediction PredictWithGradient(const Eigen::VectorXd& point, Eigen::VectorXd* mean_gradient,
                                 Eigen::VectorXd* variance_gradient) const;

  /// All about the function at a point; see Tail for `tail`.
  struct PointPosterior {
    Prediction prediction;
    Eigen::VectorXd tail;
    Eigen::VectorXd mean_gradient;      // d
    Eigen::VectorXd variance_gradient;  // d
    Eigen::MatrixXd tail_gradient;      // m × d
  };
  /// The tail of m entries is u with mean(point) + u·z the mean at the point if the last m
  /// observations came out z_i standard deviations above what was predicted for them from those
  /// before: what sampling the outcome of pending evaluations takes (after ConditionedOn them),
  /// without a new factorisation for each sample.
  PointPosterior PosteriorAt(const Eigen::VectorXd& point, int tail_size, bool gradients) const;

  /// Predict at each row of `points` (m × d): means and variances, m each; and, unless null, the
  /// last tail->cols() entries of the tail of each row (tail: resized by the caller to m × size).
  void PredictMany(const Eigen::MatrixXd& points, Eigen::VectorXd* means,
                   Eigen::VectorXd* variances, Eigen::MatrixXd* tail = nullptr) const;
  /// Joint posterior of the function at the rows of `points`: mean m, covariance m × m.
  void PredictJoint(const Eigen::MatrixXd& points, Eigen::VectorXd* mean,
                    Eigen::MatrixXd* covariance) const;

  /// The process after observations at `points` (m × d) that come out exactly at its mean, with the
  /// common noise: the mean is unchanged, the variance shrinks near the points. Hyperparameters are
  /// kept, so the cost is O(n² m).
  GaussianProcess ConditionedOn(const Eigen::MatrixXd& points) const;

  /// What the process predicts for each observation from all the others, hyperparameters and
  /// standardisation kept (Rasmussen & Williams 2006, eq. 5.10–5.12), in O(n²). Variances include
  /// the observation's noise.
  void LeaveOneOut(Eigen::VectorXd* means, Eigen::VectorXd* variances) const;

  const Hyperparameters& hyperparameters() const { return hyperparameters_; }
  /// With the warps as learned.
  const InputMap& inputs() const { return options_.inputs; }
  /// Standard deviation of the learned common noise, in the units of the observations.
  double noise_sd() const;
  double log_posterior_density() const { return log_posterior_density_; }
  /// Number of evaluations of the log posterior density in the last fit, those on a subset
  /// included.
  int evaluations() const { return evaluations_; }

 private:
  friend class SampledProcess;

  void Optimise(const Eigen::VectorXd& noise);
  void LearnWarps(const Eigen::MatrixXd& points, const Eigen::VectorXd& noise);
  void Factorise(const Eigen::VectorXd& noise);
  /// Prior covariances of the point with the rows of `inputs`, and unless null their gradients by
  /// the point's inputs, n × inputs.
  Eigen::VectorXd CovarianceAt(const Eigen::MatrixXd& inputs, const Eigen::VectorXd& point,
                               Eigen::MatrixXd* jacobian) const;
  /// Prior covariances of the rows of a with those of b (inputs), without noise.
  Eigen::MatrixXd Covariance(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) const;

  Options options_;
  Hyperparameters hyperparameters_;
  double log_posterior_density_ = 0;
  int evaluations_ = 0;
  double offset_ = 0;
  double scale_ = 1;
  Eigen::MatrixXd points_;          // inputs of the kernel, n rows
  Eigen::VectorXd values_;          // standardised
  Eigen::MatrixXd inverse_factor_;  // L⁻¹ in the lower triangle, zero above, LLᵀ = K
  Eigen::VectorXd alpha_;           // K⁻¹ y
};

}  // namespace powdercal

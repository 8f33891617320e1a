#include "optimizers/least_squares/local_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "optimizers/least_squares/bounded_lm.h"

namespace powdercal {
namespace {

constexpr double kInitialRadius = 1e2;  // see BoundedLmOptions
// A step whose residuals were predicted to this part of their change: no new stencil.
constexpr double kGoodPrediction = 0.3;
constexpr int kRejections = 3;      // in a row, of steps from a stencil
constexpr int kSureRejections = 7;  // of steps from a central one, which has been confirmed
// Two Jacobians agree where their columns differ by less than this part.
constexpr double kAgreement = 0.25;
// Slopes across the box, in units of the spread, that are looked at twice.
constexpr double kSteep = 30;
constexpr int kRefinements = 3;  // of the steps of a central stencil
constexpr double kMatched = 1e-13;

using Reason = LocalSearchEnd::Reason;

class Search {
 public:
  Search(const LocalSearchOptions& options, const Residuals& residuals, const StepRule& rule,
         const EvaluateBatch& evaluate)
      : options_(options), residuals_(residuals), rule_(rule), evaluate_(evaluate) {}

  LocalSearchEnd Run(const Observation& start);

 private:
  bool ValueAt(const Eigen::VectorXd& x, Eigen::VectorXd* rho);
  void MoveTo(const Eigen::VectorXd& x, const Eigen::VectorXd& rho);
  bool TakeStencil();
  std::optional<DifferenceJacobian> Stencil(Scheme scheme, double factor);
  bool LookForNoise();
  bool Verify(bool noise_excluded);
  bool IsSteep() const;
  bool Agree(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) const;
  bool Matched() const;
  ceres::CallbackReturnType After(const ceres::IterationSummary& summary);
  void Solve();

  const LocalSearchOptions& options_;
  const Residuals& residuals_;
  StepRule rule_;
  const EvaluateBatch& evaluate_;

  Eigen::VectorXd x_;           // the last accepted point
  Eigen::VectorXd rho_;         // residuals there
  DifferenceJacobian stencil_;  // the last one
  Eigen::MatrixXd jacobian_;    // stencil_'s, with the updates since
  bool fresh_ = false;          // without an update: stencil_ is at x_
  Scheme scheme_ = Scheme::one_sided;
  Eigen::VectorXd trial_;  // the last point without a Jacobian, and its residuals
  Eigen::VectorXd trial_rho_;
  double radius_ = kInitialRadius;
  int iterations_ = 0;
  int rejections_ = 0;  // in a row
  int failures_ = 0;
  bool noise_found_ = false;
  bool cancelled_ = false;
  bool stalled_ = false;
};

bool Search::ValueAt(const Eigen::VectorXd& x, Eigen::VectorXd* rho) {
  if (x == x_) {
    *rho = rho_;
    return true;
  }
  if (trial_.size() == 0 || x != trial_) {
    if (cancelled_) return false;
    trial_ = x;
    trial_rho_.resize(0);
    const auto answer = evaluate_({x}, {"Levenberg-Marquardt step"});
    if (!answer) {
      cancelled_ = true;
    } else if (residuals_.Complete(answer->front())) {
      trial_rho_ = residuals_.Of(answer->front());
    } else {
      ++failures_;
    }
  }
  *rho = trial_rho_;
  return trial_rho_.size() > 0;
}

// The point has been accepted. Cancelled: the Jacobian stays, and the callback ends the search.
void Search::MoveTo(const Eigen::VectorXd& x, const Eigen::VectorXd& rho) {
  const Eigen::VectorXd step = x - x_;
  if (step.squaredNorm() == 0) return;
  const Eigen::VectorXd change = rho - rho_;
  const Eigen::VectorXd error = change - jacobian_ * step;
  x_ = x;
  rho_ = rho;
  if (error.norm() <= kGoodPrediction * change.norm() || Matched()) {
    jacobian_ += error * step.transpose() / step.squaredNorm();
    fresh_ = false;
  } else {
    TakeStencil();
  }
}

std::optional<DifferenceJacobian> Search::Stencil(Scheme scheme, double factor) {
  Eigen::ArrayXd steps(x_.size());
  for (Eigen::Index k = 0; k < x_.size(); ++k) {
    steps[k] = factor * (scheme == Scheme::central ? rule_.Central(k) : rule_.OneSided(k));
  }
  auto stencil = Differences(x_, rho_, scheme, steps, residuals_, options_.symbols, evaluate_);
  if (!stencil) cancelled_ = true;
  return stencil;
}

bool Search::TakeStencil() {
  auto stencil = Stencil(scheme_, 1);
  if (!stencil) return false;
  stencil_ = std::move(*stencil);
  jacobian_ = stencil_.values;
  fresh_ = true;
  return true;
}

bool Search::Agree(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) const {
  const double floor = 1e-3 * a.norm() / std::sqrt(static_cast<double>(a.cols()));
  for (Eigen::Index k = 0; k < a.cols(); ++k) {
    if ((a.col(k) - b.col(k)).norm() > kAgreement * std::max(a.col(k).norm(), floor)) return false;
  }
  return true;
}

bool Search::IsSteep() const {
  return stencil_.values.colwise().norm().maxCoeff() > kSteep * rule_.spread;
}

// Compares the one-sided stencil, which is fresh, with one of ten times its steps. Noise σ gives
// their entries a difference of √2 σ/h, h the shorter step; curvature one of 9/2 h f''. Where it is
// noise a stencil with longer steps takes their place. False: cancelled.
bool Search::LookForNoise() {
  const auto longer = Stencil(Scheme::one_sided, 10);
  if (!longer) return false;
  double noise = 0;
  for (Eigen::Index k = 0; k < x_.size(); ++k) {
    const double difference = (stencil_.values.col(k) - longer->values.col(k)).norm();
    if (difference > 0.5 * stencil_.values.col(k).norm()) {
      noise = std::max(noise, stencil_.steps[k] * difference / std::sqrt(2.0));
    }
  }
  if (noise <= rule_.noise) return true;
  rule_.noise = noise;
  rule_.noisy = true;
  noise_found_ = true;
  scheme_ = Scheme::one_sided;
  return TakeStencil();
}

// Confirms the one-sided stencil, which is fresh, by a central one, and puts that into its place.
// Curvature may have made them differ: then its steps are shortened.
bool Search::Verify(bool noise_excluded) {
  for (int i = 0; i < kRefinements; ++i) {
    auto central = Stencil(Scheme::central, 1);
    if (!central) return false;
    const bool agree = Agree(stencil_.values, central->values);
    if (!agree && i == 0 && !noise_excluded) {
      if (!LookForNoise()) return false;
      if (rule_.noisy) return true;
    }
    if (!agree && i + 1 < kRefinements) {
      rule_.curvature = rule_.curvature.max(central->curvature);
      continue;
    }
    stencil_ = std::move(*central);
    jacobian_ = stencil_.values;
    scheme_ = Scheme::central;
    return true;
  }
  return true;
}

bool Search::Matched() const {
  const Eigen::ArrayXd targets = residuals_.targets.array() / residuals_.scales.array();
  return (rho_.array().abs() <= kMatched * targets.abs().max(1)).all();
}

ceres::CallbackReturnType Search::After(const ceres::IterationSummary& summary) {
  radius_ = summary.trust_region_radius;
  if (cancelled_ || Matched()) return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  if (summary.iteration == 0) return ceres::SOLVER_CONTINUE;
  ++iterations_;
  if (summary.step_is_successful) {
    rejections_ = 0;
    return ceres::SOLVER_CONTINUE;
  }
  ++rejections_;
  stalled_ = fresh_ && rejections_ >= (scheme_ == Scheme::central ? kSureRejections : kRejections);
  return stalled_ || !fresh_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
}

void Search::Solve() {
  rejections_ = 0;
  stalled_ = false;
  const auto function = [&](const Eigen::VectorXd& x, Eigen::VectorXd* rho,
                            Eigen::MatrixXd* jacobian) {
    if (!ValueAt(x, rho)) return false;
    if (jacobian != nullptr) {
      MoveTo(x, *rho);
      *jacobian = jacobian_;
    }
    return true;
  };
  Eigen::VectorXd x = x_;
  LevenbergMarquardt(function, static_cast<int>(residuals_.size()),
                     {.initial_radius = radius_,
                      .tolerance = options_.tolerance,
                      .max_iterations = options_.max_iterations - iterations_,
                      .after_iteration = [&](const auto& summary) { return After(summary); }},
                     &x);
}

LocalSearchEnd Search::Run(const Observation& start) {
  x_ = start.point;
  rho_ = residuals_.Of(start);
  Reason reason = Reason::converged;
  bool on = TakeStencil();
  if (on && !rule_.noisy && !rule_.fixed && IsSteep()) on = LookForNoise();
  while (on) {
    Solve();
    if (cancelled_) break;
    reason = Matched() ? Reason::matched : stalled_ ? Reason::stalled : Reason::converged;
    if (iterations_ >= options_.max_iterations) reason = Reason::exhausted;
    const bool over = reason == Reason::matched || reason == Reason::exhausted;
    if (!fresh_) {
      on = TakeStencil();
      if (over) break;
    } else if (over || rule_.noisy || rule_.fixed || scheme_ == Scheme::central) {
      break;
    } else {
      // Where steps of a stencil do not hold what it promised, noise is likely.
      if (stalled_) on = LookForNoise();
      if (on && !rule_.noisy) on = Verify(stalled_);
      radius_ = kInitialRadius;
    }
  }
  return {.reason = cancelled_ ? Reason::cancelled : reason,
          .point = x_,
          .residuals = rho_,
          .jacobian = stencil_,
          .rule = rule_,
          .noise_found = noise_found_,
          .failures = failures_};
}

}  // namespace

LocalSearchEnd SearchLocally(const LocalSearchOptions& options, const Residuals& residuals,
                             const StepRule& rule, const EvaluateBatch& evaluate,
                             const Observation& start) {
  return Search(options, residuals, rule, evaluate).Run(start);
}

}  // namespace powdercal

#include "optimizers/bayesian/improvement.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "optimizers/bayesian/expected_improvement.h"
#include "optimizers/designs/design.h"

namespace powdercal {
namespace {

constexpr int kSamples = 16;  // of the outcomes of pending evaluations

}  // namespace

ImprovementAcquisition::ImprovementAcquisition(Objective objective,
                                               std::vector<GaussianProcess> processes,
                                               Feasibility feasibility,
                                               const Eigen::MatrixXd& evaluated,
                                               const Eigen::MatrixXd& failed, std::uint64_t seed)
    : objective_(std::move(objective)),
      processes_(std::move(processes)),
      feasibility_(std::move(feasibility)),
      seed_(seed) {
  assert(evaluated.rows() > 0 && !processes_.empty());
  const auto count = static_cast<Eigen::Index>(processes_.size());
  Eigen::ArrayXXd means(evaluated.rows(), count);
  for (Eigen::Index j = 0; j < count; ++j) {
    GaussianProcess& process = processes_[static_cast<std::size_t>(j)];
    Eigen::VectorXd mean;
    Eigen::VectorXd variance;
    process.PredictMany(evaluated, &mean, &variance);
    means.col(j) = mean;
    process = process.ConditionedOn(failed);
  }
  best_ = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < evaluated.rows(); ++i) {
    const double value = ObjectiveOf(means.row(i).transpose());
    if (i == 0 || value < best_) {  // all infinite where the target lies out of all reach
      best_ = value;
      best_point_ = evaluated.row(i).transpose();
    }
  }
  sample_bests_ = {best_};
}

double ImprovementAcquisition::ObjectiveOf(const Eigen::ArrayXd& responses) const {
  if (!objective_.composite) return responses[0];
  return std::max(kSmallestObjective,
                  (objective_.weights * (responses - objective_.targets).square()).sum());
}

double ImprovementAcquisition::LogImprovementOf(double best, const Eigen::ArrayXd& means,
                                                const Eigen::ArrayXd& variances,
                                                Eigen::ArrayXd* by_mean,
                                                Eigen::ArrayXd* by_variance) const {
  if (objective_.composite) {
    return CompositeLogExpectedImprovement(best, means - objective_.targets, variances,
                                           objective_.weights, by_mean, by_variance);
  }
  const LogImprovement improvement =
      LogExpectedImprovement(best - objective_.margin, means[0], variances[0]);
  if (by_mean != nullptr) *by_mean = Eigen::ArrayXd::Constant(1, improvement.by_mean);
  if (by_variance != nullptr) *by_variance = Eigen::ArrayXd::Constant(1, improvement.by_variance);
  return improvement.value;
}

void ImprovementAcquisition::AddPending(const Eigen::VectorXd& point, bool counts) {
  const auto count = static_cast<Eigen::Index>(processes_.size());
  if (pending_ == 0) {
    sample_bests_.assign(kSamples, best_);
    samples_.assign(processes_.size(), Eigen::MatrixXd(0, kSamples));
  }
  const Eigen::MatrixXd row = point.transpose();
  // A dimension of the Sobol' sequence for each response of this pending evaluation.
  const Eigen::MatrixXd uniform =
      SobolPoints(kSamples, static_cast<int>(count),
                  RandomStream(seed_).Split(static_cast<std::uint64_t>(pending_)).seed());
  Eigen::ArrayXXd outcomes(count, kSamples);
  for (Eigen::Index j = 0; j < count; ++j) {
    GaussianProcess& process = processes_[static_cast<std::size_t>(j)];
    Eigen::MatrixXd& normals = samples_[static_cast<std::size_t>(j)];
    normals.conservativeResize(pending_ + 1, Eigen::NoChange);
    for (int k = 0; k < kSamples; ++k) normals(pending_, k) = NormalQuantile(uniform(k, j));
    process = process.ConditionedOn(row);
    // The tail at the point itself: what each sample makes of the mean there.
    const GaussianProcess::PointPosterior posterior =
        process.PosteriorAt(point, pending_ + 1, false);
    outcomes.row(j) = posterior.prediction.mean + (posterior.tail.transpose() * normals).array();
  }
  for (int k = 0; k < kSamples && counts; ++k) {
    double& best = sample_bests_[static_cast<std::size_t>(k)];
    best = std::min(best, ObjectiveOf(outcomes.col(k)));
  }
  ++pending_;
}

double ImprovementAcquisition::Evaluate(const Eigen::VectorXd& point,
                                        Eigen::VectorXd* gradient) const {
  const auto count = static_cast<Eigen::Index>(processes_.size());
  const auto sample_count = static_cast<Eigen::Index>(sample_bests_.size());
  std::vector<GaussianProcess::PointPosterior> posteriors;
  Eigen::ArrayXd variances(count);
  Eigen::ArrayXXd means(count, sample_count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const auto index = static_cast<std::size_t>(j);
    posteriors.push_back(processes_[index].PosteriorAt(point, pending_, gradient != nullptr));
    variances[j] = posteriors[index].prediction.variance;
    means.row(j) = posteriors[index].prediction.mean;
    if (pending_ > 0) {
      means.row(j) += (posteriors[index].tail.transpose() * samples_[index]).array();
    }
  }
  Eigen::ArrayXd values(sample_count);
  Eigen::ArrayXXd by_mean(count, sample_count);
  Eigen::ArrayXXd by_variance(count, sample_count);
  Eigen::ArrayXd mean_slope;
  Eigen::ArrayXd variance_slope;
  for (Eigen::Index k = 0; k < sample_count; ++k) {
    const double best = sample_bests_[static_cast<std::size_t>(k)];
    if (gradient == nullptr) {
      values[k] = LogImprovementOf(best, means.col(k), variances, nullptr, nullptr);
      continue;
    }
    values[k] = LogImprovementOf(best, means.col(k), variances, &mean_slope, &variance_slope);
    by_mean.col(k) = mean_slope;
    by_variance.col(k) = variance_slope;
  }
  Eigen::ArrayXd shares;
  const double value = LogMeanExp(values, &shares);
  if (gradient != nullptr) {
    *gradient = Eigen::VectorXd::Zero(point.size());
    for (Eigen::Index j = 0; j < count; ++j) {
      const auto index = static_cast<std::size_t>(j);
      const Eigen::VectorXd mean_shares = by_mean.row(j).transpose() * shares;
      *gradient +=
          mean_shares.sum() * posteriors[index].mean_gradient +
          (by_variance.row(j).transpose() * shares).sum() * posteriors[index].variance_gradient;
      if (pending_ > 0) {
        *gradient += posteriors[index].tail_gradient.transpose() * (samples_[index] * mean_shares);
      }
    }
  }
  return value + feasibility_.LogProbability(point, gradient);
}

Eigen::VectorXd ImprovementAcquisition::EvaluateMany(const Eigen::MatrixXd& points) const {
  const auto count = static_cast<Eigen::Index>(processes_.size());
  const auto sample_count = static_cast<Eigen::Index>(sample_bests_.size());
  Eigen::MatrixXd means(points.rows(), count);
  Eigen::MatrixXd variances(points.rows(), count);
  std::vector<Eigen::MatrixXd> tails(processes_.size(), Eigen::MatrixXd(points.rows(), pending_));
  for (Eigen::Index j = 0; j < count; ++j) {
    const auto index = static_cast<std::size_t>(j);
    Eigen::VectorXd mean;
    Eigen::VectorXd variance;
    processes_[index].PredictMany(points, &mean, &variance, &tails[index]);
    means.col(j) = mean;
    variances.col(j) = variance;
  }
  Eigen::VectorXd result(points.rows());
  Eigen::ArrayXd values(sample_count);
  Eigen::ArrayXd shares;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    for (Eigen::Index k = 0; k < sample_count; ++k) {
      Eigen::ArrayXd mean = means.row(i).transpose();
      for (Eigen::Index j = 0; j < count && pending_ > 0; ++j) {
        const auto index = static_cast<std::size_t>(j);
        mean[j] += tails[index].row(i).dot(samples_[index].col(k));
      }
      values[k] = LogImprovementOf(sample_bests_[static_cast<std::size_t>(k)], mean,
                                   variances.row(i).transpose(), nullptr, nullptr);
    }
    result[i] = LogMeanExp(values, &shares) +
                feasibility_.LogProbability(points.row(i).transpose(), nullptr);
  }
  return result;
}

}  // namespace powdercal

#include "optimizers/bayesian/sampled_acquisition.h"

#include <cassert>
#include <cmath>

#include "core/random.h"
#include "optimizers/designs/design.h"

namespace powdercal {
namespace {

constexpr int kMaxSobolDimension = 3667;

// rows × samples standard normals: Sobol' points while their dimension allows.
Eigen::MatrixXd Normals(Eigen::Index rows, Eigen::Index samples, RandomStream random) {
  Eigen::MatrixXd normals(rows, samples);
  const Eigen::Index quasi = std::min<Eigen::Index>(rows, kMaxSobolDimension);
  const Eigen::MatrixXd uniform =
      SobolPoints(static_cast<int>(samples), static_cast<int>(quasi), random.seed());
  for (Eigen::Index k = 0; k < samples; ++k) {
    for (Eigen::Index i = 0; i < rows; ++i) {
      normals(i, k) = i < quasi ? NormalQuantile(uniform(k, i)) : random.Normal();
    }
  }
  return normals;
}

}  // namespace

double ObjectiveTerm::ValueOf(const Eigen::ArrayXd& responses) const {
  double sum = 0;
  for (std::size_t j = 0; j < processes.size(); ++j) {
    const auto index = static_cast<Eigen::Index>(j);
    const double residual = responses[static_cast<Eigen::Index>(processes[j])] - targets[index];
    sum += weights[index] * (linear ? residual : residual * residual);
  }
  return sum;
}

SampledAcquisition::SampledAcquisition(Data data, std::unique_ptr<SampleUtility> utility,
                                       Eigen::Index samples, std::uint64_t seed)
    : feasibility_(std::move(data.feasibility)), utility_(std::move(utility)), samples_(samples) {
  const RandomStream stream(seed);
  const Eigen::Index points = data.counted.rows();
  assert(points > 0);
  std::vector<Eigen::MatrixXd> responses;  // for each process: points × K
  for (std::size_t j = 0; j < data.processes.size(); ++j) {
    const Eigen::Index size =
        SampledProcess::ObservationCount(data.processes[j]) + data.unobserved[j].rows();
    processes_.emplace_back(data.processes[j], data.unobserved[j],
                            Normals(size, samples, stream.Split(j)));
    Eigen::VectorXd variances;
    processes_.back().PredictMany(data.counted, &responses.emplace_back(), &variances);
  }
  const auto objectives = static_cast<Eigen::Index>(data.terms.size());
  Eigen::VectorXd first = Eigen::VectorXd::Zero(points);  // mean of the first objective
  for (Eigen::Index k = 0; k < samples; ++k) {
    Eigen::MatrixXd values(points, objectives);
    Eigen::ArrayXd at_point(static_cast<Eigen::Index>(processes_.size()));
    for (Eigen::Index i = 0; i < points; ++i) {
      for (std::size_t j = 0; j < responses.size(); ++j) {
        at_point[static_cast<Eigen::Index>(j)] = responses[j](i, k);
      }
      for (Eigen::Index o = 0; o < objectives; ++o) {
        values(i, o) = data.terms[static_cast<std::size_t>(o)].ValueOf(at_point);
      }
    }
    first += values.col(0);
    utility_->SetSample(k, values);
  }
  Eigen::Index best = 0;
  first.minCoeff(&best);
  best_point_ = data.counted.row(best).transpose();
}

double SampledAcquisition::Evaluate(const Eigen::VectorXd& point, Eigen::VectorXd* gradient) const {
  const auto count = static_cast<Eigen::Index>(processes_.size());
  const bool sloped = gradient != nullptr;
  std::vector<SampledProcess::Point> posteriors;
  Eigen::ArrayXd variances(count);
  for (Eigen::Index j = 0; j < count; ++j) {
    posteriors.push_back(processes_[static_cast<std::size_t>(j)].PosteriorAt(point, sloped));
    variances[j] = posteriors.back().variance;
  }
  Eigen::ArrayXd values(samples_);
  Eigen::ArrayXXd by_mean = Eigen::ArrayXXd::Zero(count, samples_);
  Eigen::ArrayXXd by_variance = Eigen::ArrayXXd::Zero(count, samples_);
  Eigen::ArrayXd means(count);
  Eigen::ArrayXd mean_slope;
  Eigen::ArrayXd variance_slope;
  for (Eigen::Index k = 0; k < samples_; ++k) {
    for (Eigen::Index j = 0; j < count; ++j) {
      means[j] = posteriors[static_cast<std::size_t>(j)].means[k];
    }
    values[k] = utility_->LogGain(k, means, variances, sloped ? &mean_slope : nullptr,
                                  sloped ? &variance_slope : nullptr);
    if (!sloped || !std::isfinite(values[k])) continue;
    by_mean.col(k) = mean_slope;
    by_variance.col(k) = variance_slope;
  }
  Eigen::ArrayXd shares;
  const double value = LogMeanExp(values, &shares);
  if (sloped) {
    *gradient = Eigen::VectorXd::Zero(point.size());
    for (Eigen::Index j = 0; j < count; ++j) {
      const SampledProcess::Point& posterior = posteriors[static_cast<std::size_t>(j)];
      *gradient +=
          posterior.mean_gradients.transpose() * (by_mean.row(j).transpose() * shares).matrix();
      *gradient += (by_variance.row(j).transpose() * shares).sum() * posterior.variance_gradient;
    }
  }
  return value + feasibility_.LogProbability(point, gradient);
}

Eigen::VectorXd SampledAcquisition::EvaluateMany(const Eigen::MatrixXd& points) const {
  const auto count = static_cast<Eigen::Index>(processes_.size());
  std::vector<Eigen::MatrixXd> means(processes_.size());
  std::vector<Eigen::VectorXd> variances(processes_.size());
  for (std::size_t j = 0; j < processes_.size(); ++j) {
    processes_[j].PredictMany(points, &means[j], &variances[j]);
  }
  Eigen::VectorXd result(points.rows());
  Eigen::ArrayXd values(samples_);
  Eigen::ArrayXd shares;
  Eigen::ArrayXd mean(count);
  Eigen::ArrayXd variance(count);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      variance[j] = variances[static_cast<std::size_t>(j)][i];
    }
    for (Eigen::Index k = 0; k < samples_; ++k) {
      for (Eigen::Index j = 0; j < count; ++j) mean[j] = means[static_cast<std::size_t>(j)](i, k);
      values[k] = utility_->LogGain(k, mean, variance, nullptr, nullptr);
    }
    result[i] = LogMeanExp(values, &shares) +
                feasibility_.LogProbability(points.row(i).transpose(), nullptr);
  }
  return result;
}

}  // namespace powdercal

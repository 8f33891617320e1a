#include "studies/evaluation.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "optimizers/pareto.h"

namespace powdercal {

ReducedResponses Reduce(const Objectives& objectives, const std::vector<const LedgerRun*>& runs) {
  const auto count = static_cast<Eigen::Index>(objectives.targets.size());
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  ReducedResponses reduced{Eigen::VectorXd::Constant(count, kNan),
                           Eigen::VectorXd::Constant(count, kNan), Eigen::VectorXi::Zero(count)};
  for (Eigen::Index t = 0; t < count; ++t) {
    const std::string& name = objectives.targets[static_cast<std::size_t>(t)].response;
    std::vector<double> values;
    for (const LedgerRun* run : runs) {
      const std::string prefix = run->experiment + ".";
      if (!run->outcome.ok() || !name.starts_with(prefix)) continue;
      const auto found = run->measurement.responses.find(name.substr(prefix.size()));
      if (found != run->measurement.responses.end()) values.push_back(found->second.value);
    }
    if (values.empty()) continue;
    const Eigen::Map<const Eigen::ArrayXd> array(values.data(),
                                                 static_cast<Eigen::Index>(values.size()));
    reduced.means[t] = array.mean();
    reduced.counts[t] = static_cast<int>(values.size());
    if (values.size() > 1) {
      reduced.sample_variances[t] =
          (array - array.mean()).square().sum() / static_cast<double>(values.size() - 1);
    }
  }
  return reduced;
}

Eigen::VectorXd PooledSeedVariance(const std::vector<ReducedResponses>& points, int target_count) {
  Eigen::VectorXd pooled = Eigen::VectorXd::Zero(target_count);
  for (Eigen::Index t = 0; t < target_count; ++t) {
    double sum = 0;
    int freedom = 0;
    for (const ReducedResponses& point : points) {
      if (point.counts[t] < 2) continue;
      sum += (point.counts[t] - 1) * point.sample_variances[t];
      freedom += point.counts[t] - 1;
    }
    if (freedom > 0) pooled[t] = sum / freedom;
  }
  return pooled;
}

Eigen::VectorXd VarianceOfMeans(const ReducedResponses& point, const Eigen::VectorXd& pooled) {
  Eigen::VectorXd variances = Eigen::VectorXd::Zero(pooled.size());
  for (Eigen::Index t = 0; t < pooled.size(); ++t) {
    if (point.counts[t] > 0) variances[t] = pooled[t] / point.counts[t];
  }
  return variances;
}

double ExpectedMisfit(const Objectives& objectives, const ReducedResponses& point,
                      const Eigen::VectorXd& pooled, int objective) {
  const Eigen::VectorXd variances = VarianceOfMeans(point, pooled);
  double sum = 0;
  for (Eigen::Index t = 0; t < point.means.size(); ++t) {
    const Target& target = objectives.targets[static_cast<std::size_t>(t)];
    if (objective >= 0 && target.objective != objective) continue;
    if (point.counts[t] == 0) return std::numeric_limits<double>::infinity();
    const double deviation = point.means[t] - target.value;
    sum += (deviation * deviation + variances[t]) / (target.sd * target.sd);
  }
  return sum;
}

std::vector<std::size_t> ParetoFront(const Objectives& objectives,
                                     const std::vector<ReducedResponses>& points,
                                     const Eigen::VectorXd& pooled) {
  Eigen::MatrixXd misfits(static_cast<Eigen::Index>(points.size()), ObjectiveCount(objectives));
  for (Eigen::Index i = 0; i < misfits.rows(); ++i) {
    for (int o = 0; o < misfits.cols(); ++o) {
      misfits(i, o) = ExpectedMisfit(objectives, points[static_cast<std::size_t>(i)], pooled, o);
    }
  }
  return NonDominated(misfits);
}

bool WithinTolerance(const Study& study, const ReducedResponses& point) {
  bool any = false;
  const auto observations = study.Observations();
  for (std::size_t t = 0; t < observations.size(); ++t) {
    if (!observations[t]->tolerance) continue;
    any = true;
    const double mean = point.means[static_cast<Eigen::Index>(t)];
    if (!(std::abs(mean - observations[t]->value) < *observations[t]->tolerance)) return false;
  }
  return any;
}

ExperimentFailure FailureOf(const std::string& experiment, const std::string& missing,
                            const std::vector<const LedgerRun*>& runs) {
  ExperimentFailure failure{.experiment = experiment, .reason = kNoValue};
  for (const LedgerRun* run : runs) {
    if (run->experiment != experiment) continue;
    ++failure.runs;
    if (run->outcome.ok()) continue;
    if (failure.failed_runs++ > 0) continue;
    failure.reason = ToString(run->outcome.reason);
    failure.message = run->outcome.message;
  }
  if (failure.failed_runs == 0 && failure.runs > 0) {
    failure.message = fmt::format("the simulations gave no {}", missing);
  }
  return failure;
}

std::vector<ExperimentFailure> FailuresOf(const Objectives& objectives,
                                          const ReducedResponses& point,
                                          const std::vector<const LedgerRun*>& runs) {
  std::vector<ExperimentFailure> failures;
  for (std::size_t t = 0; t < objectives.targets.size(); ++t) {
    if (point.counts[static_cast<Eigen::Index>(t)] > 0) continue;
    const std::string& name = objectives.targets[t].response;
    const std::size_t dot = name.find('.');
    const std::string experiment = name.substr(0, dot);
    if (!failures.empty() && failures.back().experiment == experiment) continue;
    failures.push_back(FailureOf(experiment, name.substr(dot + 1), runs));
  }
  return failures;
}

}  // namespace powdercal

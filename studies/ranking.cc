#include "studies/ranking.h"

#include <algorithm>
#include <exception>

#include "optimizers/models.h"

namespace powdercal {
namespace {

constexpr std::ptrdiff_t kFewestPoints = 8;

double ModelledMisfit(const Objectives& objectives, const Models& models,
                      const Eigen::VectorXd& point) {
  double sum = 0;
  for (std::size_t i = 0; i < models.targets.size(); ++i) {
    const Target& target = objectives.targets[models.targets[i]];
    const Prediction prediction = models.processes[i].Predict(point);
    const double deviation = prediction.mean - target.value;
    sum += (deviation * deviation + prediction.variance) / (target.sd * target.sd);
  }
  return sum;
}

}  // namespace

std::vector<double> RankingMisfits(const SearchSpace& space, const Objectives& objectives,
                                   const std::vector<Eigen::VectorXd>& points,
                                   const std::vector<ReducedResponses>& reduced) {
  const Eigen::VectorXd pooled =
      PooledSeedVariance(reduced, static_cast<int>(objectives.targets.size()));
  std::vector<double> misfits;
  for (const ReducedResponses& point : reduced) {
    misfits.push_back(ExpectedMisfit(objectives, point, pooled));
  }
  const std::ptrdiff_t complete = std::count_if(
      reduced.begin(), reduced.end(), [](const ReducedResponses& p) { return p.complete(); });
  if (!(pooled.array() > 0).any() ||
      complete < std::max<std::ptrdiff_t>(kFewestPoints, 2 * (space.dimension() + 1))) {
    return misfits;
  }
  ObservationsById observations;
  for (std::size_t i = 0; i < points.size(); ++i) {
    observations[static_cast<std::int64_t>(i)] = {.id = static_cast<std::int64_t>(i),
                                                  .point = points[i],
                                                  .responses = reduced[i].means,
                                                  .variances = VarianceOfMeans(reduced[i], pooled),
                                                  .failed = reduced[i].failed()};
  }
  try {
    const Models models = FitResponses(space, objectives, observations, {});
    if (models.targets.size() < objectives.targets.size()) return misfits;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (reduced[i].complete()) misfits[i] = ModelledMisfit(objectives, models, points[i]);
    }
  } catch (const std::exception&) {
    // A process that cannot be fitted says nothing; the points' own means do.
  }
  return misfits;
}

}  // namespace powdercal

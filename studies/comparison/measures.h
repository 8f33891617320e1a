#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "studies/comparison/record.h"

namespace powdercal::comparison {

/// How good a search is after each of its evaluations; lower is better; ∞ while nothing was found.
struct Trajectory {
  std::vector<double> values;
  std::vector<double> core_seconds;  ///< spent until then; ascending
};

/// joint: chi² of the point that would be reported, as it is judged.
Trajectory ReportedChi2(const ContestRecord& record);

/// What hypervolume is measured by: the logarithms of the objectives' chi², which span decades, but
/// not below kSmallestMisfit.
struct FrontScale {
  Eigen::VectorXd ideal;      ///< [ln chi²] lowest of each objective on the front of all contests
  Eigen::VectorXd reference;  ///< [ln chi²] median of each over all evaluations of all contests
  double hypervolume = 0;     ///< of the front, scaled to ideal 0 and reference 1; > 0
  bool empty() const { return ideal.size() == 0; }
};
/// chi² of an objective below which nothing is gained: a response off by a tenth of its standard
/// deviation.
inline constexpr double kSmallestMisfit = 0.01;
/// Empty where no evaluation has succeeded.
FrontScale ScaleOfFront(std::span<const ContestRecord> records);

/// pareto: share of the hypervolume of the front of all contests that the evaluations have not
/// reached, in [0, 1].
Trajectory LostHypervolume(const ContestRecord& record, const FrontScale& scale);

/// After `evaluations`, or as many as there are; ∞ with none.
double ValueAfter(const Trajectory& trajectory, int evaluations);
/// After as many evaluations as had ended when so much was spent.
double ValueWithin(const Trajectory& trajectory, double core_seconds);
/// Number of evaluations until the value is `level` or below; 0: never.
int EvaluationsTo(const Trajectory& trajectory, double level);

struct Quartiles {
  double lower = kNone;
  double median = kNone;
  double upper = kNone;
};
Quartiles QuartilesOf(const std::vector<double>& values);

/// Quartiles over contests along an axis.
struct Band {
  std::vector<double> x;
  std::vector<Quartiles> y;
};
Band BandByEvaluations(std::span<const Trajectory> trajectories, int evaluations);
Band BandByCoreSeconds(std::span<const Trajectory> trajectories, double core_seconds);

/// Levels to be reached, `count` of them, evenly spaced in the logarithm: from the median of the
/// first values of all trajectories down to the lowest value of any, but not below `floor`.
/// Descending. Empty where nothing was found at all.
std::vector<double> TargetLevels(std::span<const Trajectory> trajectories, double floor, int count);

/// Share of the pairs of contest and level that were reached after 1, 2, … evaluations (Hansen et
/// al. 2021, section 4).
std::vector<double> ShareOfTargets(std::span<const Trajectory> trajectories,
                                   const std::vector<double>& levels, int evaluations);

}  // namespace powdercal::comparison

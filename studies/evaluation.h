#pragma once

#include <optional>
#include <string>
#include <vector>

#include "optimizers/optimizer.h"
#include "studies/ledger.h"
#include "studies/results.h"
#include "studies/study.h"

namespace powdercal {

/// The runs of one parameter point, reduced to one value per target.
struct ReducedResponses {
  Eigen::VectorXd means;  ///< in the order of the targets; NaN where every replicate failed
  Eigen::VectorXd sample_variances;  ///< between replicates; NaN with fewer than two
  Eigen::VectorXi counts;            ///< replicates with a value
  bool failed() const { return (counts.array() == 0).all(); }
  bool complete() const { return (counts.array() > 0).all(); }
  bool partial() const { return !failed() && !complete(); }
};

/// Runs of any experiment and replicate, in any order; failed ones included.
ReducedResponses Reduce(const Objectives& objectives, const std::vector<const LedgerRun*>& runs);

/// Seed variance of single runs for each target, pooled over all points with at least two
/// replicates (scatter between seeds varies little over the box, and two or three seeds alone say
/// little of it): s² = Σ (n_i − 1) s_i² / Σ (n_i − 1). 0 where nothing is known.
Eigen::VectorXd PooledSeedVariance(const std::vector<ReducedResponses>& points, int target_count);

/// Variances of the means: pooled / n; 0 where unknown.
Eigen::VectorXd VarianceOfMeans(const ReducedResponses& point, const Eigen::VectorXd& pooled);

/// What points are ranked by: Σ ((mean − target)² + variance of the mean)/sd², the expected squared
/// misfit of the true response. Unlike chi², it does not reward a point for being poorly known.
/// Infinite unless every target counted has a value. objective < 0: all targets, else those of that
/// objective.
double ExpectedMisfit(const Objectives& objectives, const ReducedResponses& point,
                      const Eigen::VectorXd& pooled, int objective = -1);

/// Indices of the complete points that no other complete point dominates in the expected misfits of
/// the objectives (NonDominated, optimizers/pareto.h), ascending.
std::vector<std::size_t> ParetoFront(const Objectives& objectives,
                                     const std::vector<ReducedResponses>& points,
                                     const Eigen::VectorXd& pooled);

/// Whether every target that has a tolerance is met by the means, and at least one has.
bool WithinTolerance(const Study& study, const ReducedResponses& point);

/// For each experiment, in the order of the targets, of which a response has no value: why.
std::vector<ExperimentFailure> FailuresOf(const Objectives& objectives,
                                          const ReducedResponses& point,
                                          const std::vector<const LedgerRun*>& runs);
/// The same for one experiment, `missing` being a response without a value.
ExperimentFailure FailureOf(const std::string& experiment, const std::string& missing,
                            const std::vector<const LedgerRun*>& runs);

}  // namespace powdercal

#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "optimizers/optimizer.h"
#include "studies/comparison/contest.h"

namespace powdercal::comparison {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// The search after one more evaluation, in the order of telling.
struct Step {
  /// chi² of this evaluation for each objective (joint: one over all targets), as it is judged:
  /// of the truth where that is known, else the expected misfit of what was observed. NaN where it
  /// failed, wholly or in part.
  std::vector<double> judged;
  /// The evaluation that a study would report after this one (RankingMisfits): an index into the
  /// steps; −1: none has succeeded.
  int reported = -1;
  double core_seconds = 0;  ///< spent until then
  double told_at = 0;       ///< [s] of virtual time
  bool failed = false;      ///< no value at all, or not all of them
};

/// The reported point, simulated anew.
struct HoldOut {
  std::string fidelity;
  int seeds = 0;        ///< fresh particle seeds
  double chi2 = kNone;  ///< of the means over them; NaN where they failed
};

/// What is kept of a contest.
struct ContestRecord {
  std::string label;  ///< of the contestant
  int seed = 0;
  std::string key;  ///< hash of all that determines it
  std::vector<Step> steps;
  std::string end;                 ///< why it ended
  std::string error;               ///< of an optimizer that broke off; "" otherwise
  std::vector<double> parameters;  ///< SI, of the point reported in the end; empty: none
  double fit = kNone;              ///< what that point was ranked by (RankingMisfits)
  std::vector<HoldOut> hold_out;   ///< first at the study's own fidelity
  double core_seconds = 0;         ///< of all simulations
  double busy_seconds = 0;         ///< of all slots together, virtual
  double makespan = 0;             ///< [s] virtual
  double optimizer_seconds = 0;    ///< of the optimizer itself, as measured; not reproducible
};

/// Responses without scatter at a point of the unit box; empty: not known.
using Truth = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

/// What a contest has come to. Evaluations that ended beyond the budget of core-seconds do not
/// count. `hold_out`, `label`, `seed`, `key` and `optimizer_seconds` are the caller's.
ContestRecord Summarise(const Contest& contest, const SearchSpace& space, const Truth& truth);

/// Point (unit box) of the evaluation that is reported in the end; empty: none.
Eigen::VectorXd ReportedPoint(const Contest& contest, const ContestRecord& record);

}  // namespace powdercal::comparison

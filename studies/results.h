#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "optimizers/optimizer.h"
#include "scaling/groups.h"
#include "scaling/real_powder.h"
#include "studies/approximation.h"

namespace powdercal {

/// A response with what was simulated for it, and what it should be. SI units.
struct ResponseResult {
  std::string name;  ///< "consolidation.void_ratio"
  std::string unit;
  std::optional<double> simulated;  ///< mean over the replicates; empty when all failed
  double seed_sd = 0;               ///< standard deviation between replicates; 0: fewer than two
  int replicates = 0;               ///< how many gave a value
  double observed = 0;              ///< meaningless unless was_observed()
  double sd = 0;  ///< of the observation, > 0; 0: there is none (of a transfer only)
  std::optional<double> tolerance;
  std::string source;

  bool was_observed() const { return sd > 0; }
};

/// How well a point serves one objective of a study with several.
struct ObjectiveResult {
  std::optional<double> chi2;    ///< over its targets; empty unless all of them have a value
  std::optional<double> misfit;  ///< expected misfit (studies/evaluation.h): what points rank by
};

/// Why an experiment gave no value of a response at some parameter point.
struct ExperimentFailure {
  std::string experiment;
  std::string reason;   ///< reason code of its first failed run, or kNoValue
  std::string message;  ///< of that run
  int failed_runs = 0;
  int runs = 0;  ///< of the experiment at this point, failed ones included
};
/// The simulations were in order, but the response could not be had from them.
inline constexpr const char* kNoValue = "no_value";
/// Outcome of an evaluation some of whose experiments gave values.
inline constexpr const char* kPartial = "partial";

/// One simulation.
struct RunResult {
  std::int64_t id = 0;
  std::string experiment;
  std::string backend;
  int replicate = 0;
  std::uint64_t seed = 0;  ///< of the particles
  std::string program_hash;
  std::string reason;  ///< reason code, "ok"
  std::string message;
  double wall_seconds = 0;
  std::map<std::string, double> responses;    ///< SI
  std::map<std::string, double> diagnostics;  ///< SI
  std::string law;                            ///< as run
};

/// One parameter point, in the order of asking.
struct EvaluationResult {
  std::int64_t id = 0;
  std::map<std::string, double> parameters;  ///< SI; indices of categories
  std::string origin;                        ///< "initial design: corner 3"
  std::string fidelity;                      ///< that it was asked for at, "quick"
  std::string outcome;                       ///< "ok", kPartial, or the reason code of its failure
  std::string message;                       ///< of what failed
  std::vector<ExperimentFailure> failures;   ///< empty when ok
  std::vector<ResponseResult> responses;     ///< in the order of the targets
  std::optional<double> chi2;                ///< empty unless every response has a value
  std::optional<double> best_chi2;  ///< chi2 of the best point so far (ranked by expected misfit)
  std::vector<ObjectiveResult> objectives;  ///< as in StudyResults::objectives
  std::vector<RunResult> runs;
};

/// An experiment of the study.
struct ExperimentResult {
  std::string name;
  std::string fidelity;
  bool calibrated = true;
};

/// The best point on experiments that were not calibrated, as far as it was evaluated on them.
struct TransferResult {
  std::vector<std::string> experiments;   ///< in the order of the study; empty: none was evaluated
  std::vector<ResponseResult> responses;  ///< all that these can measure, observed or not
  std::vector<ExperimentFailure> failures;
  std::vector<RunResult> runs;
};

/// The best point on another backend: the same programs, hence the same particles.
struct ConfirmationResult {
  std::string backend;
  std::string version;  ///< "" where the backend was not available
  std::string
      outcome;  ///< "ok", kPartial, kUnavailable, kPending, or the reason code of its failure
  std::string message;  ///< of what failed
  std::string law;      ///< as run
  std::vector<ExperimentFailure> failures;
  std::vector<ResponseResult> responses;  ///< in the order of the targets; empty while pending
  std::optional<double> chi2;             ///< empty unless every response has a value
  std::vector<RunResult> runs;
};
/// Outcome of a confirmation by a backend that is not on this machine.
inline constexpr const char* kUnavailable = "unavailable";
/// Outcome of a confirmation of which nothing has been run yet.
inline constexpr const char* kPending = "pending";

/// What the study's approximations change at the best point: the calibrated experiments on
/// kReferenceBackend under both laws, from the same particles.
struct ApproximationEffect {
  std::string backend;
  std::string version;
  std::vector<ResponseResult> exact;  ///< in the order of the targets, as is `approximated`
  std::vector<ResponseResult> approximated;
  std::vector<ExperimentFailure> failures;  ///< of the law that is approximated
  std::vector<RunResult> runs;              ///< under that law
};

/// Pi groups of one experiment of the study.
struct ScalingTable {
  std::string experiment;
  std::vector<GroupComparison> groups;  ///< with the best point's parameters
  Conditions laboratory;
  Conditions simulation;
  std::optional<PowderCohesion> cohesion;  ///< what the simulated one says of the powder
};

/// All that is known of a study, from its ledger. reports/ turns this into files.
struct StudyResults {
  std::string study;
  std::string description;
  std::string powder;
  std::string fingerprint;
  std::string program_version;  ///< of powdercal
  std::uint64_t seed = 0;

  std::vector<Parameter> parameters;
  std::vector<std::string> objectives;  ///< pareto: the experiment behind each; empty: joint
  std::string optimizer;
  std::string optimizer_description;
  std::string backend;
  std::string backend_version;
  bool simulated = true;  ///< false: the table backend; no simulation was run
  std::string fidelity;   ///< of experiments without one of their own
  std::vector<ExperimentResult> experiments;
  int replicates = 1;
  std::string law;         ///< canonical contact law of the best point, before approximations
  std::string law_as_run;  ///< in the backend's terms
  std::vector<ApproximationStatement> approximations;       ///< of the law
  std::optional<ApproximationEffect> approximation_effect;  ///< as far as it was measured
  std::string scaling;
  std::string scaling_description;
  std::string study_yaml;  ///< resolved

  std::string state;        ///< "finished", "interrupted", "running"
  std::string stop_reason;  ///< "every tolerance reached", "budget of 40 evaluations used", …
  bool converged = false;   ///< every response with a tolerance is within it at the best point
  std::vector<std::string> warnings;

  int total = 0;  ///< evaluations asked for and ended, at whatever fidelity
  int ok = 0;
  int partial = 0;                        ///< some experiments gave values, others failed
  int failed = 0;                         ///< no experiment gave a value
  int cached = 0;                         ///< evaluations served from the ledger without a new run
  std::optional<std::size_t> best;        ///< index into history
  std::vector<std::size_t> pareto;        ///< the front (ParetoFront), into history; empty: joint
  std::vector<EvaluationResult> history;  ///< at the study's own fidelity
  /// What the optimizer learnt from besides: evaluations at `backend.lower_fidelities`. They are
  /// ranked nowhere, and are no part of anything that is said of the powder.
  std::vector<EvaluationResult> lower_fidelity;
  std::vector<ConfirmationResult> confirmations;  ///< on the backends of `confirm_with`, in order
  TransferResult transfer;
  std::vector<ScalingTable> scaling_tables;

  double wall_seconds = 0;        ///< of the study, over all its sessions
  double simulation_seconds = 0;  ///< sum over the simulators' processes
  double overhead_seconds = 0;    ///< work that was not inside a simulator, over all threads
  int parallel = 1;
};

}  // namespace powdercal

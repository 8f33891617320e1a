#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "studies/ledger.h"
#include "studies/results.h"
#include "studies/study.h"

namespace powdercal {

/// On which the effect of approximations is measured: it has every contact law.
inline constexpr const char* kReferenceBackend = "embedded";

/// One simulation, planned: which experiment, which particle seed, which program.
struct PlannedRun {
  std::size_t experiment = 0;  ///< index into Study::experiments
  int replicate = 0;
  std::uint64_t seed = 0;  ///< of the particles
  Program program;
  std::string program_hash;
  std::string key;  ///< cache key in the ledger
};

/// Turns parameter values into programs, and traces into ledger entries. Stateless but for the
/// study; safe to call from several threads.
class Planner {
 public:
  /// The study must outlive the planner.
  explicit Planner(const Study& study);
  /// Plans with another scaling than the study's own; it must outlive the planner, too.
  Planner(const Study& study, const Scaling& scaling);
  /// Whether programs have the law with the study's approximations, or the one that these replace.
  enum class Law { simulated, exact };
  /// Plans no experiment at a fidelity above this one.
  Planner(const Study& study, Fidelity limit);
  /// For another simulator than the study's own, which must outlive the planner as well;
  /// Prepare()d.
  Planner(const Study& study, const Backend& backend, Law law = Law::simulated);

  /// Why there is no program of an experiment, for the scaling or the experiment itself, or "".
  std::string ExplainUnplanned(std::size_t experiment) const;
  /// The program of one replicate of an experiment. Requires ExplainUnplanned() == "".
  /// `parameters`: SI, in the order of the search space. `seed` overrides the particle seed that
  /// follows from study seed, values and replicate.
  PlannedRun PlanExperiment(std::size_t experiment, const std::vector<double>& parameters,
                            int replicate, std::optional<std::uint64_t> seed = {}) const;
  /// Programs of one replicate, one for each experiment that is calibrated.
  std::vector<PlannedRun> Plan(const std::vector<double>& parameters, int replicate) const;

  /// The centre of the search box [SI].
  std::vector<double> Centre() const;
  /// The same with each combination of the categories; without categories the centre alone.
  std::vector<std::vector<double>> Centres() const;

  /// Why these experiments cannot be run, for the scaling, themselves or the backend, or "".
  std::string ExplainUnsupported(const std::vector<std::size_t>& experiments) const;
  /// The same for those that are calibrated.
  std::string ExplainUnsupported() const;

  /// What a user should know before anything is run: the study's own warnings, a time step beyond
  /// 0.4 Rayleigh times, and what the experiments warn of at the largest rolling friction.
  std::vector<std::string> Warnings(const std::vector<std::size_t>& evaluate_also = {}) const;

  /// Why the backends of `confirm_with` will not, or not wholly, confirm the best point: a sentence
  /// for each.
  std::vector<std::string> ConfirmationWarnings() const;

  /// Runs a planned simulation and measures it. Never throws for failures of the simulation;
  /// `unsupported` where the backend is not available.
  LedgerRun Execute(const PlannedRun& run, const RunContext& context) const;

  /// Conditions of an experiment in the laboratory and, with these parameters, in the simulation.
  Conditions Laboratory(std::size_t experiment) const;
  Conditions Simulation(std::size_t experiment, const std::vector<double>& parameters) const;
  /// Pi groups of these experiments, as far as they can be planned.
  std::vector<ScalingTable> ScalingTables(const std::vector<std::size_t>& experiments,
                                          const std::vector<double>& parameters) const;

  /// What one run of an experiment costs, at the centre of the box; zeros if it cannot be planned.
  struct ExperimentCost {
    std::size_t experiment = 0;
    int runs = 0;  ///< all evaluations, replicates and the confirmation; or the seeds of a transfer
    int particles = 0;
    double steps = 0;    ///< of one run
    double seconds = 0;  ///< of one run, on as many cores as it keeps busy; 0: no simulation
  };
  /// What it costs to confirm the best point on another backend; the experiments that it can run.
  struct ConfirmationCost {
    std::string backend;
    std::vector<ExperimentCost> experiments;
  };
  /// What the whole study may cost, from the centre of the box; right within a factor of about 2.
  struct Cost {
    std::vector<ExperimentCost> experiments;
    std::vector<ConfirmationCost> confirmations;
    /// Of measuring what the study's approximations change, on kReferenceBackend.
    std::vector<ExperimentCost> approximation;
    int runs = 0;                ///< sum over the experiments and confirmations
    double steps_per_run = 0;    ///< mean over the runs
    double seconds_per_run = 0;  ///< mean over the runs
    double seconds = 0;          ///< wall clock with the study's parallelism
  };
  /// `evaluate_also`: experiments that the best point is evaluated on at the end.
  Cost EstimateCost(const std::vector<std::size_t>& evaluate_also = {}) const;
  ExperimentCost CostOf(std::size_t experiment, int runs) const;
  Fidelity FidelityOf(std::size_t experiment) const;

  const Study& study() const { return study_; }
  const Scaling& scaling() const { return scaling_; }
  const Backend& backend() const { return backend_; }
  Law law() const { return law_; }
  const Availability& availability() const { return availability_; }

 private:
  Planner(const Study& study, const Scaling& scaling, const Backend& backend, Law law);
  SimulatedPowder MakePowder(const Conditions& simulation,
                             const std::vector<double>& parameters) const;
  std::string ExplainBackend(std::size_t experiment) const;

  const Study& study_;
  const Scaling& scaling_;
  const Backend& backend_;
  Law law_;
  std::optional<Fidelity> limit_;
  Availability availability_;
  std::optional<double> largest_stress_;  // [Pa] of all experiments of the study
};

}  // namespace powdercal

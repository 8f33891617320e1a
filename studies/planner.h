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

  /// Programs of one replicate, one for each experiment. `parameters`: SI, in the order of the
  /// search space. `seed` overrides the particle seed that follows from study seed, values and
  /// replicate.
  std::vector<PlannedRun> Plan(const std::vector<double>& parameters, int replicate,
                               std::optional<std::uint64_t> seed = {}) const;

  /// The centre of the search box [SI].
  std::vector<double> Centre() const;

  /// Why the study cannot be run, for the scaling, an experiment or the backend, or "".
  std::string ExplainUnsupported() const;

  /// What a user should know before anything is run: the study's own warnings, a time step beyond
  /// 0.4 Rayleigh times, and what the experiments warn of at the largest rolling friction.
  std::vector<std::string> Warnings() const;

  /// Runs a planned simulation and measures it. Never throws for failures of the simulation.
  LedgerRun Execute(const PlannedRun& run, const RunContext& context) const;

  /// Conditions of an experiment in the laboratory and, with these parameters, in the simulation.
  Conditions Laboratory(std::size_t experiment) const;
  Conditions Simulation(std::size_t experiment, const std::vector<double>& parameters) const;
  /// Pi groups of every experiment.
  std::vector<ScalingTable> ScalingTables(const std::vector<double>& parameters) const;

  /// What the whole study may cost, from the centre of the box; right within a factor of about 2.
  struct Cost {
    int runs = 0;                ///< all evaluations, replicates and the confirmation
    double steps_per_run = 0;    ///< mean over the experiments
    double seconds_per_run = 0;  ///< on one core; 0: no simulation
    double seconds = 0;          ///< wall clock with the study's parallelism
  };
  Cost EstimateCost() const;

  const Study& study() const { return study_; }
  const Availability& availability() const { return availability_; }

 private:
  SimulatedPowder MakePowder(const Conditions& simulation,
                             const std::vector<double>& parameters) const;

  const Study& study_;
  Availability availability_;
};

}  // namespace powdercal

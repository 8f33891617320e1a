#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "studies/executor.h"
#include "studies/ledger.h"
#include "studies/planner.h"
#include "studies/run_directory.h"

namespace powdercal::comparison {

/// Simulations for several parties at once, each simulated only once: what the ledger holds is
/// served from it, what is under way already is waited for.
class SimulationPool {
 public:
  using Callback = std::function<void(const LedgerRun&)>;

  /// Work folders are those of `folder`. Failed runs are results, and are kept as well.
  SimulationPool(const RunDirectory& folder, Ledger& ledger, int parallel,
                 std::optional<std::chrono::duration<double>> time_limit);

  /// Has a replicate of an experiment simulated; calls back with its run, at once where it is
  /// known. Low priorities go first. `own`: the run is one of the point's own replicates in the
  /// ledger; others are kept apart. The planner must outlive the pool.
  void Ask(int priority, const Planner& planner, std::size_t experiment,
           const std::vector<double>& parameters, int replicate, bool own, Callback callback);

  /// Whether a slot is free and nothing is waiting for it.
  bool hungry() const { return pending_.empty() && Free(); }
  bool idle() const { return pending_.empty() && in_flight_.empty(); }
  /// Starts what can be started, and waits a moment for a run to end; returns it.
  std::optional<LedgerRun> Step();
  /// Gives up everything; what is under way is cancelled, and nobody is called back.
  void Cancel();

 private:
  struct Job {
    PlannedRun run;
    const Planner* planner = nullptr;
    std::vector<double> parameters;
    bool own = true;
  };

  bool Free() const { return static_cast<int>(in_flight_.size()) < executor_.capacity(); }
  void Submit();
  std::int64_t CandidateOf(const Job& job);

  const RunDirectory& folder_;
  Ledger& ledger_;
  std::optional<std::chrono::duration<double>> time_limit_;
  std::map<std::vector<double>, std::int64_t> candidates_;  // by parameters
  std::map<std::pair<int, std::int64_t>, Job> pending_;     // by priority, then order
  std::map<std::int64_t, Job> in_flight_;                   // by ticket
  std::map<std::string, std::vector<Callback>> waiting_;    // by cache key
  std::int64_t next_ = 0;
  LocalExecutor executor_;  // last: its jobs use the other members' referents
};

}  // namespace powdercal::comparison

#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "studies/comparison/field.h"
#include "studies/comparison/oracle.h"
#include "studies/comparison/record.h"
#include "studies/planner.h"
#include "studies/run_directory.h"

namespace powdercal::comparison {

/// A contest that is to be held.
struct Task {
  const Contestant* contestant = nullptr;
  int seed = 0;
  std::string key;  ///< see ContestKey
};

/// SHA-256 of all that a contest's record depends on. `source`: what answers for the simulator.
std::string ContestKey(Study& study, const Field& field, const Contestant& contestant, int seed,
                       const Rules& rules, const std::string& source, int hold_out_seeds);

/// Told from the calling thread.
class ContestListener {
 public:
  virtual ~ContestListener() = default;
  /// A contest has ended; `done` of `all` have.
  virtual void OnContest(const ContestRecord& /*record*/, int /*done*/, int /*all*/) {}
  /// A simulation has ended.
  virtual void OnRun(const LedgerRun& /*run*/) {}
  /// Some times a second.
  virtual void OnTick(int /*done*/, int /*all*/) {}
};

struct ContestOptions {
  Rules rules;
  int hold_out_seeds = 3;               ///< fresh particle seeds of the reported point; 0: none
  std::stop_token stop;                 ///< contests that have not ended by then are left out
  ContestListener* listener = nullptr;  ///< null: nobody listens
};

/// Holds contests against an oracle, `threads` at a time. Evaluations are judged by its truth.
/// Returns the records of those that ended, in the order of the tasks.
std::vector<ContestRecord> HoldOnOracle(const Study& study, const Field& field,
                                        const std::vector<Task>& tasks, const Oracle& oracle,
                                        const ContestOptions& options, int threads);

/// Holds contests on the study's simulator, several interleaved so that no core idles. Every run is
/// committed to the ledger of `folder` when it ends, and what the ledger holds is not repeated,
/// whichever contest it was simulated for. Evaluations are judged by what was observed, reported
/// points by fresh particle seeds, and by as many at the next higher fidelity if `raised` has it
/// (null: not).
std::vector<ContestRecord> HoldOnSimulator(const Field& field, const std::vector<Task>& tasks,
                                           const Planner& planner, const Planner* raised,
                                           const RunDirectory& folder, Ledger& ledger,
                                           const ContestOptions& options);

/// The study at the next higher fidelity of each experiment; null where all are at the highest.
std::unique_ptr<Study> RaisedFidelity(Study& study);

}  // namespace powdercal::comparison

#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "backends/backend.h"
#include "experiments/experiment.h"
#include "studies/ledger.h"
#include "verification/finding.h"

namespace powdercal::verification {

/// A backend that is verified. The backend must outlive it.
struct Contender {
  explicit Contender(const Backend& verified)
      : name(verified.name()), backend(&verified), availability(verified.availability()) {}

  /// "" if it can run the program here and now, else why not.
  std::string ExplainUnsupported(const Program& program) const;

  std::string name;  ///< distinct among the backends of a ladder
  const Backend* backend;
  Availability availability;
};

/// One simulation that a rung needs.
struct Job {
  const Contender* contender = nullptr;
  Program program;
  std::uint64_t seed = 0;
  std::string name;  ///< for people and folders: "packing, seed 3"
  bool keep = true;  ///< in the ledger, where there is one
  /// Measures a trace whose outcome is ok; called from the job's own thread.
  std::function<Measurement(const Trace&, Outcome*)> measure;
};

/// Told from the calling thread, in the order in which runs end.
class RunListener {
 public:
  virtual ~RunListener() = default;
  /// A rung begins; `known` of its runs are in the ledger.
  virtual void OnRung(Rung /*rung*/, int /*runs*/, int /*known*/) {}
  virtual void OnRun(const Job& /*job*/, const LedgerRun& /*run*/, int /*done*/, int /*all*/) {}
  /// Some times a second.
  virtual void OnTick(int /*done*/, int /*all*/) {}
};

struct RunOptions {
  int parallel = 1;
  std::optional<std::chrono::duration<double>> time_limit;  ///< of one run
  std::filesystem::path work_folder;                        ///< of the simulators; must exist
  std::stop_token stop;
  RunListener* listener = nullptr;  ///< null: nobody listens
  Ledger* ledger = nullptr;         ///< null: nothing is kept
};

/// Runs all jobs, several at a time, and returns what came of each, in order. Runs that the ledger
/// holds are not repeated; those that end well are committed to it as they end, failed ones are
/// not, so that another attempt can be made. After a stop request what is left is `cancelled`.
std::vector<LedgerRun> RunJobs(Rung rung, std::span<const Job> jobs, const RunOptions& options);

}  // namespace powdercal::verification

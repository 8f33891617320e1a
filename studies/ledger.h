#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backends/trace.h"
#include "experiments/experiment.h"
#include "optimizers/optimizer.h"

namespace SQLite {
class Database;
}

namespace powdercal {

/// One simulation as the ledger knows it.
struct LedgerRun {
  std::int64_t id = 0;
  std::string key;  ///< cache key: program hash, backend, version, fingerprint
  std::string experiment;
  std::string program_hash;
  std::uint64_t seed = 0;  ///< of the particles
  std::string backend;
  std::string backend_version;
  std::string fidelity;
  Outcome outcome;
  Measurement measurement;  ///< empty unless ok
  Diagnostics diagnostics;
  double total_seconds =
      0;  ///< from planning to measuring; diagnostics.wall_seconds of it simulated
};

/// A parameter point that was asked for.
struct LedgerCandidate {
  Candidate candidate;
  std::vector<double> parameters;  ///< SI, in the order of the search space
  int cached_runs = 0;             ///< how many of its runs the ledger held when it was asked
  std::vector<std::int64_t> runs;  ///< ids, in the order they were attached
  /// Replicate index of each of `runs`; −1 − index of those that are not the point's own: of the
  /// best point on other backends, under other laws, in other experiments.
  std::vector<int> replicates;
};

/// One step of the conversation with the optimizer, in order; replaying them rebuilds it.
struct LedgerEvent {
  enum class Kind { ask, tell };
  Kind kind = Kind::ask;
  int max_count = 0;                       ///< ask: the argument
  std::vector<std::int64_t> candidates;    ///< ask: the ids that came
  std::optional<Observation> observation;  ///< tell
  int replicates = 0;                      ///< tell: how many replicates went into it
};

/// The record of a study: the only truth, from which everything else is rebuilt. SQLite in WAL
/// mode; every call that writes has committed when it returns. One process at a time writes (see
/// RunDirectory); any number may read.
class Ledger {
 public:
  enum class Mode { read_only, read_write };

  /// Opens or creates (read_write only). A ledger of an earlier schema is upgraded when it is
  /// opened for writing, and read as it is otherwise. Throws InputError if the file is not a
  /// ledger, is damaged, or has a schema that this program does not know.
  Ledger(const std::filesystem::path& file, Mode mode);
  ~Ledger();

  /// Whether the file holds nothing yet, as a process leaves it that was killed while creating it;
  /// opening it for writing goes on from there.
  static bool IsBlank(const std::filesystem::path& file);

  std::optional<std::string> GetMeta(const std::string& key) const;
  void SetMeta(const std::string& key, const std::string& value);

  /// The run of that cache key, if it has ended (cancelled ones are never stored).
  std::optional<LedgerRun> FindRun(const std::string& key) const;
  LedgerRun GetRun(std::int64_t id) const;
  std::vector<LedgerRun> Runs() const;

  /// Stores a run that has ended, and attaches it to a candidate; returns its id.
  std::int64_t AddRun(const LedgerRun& run, std::int64_t candidate, int replicate);
  /// Attaches a run that the ledger already held.
  void AttachRun(std::int64_t run, std::int64_t candidate, int replicate);

  /// Stores the candidates together with the event of asking for them.
  void AddAsk(int max_count, const std::vector<LedgerCandidate>& candidates);
  void SetCachedRuns(std::int64_t candidate, int count);
  void AddTell(const Observation& observation, int replicates);

  std::vector<LedgerCandidate> Candidates() const;
  std::vector<LedgerEvent> Events() const;

  /// Seconds over all sessions: wall clock of the study, and work outside the simulators.
  struct Times {
    double wall = 0;
    double overhead = 0;
  };
  /// Starts a session and returns its number; UpdateSession overwrites that session's times.
  std::int64_t StartSession();
  void UpdateSession(std::int64_t session, const Times& times);
  Times TotalTimes() const;

 private:
  void Upgrade();

  std::unique_ptr<SQLite::Database> database_;
  int schema_ = 0;
};

}  // namespace powdercal

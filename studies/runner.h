#pragma once

#include <chrono>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "studies/evaluation.h"
#include "studies/executor.h"
#include "studies/fidelities.h"
#include "studies/ledger.h"
#include "studies/planner.h"
#include "studies/results.h"
#include "studies/run_directory.h"
#include "studies/study.h"

namespace powdercal {

/// Where a study stands, for whoever watches it.
struct Progress {
  int done = 0;     ///< evaluations told to the optimizer
  double used = 0;  ///< of the budget: `done`, each counted as it costs compared with one at the
                    ///< study's own fidelity
  int budget = 0;
  int failed = 0;                       ///< without any value
  int partial = 0;                      ///< with some values
  int running = 0;                      ///< simulations in flight
  int confirmation_runs = 0;            ///< see OnConfirmation; 0 before the calibration has ended
  int confirmation_done = 0;            ///< of these, how many have ended
  int transfer_runs = 0;                ///< of `evaluate_also`; 0 before the calibration has ended
  int transfer_done = 0;                ///< of these, how many have ended
  std::optional<std::int64_t> best;     ///< candidate
  std::vector<double> best_parameters;  ///< SI
  ReducedResponses best_responses;
  double elapsed_seconds = 0;          ///< of the study, over all its sessions
  std::optional<double> seconds_left;  ///< estimate from the runs so far
};

class ProgressListener {
 public:
  virtual ~ProgressListener() = default;
  virtual void OnResume(int /*evaluations*/) {}
  /// A simulation has ended.
  virtual void OnRun(const LedgerRun&, const Progress&) {}
  /// A parameter point has all its runs; with what failed of it.
  virtual void OnEvaluation(const LedgerCandidate&, const ReducedResponses&,
                            const std::vector<ExperimentFailure>&, const Progress&) {}
  /// The calibration has ended, and its best point is simulated on other backends, or under the law
  /// that the study approximates.
  virtual void OnConfirmation(const LedgerCandidate&, const Progress&) {}
  /// The calibration has ended, and its best point is evaluated on further experiments.
  virtual void OnTransfer(const LedgerCandidate&, const Progress&) {}
  /// About four times a second.
  virtual void OnTick(const Progress&) {}
};

/// Runs a study in its folder, from wherever an earlier process left it.
///
///   open folder → replay the ledger's events → { ask, plan, submit | collect, commit, tell }* →
///   done
///
/// A run is in the ledger before the optimizer hears of it. A point is told when all its replicates
/// are known, and again when further replicates are added to confirm it: the best point gets
/// `confirm_replicates` before the study ends. After that the best point is simulated on the
/// backends of `confirm_with`, under the law that it approximates, and evaluated on the experiments
/// of `evaluate_also`, with as many replicates, of which the optimizer never hears.
class StudyRunner {
 public:
  struct Options {
    std::filesystem::path folder;
    std::stop_token stop;                         ///< a request ends the study, resumable
    ProgressListener* listener = nullptr;         ///< not owned; may be null
    std::vector<std::size_t> evaluate_also = {};  ///< Study::TransferExperiments()
  };

  /// Opens the folder. Throws InputError before anything is written if the study cannot run here.
  StudyRunner(Study& study, Options options);
  ~StudyRunner();

  enum class End { finished, interrupted };
  /// `interrupted` also where that befell `confirm_with` or `evaluate_also` alone, the study itself
  /// being finished.
  End Run();

 private:
  // A parameter point and its runs.
  struct Point {
    struct Slot {
      int replicate = 0;
      std::string key;
      std::optional<std::int64_t> run;  // id in the ledger; empty while queued or in flight
    };
    LedgerCandidate entry;
    std::vector<Slot> slots;
    int replicates = 0;       // planned
    int told_replicates = 0;  // 0: not told yet
    ReducedResponses told;    // as of the last tell
  };
  struct Job {
    std::int64_t candidate = 0;
    PlannedRun run;
    const Planner* planner = nullptr;
    bool besides = false;  // of the best point, after the calibration
  };

  void RunJobs(const std::function<void()>& submit);
  void PlanOthers();
  void ConfirmElsewhere();
  void EvaluateTransfer();
  void PlanBesides(const Planner& planner, std::size_t experiment, std::vector<Job>& jobs);
  void RunQueue();
  void Replay();
  void Register(const LedgerCandidate& candidate);
  void AddReplicates(Point& point, int count);
  void AskAndSubmit();
  bool MayAsk() const;
  bool Ask();
  bool HasFreeSlot() const;
  bool Submit();
  void Collect(const Executor::Finished& finished);
  bool IsReady(const Point& point) const;
  void TellWhatIsReady();
  void ConverseInOrder();
  void KeepTold(Point& point, int replicates, const std::vector<const LedgerRun*>& runs);
  void Tell(Point& point);
  void Decide();
  bool IsDone(const std::string& key) const;
  bool IsInFlight(const std::string& key) const;
  /// The best point that has been told (RankingMisfits); null while there is none.
  Point* Incumbent();
  std::vector<const LedgerRun*> RunsOf(const Point& point, int replicates) const;
  /// Seed variance of runs at this fidelity.
  Eigen::VectorXd Pooled(double fidelity) const;
  bool BudgetUsed() const;
  double Elapsed() const;
  std::vector<double> SecondsPerRun(const std::string& backend,
                                    const std::vector<Planner::ExperimentCost>& expected) const;
  double SecondsLeft() const;
  Progress CurrentProgress();
  void SaveTimes(bool now);

  Study& study_;
  Options options_;
  Objectives objectives_;
  Planner planner_;
  StudyFidelities fidelities_;
  Planner::Cost cost_;  // as expected before anything has run
  // What simulates the best point besides: the backends of `confirm_with`, and the reference for
  // what the approximations change.
  struct Other {
    std::unique_ptr<Planner> planner;
    std::vector<Planner::ExperimentCost> expected;
  };
  std::vector<Other> others_;
  std::unique_ptr<Backend> reference_;
  std::unique_ptr<RunDirectory> directory_;
  std::unique_ptr<Ledger> ledger_;
  std::unique_ptr<Optimizer> optimizer_;
  std::unique_ptr<Executor> executor_;

  std::map<std::int64_t, Point> points_;    // by candidate id
  std::optional<Point*> incumbent_;         // of what has been told; none: to be found
  std::deque<std::int64_t> awaiting_tell_;  // in asking order
  std::deque<Job> queue_;                   // planned, not yet submitted
  std::map<std::int64_t, Job> in_flight_;   // by ticket
  std::map<std::int64_t, LedgerRun> runs_;  // by run id
  std::int64_t next_ticket_ = 0;
  bool worked_ = false;  // this session asked, ran or told something
  double asked_ = 0;     // evaluations, each counted as it costs; as is told_cost_
  double told_cost_ = 0;
  int told_ = 0;
  int failed_ = 0;
  int partial_ = 0;
  std::vector<Job> confirmation_;  // without their programs, as is transfer_
  std::vector<Job> transfer_;
  std::string stop_reason_;  // no more asking once this is set
  bool complete_ = false;    // the result is settled: no more telling either
  bool ended_ = false;       // the calibration has
  bool interrupted_ = false;

  std::int64_t session_ = 0;
  Ledger::Times earlier_;  // of earlier sessions
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point saved_;
  double waiting_seconds_ = 0;    // blocked while simulators run
  double outside_simulator_ = 0;  // of the runs: planning, files, measuring
};

/// Everything that is known of a study, from its ledger.
StudyResults CollectResults(Study& study, const Ledger& ledger);

}  // namespace powdercal

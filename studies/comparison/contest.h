#pragma once

#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "optimizers/optimizer.h"
#include "studies/evaluation.h"
#include "studies/ledger.h"

namespace powdercal::comparison {

/// What every contestant of a comparison is given alike.
struct Rules {
  std::vector<std::size_t> experiments;  ///< of the study; an evaluation simulates each of them
  int replicates = 1;                    ///< so often
  int slots = 1;                         ///< simulations at a time
  int cores = 1;                         ///< that one simulation keeps busy
  int evaluations = 1;                   ///< failed ones included
  double core_seconds = std::numeric_limits<double>::infinity();  ///< of all simulations
};

/// A simulation that a contest waits for.
struct Simulation {
  int evaluation = 0;          ///< index in asking order
  std::size_t experiment = 0;  ///< of the study
  int replicate = 0;
};

/// One optimizer's search under the rules, in virtual time: each simulation takes a slot for as
/// long as its run says that it took, whenever and wherever that was simulated. So the same runs
/// give the same contest, a run that serves several contests is charged to each, and a contest
/// whose runs are all known is over in moments.
///
///   Advance → its simulations → Provide each → Advance … until it returns none.
///
/// The scheduling is that of StudyRunner: a point is asked for when a slot is free and no
/// simulation is queued; it is told when all its runs have ended. A point that was told before is
/// answered from memory, at once and at no cost, but counts as an evaluation.
class Contest {
 public:
  struct Evaluation {
    Candidate candidate;
    std::vector<LedgerRun> runs;
    ReducedResponses responses;  ///< once told
    double told_at = 0;          ///< [s] of virtual time
    double core_seconds = 0;     ///< spent by the contest until it was told
    bool repeated = false;       ///< answered from memory
  };

  Contest(std::unique_ptr<Optimizer> optimizer, Objectives objectives, Rules rules);

  /// Goes on as far as is known; returns the simulations whose runs it must be given first. Empty:
  /// it has ended.
  std::vector<Simulation> Advance();
  void Provide(const Simulation& simulation, const LedgerRun& run);

  bool ended() const { return !end_.empty(); }
  const std::string& end() const { return end_; }  ///< why; "" while it goes on
  const Objectives& objectives() const { return objectives_; }
  const std::vector<Evaluation>& evaluations() const { return evaluations_; }  ///< as asked
  const std::vector<int>& told() const { return told_; }  ///< indices, in the order of telling
  double now() const { return now_; }                     ///< [s] of virtual time
  double busy_seconds() const { return busy_seconds_; }   ///< of all slots together
  double core_seconds() const { return spent_; }
  const Rules& rules() const { return rules_; }

 private:
  struct Job {
    Simulation simulation;
    double start = 0;
    std::optional<LedgerRun> run;
  };

  void FillSlots();
  bool MayAsk() const;
  bool Ask();
  void FinishNext();
  void Tell(int evaluation);
  std::string ReasonToEnd() const;

  std::unique_ptr<Optimizer> optimizer_;
  Objectives objectives_;
  Rules rules_;
  std::vector<Evaluation> evaluations_;
  std::vector<int> told_;
  std::vector<ReducedResponses> reduced_;  // of told_
  std::deque<Simulation> queue_;
  std::vector<Job> in_flight_;  // in the order of starting
  double now_ = 0;
  double busy_seconds_ = 0;
  double spent_ = 0;
  std::string end_;
};

}  // namespace powdercal::comparison

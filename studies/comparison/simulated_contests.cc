#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <list>

#include "studies/comparison/contest_runner.h"
#include "studies/comparison/hold_out.h"
#include "studies/comparison/simulation_pool.h"

namespace powdercal::comparison {
namespace {

using Clock = std::chrono::steady_clock;

// A contest and what it is waiting for.
struct Active {
  const Task* task = nullptr;
  int order = 0;
  std::unique_ptr<Contest> contest;
  int missing = 0;  // runs
  bool holding_out = false;
  ContestRecord record;
  std::vector<LedgerRun> fresh;   // of the reported point
  std::vector<LedgerRun> raised;  // of the same at a higher fidelity
  std::chrono::duration<double> own{0};
  std::string error;
  bool done = false;
};

class SimulatedContests {
 public:
  SimulatedContests(const Field& field, const std::vector<Task>& tasks, const Planner& planner,
                    const Planner* raised, const RunDirectory& folder, Ledger& ledger,
                    const ContestOptions& options)
      : field_(field),
        tasks_(tasks),
        planner_(planner),
        raised_(raised),
        options_(options),
        study_(planner.study()),
        pool_(folder, ledger, study_.parallel(), TimeLimit(study_)) {}

  std::vector<ContestRecord> Hold();

 private:
  static std::optional<std::chrono::duration<double>> TimeLimit(const Study& study) {
    if (!study.budget.run_timeout) return std::nullopt;
    return std::chrono::duration<double>(*study.budget.run_timeout);
  }
  void Begin();
  bool GoOn();
  void Advance(Active& active);
  void AskForSimulations(Active& active, const std::vector<Simulation>& simulations);
  void HoldOutPoint(Active& active);
  void AskForHoldOut(Active& active, const Planner& planner, std::vector<LedgerRun>* runs);
  void Finish(Active& active);

  const Field& field_;
  const std::vector<Task>& tasks_;
  const Planner& planner_;
  const Planner* raised_;
  const ContestOptions& options_;
  const Study& study_;
  std::size_t begun_ = 0;
  std::list<Active> active_;  // addresses stay
  std::map<int, ContestRecord> records_;
  SimulationPool pool_;
};

std::vector<ContestRecord> SimulatedContests::Hold() {
  const auto all = static_cast<int>(tasks_.size());
  while (!active_.empty() || begun_ < tasks_.size()) {
    if (options_.stop.stop_requested()) {
      pool_.Cancel();
      break;
    }
    if (GoOn()) continue;
    if (pool_.hungry() && begun_ < tasks_.size()) {
      Begin();
      continue;
    }
    const std::optional<LedgerRun> run = pool_.Step();
    if (options_.listener == nullptr) continue;
    if (run) options_.listener->OnRun(*run);
    options_.listener->OnTick(static_cast<int>(records_.size()), all);
  }
  std::vector<ContestRecord> records;
  for (auto& [order, record] : records_) records.push_back(std::move(record));
  return records;
}

void SimulatedContests::Begin() {
  const Task& task = tasks_[begun_];
  Active& active = active_.emplace_back();
  active.task = &task;
  active.order = static_cast<int>(begun_++);
  active.contest = std::make_unique<Contest>(field_.Make(*task.contestant, task.seed),
                                             study_.MakeObjectives(), options_.rules);
}

// Every contest as far as it gets; false if none could do anything.
bool SimulatedContests::GoOn() {
  bool any = false;
  for (Active& active : active_) {
    while (active.missing == 0 && !active.done && !options_.stop.stop_requested()) {
      any = true;
      if (active.holding_out) {
        Finish(active);
      } else {
        Advance(active);
      }
    }
  }
  active_.remove_if([](const Active& active) { return active.done; });
  return any;
}

void SimulatedContests::Advance(Active& active) {
  const auto before = Clock::now();
  std::vector<Simulation> simulations;
  try {
    simulations = active.contest->Advance();
  } catch (const std::exception& problem) {
    active.error = problem.what();
  }
  active.own += Clock::now() - before;
  if (simulations.empty()) {
    HoldOutPoint(active);
  } else {
    AskForSimulations(active, simulations);
  }
}

void SimulatedContests::AskForSimulations(Active& active,
                                          const std::vector<Simulation>& simulations) {
  active.missing = static_cast<int>(simulations.size());
  for (const Simulation& s : simulations) {
    const auto& evaluation = active.contest->evaluations()[static_cast<std::size_t>(s.evaluation)];
    const Eigen::VectorXd values = study_.space.FromUnit(evaluation.candidate.point);
    pool_.Ask(active.order, planner_, s.experiment, {values.begin(), values.end()}, s.replicate,
              true, [&active, s](const LedgerRun& run) {
                active.contest->Provide(s, run);
                --active.missing;
              });
  }
}

void SimulatedContests::HoldOutPoint(Active& active) {
  active.record = Summarise(*active.contest, study_.space, {});
  active.record.error = active.error;
  Sign(*active.task, active.own.count(), &active.record);
  active.holding_out = true;
  if (active.record.parameters.empty() || options_.hold_out_seeds == 0) return;
  const int each = options_.hold_out_seeds * static_cast<int>(options_.rules.experiments.size());
  active.missing = raised_ == nullptr ? each : 2 * each;
  AskForHoldOut(active, planner_, &active.fresh);
  if (raised_ != nullptr) AskForHoldOut(active, *raised_, &active.raised);
}

void SimulatedContests::AskForHoldOut(Active& active, const Planner& planner,
                                      std::vector<LedgerRun>* runs) {
  for (int s = 0; s < options_.hold_out_seeds; ++s) {
    for (const std::size_t experiment : options_.rules.experiments) {
      pool_.Ask(active.order, planner, experiment, active.record.parameters, kFirstHoldOut + s,
                false, [&active, runs](const LedgerRun& run) {
                  runs->push_back(run);
                  --active.missing;
                });
    }
  }
}

void SimulatedContests::Finish(Active& active) {
  const Objectives objectives = study_.MakeObjectives();
  if (!active.fresh.empty()) {
    active.record.hold_out.push_back(
        {FidelityText(study_), options_.hold_out_seeds, HoldOutChi2(objectives, active.fresh)});
  }
  if (!active.raised.empty()) {
    active.record.hold_out.push_back({FidelityText(raised_->study()), options_.hold_out_seeds,
                                      HoldOutChi2(objectives, active.raised)});
  }
  active.done = true;
  records_.emplace(active.order, active.record);
  if (options_.listener != nullptr) {
    options_.listener->OnContest(active.record, static_cast<int>(records_.size()),
                                 static_cast<int>(tasks_.size()));
  }
}

}  // namespace

std::vector<ContestRecord> HoldOnSimulator(const Field& field, const std::vector<Task>& tasks,
                                           const Planner& planner, const Planner* raised,
                                           const RunDirectory& folder, Ledger& ledger,
                                           const ContestOptions& options) {
  return SimulatedContests(field, tasks, planner, raised, folder, ledger, options).Hold();
}

}  // namespace powdercal::comparison

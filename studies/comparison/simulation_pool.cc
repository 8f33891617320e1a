#include "studies/comparison/simulation_pool.h"

#include <fmt/format.h>

namespace powdercal::comparison {
namespace {

constexpr auto kTick = std::chrono::milliseconds(250);

}  // namespace

SimulationPool::SimulationPool(const RunDirectory& folder, Ledger& ledger, int parallel,
                               std::optional<std::chrono::duration<double>> time_limit)
    : folder_(folder), ledger_(ledger), time_limit_(time_limit), executor_(parallel) {
  for (const LedgerCandidate& entry : ledger.Candidates()) {
    candidates_.emplace(entry.parameters, entry.candidate.id);
  }
}

void SimulationPool::Ask(int priority, const Planner& planner, std::size_t experiment,
                         const std::vector<double>& parameters, int replicate, bool own,
                         Callback callback) {
  PlannedRun planned = planner.PlanExperiment(experiment, parameters, replicate);
  if (const auto known = ledger_.FindRun(planned.key)) {
    callback(*known);
    return;
  }
  std::vector<Callback>& waiting = waiting_[planned.key];
  waiting.push_back(std::move(callback));
  if (waiting.size() > 1) return;
  pending_.emplace(std::pair(priority, next_++),
                   Job{std::move(planned), &planner, parameters, own});
}

void SimulationPool::Submit() {
  while (Free() && !pending_.empty()) {
    Job job = std::move(pending_.extract(pending_.begin()).mapped());
    const std::int64_t ticket = next_++;
    RunContext context{
        .work_folder = folder_.work_folder(fmt::format("{}-{}-{}", job.run.program.experiment,
                                                       job.run.program_hash.substr(0, 12), ticket)),
        .time_limit = time_limit_};
    executor_.Submit(ticket,
                     [run = job.run, planner = job.planner, context](std::stop_token stop) mutable {
                       context.stop = std::move(stop);
                       return planner->Execute(run, context);
                     });
    in_flight_.emplace(ticket, std::move(job));
  }
}

// Every parameter point is one candidate, so that an emulator can be fitted to this ledger as well.
std::int64_t SimulationPool::CandidateOf(const Job& job) {
  const auto known = candidates_.find(job.parameters);
  if (known != candidates_.end()) return known->second;
  const auto id = static_cast<std::int64_t>(candidates_.size());
  const Eigen::VectorXd values = Eigen::Map<const Eigen::VectorXd>(
      job.parameters.data(), static_cast<Eigen::Index>(job.parameters.size()));
  ledger_.AddAsk(1, {{.candidate = {id, job.planner->study().space.ToUnit(values), "comparison"},
                      .parameters = job.parameters}});
  candidates_.emplace(job.parameters, id);
  return id;
}

std::optional<LedgerRun> SimulationPool::Step() {
  Submit();
  std::optional<Executor::Finished> finished = executor_.Wait(kTick);
  if (!finished) return std::nullopt;
  const Job job = std::move(in_flight_.extract(finished->ticket).mapped());
  LedgerRun run = std::move(finished->run);
  if (run.outcome.reason == Reason::cancelled) return std::nullopt;
  run.id =
      ledger_.AddRun(run, CandidateOf(job), job.own ? job.run.replicate : -1 - job.run.replicate);
  const auto waiting = waiting_.extract(run.key);
  for (const Callback& callback : waiting.mapped()) callback(run);
  return run;
}

void SimulationPool::Cancel() {
  pending_.clear();
  waiting_.clear();
  executor_.Cancel();
  while (!in_flight_.empty()) {
    if (const auto finished = executor_.Wait(kTick)) in_flight_.erase(finished->ticket);
  }
}

}  // namespace powdercal::comparison

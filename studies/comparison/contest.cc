#include "studies/comparison/contest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

namespace powdercal::comparison {
namespace {

bool Same(const Simulation& a, const Simulation& b) {
  return a.evaluation == b.evaluation && a.experiment == b.experiment && a.replicate == b.replicate;
}

}  // namespace

Contest::Contest(std::unique_ptr<Optimizer> optimizer, Objectives objectives, Rules rules)
    : optimizer_(std::move(optimizer)),
      objectives_(std::move(objectives)),
      rules_(std::move(rules)) {
  assert(rules_.slots > 0 && rules_.replicates > 0 && !rules_.experiments.empty());
}

std::vector<Simulation> Contest::Advance() {
  while (!ended()) {
    FillSlots();
    if (in_flight_.empty()) {
      end_ = ReasonToEnd();
      break;
    }
    // Which of them ends first is only known once all are.
    std::vector<Simulation> unknown;
    for (const Job& job : in_flight_) {
      if (!job.run) unknown.push_back(job.simulation);
    }
    if (!unknown.empty()) return unknown;
    FinishNext();
  }
  return {};
}

void Contest::Provide(const Simulation& simulation, const LedgerRun& run) {
  for (Job& job : in_flight_) {
    if (!job.run && Same(job.simulation, simulation)) {
      job.run = run;
      return;
    }
  }
  assert(false && "a run that was not asked for");
}

void Contest::FillSlots() {
  while (static_cast<int>(in_flight_.size()) < rules_.slots) {
    if (!queue_.empty()) {
      in_flight_.push_back({.simulation = queue_.front(), .start = now_, .run = {}});
      queue_.pop_front();
    } else if (!MayAsk() || !Ask()) {
      return;
    }
  }
}

bool Contest::MayAsk() const {
  return static_cast<int>(evaluations_.size()) < rules_.evaluations &&
         spent_ < rules_.core_seconds && optimizer_->status().phase == Status::Phase::ready;
}

bool Contest::Ask() {
  std::vector<Candidate> candidates = optimizer_->Ask(1);
  for (Candidate& candidate : candidates) {
    const auto index = static_cast<int>(evaluations_.size());
    const auto earlier = std::find_if(told_.begin(), told_.end(), [&](int i) {
      return evaluations_[static_cast<std::size_t>(i)].candidate.point == candidate.point;
    });
    Evaluation evaluation{.candidate = std::move(candidate), .runs = {}, .responses = {}};
    if (earlier != told_.end()) {
      evaluation.runs = evaluations_[static_cast<std::size_t>(*earlier)].runs;
      evaluation.repeated = true;
      evaluations_.push_back(std::move(evaluation));
      Tell(index);
      continue;
    }
    evaluations_.push_back(std::move(evaluation));
    for (int replicate = 0; replicate < rules_.replicates; ++replicate) {
      for (const std::size_t experiment : rules_.experiments) {
        queue_.push_back({index, experiment, replicate});
      }
    }
  }
  return !candidates.empty();
}

// The simulation in flight that ends first; of several at once the one that was started first.
void Contest::FinishNext() {
  const auto finish = [](const Job& job) { return job.start + job.run->diagnostics.wall_seconds; };
  const auto next =
      std::min_element(in_flight_.begin(), in_flight_.end(),
                       [&](const Job& a, const Job& b) { return finish(a) < finish(b); });
  const double seconds = next->run->diagnostics.wall_seconds;
  now_ = finish(*next);
  busy_seconds_ += seconds;
  spent_ += seconds * rules_.cores;
  const int index = next->simulation.evaluation;
  Evaluation& evaluation = evaluations_[static_cast<std::size_t>(index)];
  evaluation.runs.push_back(std::move(*next->run));
  in_flight_.erase(next);
  if (evaluation.runs.size() ==
      rules_.experiments.size() * static_cast<std::size_t>(rules_.replicates)) {
    Tell(index);
  }
}

void Contest::Tell(int index) {
  Evaluation& evaluation = evaluations_[static_cast<std::size_t>(index)];
  std::vector<const LedgerRun*> runs;
  for (const LedgerRun& run : evaluation.runs) runs.push_back(&run);
  evaluation.responses = Reduce(objectives_, runs);
  evaluation.told_at = now_;
  evaluation.core_seconds = spent_;
  told_.push_back(index);
  reduced_.push_back(evaluation.responses);
  const Eigen::VectorXd pooled =
      PooledSeedVariance(reduced_, static_cast<int>(objectives_.targets.size()));
  std::vector<std::string> reasons;
  for (const ExperimentFailure& failure : FailuresOf(objectives_, evaluation.responses, runs)) {
    reasons.push_back(failure.experiment + " " + failure.reason);
  }
  const Observation observation{.id = evaluation.candidate.id,
                                .point = evaluation.candidate.point,
                                .responses = evaluation.responses.means,
                                .variances = VarianceOfMeans(evaluation.responses, pooled),
                                .failed = evaluation.responses.failed(),
                                .failure = JoinNames(reasons)};
  optimizer_->Tell(std::span(&observation, 1));
}

std::string Contest::ReasonToEnd() const {
  if (static_cast<int>(evaluations_.size()) >= rules_.evaluations) {
    return fmt::format("budget of {} evaluations used", rules_.evaluations);
  }
  if (spent_ >= rules_.core_seconds) {
    return fmt::format("budget of {:.4g} core-seconds used", rules_.core_seconds);
  }
  const Status status = optimizer_->status();
  return status.message.empty() ? "the optimizer has no more points"
                                : "the optimizer has finished: " + status.message;
}

}  // namespace powdercal::comparison

#include "studies/comparison/contest_runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include "core/hash.h"
#include "core/version.h"
#include "studies/comparison/hold_out.h"

namespace powdercal::comparison {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kTick = std::chrono::milliseconds(250);

// Contests of one task after the other, in one of several threads.
class OracleThreads {
 public:
  OracleThreads(const Study& study, const Field& field, const std::vector<Task>& tasks,
                const Oracle& oracle, const ContestOptions& options)
      : study_(study), field_(field), tasks_(tasks), oracle_(oracle), options_(options) {}

  std::vector<ContestRecord> Hold(int threads);

 private:
  void Work();
  std::optional<ContestRecord> Play(const Task& task);
  std::unique_ptr<Contest> Begin(const Task& task);

  const Study& study_;
  const Field& field_;
  const std::vector<Task>& tasks_;
  const Oracle& oracle_;
  const ContestOptions& options_;
  std::atomic<std::size_t> next_ = 0;
  std::mutex making_;  // reading options is not safe in several threads
  std::mutex mutex_;
  std::condition_variable ended_;
  std::map<std::size_t, ContestRecord> records_;  // by task
  std::vector<std::size_t> fresh_;                // not announced yet
  int working_ = 0;
};

std::unique_ptr<Contest> OracleThreads::Begin(const Task& task) {
  const std::lock_guard lock(making_);
  return std::make_unique<Contest>(field_.Make(*task.contestant, task.seed),
                                   study_.MakeObjectives(), options_.rules);
}

std::optional<ContestRecord> OracleThreads::Play(const Task& task) {
  const RandomStream world = WorldOf(study_, task.seed);
  const std::unique_ptr<Contest> contest = Begin(task);
  std::string error;
  std::chrono::duration<double> own{0};
  try {
    while (!contest->ended()) {
      if (options_.stop.stop_requested()) return std::nullopt;
      const auto before = Clock::now();
      const std::vector<Simulation> simulations = contest->Advance();
      own += Clock::now() - before;
      for (const Simulation& s : simulations) {
        const auto& point =
            contest->evaluations()[static_cast<std::size_t>(s.evaluation)].candidate.point;
        contest->Provide(s, oracle_.Simulate(s.experiment, point, s.replicate, world));
      }
    }
  } catch (const std::exception& problem) {
    error = problem.what();
  }
  ContestRecord record = Summarise(*contest, study_.space,
                                   [this](const Eigen::VectorXd& p) { return oracle_.Truth(p); });
  record.error = error;
  Sign(task, own.count(), &record);
  const Eigen::VectorXd point = ReportedPoint(*contest, record);
  if (point.size() > 0 && oracle_.noisy() && options_.hold_out_seeds > 0) {
    record.hold_out.push_back(
        HoldOutOnOracle(study_, oracle_, point, options_.hold_out_seeds, world));
  }
  return record;
}

void OracleThreads::Work() {
  for (;;) {
    const std::size_t i = next_++;
    if (i >= tasks_.size() || options_.stop.stop_requested()) break;
    std::optional<ContestRecord> record = Play(tasks_[i]);
    if (!record) break;
    const std::lock_guard lock(mutex_);
    records_.emplace(i, std::move(*record));
    fresh_.push_back(i);
    ended_.notify_one();
  }
  const std::lock_guard lock(mutex_);
  --working_;
  ended_.notify_one();
}

std::vector<ContestRecord> OracleThreads::Hold(int threads) {
  working_ = std::clamp(threads, 1, std::max(1, static_cast<int>(tasks_.size())));
  std::vector<std::jthread> workers;
  for (int i = 0, count = working_; i < count; ++i) workers.emplace_back([this] { Work(); });
  const auto all = static_cast<int>(tasks_.size());
  int done = 0;
  std::unique_lock lock(mutex_);
  while (working_ > 0 || !fresh_.empty()) {
    ended_.wait_for(lock, kTick, [this] { return !fresh_.empty() || working_ == 0; });
    std::vector<ContestRecord> fresh;
    for (const std::size_t i : fresh_) fresh.push_back(records_.at(i));
    fresh_.clear();
    lock.unlock();  // the listener may take its time
    for (const ContestRecord& record : fresh) {
      ++done;
      if (options_.listener != nullptr) options_.listener->OnContest(record, done, all);
    }
    if (options_.listener != nullptr) options_.listener->OnTick(done, all);
    lock.lock();
  }
  lock.unlock();
  std::vector<ContestRecord> records;
  for (auto& [i, record] : records_) records.push_back(std::move(record));
  return records;
}

}  // namespace

std::string ContestKey(Study& study, const Field& field, const Contestant& contestant, int seed,
                       const Rules& rules, const std::string& source, int hold_out_seeds) {
  DesignOptions design = field.initial_design();
  std::string text =
      fmt::format("contest 1\n{}\n{}\n{}\n{}\n{}\n{}", kVersion, study.Fingerprint(), source,
                  contestant.label, contestant.options,
                  contestant.initial_design
                      ? WriteYaml([&](Archive& archive) { design.Serialize(archive, study.space); })
                      : "");
  text += fmt::format("\n{} {} {} {} {} {} {}", seed, rules.replicates, rules.slots, rules.cores,
                      rules.evaluations, rules.core_seconds, hold_out_seeds);
  return Sha256(text);
}

std::vector<ContestRecord> HoldOnOracle(const Study& study, const Field& field,
                                        const std::vector<Task>& tasks, const Oracle& oracle,
                                        const ContestOptions& options, int threads) {
  return OracleThreads(study, field, tasks, oracle, options).Hold(threads);
}

}  // namespace powdercal::comparison

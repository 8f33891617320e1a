#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <vector>

#include "studies/ledger.h"

namespace powdercal {

/// Carries out runs somewhere, several at a time. Jobs are handed in from one thread, which also
/// collects them.
class Executor {
 public:
  using Job = std::function<LedgerRun(std::stop_token)>;

  struct Finished {
    std::int64_t ticket = 0;
    LedgerRun run;
  };

  virtual ~Executor() = default;

  /// How many jobs it works on at a time.
  virtual int capacity() const = 0;
  virtual void Submit(std::int64_t ticket, Job job) = 0;
  /// The next job that has ended, waiting for at most `timeout`.
  virtual std::optional<Finished> Wait(std::chrono::milliseconds timeout) = 0;
  /// Asks every job to end with `cancelled`; they still have to be collected.
  virtual void Cancel() = 0;
};

/// Threads of this process; simulators that are programs of their own run as their children.
class LocalExecutor final : public Executor {
 public:
  explicit LocalExecutor(int threads);
  ~LocalExecutor() override;  ///< cancels what still runs and waits for it

  int capacity() const override { return static_cast<int>(threads_.size()); }
  void Submit(std::int64_t ticket, Job job) override;
  std::optional<Finished> Wait(std::chrono::milliseconds timeout) override;
  void Cancel() override;

 private:
  void Work();

  std::mutex mutex_;
  std::condition_variable work_available_;
  std::condition_variable result_available_;
  std::deque<std::pair<std::int64_t, Job>> queue_;
  std::deque<Finished> finished_;
  bool closing_ = false;
  std::stop_source stop_;
  std::vector<std::jthread> threads_;  // last: joined before the members they use are destroyed
};

}  // namespace powdercal

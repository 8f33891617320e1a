#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace powdercal::embedded {

/// Threads that work together on one simulation, thousands of times a second: they wait for work
/// awake for some microseconds before they sleep.
class Team {
 public:
  /// `size` ≥ 1 threads, the caller's among them.
  explicit Team(int size);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int size() const { return static_cast<int>(workers_.size()) + 1; }

  /// Calls task(thread) for thread = 0 … size − 1, each on its own thread, and returns when all
  /// have returned. The task must not throw.
  template <typename Task>
  void Run(const Task& task) {
    if (workers_.empty()) {
      task(0);
      return;
    }
    Start([](const void* t, int thread) { (*static_cast<const Task*>(t))(thread); }, &task);
    task(0);
    Finish();
  }

 private:
  using Call = void (*)(const void* task, int thread);

  void Start(Call call, const void* task);
  void Finish();
  void Work(int thread);
  void AwaitChange(const std::atomic<std::uint32_t>& value, std::uint32_t old) const;

  int spins_ = 0;  // before a thread that waits goes to sleep
  Call call_ = nullptr;
  const void* task_ = nullptr;
  std::atomic<std::uint32_t> round_{0};
  std::atomic<std::uint32_t> finished_{0};
  std::atomic<bool> quit_{false};
  std::vector<std::thread> workers_;
};

}  // namespace powdercal::embedded

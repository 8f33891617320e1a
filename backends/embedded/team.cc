#include "backends/embedded/team.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace powdercal::embedded {
namespace {

constexpr int kSpins = 4000;  // some 50 µs

void Pause() {
#if defined(__SSE2__)
  _mm_pause();
#endif
}

}  // namespace

Team::Team(int size)
    : spins_(static_cast<unsigned>(size) <= std::thread::hardware_concurrency() ? kSpins : 0) {
  for (int thread = 1; thread < size; ++thread) {
    workers_.emplace_back([this, thread] { Work(thread); });
  }
}

Team::~Team() {
  quit_ = true;
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

// Waits until `value` is no longer `old`.
void Team::AwaitChange(const std::atomic<std::uint32_t>& value, std::uint32_t old) const {
  for (int spin = 0; spin < spins_; ++spin) {
    if (value.load(std::memory_order_acquire) != old) return;
    Pause();
  }
  while (value.load(std::memory_order_acquire) == old) value.wait(old, std::memory_order_acquire);
}

void Team::Start(Call call, const void* task) {
  call_ = call;
  task_ = task;
  finished_.store(0, std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
}

void Team::Finish() {
  const auto all = static_cast<std::uint32_t>(workers_.size());
  for (std::uint32_t done = finished_.load(std::memory_order_acquire); done != all;
       done = finished_.load(std::memory_order_acquire)) {
    AwaitChange(finished_, done);
  }
}

void Team::Work(int thread) {
  std::uint32_t round = 0;
  while (true) {
    AwaitChange(round_, round);
    ++round;
    if (quit_) return;
    call_(task_, thread);
    finished_.fetch_add(1, std::memory_order_acq_rel);
    finished_.notify_one();
  }
}

}  // namespace powdercal::embedded

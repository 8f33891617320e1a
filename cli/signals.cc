#include "cli/signals.h"

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <ctime>

#include "cli/commands.h"
#include "cli/output.h"

namespace powdercal::cli {
namespace {

sigset_t StopSignals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

}  // namespace

SignalStop::SignalStop() {
  const sigset_t set = StopSignals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  thread_ = std::jthread([this](std::stop_token closing) {
    const sigset_t awaited = StopSignals();
    const timespec interval{.tv_sec = 0, .tv_nsec = 100'000'000};
    std::chrono::steady_clock::time_point first;
    while (!closing.stop_requested()) {
      if (sigtimedwait(&awaited, nullptr, &interval) < 0) continue;
      // Some senders signal the process and its group at once: that is one request, not two.
      const auto now = std::chrono::steady_clock::now();
      if (stop_.stop_requested() && now - first < std::chrono::seconds(1)) continue;
      if (stop_.stop_requested()) _exit(kInterrupted);
      first = now;
      Say("\nstopping; the same command resumes. Again to stop at once.\n");
      stop_.request_stop();
    }
  });
}

SignalStop::~SignalStop() {
  thread_.request_stop();
  thread_.join();
  const sigset_t set = StopSignals();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

}  // namespace powdercal::cli

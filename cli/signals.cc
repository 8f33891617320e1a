#include "cli/signals.h"

#include <semaphore.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <ctime>

#include "cli/commands.h"
#include "cli/output.h"

namespace powdercal::cli {
namespace {

sem_t requests;  // posted once for each signal: all that a handler may do

extern "C" void OnStopSignal(int) {
  const int saved = errno;
  sem_post(&requests);
  errno = saved;
}

sigset_t StopSignals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

// Whether a request came within a tenth of a second.
bool AwaitRequest() {
  timespec until{};
  clock_gettime(CLOCK_REALTIME, &until);
  until.tv_nsec += 100'000'000;
  if (until.tv_nsec >= 1'000'000'000) {
    until.tv_nsec -= 1'000'000'000;
    ++until.tv_sec;
  }
  return sem_timedwait(&requests, &until) == 0;
}

}  // namespace

// The signals are blocked in this thread and its children, and taken by the waiting thread; or by a
// thread that a library began before main, which blocks nothing (OpenBLAS does that). Hence a
// handler, which serves whichever thread they come to.
SignalStop::SignalStop() {
  sem_init(&requests, 0, 0);
  struct sigaction action = {};
  action.sa_handler = OnStopSignal;
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, &earlier_interrupt_);
  sigaction(SIGTERM, &action, &earlier_terminate_);
  const sigset_t set = StopSignals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  thread_ = std::jthread([this](std::stop_token closing) {
    const sigset_t taken = StopSignals();
    pthread_sigmask(SIG_UNBLOCK, &taken, nullptr);
    std::chrono::steady_clock::time_point first;
    while (!closing.stop_requested()) {
      if (!AwaitRequest()) continue;
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
  sigaction(SIGINT, &earlier_interrupt_, nullptr);
  sigaction(SIGTERM, &earlier_terminate_, nullptr);
  const sigset_t set = StopSignals();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

}  // namespace powdercal::cli

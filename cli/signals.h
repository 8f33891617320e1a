#pragma once

#include <csignal>
#include <stop_token>
#include <thread>

namespace powdercal::cli {

/// Turns SIGINT and SIGTERM into a stop request while it lives; a second signal ends the process at
/// once (nothing that finished is lost then either). Create it before any other thread, one at a
/// time.
class SignalStop {
 public:
  SignalStop();
  ~SignalStop();

  SignalStop(const SignalStop&) = delete;
  SignalStop& operator=(const SignalStop&) = delete;

  std::stop_token token() const { return stop_.get_token(); }

 private:
  struct sigaction earlier_interrupt_ {};
  struct sigaction earlier_terminate_ {};
  std::stop_source stop_;
  std::jthread thread_;
};

}  // namespace powdercal::cli

#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace powdercal {

/// How a child process is to be run.
struct ProcessOptions {
  std::vector<std::string> arguments;       ///< program (looked up on PATH) and its arguments
  std::filesystem::path working_directory;  ///< empty: the caller's
  std::vector<std::pair<std::string, std::string>> environment;  ///< added to the caller's own
  std::optional<std::chrono::duration<double>> time_limit;       ///< wall clock; none: no limit
  std::size_t output_limit = 64 * 1024;  ///< bytes kept of stdout and stderr together, half from
                                         ///< the beginning and half from the end
};

/// How a child process ended.
struct ProcessResult {
  enum class End {
    exited,       ///< by itself; see exit_status
    signalled,    ///< killed by a signal that was not ours; see signal
    time_limit,   ///< killed here: the wall-clock limit was reached
    cancelled,    ///< killed here: a stop was requested
    not_started,  ///< the program was not found or could not be executed; see `output`
  };
  End end = End::not_started;
  int exit_status = -1;
  int signal = 0;
  std::string output;  ///< valid UTF-8 (bytes that are not are replaced)
  bool output_truncated = false;
  double wall_seconds = 0;

  bool succeeded() const { return end == End::exited && exit_status == 0; }
  /// "exited with status 1", "killed by signal 9 (Killed)", "exceeded its limit of 600 s", …
  std::string Describe() const;
};

/// Runs a child in a process group of its own and waits for it. The whole group, grandchildren
/// included, is killed when the limit is reached, when a stop is requested (within 50 ms), when the
/// child itself ends, and when the calling process dies, by whatever cause, SIGKILL included: a
/// guard process holds a pipe from the caller and kills the group when that pipe closes. Safe to
/// call from several threads at once.
ProcessResult RunProcess(const ProcessOptions& options, std::stop_token stop = {});

/// Full path of a program on PATH, or empty if there is none.
std::filesystem::path FindProgram(const std::string& name);

}  // namespace powdercal

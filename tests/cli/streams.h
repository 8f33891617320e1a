#pragma once

#include "tests/support/program.h"

namespace powdercal {

/// What the program wrote to each of its streams.
struct Streams {
  int exit_status = -1;
  std::string output;
  std::string error;
};

/// Runs the built program with its streams in files, hence not on a terminal.
inline Streams PowdercalStreams(const std::vector<std::string>& arguments,
                                const std::filesystem::path& working_directory,
                                const std::string& redirections = ">\"$output\" 2>\"$error\"") {
  const TemporaryFolder folder;
  std::vector<std::string> command = {"/bin/sh", "-c", "exec \"$@\" " + redirections, "sh",
                                      POWDERCAL_PROGRAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const std::filesystem::path output = folder / "output";
  const std::filesystem::path error = folder / "error";
  for (const auto& file : {output, error}) WriteFileAtomically(file, "");
  const ProcessResult result =
      RunProcess({.arguments = std::move(command),
                  .working_directory = working_directory,
                  .environment = {{"output", output.string()}, {"error", error.string()}},
                  .time_limit = std::chrono::minutes(2)});
  return {result.exit_status, ReadFile(output), ReadFile(error)};
}

/// Names of what lies in a folder, sorted.
inline std::vector<std::string> Listing(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

inline std::vector<std::string> With(std::vector<std::string> arguments,
                                     const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

/// Arguments that are refused, and how.
struct Mistake {
  std::vector<std::string> arguments;
  std::vector<std::string> message;  // pieces of it
};

}  // namespace powdercal

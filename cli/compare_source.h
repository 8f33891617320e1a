#pragma once

#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "studies/comparison/emulator.h"

namespace powdercal::cli {

/// What an emulator is fitted to.
struct EmulatorData {
  std::vector<comparison::KnownPoint> points;
  std::string text;  ///< where they come from
  bool interrupted = false;
};

/// Points of these run folders. Throws InputError for a folder that is none, or of another problem.
EmulatorData ReadRuns(Study& study, const std::vector<std::string>& folders);

/// The newest finished run of the study where `run` keeps them (`folder`, and with other seeds); ""
/// without one.
std::filesystem::path FindFinishedRun(Study& study, const std::filesystem::path& folder);

/// Simulates a Sobol' design of so many points in `folder`, or goes on with it, and reads it.
EmulatorData SimulateDesign(Study& study, int points, const std::filesystem::path& folder,
                            std::stop_token stop);

}  // namespace powdercal::cli

#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>

#include "backends/backend.h"
#include "core/process.h"

namespace powdercal {

/// LIGGGHTS-PUBLIC 3.8.0, run as a program of its own, one process and one core for each run.
std::unique_ptr<Backend> MakeLiggghtsBackend();

namespace liggghts {

/// Runs the deck kDeckFile of a folder there, one process on one core; what LIGGGHTS prints goes to
/// kScreenFile.
ProcessResult RunDeck(const std::filesystem::path& folder,
                      std::optional<std::chrono::duration<double>> time_limit,
                      std::stop_token stop = {});

}  // namespace liggghts

}  // namespace powdercal

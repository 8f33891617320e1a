#pragma once

#include <filesystem>
#include <string_view>

#include "backends/backend.h"

namespace powdercal {

// The work folder of a simulator that runs as a process of its own.

/// Without waiting for the disk: nobody reads these after a crash of the machine. Throws
/// InputError.
void WriteWorkFile(const std::filesystem::path& path, std::string_view text);

/// After the run: writes outcome.txt with reason, message and what the process printed into a
/// failed run's folder; removes that of a good or cancelled one, unless its files are to be kept.
void LeaveWorkFolder(const RunContext& context, const Outcome& outcome, std::string_view output);

}  // namespace powdercal

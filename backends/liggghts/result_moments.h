#pragma once

#include <filesystem>
#include <vector>

#include "backends/liggghts/result_files.h"
#include "backends/program.h"
#include "backends/trace.h"

namespace powdercal::liggghts {

/// Moments, series and slab of a run that came to its end. Packings come sorted by id, wrapped into
/// the domain along its periodic axes, without those that are beyond an outflow side. Returns how
/// many particles were seen beyond an open side, the most at any moment. Throws std::runtime_error
/// when a file is missing or damaged.
int ReadMoments(const Program& program, const std::filesystem::path& folder,
                const std::vector<Record>& records, Trace& trace);

}  // namespace powdercal::liggghts

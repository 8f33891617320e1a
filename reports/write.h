#pragma once

#include <filesystem>

#include "studies/results.h"

namespace powdercal {

/// Writes results.json, material_card.yaml and report.html into the run folder, which must exist,
/// each atomically. All three are made before the first is written. Throws InputError where a file
/// cannot be written.
void WriteReports(const StudyResults& results, const std::filesystem::path& run_folder);

}  // namespace powdercal

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "reports/plots.h"
#include "studies/comparison/comparison.h"

namespace powdercal {

/// comparison.html: recommendation and its limits, the optimizers side by side, plots, who was
/// refused, how good the emulator is, and the command. One file that opens offline.
std::string ComparisonPage(const comparison::Comparison& comparison);

/// The page's plots; none before a seed has been ended by all.
std::vector<Figure> ComparisonFigures(const comparison::Comparison& comparison);

/// Writes comparison.json and comparison.html into the folder, which must exist. Throws InputError
/// where a file cannot be written.
void WriteComparison(const comparison::Comparison& comparison, const std::filesystem::path& folder);

}  // namespace powdercal

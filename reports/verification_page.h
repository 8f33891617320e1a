#pragma once

#include <filesystem>
#include <string>

#include "verification/ladder.h"

namespace powdercal {

/// The ladder of backends as one HTML file that opens offline: the verdict on each rung and pair,
/// every figure with its tolerance, what was not supported and why, failed runs, versions.
std::string VerificationPage(const verification::LadderReport& report);

/// Writes verification.json and verification.html into the folder.
void WriteVerification(const verification::LadderReport& report,
                       const std::filesystem::path& folder);

}  // namespace powdercal

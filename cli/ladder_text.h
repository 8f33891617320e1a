#pragma once

#include <string>

#include "verification/ladder.h"

namespace powdercal::cli {

/// What the ladder found, for people: a table for each rung, what was not supported and why, the
/// failed runs, and the result.
std::string LadderText(const verification::LadderReport& report);

}  // namespace powdercal::cli

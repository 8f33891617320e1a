#pragma once

#include <nlohmann/json_fwd.hpp>

#include "verification/ladder.h"

namespace powdercal::verification {

/// Everything in the report, by name: docs/commands.md, "verify". Figures that are not known are
/// null.
nlohmann::json LadderToJson(const LadderReport& report);

}  // namespace powdercal::verification

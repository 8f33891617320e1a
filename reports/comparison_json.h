#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "studies/comparison/comparison.h"

namespace powdercal {

/// comparison.json, schema 1 (docs/commands.md). Numbers in SI; infinite ones and those that are
/// not known are null.
nlohmann::json ComparisonToJson(const comparison::Comparison& comparison);

/// The `contests` of comparison.json, to go on from: only those that are whole. Throws InputError
/// for a document of another form.
std::vector<comparison::ContestRecord> ContestsFromJson(const nlohmann::json& document);

}  // namespace powdercal

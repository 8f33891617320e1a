#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "studies/results.h"

namespace powdercal {

/// results.json, schema 1 (docs/results.md). Numbers in SI, not-finite ones as null. `history` is a
/// function of the study and its seed alone: no times, no paths, no run ids, nothing of whether the
/// study was interrupted; those are in `runs` and `failures`.
nlohmann::json ResultsToJson(const StudyResults& results);

/// A parameter's value: a number, or the name of a category.
nlohmann::json ValueToJson(const Parameter& parameter, double value);

/// A list of {part, name, text}.
nlohmann::json ApproximationsToJson(const std::vector<ApproximationStatement>& approximations);

/// The `pi_groups` of results.json: a list of {experiment, groups: [{symbol, meaning, experiment,
/// simulation, ratio, verdict, remark}]}.
nlohmann::json PiGroupsToJson(const std::vector<ScalingTable>& tables);

/// JSON text, indented, ending in a newline; bytes that are not UTF-8 are replaced.
std::string JsonText(const nlohmann::json& json);

}  // namespace powdercal

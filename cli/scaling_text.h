#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "studies/mode_costs.h"
#include "studies/results.h"

namespace powdercal::cli {

/// The Pi groups of one experiment as an aligned table, remarks below. `colours`: verdicts green,
/// yellow and red, for terminals.
std::string GroupTable(const ScalingTable& table, bool colours);

/// What differs between the laboratory's conditions and the simulation's, as an aligned table.
std::string ConditionsTable(const ScalingTable& table);

/// What the simulated cohesion says of the powder, a sentence a line; "" where nothing is known.
std::string CohesionText(const std::vector<ScalingTable>& tables);

/// Said beside it.
inline constexpr const char* kModeTableRemark =
    ", at the centre of the box (cohesion is left out of what is violated where k is sought, or "
    "stated for the study's own modulus)";

/// What each mode costs and breaks, as an aligned table with what it means below.
std::string ModeTable(const std::vector<ModeCost>& costs);
nlohmann::json ModesToJson(const std::vector<ModeCost>& costs);

}  // namespace powdercal::cli

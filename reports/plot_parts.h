#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "studies/results.h"

namespace powdercal {

// Pieces of Vega-Lite specifications that several figures share. Fields have neutral names (p0,
// r1): dots and brackets in a field's name would mean something to Vega.

/// "k, cohesion energy density (J/m³)".
std::string ParameterTitle(const Parameter& parameter);
/// "void ratio" or "shear stress (Pa)".
std::string ResponseAxisTitle(const ResponseResult& response);

/// A positional channel over a parameter's whole searched range, on its search scale.
nlohmann::json ParameterChannel(const std::string& field, const Parameter& parameter);

/// One row for each evaluation: evaluation, origin, outcome, kind ("initial design", "search",
/// "failed", "best"), chi2, best_chi2, p0 …, r0 … (null where there is none).
nlohmann::json EvaluationRows(const StudyResults& results);
/// Tooltip channel for those rows.
nlohmann::json EvaluationTooltip(const StudyResults& results);

/// Points drawn by `kind`: circles, crosses for failures, a star for the best. `search` and
/// `initial` are fill colours. Needs x and y channels besides. `kinds`: those of the rows, for the
/// legend.
nlohmann::json KindChannels(const nlohmann::json& rows, const std::string& initial_fill,
                            const std::string& search_fill, const std::string& circle_stroke);

/// A logarithmic scale over whole decades around the values from `low` to `high`, both > 0, and its
/// ticks, about eight at most.
nlohmann::json DecadeScale(double low, double high, nlohmann::json* ticks);

/// Five significant digits: data for pictures.
double Rounded(double value);

/// In Vega's own path notation, in a square from −1 to 1.
inline constexpr char kStarSymbol[] =
    "M0,-1L0.225,-0.309L0.951,-0.309L0.363,0.118L0.588,0.809L0,0.382L-0.588,0.809L-0.363,0.118"
    "L-0.951,-0.309L-0.225,-0.309Z";
inline constexpr char kCrossSymbol[] = "M-0.75,-0.75L0.75,0.75M-0.75,0.75L0.75,-0.75";
inline constexpr char kNumberFormat[] = ".6~g";

}  // namespace powdercal

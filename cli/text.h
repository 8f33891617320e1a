#pragma once

#include <optional>
#include <string>
#include <vector>

#include "studies/results.h"

namespace powdercal::cli {

/// "4.75e+04 J/m3"; the name of a category.
std::string HumanValue(const Parameter& parameter, double value);

/// "k = 4.75e+04 J/m3, mu_r = 0.5".
std::string DescribePoint(const std::vector<Parameter>& parameters,
                          const std::vector<double>& values);

/// Rows of equal length, the first being the header, columns aligned.
std::string AlignedTable(const std::vector<std::vector<std::string>>& rows);

/// What a finished or interrupted study has found, for people.
std::string Summary(const StudyResults& results);

/// Said wherever results of the table backend are shown.
inline constexpr const char* kNoSimulation =
    "NOTE: no simulation was run; responses come from a surrogate fitted to a table.";

}  // namespace powdercal::cli

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "studies/surrogate_comparison.h"

namespace powdercal {

/// What `powdercal compare --surrogates SOURCE --json` prints (docs/commands.md).
nlohmann::json SurrogatesToJson(const std::string& source, const KnownEvaluations& known,
                                const ComparisonOptions& options,
                                std::span<const ResponseComparison> comparisons);

/// That document as a page that opens offline: for each response the table, a bar chart of R², and
/// what leave-one-out predicts over what is known.
std::string SurrogatesPage(const nlohmann::json& document);

}  // namespace powdercal

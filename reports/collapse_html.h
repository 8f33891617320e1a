#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace powdercal {

/// A page that opens offline, with every response of a collapse analysis (the document that
/// `powdercal scale STUDY --collapse --json` prints) against every group that distinguishes the
/// modes.
std::string CollapseHtml(const nlohmann::json& document);

}  // namespace powdercal

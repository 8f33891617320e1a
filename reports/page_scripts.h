#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace powdercal {

/// The plotting libraries as inline scripts: the page opens offline.
std::string ScriptLibraries();
/// JSON that no HTML parser can take for markup.
std::string ScriptJson(const nlohmann::json& value);

}  // namespace powdercal

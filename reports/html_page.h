#pragma once

#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace powdercal {

/// The text with each {{key}} replaced by its value, by nothing where there is none. In one pass:
/// what is put in is not searched for further keys.
std::string FillTemplate(std::string_view text,
                         const std::map<std::string, std::string, std::less<>>& values);
/// The plotting libraries as inline scripts: the page opens offline.
std::string ScriptLibraries();
/// JSON that no HTML parser can take for markup.
std::string ScriptJson(const nlohmann::json& value);

}  // namespace powdercal

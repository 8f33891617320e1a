#include "reports/page_scripts.h"

#include <nlohmann/json.hpp>
#include <string_view>

#include "reports/assets.h"

namespace powdercal {
namespace {

// Source maps would be looked for beside the report.
std::string_view WithoutSourceMap(std::string_view script) {
  const std::size_t comment = script.rfind("//# sourceMappingURL=");
  return comment == std::string_view::npos ? script : script.substr(0, comment);
}

}  // namespace

std::string ScriptLibraries() {
  std::string scripts;
  for (const char* name : {"vega.min.js", "vega-lite.min.js", "vega-embed.min.js"}) {
    scripts.append("<script>").append(WithoutSourceMap(Asset(name))).append("</script>\n");
  }
  return scripts;
}

std::string ScriptJson(const nlohmann::json& value) {
  const std::string json = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      safe += "\\u003c";
    } else if (c == '>') {
      safe += "\\u003e";
    } else if (c == '&') {
      safe += "\\u0026";
    } else {
      safe += c;
    }
  }
  return safe;
}

}  // namespace powdercal

#include "reports/html_page.h"

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

std::string FillTemplate(std::string_view text,
                         const std::map<std::string, std::string, std::less<>>& values) {
  std::string filled;
  while (true) {
    const std::size_t open = text.find("{{");
    const std::size_t close = text.find("}}", open == std::string_view::npos ? 0 : open);
    if (open == std::string_view::npos || close == std::string_view::npos) break;
    filled += text.substr(0, open);
    const auto value = values.find(text.substr(open + 2, close - open - 2));
    if (value != values.end()) filled += value->second;
    text.remove_prefix(close + 2);
  }
  return filled.append(text);
}

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

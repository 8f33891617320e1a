#include "reports/collapse_html.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "reports/html_page.h"
#include "reports/text.h"

namespace powdercal {
namespace {

using nlohmann::json;

// Every seed's value of a response against a group, coloured by mode.
json Plot(const json& document, const std::string& experiment, const std::string& response,
          const std::string& group) {
  json values = json::array();
  for (const json& point : document["points"]) {
    if (point["experiment"] != experiment || !point["groups"].contains(group)) continue;
    const auto found = point["responses"].find(response);
    if (found == point["responses"].end()) continue;
    for (const json& value : *found) {
      values.push_back(
          {{"mode", point["mode"]}, {"group", point["groups"][group]}, {"response", value}});
    }
  }
  const json zero_free = {{"zero", false}};
  return {{"$schema", "https://vega.github.io/schema/vega-lite/v5.json"},
          {"width", 300},
          {"height", 220},
          {"data", {{"values", values}}},
          {"mark", {{"type", "point"}, {"filled", true}, {"size", 50}}},
          {"encoding",
           {{"x",
             {{"field", "group"},
              {"type", "quantitative"},
              {"title", SymbolText(group)},
              {"scale", {{"type", "log"}}}}},
            {"y",
             {{"field", "response"},
              {"type", "quantitative"},
              {"title", ReadableName(response)},
              {"scale", zero_free}}},
            {"color", {{"field", "mode"}, {"type", "nominal"}}}}}};
}

}  // namespace

std::string CollapseHtml(const json& document) {
  std::string figures;
  std::string scripts;
  int index = 0;
  for (const json& trend : document["trends"]) {
    const std::string name = trend["response"];
    const std::size_t dot = name.find('.');
    const json spec = Plot(document, name.substr(0, dot), name.substr(dot + 1),
                           trend["group"].get<std::string>());
    figures += fmt::format(
        "<figure><div id=\"f{}\"></div><figcaption>{}: collapse {:.2f}</figcaption></figure>\n",
        index, EscapeHtml(name), trend["collapse"].get<double>());
    scripts += fmt::format("vegaEmbed('#f{}', {}, {{actions: false}});\n", index, ScriptJson(spec));
    ++index;
  }
  const std::string title = "Collapse analysis of " + document["study"].get<std::string>();
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title>\n"
      "<style>body {{ font-family: sans-serif; margin: 2em; }} figure {{ display: inline-block; "
      "margin: 1em; }}</style>\n{1}</head><body><h1>{0}</h1>\n<p>Every point is one simulation. "
      "Where a response is a function of one group alone, the points of all modes lie on one "
      "curve.</p>\n{2}<script>\n{3}</script></body></html>\n",
      EscapeHtml(title), ScriptLibraries(), figures, scripts);
}

}  // namespace powdercal

#include "reports/surrogates_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/json.h"
#include "core/version.h"
#include "reports/assets.h"
#include "reports/html_page.h"
#include "reports/plot_parts.h"
#include "reports/text.h"

namespace powdercal {
namespace {

using nlohmann::json;

constexpr char kSchema[] = "https://vega.github.io/schema/vega-lite/v5.json";
constexpr char kBestColour[] = "#14602f";
constexpr char kColour[] = "#0b5cad";

json Partitions(const RepeatedAccuracy& accuracy) {
  return {{"r2", JsonNumber(accuracy.median_r2())},
          {"r2_each", accuracy.r2},
          {"rmse", JsonNumber(accuracy.rmse)}};
}

json ToJson(const SurrogateAccuracy& one) {
  if (!one.why_not.empty()) return {{"name", one.name}, {"problem", one.why_not}};
  const Eigen::VectorXd& predicted = one.leave_one_out.predicted;
  return {{"name", one.name},
          {"problem", ""},
          {"description", one.description},
          {"leave_one_out",
           {{"r2", JsonNumber(one.leave_one_out.r2)},
            {"rmse", JsonNumber(one.leave_one_out.rmse)},
            {"predicted", std::vector<double>(predicted.begin(), predicted.end())}}},
          {"k_fold", Partitions(one.k_fold)},
          {"hold_out", Partitions(one.hold_out)}};
}

std::string WithUnit(const std::string& name, const std::string& unit) {
  const std::string pretty = PrettyUnit(unit);
  return pretty.empty() ? name : fmt::format("{} ({})", name, pretty);
}

std::string NumberOrDash(const json& value, int digits = 3) {
  return value.is_number() ? NumberText(value.get<double>(), digits) : "—";
}

std::string R2Cell(const json& value) {
  return value.is_number() ? fmt::format("{:.3f}", value.get<double>()) : "—";
}

// Median, and from the lowest to the highest.
std::string PartitionsCell(const json& partitions) {
  const auto each = partitions.at("r2_each").get<std::vector<double>>();
  if (each.empty()) return "—";
  const auto [low, high] = std::minmax_element(each.begin(), each.end());
  return fmt::format("{} <span class=\"muted small\">({:.2f} … {:.2f})</span>",
                     R2Cell(partitions.at("r2")), *low, *high);
}

std::string TableOf(const json& document, const json& response) {
  std::string html = fmt::format(
      "<table><thead><tr><th>surrogate</th><th class=\"number\">R², leave-one-out</th>"
      "<th class=\"number\">RMSE{}</th><th class=\"number\">R², {} folds, {} times</th>"
      "<th class=\"number\">R², {:.0f} % held out, {} times</th><th>fitted to all points</th></tr>"
      "</thead><tbody>\n",
      response.at("unit") == "1"
          ? ""
          : ", " + EscapeHtml(PrettyUnit(response.at("unit").get<std::string>())),
      response.at("folds").get<int>(), document.at("repeats").get<int>(),
      100 * document.at("hold_out").get<double>(), document.at("repeats").get<int>());
  for (const json& one : response.at("surrogates")) {
    const std::string name = one.at("name");
    const bool best = response.at("best") == name;
    html += fmt::format("<tr{}><td>{}{}</td>", best ? " class=\"best\"" : "",
                        EscapeHtml(ReadableName(name)),
                        best ? " <span class=\"tag good\">best</span>" : "");
    if (const std::string problem = one.at("problem"); !problem.empty()) {
      html +=
          fmt::format("<td colspan=\"5\" class=\"message\">{}</td></tr>\n", EscapeHtml(problem));
      continue;
    }
    html += fmt::format(
        "<td class=\"number\">{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td>"
        "<td class=\"number\">{}</td><td class=\"small\">{}</td></tr>\n",
        R2Cell(one.at("leave_one_out").at("r2")), NumberOrDash(one.at("leave_one_out").at("rmse")),
        PartitionsCell(one.at("k_fold")), PartitionsCell(one.at("hold_out")),
        EscapeHtml(one.at("description").get<std::string>()));
  }
  return html + "</tbody></table>\n";
}

// Negative R² would squeeze all others; their bars end at 0 with the figure beside them.
json BarSpec(const json& response) {
  json rows = json::array();
  for (const json& one : response.at("surrogates")) {
    if (!one.at("problem").get<std::string>().empty()) continue;
    const json& r2 = one.at("leave_one_out").at("r2");
    rows.push_back({{"surrogate", ReadableName(one.at("name").get<std::string>())},
                    {"r2", r2},
                    {"bar", std::max(0.0, r2.get<double>())},
                    {"best", one.at("name") == response.at("best")}});
  }
  const json y = {
      {"field", "surrogate"}, {"type", "nominal"}, {"sort", nullptr}, {"title", nullptr}};
  const json x = {{"field", "bar"},
                  {"type", "quantitative"},
                  {"title", "R² by leave-one-out"},
                  {"scale", {{"domain", {0, 1}}}}};
  return {{"$schema", kSchema},
          {"width", 430},
          {"height", {{"step", 30}}},
          {"data", {{"values", rows}}},
          {"encoding", {{"y", y}, {"x", x}}},
          {"layer",
           {{{"mark", {{"type", "bar"}, {"height", 18}}},
             {"encoding",
              {{"color",
                {{"condition", {{"test", "datum.best"}, {"value", kBestColour}}},
                 {"value", kColour}}}}}},
            {{"mark", {{"type", "text"}, {"align", "left"}, {"dx", 4}}},
             {"encoding",
              {{"text", {{"field", "r2"}, {"type", "quantitative"}, {"format", ".3f"}}}}}}}}};
}

json ScatterSpec(const json& response) {
  const auto known = response.at("values").get<std::vector<double>>();
  double low = *std::min_element(known.begin(), known.end());
  double high = *std::max_element(known.begin(), known.end());
  json rows = json::array();
  for (const json& one : response.at("surrogates")) {
    if (!one.at("problem").get<std::string>().empty()) continue;
    const json& predicted = one.at("leave_one_out").at("predicted");
    const std::string panel =
        fmt::format("{} (R² {:.2f})", ReadableName(one.at("name").get<std::string>()),
                    one.at("leave_one_out").at("r2").get<double>());
    for (std::size_t i = 0; i < known.size(); ++i) {
      const double value = predicted.at(i);
      low = std::min(low, value);
      high = std::max(high, value);
      rows.push_back({{"panel", panel},
                      {"row", i + 1},
                      {"known", Rounded(known[i])},
                      {"predicted", Rounded(value)}});
    }
  }
  const double margin = 0.04 * (high - low);
  const json domain = {low - margin, high + margin};
  const std::string title =
      WithUnit(ReadableName(response.at("name").get<std::string>()), response.at("unit"));
  const auto channel = [&](const char* field, const std::string& text) -> json {
    return {{"field", field},
            {"type", "quantitative"},
            {"title", text},
            {"scale", {{"domain", domain}, {"nice", false}, {"zero", false}}},
            {"axis", {{"tickCount", 5}, {"format", "~g"}}}};
  };
  const json diagonal = {
      {"data", {{"values", json::array({{{"a", domain[0]}, {"b", domain[1]}}})}}},
      {"mark", {{"type", "rule"}, {"color", "#5b6670"}, {"strokeDash", {4, 3}}}},
      {"encoding",
       {{"x", {{"field", "a"}, {"type", "quantitative"}}},
        {"x2", {{"field", "b"}}},
        {"y", {{"field", "a"}, {"type", "quantitative"}}},
        {"y2", {{"field", "b"}}}}}};
  const json points = {
      {"mark", {{"type", "point"}, {"filled", true}, {"size", 45}, {"color", kColour}}},
      {"encoding",
       {{"x", channel("known", title)},
        {"y", channel("predicted", "predicted from the others")},
        {"tooltip",
         {{{"field", "row"}, {"title", "point"}, {"type", "quantitative"}},
          {{"field", "known"}, {"title", "known"}, {"type", "quantitative"}},
          {{"field", "predicted"}, {"title", "predicted"}, {"type", "quantitative"}}}}}}};
  return {
      {"$schema", kSchema},
      {"data", {{"values", rows}}},
      {"facet", {{"field", "panel"}, {"type", "nominal"}, {"title", nullptr}, {"sort", nullptr}}},
      {"columns", 3},
      {"spec", {{"width", 340}, {"height", 300}, {"layer", {diagonal, points}}}}};
}

std::string Inputs(const json& document) {
  std::vector<std::string> names;
  for (const json& input : document.at("inputs")) {
    names.push_back(WithUnit(input.at("name"), input.at("unit")) +
                    (input.at("logarithmic").get<bool>() ? ", log scale" : ""));
  }
  return Enumerated(names);
}

}  // namespace

json SurrogatesToJson(const std::string& source, const KnownEvaluations& known,
                      const ComparisonOptions& options,
                      std::span<const ResponseComparison> comparisons) {
  json document = {{"schema", 1},
                   {"source", source},
                   {"notes", known.notes},
                   {"repeats", options.repeats},
                   {"hold_out", options.hold_out},
                   {"seed", options.seed},
                   {"inputs", json::array()},
                   {"responses", json::array()}};
  for (const Parameter& parameter : known.space.parameters) {
    document["inputs"].push_back({{"name", parameter.name},
                                  {"unit", parameter.unit},
                                  {"lower", parameter.lower},
                                  {"upper", parameter.upper},
                                  {"logarithmic", parameter.logarithmic}});
  }
  for (const ResponseComparison& one : comparisons) {
    json response = {{"name", one.response},
                     {"unit", one.unit},
                     {"values", std::vector<double>(one.values.begin(), one.values.end())},
                     {"folds", one.folds},
                     {"best", one.best},
                     {"surrogates", json::array()}};
    for (const SurrogateAccuracy& accuracy : one.surrogates) {
      response["surrogates"].push_back(ToJson(accuracy));
    }
    document["responses"].push_back(std::move(response));
  }
  return document;
}

std::string SurrogatesPage(const json& document) {
  const std::string source = document.at("source");
  std::string body;
  std::string scripts;
  int figure = 0;
  const auto add = [&](const json& spec, const std::string& caption) {
    body += fmt::format(
        "<figure><div class=\"plot\" id=\"f{}\"></div><figcaption>{}</figcaption></figure>\n",
        figure, caption);
    scripts += fmt::format("vegaEmbed('#f{}', {}, {{actions: false, renderer: 'svg'}});\n", figure,
                           ScriptJson(spec));
    ++figure;
  };
  for (const json& response : document.at("responses")) {
    body +=
        fmt::format("<h2>{}</h2>\n<p>{}.</p>\n{}",
                    EscapeHtml(WithUnit(response.at("name"), response.at("unit"))),
                    EscapeHtml(CountText(static_cast<int>(response.at("values").size()), "point") +
                               " over " + Inputs(document)),
                    TableOf(document, response));
    if (response.at("best").get<std::string>().empty()) continue;
    body += "<div class=\"figures\" style=\"margin-top: 14px\">\n";
    add(BarSpec(response), "Green: the best by the rule below.");
    body += "</div><div style=\"margin-top: 14px\">\n";
    add(ScatterSpec(response),
        "Every point is predicted by a fit to all the others. Dashed: perfect prediction.");
    body += "</div>\n";
  }
  const std::string heading = "Surrogates compared on " + source;
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"generator\" content=\"powdercal {0}\"><title>{1}</title>\n"
      "<link rel=\"icon\" href=\"data:,\"><style>{2}</style>\n{3}</head><body>\n"
      "<h1>{1}</h1>\n{4}<p class=\"small muted\" style=\"margin-top: 20px\">R² of k folds and of "
      "hold-out: median, lowest and highest over the repeats. Best: the highest R² by "
      "leave-one-out; of those within {5} of it the simplest.</p>\n"
      "<script>\n{6}</script></body></html>\n",
      kVersion, EscapeHtml(heading), Asset("report.css"), ScriptLibraries(), body, kEqualR2,
      scripts);
}

}  // namespace powdercal

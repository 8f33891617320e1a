#include "reports/plot_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/json.h"
#include "reports/statements.h"
#include "reports/text.h"

namespace powdercal {
namespace {

using nlohmann::json;

std::string WithUnit(const std::string& text, std::string_view unit) {
  const std::string pretty = PrettyUnit(unit);
  return pretty.empty() ? text : fmt::format("{} ({})", text, pretty);
}

std::string KindOf(const EvaluationResult& evaluation, const EvaluationResult* best) {
  if (&evaluation == best) return "best";
  if (evaluation.outcome != "ok" || !evaluation.chi2) return "failed";
  return evaluation.origin.starts_with("initial") ? "initial design" : "search";
}

}  // namespace

std::string ParameterTitle(const Parameter& parameter) {
  const std::string symbol = SymbolText(parameter.symbol);
  const std::string name = ReadableName(parameter.name);
  return WithUnit(symbol == name || symbol.empty() ? name : symbol + ", " + name, parameter.unit);
}

std::string ResponseAxisTitle(const ResponseResult& response) {
  return WithUnit(ReadableName(response.name), response.unit);
}

json ParameterChannel(const std::string& field, const Parameter& parameter) {
  if (parameter.categorical()) {
    json labels = parameter.categories;
    json positions = json::array();
    for (int level = 0; level < parameter.levels(); ++level) positions.push_back(level);
    return {{"field", field},
            {"type", "quantitative"},
            {"title", ParameterTitle(parameter)},
            {"scale", {{"domain", json::array({-0.5, parameter.upper + 0.5})}, {"nice", false}}},
            {"axis",
             {{"grid", false},
              {"values", std::move(positions)},
              {"labelExpr", labels.dump() + "[datum.value]"}}}};
  }
  json scale = {{"type", parameter.logarithmic ? "log" : "linear"},
                {"domain", json::array({parameter.lower, parameter.upper})},
                {"nice", false}};
  if (!parameter.logarithmic) scale["zero"] = false;
  json axis = {{"grid", false}, {"tickCount", 6}, {"labelFlush", false}};
  const double largest = std::max(std::abs(parameter.lower), std::abs(parameter.upper));
  if (largest >= 1e4) axis["format"] = "~s";
  if (largest < 1e-3) axis["format"] = ".2~e";
  return {{"field", field},
          {"type", "quantitative"},
          {"title", ParameterTitle(parameter)},
          {"scale", std::move(scale)},
          {"axis", std::move(axis)}};
}

json EvaluationRows(const StudyResults& results) {
  const EvaluationResult* best = BestEvaluation(results);
  json rows = json::array();
  for (const EvaluationResult& evaluation : results.history) {
    json row = {
        {"evaluation", evaluation.id},         {"origin", evaluation.origin},
        {"outcome", evaluation.outcome},       {"kind", KindOf(evaluation, best)},
        {"chi2", JsonNumber(evaluation.chi2)}, {"best_chi2", JsonNumber(evaluation.best_chi2)}};
    for (std::size_t i = 0; i < results.parameters.size(); ++i) {
      const auto found = evaluation.parameters.find(results.parameters[i].name);
      row[fmt::format("p{}", i)] =
          found == evaluation.parameters.end() ? json(nullptr) : JsonNumber(found->second);
      if (results.parameters[i].categorical() && found != evaluation.parameters.end()) {
        row[fmt::format("category{}", i)] = results.parameters[i].CategoryAt(found->second);
      }
    }
    for (std::size_t i = 0; i < evaluation.responses.size(); ++i) {
      row[fmt::format("r{}", i)] = JsonNumber(evaluation.responses[i].simulated);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

json EvaluationTooltip(const StudyResults& results) {
  const auto number = [](const std::string& field, const std::string& title) -> json {
    return {
        {"field", field}, {"title", title}, {"type", "quantitative"}, {"format", kNumberFormat}};
  };
  const auto text = [](const std::string& field, const std::string& title) -> json {
    return {{"field", field}, {"title", title}, {"type", "nominal"}};
  };
  json tooltip = json::array(
      {text("evaluation", "evaluation"), text("origin", "origin"), text("outcome", "outcome")});
  for (std::size_t i = 0; i < results.parameters.size(); ++i) {
    const Parameter& parameter = results.parameters[i];
    const std::string title = WithUnit(SymbolText(parameter.symbol), parameter.unit);
    tooltip.push_back(parameter.categorical() ? text(fmt::format("category{}", i), title)
                                              : number(fmt::format("p{}", i), title));
  }
  const std::vector<ResponseResult> targets = TargetResponses(results);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    tooltip.push_back(number(fmt::format("r{}", i), ResponseAxisTitle(targets[i])));
  }
  tooltip.push_back(number("chi2", "χ²"));
  return tooltip;
}

json KindChannels(const json& rows, const std::string& initial_fill, const std::string& search_fill,
                  const std::string& circle_stroke) {
  struct Kind {
    const char* name;
    const char* shape;
    std::string fill;
    std::string stroke;
  };
  const Kind kinds[] = {{"initial design", "circle", initial_fill, circle_stroke},
                        {"search", "circle", search_fill, circle_stroke},
                        {"failed", kCrossSymbol, "transparent", "#a3128f"},
                        {"best", kStarSymbol, "#d7191c", "#ffffff"}};
  json domain = json::array();
  json shapes = json::array();
  json fills = json::array();
  json strokes = json::array();
  for (const Kind& kind : kinds) {
    bool present = false;
    for (const json& row : rows) present = present || row.at("kind") == kind.name;
    if (!present) continue;
    domain.push_back(kind.name);
    shapes.push_back(kind.shape);
    fills.push_back(kind.fill);
    strokes.push_back(kind.stroke);
  }
  const auto channel = [&](const json& range) -> json {
    return {{"field", "kind"},
            {"type", "nominal"},
            {"scale", {{"domain", domain}, {"range", range}}},
            {"legend", {{"title", nullptr}, {"orient", "bottom"}, {"symbolSize", 170}}}};
  };
  return {{"shape", channel(shapes)},
          {"fill", channel(fills)},
          {"stroke", channel(strokes)},
          {"size",
           {{"condition", json::array({{{"test", "datum.kind == 'best'"}, {"value", 420}},
                                       {{"test", "datum.kind == 'failed'"}, {"value", 130}}})},
            {"value", 70}}}};
}

json DecadeScale(double low, double high, json* ticks) {
  const int first = static_cast<int>(std::floor(std::log10(low) - 0.15));
  const int last = static_cast<int>(std::ceil(std::log10(high) + 0.15));
  const int step = std::max(1, (last - first + 7) / 8);
  *ticks = json::array();
  for (int decade = first; decade <= last; decade += step) {
    ticks->push_back(std::pow(10.0, decade));
  }
  return {{"type", "log"},
          {"domain", json::array({std::pow(10.0, first), std::pow(10.0, last)})},
          {"nice", false}};
}

double Rounded(double value) { return std::stod(fmt::format("{:.5g}", value)); }

}  // namespace powdercal

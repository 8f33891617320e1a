#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "reports/plot_parts.h"
#include "reports/plots.h"
#include "reports/statements.h"
#include "reports/text.h"

namespace powdercal {
namespace {

using nlohmann::json;

constexpr char kDominated[] = "other evaluation";
constexpr char kFront[] = "on the front";
constexpr char kBest[] = "best: lowest sum";
constexpr char kBestColour[] = "#d7191c";
constexpr char kFrontColour[] = "#0b5cad";
constexpr char kRestColour[] = "#7d8790";
constexpr double kSmallestMisfit = 1e-6;  // 0 has no place on a logarithmic axis

// A row for each evaluation that has all misfits: those of EvaluationRows, `standing`, and m0, m1 …
json FrontRows(const StudyResults& results) {
  const json all = EvaluationRows(results);
  json rows = json::array();
  for (std::size_t i = 0; i < results.history.size(); ++i) {
    const EvaluationResult& evaluation = results.history[i];
    json row = all[i];
    bool complete = true;
    for (std::size_t o = 0; o < results.objectives.size(); ++o) {
      const std::optional<double>& misfit = evaluation.objectives[o].misfit;
      complete = complete && misfit;
      if (misfit) row[fmt::format("m{}", o)] = std::max(*misfit, kSmallestMisfit);
    }
    if (!complete) continue;
    const bool front =
        std::find(results.pareto.begin(), results.pareto.end(), i) != results.pareto.end();
    row["standing"] = &evaluation == BestEvaluation(results) ? kBest : front ? kFront : kDominated;
    rows.push_back(std::move(row));
  }
  return rows;
}

// Misfit of an objective at which its responses are off by one standard deviation each; > 0.
int Level(const StudyResults& results, std::size_t objective) {
  return std::max(1, TargetCount(results, objective));
}

std::string MisfitTitle(const StudyResults& results, std::size_t objective) {
  return "misfit of " + ReadableName(results.objectives[objective]);
}

json MisfitTooltip(const StudyResults& results) {
  json tooltip = EvaluationTooltip(results);
  for (std::size_t o = 0; o < results.objectives.size(); ++o) {
    tooltip.push_back({{"field", fmt::format("m{}", o)},
                       {"title", MisfitTitle(results, o)},
                       {"type", "quantitative"},
                       {"format", kNumberFormat}});
  }
  return tooltip;
}

// Of one objective, over its misfits and its level.
json MisfitChannel(const StudyResults& results, const json& rows, std::size_t objective) {
  const std::string field = fmt::format("m{}", objective);
  double low = Level(results, objective);
  double high = low;
  for (const json& row : rows) {
    low = std::min(low, row.at(field).get<double>());
    high = std::max(high, row.at(field).get<double>());
  }
  json ticks;
  json scale = DecadeScale(low, high, &ticks);
  return {{"field", field},
          {"type", "quantitative"},
          {"title", MisfitTitle(results, objective)},
          {"scale", std::move(scale)},
          {"axis", {{"values", std::move(ticks)}, {"format", "~g"}}}};
}

json StandingChannel(const json& range) {
  return {{"field", "standing"},
          {"type", "nominal"},
          {"scale", {{"domain", {kDominated, kFront, kBest}}, {"range", range}}},
          {"legend",
           {{"title", nullptr}, {"orient", "bottom"}, {"symbolSize", 170}, {"symbolOpacity", 1}}}};
}

json LevelLayer(const char* axis, const json& channel, int level) {
  json datum = channel;
  datum.erase("field");
  datum["datum"] = level;
  return {{"data", {{"values", json::array({json::object()})}}},
          {"mark", {{"type", "rule"}, {"strokeDash", {4, 4}}, {"color", "#5b6670"}}},
          {"encoding", {{axis, std::move(datum)}}}};
}

json PlaneSpec(const StudyResults& results, const json& rows) {
  const json x = MisfitChannel(results, rows, 0);
  const json y = MisfitChannel(results, rows, 1);
  const std::string front_only = fmt::format("datum.standing != '{}'", kDominated);
  json points = {
      {"x", x},
      {"y", y},
      {"shape", StandingChannel({"circle", "circle", kStarSymbol})},
      {"fill", StandingChannel({"transparent", kFrontColour, kBestColour})},
      {"stroke", StandingChannel({kRestColour, "#ffffff", "#ffffff"})},
      {"size",
       {{"condition", {{"test", fmt::format("datum.standing == '{}'", kBest)}, {"value", 420}}},
        {"value", 80}}},
      {"tooltip", MisfitTooltip(results)}};
  return {
      {"width", "container"},
      {"height", 420},
      {"data", {{"values", rows}}},
      {"layer",
       json::array(
           {LevelLayer("x", x, Level(results, 0)),
            LevelLayer("y", y, Level(results, 1)),
            {{"transform", {{{"filter", front_only}}}},
             {"mark",
              {{"type", "line"},
               {"interpolate", "step-after"},
               {"color", kFrontColour},
               {"strokeWidth", 1.5}}},
             {"encoding", {{"x", x}, {"y", y}}}},
            {{"mark", {{"type", "point"}, {"strokeWidth", 1.2}, {"opacity", 1}}},
             {"encoding", std::move(points)}},
            {{"transform", {{{"filter", front_only}}}},
             {"mark", {{"type", "text"}, {"align", "left"}, {"dx", 9}, {"dy", -9}}},
             {"encoding",
              {{"x", x}, {"y", y}, {"text", {{"field", "evaluation"}, {"type", "nominal"}}}}}}})}};
}

// One row for each objective of each evaluation.
json LineRows(const StudyResults& results, const json& rows) {
  json lines = json::array();
  for (const json& row : rows) {
    for (std::size_t o = 0; o < results.objectives.size(); ++o) {
      lines.push_back({{"evaluation", row.at("evaluation")},
                       {"standing", row.at("standing")},
                       {"objective", ReadableName(results.objectives[o])},
                       {"misfit", row.at(fmt::format("m{}", o))}});
    }
  }
  return lines;
}

json LinesSpec(const StudyResults& results, const json& rows) {
  const json lines = LineRows(results, rows);
  json order = json::array();
  json levels = json::array();
  double low = std::numeric_limits<double>::infinity();
  double high = 0;
  for (const json& row : lines) {
    low = std::min(low, row.at("misfit").get<double>());
    high = std::max(high, row.at("misfit").get<double>());
  }
  for (std::size_t o = 0; o < results.objectives.size(); ++o) {
    const int level = Level(results, o);
    order.push_back(ReadableName(results.objectives[o]));
    levels.push_back({{"objective", order.back()}, {"misfit", level}});
    low = std::min<double>(low, level);
    high = std::max<double>(high, level);
  }
  json ticks;
  const json scale = DecadeScale(low, high, &ticks);
  const json x = {{"field", "objective"},
                  {"type", "nominal"},
                  {"sort", order},
                  {"title", nullptr},
                  {"axis", {{"labelAngle", 0}, {"labelLimit", 220}, {"grid", true}}},
                  {"scale", {{"type", "point"}}}};
  const json y = {{"field", "misfit"},
                  {"type", "quantitative"},
                  {"title", "misfit (logarithmic)"},
                  {"scale", scale},
                  {"axis", {{"values", ticks}, {"format", "~g"}}}};
  const json tooltip =
      json::array({{{"field", "evaluation"}, {"type", "nominal"}},
                   {{"field", "objective"}, {"type", "nominal"}},
                   {{"field", "misfit"}, {"type", "quantitative"}, {"format", kNumberFormat}}});
  const json colour = StandingChannel({kRestColour, kFrontColour, kBestColour});
  const json detail = {{"field", "evaluation"}, {"type", "nominal"}};
  json layers = json::array();
  // The best is drawn last.
  for (const auto& [standing, width, opacity] :
       {std::tuple{kDominated, 1.0, 0.35}, {kFront, 1.8, 0.9}, {kBest, 3.5, 1.0}}) {
    layers.push_back(
        {{"transform", {{{"filter", fmt::format("datum.standing == '{}'", standing)}}}},
         {"mark",
          {{"type", "line"},
           {"point", {{"size", 35}}},
           {"strokeWidth", width},
           {"opacity", opacity}}},
         {"encoding",
          {{"x", x}, {"y", y}, {"detail", detail}, {"color", colour}, {"tooltip", tooltip}}}});
  }
  layers.push_back(
      {{"data", {{"values", levels}}},
       {"mark", {{"type", "tick"}, {"size", 46}, {"thickness", 2}, {"color", "#1c2329"}}},
       {"encoding", {{"x", x}, {"y", y}}}});
  return {{"width", "container"},
          {"height", 380},
          {"data", {{"values", lines}}},
          {"layer", std::move(layers)}};
}

}  // namespace

std::vector<Figure> ParetoFigures(const StudyResults& results) {
  if (results.objectives.size() < 2 || results.pareto.empty()) return {};
  const json rows = FrontRows(results);
  Figure figure{.key = "pareto"};
  if (results.objectives.size() == 2) {
    figure.title = fmt::format("Misfits of {} and {}", ReadableName(results.objectives[0]),
                               ReadableName(results.objectives[1]));
    figure.caption =
        "Every evaluation by its misfits; better is down and to the left. Blue line: the front, "
        "below and left of which no evaluation lies; the numbers are those of the evaluations. "
        "Dashed: every response one standard deviation off.";
    figure.spec = PlaneSpec(results, rows);
  } else {
    figure.title = "The experiments side by side";
    figure.caption =
        "Every evaluation as a line across its misfits; lower is better. Lines on the front that "
        "cross show what one experiment gains and another loses. Black ticks: every response one "
        "standard deviation off.";
    figure.spec = LinesSpec(results, rows);
  }
  return {figure};
}

}  // namespace powdercal

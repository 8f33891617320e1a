#include "reports/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "reports/plot_parts.h"
#include "reports/statements.h"
#include "reports/text.h"

namespace powdercal {
namespace {

using nlohmann::json;

json Quantitative(const char* field, const char* title) {
  return {{"field", field}, {"type", "quantitative"}, {"title", title}};
}

// chi² of 0 has no place on a logarithmic axis: it is drawn below all others.
double LowestDrawnChi2(const StudyResults& results) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const EvaluationResult& evaluation : results.history) {
    if (evaluation.chi2 && *evaluation.chi2 > 0) lowest = std::min(lowest, *evaluation.chi2);
  }
  return std::isfinite(lowest) ? lowest / 10 : 1e-6;
}

json ConvergenceLayers(const StudyResults& results, const json& rows, std::size_t targets,
                       const json& x, const json& y) {
  json points = KindChannels(rows, "#ffffff", "#0b5cad", "#0b5cad");
  points["x"] = x;
  points["y"] = y;
  points["tooltip"] = EvaluationTooltip(results);
  json failures = points;
  failures["y"] = {{"value", 12}};
  json line = {{"x", x}, {"y", y}};
  line["y"]["field"] = "drawn_best";
  json level = {{"y", y}};
  level["y"].erase("field");
  level["y"]["datum"] = targets;
  json label = level;
  label["x"] = {{"value", 0}};
  label["text"] = {
      {"value", targets == 1 ? std::string("χ² = 1: one standard deviation off")
                             : fmt::format("χ² = {}: one standard deviation off, each", targets)}};
  // One row, so that each is drawn once.
  const json single = {{"values", json::array({json::object()})}};
  return json::array(
      {{{"data", single},
        {"mark", {{"type", "rule"}, {"strokeDash", {4, 4}}, {"color", "#5b6670"}}},
        {"encoding", std::move(level)}},
       {{"data", single},
        {"mark",
         {{"type", "text"}, {"align", "left"}, {"dy", -7}, {"dx", 6}, {"color", "#414b54"}}},
        {"encoding", std::move(label)}},
       {{"transform", {{{"filter", "isValid(datum.drawn_best)"}}}},
        {"mark",
         {{"type", "line"},
          {"interpolate", "step-after"},
          {"color", "#1c2329"},
          {"strokeWidth", 2}}},
        {"encoding", std::move(line)}},
       {{"transform", {{{"filter", "datum.kind == 'failed'"}}}},
        {"mark", {{"type", "point"}, {"strokeWidth", 2.5}, {"opacity", 1}}},
        {"encoding", std::move(failures)}},
       {{"transform", {{{"filter", "datum.kind != 'failed'"}}}},
        {"mark", {{"type", "point"}, {"strokeWidth", 1.5}, {"opacity", 1}}},
        {"encoding", std::move(points)}}});
}

// Whole decades around the values, and the level itself.
json Chi2Scale(const json& rows, double level, json* ticks) {
  double low = level;
  double high = level;
  for (const json& row : rows) {
    if (row["drawn"].is_null()) continue;
    low = std::min(low, row["drawn"].get<double>());
    high = std::max(high, row["drawn"].get<double>());
  }
  return DecadeScale(low, high, ticks);
}

struct Span {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void Include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

json FitColour() {
  return {{"field", "fit"},
          {"type", "nominal"},
          {"scale",
           {{"domain", json::array({"within", "outside"})},
            {"range", json::array({"#0b5cad", "#b3261e"})}}},
          {"legend", {{"title", nullptr}, {"orient", "bottom"}}}};
}

json FitSpec(const std::vector<const ResponseResult*>& responses) {
  json rows = json::array();
  Span span;
  for (const ResponseResult* response : responses) {
    const double simulated = *response->simulated;
    for (const double value : {response->observed - response->sd, response->observed + response->sd,
                               simulated - response->seed_sd, simulated + response->seed_sd}) {
      span.Include(value);
    }
    rows.push_back({{"response", response->name},
                    {"label", ReadableName(response->name)},
                    {"observed", response->observed},
                    {"low", response->observed - response->sd},
                    {"high", response->observed + response->sd},
                    {"simulated", simulated},
                    {"sim_low", simulated - response->seed_sd},
                    {"sim_high", simulated + response->seed_sd},
                    {"sd", response->sd},
                    {"fit", JudgeFit(*response).within ? "within" : "outside"}});
  }
  const double margin = 0.12 * std::max(span.high - span.low, 1e-9 * std::abs(span.high));
  const double low = span.low - margin;
  const double high = span.high + margin;
  const std::string unit = PrettyUnit(responses[0]->unit);
  const auto axis = [&](const char* field, std::string title) -> json {
    if (!unit.empty()) title += " (" + unit + ")";
    return {{"field", field},
            {"type", "quantitative"},
            {"title", title},
            {"scale", {{"domain", json::array({low, high})}, {"nice", false}, {"zero", false}}}};
  };
  const json x = axis("observed", "observed");
  const json y = axis("simulated", "simulated");
  json tooltip = json::array({{{"field", "response"}, {"type", "nominal"}}});
  for (const char* field : {"observed", "sd", "simulated"}) {
    tooltip.push_back({{"field", field}, {"type", "quantitative"}, {"format", kNumberFormat}});
  }
  const json color = FitColour();
  return {
      {"width", 400},
      {"height", 340},
      {"data", {{"values", rows}}},
      {"layer",
       json::array(
           {{{"data",
              {{"values", json::array({{{"a", low}, {"b", low}}, {{"a", high}, {"b", high}}})}}},
             {"mark", {{"type", "line"}, {"strokeDash", {4, 4}}, {"color", "#5b6670"}}},
             {"encoding",
              {{"x", {{"field", "a"}, {"type", "quantitative"}}},
               {"y", {{"field", "b"}, {"type", "quantitative"}}}}}},
            {{"mark", {{"type", "rule"}, {"strokeWidth", 1.5}}},
             {"encoding",
              {{"x", {{"field", "low"}, {"type", "quantitative"}}},
               {"x2", {{"field", "high"}}},
               {"y", y},
               {"color", color}}}},
            {{"mark", {{"type", "rule"}, {"strokeWidth", 1.5}}},
             {"encoding",
              {{"x", x},
               {"y", {{"field", "sim_low"}, {"type", "quantitative"}}},
               {"y2", {{"field", "sim_high"}}},
               {"color", color}}}},
            {{"mark", {{"type", "point"}, {"filled", true}, {"size", 90}, {"opacity", 1}}},
             {"encoding", {{"x", x}, {"y", y}, {"color", color}, {"tooltip", tooltip}}}},
            {{"mark", {{"type", "text"}, {"align", "left"}, {"dx", 9}, {"dy", 12}}},
             {"encoding",
              {{"x", x}, {"y", y}, {"text", {{"field", "label"}, {"type", "nominal"}}}}}}})}};
}

json DeviationSpec(const std::vector<ResponseResult>& responses) {
  json rows = json::array();
  json order = json::array();
  double widest = 2.5;
  for (const ResponseResult& response : responses) {
    const Fit fit = JudgeFit(response);
    order.push_back(response.name);
    if (!fit.deviation || response.sd <= 0) continue;
    const double z = *fit.deviation / response.sd;
    widest = std::max(widest, 1.1 * std::abs(z));
    rows.push_back({{"response", response.name},
                    {"z", z},
                    {"deviation", *fit.deviation},
                    {"unit", PrettyUnit(response.unit)},
                    {"fit", fit.within ? "within" : "outside"}});
  }
  const json y = {{"field", "response"},
                  {"type", "nominal"},
                  {"sort", order},
                  {"title", nullptr},
                  {"scale", {{"domain", order}}},
                  {"axis", {{"labelLimit", 220}, {"grid", true}}}};
  const auto x = [&](const char* field) -> json {
    return {{"field", field},
            {"type", "quantitative"},
            {"title", "(simulated − observed) / sd"},
            {"scale", {{"domain", json::array({-widest, widest})}}}};
  };
  json tooltip = json::array({{{"field", "response"}, {"type", "nominal"}}});
  for (const char* field : {"z", "deviation"}) {
    tooltip.push_back({{"field", field}, {"type", "quantitative"}, {"format", kNumberFormat}});
  }
  tooltip.push_back({{"field", "unit"}, {"type", "nominal"}});
  const json band = {{"values", json::array({{{"from", -2}, {"to", 2}, {"zero", 0}}})}};
  return {
      {"width", "container"},
      {"height", 34 * responses.size()},
      {"layer",
       json::array({{{"data", band},
                     {"mark", {{"type", "rect"}, {"color", "#0b5cad"}, {"opacity", 0.12}}},
                     {"encoding", {{"x", x("from")}, {"x2", {{"field", "to"}}}}}},
                    {{"data", band},
                     {"mark", {{"type", "rule"}, {"strokeDash", {4, 4}}, {"color", "#5b6670"}}},
                     {"encoding", {{"x", x("zero")}}}},
                    {{"data", {{"values", rows}}},
                     {"mark", {{"type", "point"}, {"filled", true}, {"size", 90}, {"opacity", 1}}},
                     {"encoding",
                      {{"x", x("z")}, {"y", y}, {"color", FitColour()}, {"tooltip", tooltip}}}}})}};
}

// One row for each parameter of each evaluation that succeeded.
json ParallelRows(const StudyResults& results, const json& titles) {
  const SearchSpace space{results.parameters};
  const EvaluationResult* best = BestEvaluation(results);
  const double lowest = LowestDrawnChi2(results);
  json rows = json::array();
  for (const EvaluationResult& evaluation : results.history) {
    if (!evaluation.chi2) continue;
    Eigen::VectorXd values(space.dimension());
    for (int d = 0; d < space.dimension(); ++d) {
      const auto found = evaluation.parameters.find(space.parameters[d].name);
      values[d] = found == evaluation.parameters.end() ? NAN : found->second;
    }
    if (!values.allFinite()) continue;
    const Eigen::VectorXd unit = space.ToUnit(values);
    for (int d = 0; d < space.dimension(); ++d) {
      rows.push_back(
          {{"evaluation", evaluation.id},
           {"parameter", titles[d]},
           {"position", Rounded(unit[d])},
           {"value", space.parameters[d].categorical() ? json(nullptr) : json(values[d])},
           {"category", space.parameters[d].categorical()
                            ? json(space.parameters[d].CategoryAt(values[d]))
                            : json(nullptr)},
           {"chi2", *evaluation.chi2},
           {"drawn", std::max(*evaluation.chi2, lowest)},
           {"best", &evaluation == best}});
    }
  }
  return rows;
}

}  // namespace

Figure ConvergenceFigure(const StudyResults& results) {
  Figure figure{.key = "convergence", .title = "Convergence"};
  if (results.history.empty()) {
    figure.caption = "No evaluation has ended yet.";
    return figure;
  }
  json rows = EvaluationRows(results);
  const double lowest = LowestDrawnChi2(results);
  for (json& row : rows) {
    for (const auto& [from, to] : {std::pair{"chi2", "drawn"}, {"best_chi2", "drawn_best"}}) {
      const json& value = row[from];
      row[to] = value.is_null() ? json(nullptr) : json(std::max(value.get<double>(), lowest));
    }
  }
  const std::size_t targets = std::max<std::size_t>(1, TargetResponses(results).size());
  json x = Quantitative("evaluation", "evaluation, in the order of asking");
  x["scale"] = {
      {"domain", json::array({results.history.front().id - 0.5, results.history.back().id + 0.5})},
      {"nice", false},
      {"zero", false}};
  x["axis"] = {{"tickMinStep", 1}, {"format", "d"}, {"grid", false}};
  json y = Quantitative("drawn", "χ² (logarithmic)");
  json ticks;
  y["scale"] = Chi2Scale(rows, static_cast<double>(targets), &ticks);
  y["axis"] = {{"values", std::move(ticks)}, {"format", "~g"}};
  figure.spec = {{"width", "container"},
                 {"height", 340},
                 {"data", {{"values", rows}}},
                 {"layer", ConvergenceLayers(results, rows, targets, x, y)}};
  figure.caption =
      "χ² of every evaluation: the sum over the responses of (simulated − observed)² over the "
      "variance. Line: χ² of the best point so far.";
  if (results.failed + results.partial > 0) {
    figure.caption += results.partial == 0
                          ? " Crosses at the top: evaluations that failed."
                          : " Crosses at the top: evaluations that failed, wholly or in part.";
  }
  return figure;
}

std::vector<Figure> ParallelFigures(const StudyResults& results) {
  if (results.parameters.size() <= 3 || results.ok == 0) return {};
  json order = json::array();
  for (const Parameter& parameter : results.parameters) order.push_back(ParameterTitle(parameter));
  const json rows = ParallelRows(results, order);
  json tooltip = json::array({{{"field", "evaluation"}, {"type", "nominal"}}});
  const bool names = std::any_of(results.parameters.begin(), results.parameters.end(),
                                 [](const Parameter& p) { return p.categorical(); });
  if (names) tooltip.push_back({{"field", "category"}, {"type", "nominal"}});
  for (const char* field : {"value", "chi2"}) {
    tooltip.push_back({{"field", field}, {"type", "quantitative"}, {"format", kNumberFormat}});
  }
  const json x = {{"field", "parameter"},
                  {"type", "nominal"},
                  {"sort", order},
                  {"title", nullptr},
                  {"axis", {{"labelAngle", 0}, {"labelLimit", 220}, {"grid", true}}},
                  {"scale", {{"type", "point"}}}};
  const json y = {{"field", "position"},
                  {"type", "quantitative"},
                  {"title", "position in the searched range"},
                  {"scale", {{"domain", json::array({0, 1})}}}};
  const json detail = {{"field", "evaluation"}, {"type", "nominal"}};
  const json color = {{"field", "drawn"},
                      {"type", "quantitative"},
                      {"title", "χ²"},
                      {"scale", {{"type", "log"}, {"scheme", "viridis"}}},
                      {"legend", {{"type", "gradient"}, {"gradientLength", 240}}}};
  Figure figure{.key = "parallel", .title = "All parameters"};
  figure.caption =
      "Each line is one evaluation; its colour is its χ². Red: the best. The plot above shows only "
      "the plane of the first two parameters.";
  figure.spec = {
      {"width", "container"},
      {"height", 300},
      {"data", {{"values", rows}}},
      {"layer",
       json::array({{{"transform", {{{"filter", "!datum.best"}}}},
                     {"mark", {{"type", "line"}, {"opacity", 0.7}}},
                     {"encoding", {{"x", x}, {"y", y}, {"detail", detail}, {"color", color}}}},
                    {{"transform", {{{"filter", "!datum.best"}}}},
                     {"mark", {{"type", "circle"}, {"color", "#5b6670"}, {"size", 30}}},
                     {"encoding", {{"x", x}, {"y", y}, {"tooltip", tooltip}}}},
                    {{"transform", {{{"filter", "datum.best"}}}},
                     {"mark",
                      {{"type", "line"},
                       {"point", {{"color", "#d7191c"}, {"size", 70}}},
                       {"color", "#d7191c"},
                       {"strokeWidth", 3.5}}},
                     {"encoding", {{"x", x}, {"y", y}, {"tooltip", tooltip}}}}})}};
  return {figure};
}

std::vector<Figure> FitFigures(const StudyResults& results) {
  const EvaluationResult* best = BestEvaluation(results);
  if (best == nullptr || best->responses.size() < 2) return {};
  std::map<std::string, std::vector<const ResponseResult*>> by_unit;
  for (const ResponseResult& response : best->responses) {
    if (response.simulated && std::isfinite(*response.simulated)) {
      by_unit[response.unit].push_back(&response);
    }
  }
  std::vector<Figure> figures = {{.key = "fit", .title = "Deviation of each response"}};
  figures[0].caption =
      "Simulated minus observed at the best point, in standard deviations of the observation. "
      "Shaded: two standard deviations to either side.";
  figures[0].spec = DeviationSpec(best->responses);
  for (const auto& [unit, responses] : by_unit) {
    if (responses.size() < 2) continue;
    const std::string pretty = PrettyUnit(unit);
    Figure figure{.key = fmt::format("fit-{}", figures.size()),
                  .title = pretty.empty() ? "Simulated against observed"
                                          : fmt::format("Simulated against observed, {}", pretty)};
    figure.caption =
        "At the best point. Horizontal bars: standard deviation of the observation; vertical bars: "
        "scatter between particle seeds. On the dashed line the two agree.";
    figure.spec = FitSpec(responses);
    figures.push_back(std::move(figure));
  }
  return figures;
}

std::vector<Figure> TransferFigures(const StudyResults& results) {
  std::vector<ResponseResult> compared;
  for (const ResponseResult& response : results.transfer.responses) {
    if (response.was_observed()) compared.push_back(response);
  }
  if (compared.size() < 2) return {};
  Figure figure{.key = "transfer", .title = "Deviation of what was not fitted"};
  figure.caption =
      "Simulated minus observed at the best point, in standard deviations of the observation, of "
      "the experiments that took no part in the calibration.";
  figure.spec = DeviationSpec(compared);
  return {figure};
}

}  // namespace powdercal

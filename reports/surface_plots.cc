#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "reports/contour.h"
#include "reports/plot_parts.h"
#include "reports/plots.h"
#include "reports/response_surface.h"
#include "reports/statements.h"
#include "reports/text.h"

namespace powdercal {
namespace {

using nlohmann::json;

constexpr int kLineNodes = 121;
constexpr char kHalo[] = "#ffffff";
constexpr char kLevel[] = "#111111";

// Indices of the parameters that a surface can be drawn over: not those of names.
std::vector<int> Numbers(const StudyResults& results) {
  std::vector<int> indices;
  for (std::size_t i = 0; i < results.parameters.size(); ++i) {
    if (!results.parameters[i].categorical()) indices.push_back(static_cast<int>(i));
  }
  return indices;
}

std::vector<std::pair<int, int>> Pairs(const StudyResults& results) {
  const std::vector<int> numbers = Numbers(results);
  const std::size_t d = numbers.size();
  if (d < 2) return {};
  if (d > 3) return {{numbers[0], numbers[1]}};
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < d; ++i) {
    for (std::size_t j = i + 1; j < d; ++j) pairs.emplace_back(numbers[i], numbers[j]);
  }
  return pairs;
}

// The best point, or the middle, in the unit box.
Eigen::VectorXd BasePoint(const StudyResults& results) {
  const SearchSpace space{results.parameters};
  const EvaluationResult* best = BestEvaluation(results);
  Eigen::VectorXd base = Eigen::VectorXd::Constant(space.dimension(), 0.5);
  if (best == nullptr) return base;
  Eigen::VectorXd values = space.FromUnit(base);
  for (int d = 0; d < space.dimension(); ++d) {
    const auto found = best->parameters.find(space.parameters[d].name);
    if (found != best->parameters.end()) values[d] = found->second;
  }
  return space.ToUnit(values);
}

double FromUnit(const Parameter& parameter, double u) {
  return parameter.logarithmic ? parameter.lower * std::pow(parameter.upper / parameter.lower, u)
                               : parameter.lower + (parameter.upper - parameter.lower) * u;
}

// The same as a Vega expression.
std::string FromUnitExpression(const Parameter& parameter, const std::string& u) {
  return parameter.logarithmic
             ? fmt::format("{} * pow({}, {})", parameter.lower, parameter.upper / parameter.lower,
                           u)
             : fmt::format("{} + ({}) * {}", parameter.lower, parameter.upper - parameter.lower, u);
}

json TooltipNumber(const std::string& field, const std::string& title) {
  return {{"field", field}, {"title", title}, {"type", "quantitative"}, {"format", kNumberFormat}};
}

// Means and deviations travel as two bare lists; Vega-Lite works out the rectangles. Each rectangle
// reaches under its right and upper neighbours, which are drawn later: no seams between the
// colours.
json ColourMapLayer(const SurfaceGrid& grid, const Parameter& px, const Parameter& py,
                    const ResponseResult& target) {
  const auto nodes = grid.mean.rows();
  json mean = json::array();
  json sd = json::array();
  for (Eigen::Index i = 0; i < nodes; ++i) {
    for (Eigen::Index j = 0; j < nodes; ++j) {
      mean.push_back(Rounded(grid.mean(i, j)));
      sd.push_back(Rounded(grid.sd(i, j)));
    }
  }
  json transform = json::array(
      {{{"flatten", {"mean", "sd"}}}, {{"window", {{{"op", "row_number"}, {"as", "n"}}}}}});
  const auto calculate = [&](const std::string& expression, const char* as) {
    transform.push_back({{"calculate", expression}, {"as", as}});
  };
  calculate(fmt::format("floor((datum.n - 1) / {})", nodes), "i");
  calculate(fmt::format("(datum.n - 1) % {}", nodes), "j");
  const auto unit = [&](const char* index, const char* offset) {
    return fmt::format("clamp((datum.{} {}) / {}, 0, 1)", index, offset, nodes - 1);
  };
  calculate(FromUnitExpression(px, unit("i", "- 0.5")), "x1");
  calculate(FromUnitExpression(px, unit("i", "+ 1")), "x2");
  calculate(FromUnitExpression(py, unit("j", "- 0.5")), "y1");
  calculate(FromUnitExpression(py, unit("j", "+ 1")), "y2");
  calculate(FromUnitExpression(px, unit("i", "+ 0")), "xc");
  calculate(FromUnitExpression(py, unit("j", "+ 0")), "yc");
  const std::string title = ResponseAxisTitle(target);
  return {
      {"data", {{"values", json::array({{{"mean", mean}, {"sd", sd}}})}}},
      {"transform", std::move(transform)},
      {"mark", {{"type", "rect"}, {"strokeWidth", 0}}},
      {"encoding",
       {{"x", ParameterChannel("x1", px)},
        {"x2", {{"field", "x2"}}},
        {"y", ParameterChannel("y1", py)},
        {"y2", {{"field", "y2"}}},
        {"color",
         {{"field", "mean"},
          {"type", "quantitative"},
          {"scale", {{"scheme", "viridis"}, {"zero", false}, {"nice", false}}},
          {"legend",
           {{"title", title}, {"gradientLength", 300}, {"orient", "right"}, {"format", ".4~g"}}}}},
        {"tooltip", json::array({TooltipNumber("xc", ParameterTitle(px)),
                                 TooltipNumber("yc", ParameterTitle(py)),
                                 TooltipNumber("mean", title + ", model"),
                                 TooltipNumber("sd", "± of the model (sd)")})}}}};
}

json LevelRows(const SurfaceGrid& grid, const Parameter& px, const Parameter& py, double level) {
  const double last = static_cast<double>(grid.mean.rows() - 1);
  json rows = json::array();
  for (const ContourSegment& s : Contour(grid.mean, level)) {
    rows.push_back({{"x1", Rounded(FromUnit(px, s.x1 / last))},
                    {"y1", Rounded(FromUnit(py, s.y1 / last))},
                    {"x2", Rounded(FromUnit(px, s.x2 / last))},
                    {"y2", Rounded(FromUnit(py, s.y2 / last))}});
  }
  return rows;
}

json LevelLayer(const json& rows, const Parameter& px, const Parameter& py, const char* color,
                double width) {
  return {{"data", {{"values", rows}}},
          {"mark",
           {{"type", "rule"},
            {"color", color},
            {"strokeWidth", width},
            {"strokeCap", "round"},
            {"tooltip", nullptr}}},
          {"encoding",
           {{"x", ParameterChannel("x1", px)},
            {"x2", {{"field", "x2"}}},
            {"y", ParameterChannel("y1", py)},
            {"y2", {{"field", "y2"}}}}}};
}

json PointLayer(const StudyResults& results, const json& rows, json x, json y) {
  json encoding = KindChannels(rows, "#ffffff", "#ffffff", "#111111");
  encoding["x"] = std::move(x);
  encoding["y"] = std::move(y);
  encoding["tooltip"] = EvaluationTooltip(results);
  // The best on top of the others.
  encoding["order"] = {{"field", "rank"}, {"type", "quantitative"}};
  return {
      {"data", {{"values", rows}}},
      {"transform", json::array({{{"calculate", "datum.kind == 'best' ? 1 : 0"}, {"as", "rank"}}})},
      {"mark", {{"type", "point"}, {"strokeWidth", 1.5}, {"opacity", 1}}},
      {"encoding", std::move(encoding)}};
}

// White beneath the crosses, which would be lost on the map's dark end.
json FailureHaloLayer(const json& rows, json x, json y) {
  return {{"data", {{"values", rows}}},
          {"transform", {{{"filter", "datum.kind == 'failed'"}}}},
          {"mark",
           {{"type", "point"},
            {"shape", kCrossSymbol},
            {"size", 130},
            {"stroke", kHalo},
            {"strokeWidth", 5},
            {"strokeCap", "round"},
            {"opacity", 1}}},
          {"encoding", {{"x", std::move(x)}, {"y", std::move(y)}}}};
}

// The first design and the search are told apart in the convergence plot; here both are circles.
json PlainRows(const StudyResults& results) {
  json rows = EvaluationRows(results);
  for (json& row : rows) {
    if (row["kind"] == "initial design") row["kind"] = "search";
  }
  return rows;
}

void NameCircles(json& spec_layer) {
  for (const char* channel : {"shape", "fill", "stroke"}) {
    json& legend = spec_layer["encoding"][channel]["legend"];
    legend["labelExpr"] = "datum.label == 'search' ? 'evaluated' : datum.label";
  }
}

std::string LevelCaption(const ResponseResult& target, bool reached) {
  const Fit fit = JudgeFit(target);
  const std::string name = ReadableName(target.name);
  if (!reached) {
    return fmt::format(" The observed {}, {}, is not reached here.", name,
                       ValueText(target.observed, target.unit));
  }
  return fmt::format(" Thick line: the observed {}, {}; thin lines: ± {} ({}).", name,
                     ValueText(target.observed, target.unit), ValueText(fit.limit, target.unit),
                     fit.has_tolerance ? "tolerance" : "two standard deviations");
}

Figure PlaneFigure(const StudyResults& results, const ResponseResult& target,
                   const ResponseSurface& surface, std::pair<int, int> axes, bool single_pair) {
  const Parameter& px = results.parameters[axes.first];
  const Parameter& py = results.parameters[axes.second];
  const SurfaceGrid grid =
      EvaluateGrid(surface, BasePoint(results), axes.first, axes.second, single_pair ? 61 : 41);
  const json level = LevelRows(grid, px, py, target.observed);
  const double limit = JudgeFit(target).limit;
  json margins = LevelRows(grid, px, py, target.observed - limit);
  for (const json& row : LevelRows(grid, px, py, target.observed + limit)) margins.push_back(row);
  const json rows = PlainRows(results);
  const json x = ParameterChannel(fmt::format("p{}", axes.first), px);
  const json y = ParameterChannel(fmt::format("p{}", axes.second), py);
  json points = PointLayer(results, rows, x, y);
  NameCircles(points);
  Figure figure;
  figure.title = fmt::format("{} over {} and {}", ReadableName(target.name), SymbolText(px.symbol),
                             SymbolText(py.symbol));
  figure.caption = fmt::format(
      "Colour: a Gaussian process through {}, a model and not a simulation.{}",
      CountText(surface.point_count(), "evaluation"), LevelCaption(target, !level.empty()));
  if (results.parameters.size() > 2) {
    figure.caption +=
        " The other parameters are held at the best point; the circles are projected onto this "
        "plane.";
  }
  figure.spec = {
      {"width", 365},
      {"height", 340},
      {"resolve", {{"scale", {{"color", "independent"}}}}},
      {"layer",
       json::array({ColourMapLayer(grid, px, py, target), LevelLayer(margins, px, py, kHalo, 2.4),
                    LevelLayer(margins, px, py, kLevel, 0.9), LevelLayer(level, px, py, kHalo, 4.5),
                    LevelLayer(level, px, py, kLevel, 2.2), FailureHaloLayer(rows, x, y),
                    std::move(points)})}};
  return figure;
}

Figure LineFigure(const StudyResults& results, const ResponseResult& target,
                  const ResponseSurface& surface, std::size_t index) {
  const int which = Numbers(results).front();
  const Parameter& parameter = results.parameters[static_cast<std::size_t>(which)];
  Eigen::VectorXd point = BasePoint(results);
  json curve = json::array();
  for (int i = 0; i < kLineNodes; ++i) {
    const double u = static_cast<double>(i) / (kLineNodes - 1);
    point[which] = u;
    const Prediction prediction = surface.Predict(point);
    const double sd = std::sqrt(std::max(0.0, prediction.variance));
    curve.push_back({{"x", Rounded(FromUnit(parameter, u))},
                     {"mean", Rounded(prediction.mean)},
                     {"low", Rounded(prediction.mean - 2 * sd)},
                     {"high", Rounded(prediction.mean + 2 * sd)}});
  }
  const json x = ParameterChannel("x", parameter);
  const auto y = [&](const std::string& field) -> json {
    return {{"field", field},
            {"type", "quantitative"},
            {"title", ResponseAxisTitle(target)},
            {"scale", {{"zero", false}}}};
  };
  const std::string response = fmt::format("r{}", index);
  json rows = PlainRows(results);
  json points = PointLayer(results, rows, ParameterChannel(fmt::format("p{}", which), parameter),
                           y(response));
  points["transform"].push_back({{"filter", fmt::format("isValid(datum.{})", response)}});
  NameCircles(points);
  Figure figure;
  figure.title = fmt::format("{} over {}", ReadableName(target.name), SymbolText(parameter.symbol));
  figure.caption = fmt::format(
      "Line and band: a Gaussian process through {} with two standard deviations, a model and not "
      "a "
      "simulation. Dashed: the observed {}, {}.",
      CountText(surface.point_count(), "evaluation"), ReadableName(target.name),
      ValueText(target.observed, target.unit));
  figure.spec = {
      {"width", "container"},
      {"height", 320},
      {"layer",
       json::array({{{"data", {{"values", curve}}},
                     {"mark", {{"type", "area"}, {"color", "#0b5cad"}, {"opacity", 0.18}}},
                     {"encoding", {{"x", x}, {"y", y("low")}, {"y2", {{"field", "high"}}}}}},
                    {{"data", {{"values", curve}}},
                     {"mark", {{"type", "line"}, {"color", "#0b5cad"}, {"strokeWidth", 2}}},
                     {"encoding", {{"x", x}, {"y", y("mean")}}}},
                    {{"data", {{"values", json::array({{{"level", target.observed}}})}}},
                     {"mark", {{"type", "rule"}, {"strokeDash", {6, 4}}, {"color", kLevel}}},
                     {"encoding", {{"y", y("level")}}}},
                    std::move(points)})}};
  return figure;
}

}  // namespace

std::vector<std::string> ParameterPairs(const StudyResults& results) {
  std::vector<std::string> titles;
  for (const auto& [i, j] : Pairs(results)) {
    titles.push_back(fmt::format("{} and {}", SymbolText(results.parameters[i].symbol),
                                 SymbolText(results.parameters[j].symbol)));
  }
  return titles;
}

std::vector<Figure> SurfaceFigures(const StudyResults& results) {
  if (Numbers(results).empty()) return {};
  const std::vector<std::pair<int, int>> pairs = Pairs(results);
  const std::vector<ResponseResult> targets = TargetResponses(results);
  std::vector<Figure> figures;
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const ResponseSurface surface(results, t);
    const std::string key = fmt::format("surface-{}", t);
    if (!surface.fitted()) {
      figures.push_back(
          {.key = key, .title = ReadableName(targets[t].name), .caption = surface.why_not() + "."});
      continue;
    }
    if (pairs.empty()) {
      figures.push_back(LineFigure(results, targets[t], surface, t));
      figures.back().key = key;
    }
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      figures.push_back(PlaneFigure(results, targets[t], surface, pairs[p], pairs.size() == 1));
      figures.back().key = fmt::format("{}-{}", key, p);
      figures.back().pair = pairs.size() > 1 ? static_cast<int>(p) : -1;
    }
  }
  return figures;
}

}  // namespace powdercal

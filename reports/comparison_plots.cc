#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "reports/comparison_page.h"
#include "reports/plot_parts.h"
#include "reports/text.h"

namespace powdercal {
namespace {

using namespace comparison;
using nlohmann::json;

constexpr int kHeight = 340;
constexpr const char* kFirstColour = "#0b4f96";
constexpr const char* kEqualColour = "#5f9bd1";
constexpr const char* kOtherColour = "#8b979f";

json Labels(const Comparison& comparison) {
  json labels = json::array();
  for (const Standing& standing : comparison.standings) labels.push_back(standing.contestant.label);
  return labels;
}

// The same colours in all plots; a click on the legend picks an optimizer out.
json ColourChannel(const Comparison& comparison) {
  return {{"field", "o"},
          {"type", "nominal"},
          {"scale", {{"domain", Labels(comparison)}, {"scheme", "tableau20"}}},
          {"legend",
           {{"title", nullptr},
            {"orient", "bottom"},
            {"columns", 3},
            {"labelLimit", 260},
            {"symbolOpacity", 1},
            {"symbolType", "stroke"},
            {"symbolStrokeWidth", 3}}}};
}

json Choice() {
  return json::array({{{"name", "chosen"},
                       {"select", {{"type", "point"}, {"fields", {"o"}}}},
                       {"bind", "legend"}}});
}

json FadeOthers() { return {{"condition", {{"param", "chosen"}, {"value", 1}}}, {"value", 0.12}}; }

std::string MeasureTitle(const Comparison& comparison) {
  if (comparison.pareto) return "lost hypervolume";
  return comparison.setting.source == Source::simulator ? "χ² of the reported point, as observed"
                                                        : "χ² of the reported point, true";
}

// The first three and the baseline; of more lines than that nobody can see all bands.
bool Emphasised(const Comparison& comparison, const Standing& standing) {
  const auto place = &standing - comparison.standings.data();
  return place < 3 || standing.contestant.label == "random";
}

// What is negligible looks alike.
double Shown(const Comparison& comparison, double value) {
  return Rounded(std::max(value, comparison.negligible));
}

json LogChannel(const json& rows, const std::vector<const char*>& fields,
                const std::string& title) {
  double low = std::numeric_limits<double>::infinity();
  double high = 0;
  for (const json& row : rows) {
    for (const char* field : fields) {
      if (!row.contains(field)) continue;
      low = std::min(low, row.at(field).get<double>());
      high = std::max(high, row.at(field).get<double>());
    }
  }
  if (!(high > 0)) low = high = 1;
  json ticks;
  json scale = DecadeScale(low, high, &ticks);
  return {{"field", fields.front()},
          {"type", "quantitative"},
          {"title", title},
          {"scale", std::move(scale)},
          {"axis", {{"values", std::move(ticks)}, {"format", "~g"}}}};
}

json BandRows(const Comparison& comparison, Band Standing::*band) {
  json rows = json::array();
  for (const Standing& standing : comparison.standings) {
    const Band& one = standing.*band;
    for (std::size_t i = 0; i < one.x.size(); ++i) {
      const Quartiles& q = one.y[i];
      if (!std::isfinite(q.median)) continue;
      json row = {{"o", standing.contestant.label},
                  {"e", Emphasised(comparison, standing)},
                  {"x", Rounded(one.x[i])},
                  {"median", Shown(comparison, q.median)},
                  {"lower", Shown(comparison, q.lower)}};
      if (std::isfinite(q.upper)) row["upper"] = Shown(comparison, q.upper);
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

json BandSpec(const Comparison& comparison, Band Standing::*band, const std::string& x_title) {
  const json rows = BandRows(comparison, band);
  const json x = {{"field", "x"},
                  {"type", "quantitative"},
                  {"title", x_title},
                  {"axis", {{"grid", false}}},
                  {"scale", {{"nice", false}}}};
  json y = LogChannel(rows, {"median", "lower", "upper"}, MeasureTitle(comparison));
  json lower = y;
  lower["field"] = "lower";
  const json colour = ColourChannel(comparison);
  const json tooltip =
      json::array({{{"field", "o"}, {"title", "optimizer"}, {"type", "nominal"}},
                   {{"field", "x"}, {"title", x_title}, {"type", "quantitative"}},
                   {{"field", "median"}, {"type", "quantitative"}, {"format", kNumberFormat}},
                   {{"field", "lower"},
                    {"title", "lower quartile"},
                    {"type", "quantitative"},
                    {"format", kNumberFormat}},
                   {{"field", "upper"},
                    {"title", "upper quartile"},
                    {"type", "quantitative"},
                    {"format", kNumberFormat}}});
  json lines = {
      {"params", Choice()},
      {"mark", {{"type", "line"}, {"interpolate", "step-after"}}},
      {"encoding",
       {{"x", x},
        {"strokeWidth", {{"condition", {{"test", "datum.e"}, {"value", 2.6}}}, {"value", 1.3}}},
        {"y", y},
        {"color", colour},
        {"tooltip", tooltip},
        {"opacity", FadeOthers()}}}};
  json bands = {
      {"transform", {{{"filter", "isValid(datum.upper)"}}}},
      {"mark", {{"type", "area"}, {"interpolate", "step-after"}}},
      {"encoding",
       {{"x", x},
        {"y", lower},
        {"y2", {{"field", "upper"}}},
        {"color", colour},
        {"opacity",
         {{"condition", json::array({{{"param", "chosen"}, {"empty", false}, {"value", 0.3}},
                                     {{"test", "datum.e"}, {"value", 0.1}}})},
          {"value", 0}}}}}};
  return {{"width", "container"},
          {"height", kHeight},
          {"data", {{"values", rows}}},
          {"layer", json::array({std::move(bands), std::move(lines)})}};
}

Figure ByEvaluations(const Comparison& comparison) {
  return {
      .key = "by-evaluations",
      .title = comparison.pareto ? "Hypervolume still lost" : "Best so far, by evaluations",
      .caption = fmt::format(
          "Median over {} seeds; shaded: between the quartiles, of the first three and of random. "
          "Click an optimizer in the legend to pick it out, Shift-click for several. Values below "
          "{} are drawn there.",
          comparison.seeds.size(), NumberText(comparison.negligible, 2)),
      .spec = BandSpec(comparison, &Standing::by_evaluations, "evaluations")};
}

Figure ByCoreSeconds(const Comparison& comparison) {
  return {.key = "by-core-seconds",
          .title = "The same by simulated core-seconds",
          .caption = fmt::format(
              "What was spent on simulations until then, failed ones included; {} is where all are "
              "compared.",
              DurationText(comparison.core_seconds)),
          .spec = BandSpec(comparison, &Standing::by_core_seconds, "core-seconds")};
}

Figure Targets(const Comparison& comparison) {
  json rows = json::array();
  for (const Standing& standing : comparison.standings) {
    rows.push_back({{"o", standing.contestant.label}, {"x", 0}, {"y", 0}});
    for (std::size_t i = 0; i < standing.share_of_targets.size(); ++i) {
      rows.push_back({{"o", standing.contestant.label},
                      {"x", i + 1},
                      {"y", Rounded(standing.share_of_targets[i])}});
    }
  }
  Figure figure{.key = "targets", .title = "Share of targets reached"};
  figure.caption = fmt::format(
      "Of {} levels from {} down to {}, evenly spaced in the logarithm, in {} seeds: the share "
      "that "
      "was reached so far. Higher is better.",
      comparison.targets.size(), NumberText(comparison.targets.front(), 2),
      NumberText(comparison.targets.back(), 2), comparison.seeds.size());
  figure.spec = {
      {"width", "container"},
      {"height", kHeight},
      {"data", {{"values", std::move(rows)}}},
      {"params", Choice()},
      {"mark", {{"type", "line"}, {"interpolate", "step-after"}, {"strokeWidth", 2}}},
      {"encoding",
       {{"x",
         {{"field", "x"},
          {"type", "quantitative"},
          {"title", "evaluations"},
          {"axis", {{"grid", false}}},
          {"scale", {{"nice", false}}}}},
        {"y",
         {{"field", "y"},
          {"type", "quantitative"},
          {"title", "share of targets"},
          {"scale", {{"domain", {0, 1}}}},
          {"axis", {{"format", ".0%"}}}}},
        {"color", ColourChannel(comparison)},
        {"opacity", FadeOthers()},
        {"tooltip",
         json::array({{{"field", "o"}, {"title", "optimizer"}, {"type", "nominal"}},
                      {{"field", "x"}, {"title", "evaluations"}, {"type", "quantitative"}},
                      {{"field", "y"},
                       {"title", "share"},
                       {"type", "quantitative"},
                       {"format", ".0%"}}})}}}};
  return figure;
}

json OptimizerAxis(const Comparison& comparison) {
  return {{"field", "o"},
          {"type", "nominal"},
          {"title", nullptr},
          {"sort", Labels(comparison)},
          {"axis", {{"labelLimit", 260}, {"grid", true}}}};
}

int RowsHeight(const Comparison& comparison) {
  return 30 + 24 * static_cast<int>(comparison.standings.size());
}

Figure Ranks(const Comparison& comparison) {
  Figure figure{.key = "ranks", .title = "Mean ranks"};
  if (!std::isfinite(comparison.critical_difference)) {
    figure.caption = "Ranks need two optimizers and two seeds at least.";
    return figure;
  }
  const double half = comparison.critical_difference / 2;
  const double first = comparison.standings.front().mean_rank;
  json rows = json::array();
  for (const Standing& standing : comparison.standings) {
    const double rank = standing.mean_rank;
    rows.push_back({{"o", standing.contestant.label},
                    {"rank", Rounded(rank)},
                    {"from", Rounded(rank - half)},
                    {"to", Rounded(rank + half)},
                    {"colour", rank == first                                   ? kFirstColour
                               : rank - first < comparison.critical_difference ? kEqualColour
                                                                               : kOtherColour}});
  }
  const json y = OptimizerAxis(comparison);
  const json colour = {{"field", "colour"}, {"type", "nominal"}, {"scale", nullptr}};
  const json x = {{"field", "rank"},
                  {"type", "quantitative"},
                  {"title", "mean rank (1: best)"},
                  {"scale", {{"zero", false}}}};
  json from = x;
  from["field"] = "from";
  figure.caption = fmt::format(
      "Bars are one critical difference wide ({}, Nemenyi, level 0.05): where two bars do not "
      "overlap, the ranks differ. Grey: shown to be worse than the first.",
      NumberText(comparison.critical_difference, 3));
  figure.spec = {
      {"width", "container"},
      {"height", RowsHeight(comparison)},
      {"data", {{"values", std::move(rows)}}},
      {"layer",
       json::array(
           {{{"mark", {{"type", "rule"}, {"strokeWidth", 7}, {"opacity", 0.35}}},
             {"encoding", {{"y", y}, {"x", from}, {"x2", {{"field", "to"}}}, {"color", colour}}}},
            {{"mark", {{"type", "point"}, {"filled", true}, {"size", 80}, {"opacity", 1}}},
             {"encoding",
              {{"y", y},
               {"x", x},
               {"color", colour},
               {"tooltip",
                json::array({{{"field", "o"}, {"title", "optimizer"}, {"type", "nominal"}},
                             {{"field", "rank"},
                              {"title", "mean rank"},
                              {"type", "quantitative"}}})}}}}})}};
  return figure;
}

Figure Ends(const Comparison& comparison) {
  Figure figure{.key = "ends", .title = "At the end of the budget"};
  json rows = json::array();
  for (const Standing& standing : comparison.standings) {
    const Quartiles& q = standing.final_value;
    if (!std::isfinite(q.median)) continue;
    json row = {{"o", standing.contestant.label},
                {"median", Shown(comparison, q.median)},
                {"lower", Shown(comparison, q.lower)}};
    row["upper"] = Shown(comparison, std::isfinite(q.upper) ? q.upper : q.median);
    rows.push_back(std::move(row));
  }
  const json y = OptimizerAxis(comparison);
  json x = LogChannel(rows, {"median", "lower", "upper"}, MeasureTitle(comparison));
  json lower = x;
  lower["field"] = "lower";
  const json level = {{"data", {{"values", json::array({{{"median", comparison.level}}})}}},
                      {"mark", {{"type", "rule"}, {"strokeDash", {4, 4}}, {"color", "#5b6670"}}},
                      {"encoding", {{"x", x}}}};
  figure.caption = fmt::format(
      "Median and quartiles after {} evaluations. Dashed: the level to which evaluations are "
      "counted, {}.",
      comparison.setting.rules.evaluations, NumberText(comparison.level, 3));
  figure.spec = {
      {"width", "container"},
      {"height", RowsHeight(comparison)},
      {"data", {{"values", std::move(rows)}}},
      {"layer",
       json::array({level,
                    {{"mark", {{"type", "rule"}, {"strokeWidth", 3}, {"color", kEqualColour}}},
                     {"encoding", {{"y", y}, {"x", lower}, {"x2", {{"field", "upper"}}}}}},
                    {{"mark",
                      {{"type", "point"},
                       {"filled", true},
                       {"size", 80},
                       {"color", kFirstColour},
                       {"opacity", 1}}},
                     {"encoding", {{"y", y}, {"x", x}}}}})}};
  return figure;
}

}  // namespace

std::vector<Figure> ComparisonFigures(const Comparison& comparison) {
  if (comparison.standings.empty()) return {};
  std::vector<Figure> figures = {ByEvaluations(comparison)};
  if (comparison.setting.source != Source::table) figures.push_back(ByCoreSeconds(comparison));
  if (!comparison.targets.empty()) figures.push_back(Targets(comparison));
  figures.push_back(Ends(comparison));
  figures.push_back(Ranks(comparison));
  return figures;
}

}  // namespace powdercal

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "scaling/group_definitions.h"
#include "scaling/groups.h"
#include "scaling/relevance.h"

namespace powdercal {
namespace {

using Verdict = GroupComparison::Verdict;

// For people: three digits ("572", "0.163"), two with an exponent where that is shorter ("5.6e5").
std::string Readable(double value) {
  const double magnitude = std::abs(value);
  if (magnitude == 0 || (magnitude >= 1e-3 && magnitude < 9999.5)) {
    return fmt::format("{}", std::stod(fmt::format("{:.3g}", value)));
  }
  const std::string text = fmt::format("{:.1e}", value);
  const std::size_t e = text.find('e');
  return fmt::format("{}e{}", std::stod(text.substr(0, e)), std::stoi(text.substr(e + 1)));
}

std::string Fill(const char* text, double factor, const GroupComparison& group) {
  return fmt::format(fmt::runtime(text), fmt::arg("factor", Readable(factor)),
                     fmt::arg("simulation", Readable(*group.simulation)),
                     fmt::arg("experiment", Readable(*group.experiment)));
}

std::string Remark(const GroupDefinition& definition, double factor, const GroupComparison& group) {
  const bool load = group.symbol == "sigma/(rho_b g h)";
  if (load && *group.simulation < 1 && *group.experiment >= 1) {
    return fmt::format(
        "self-weight exceeds the applied stress {} times: the void ratio follows gravity, not the "
        "stress (in the experiment the stress is {} times the self-weight)",
        Readable(1 / *group.simulation), Readable(*group.experiment));
  }
  return Fill(*group.ratio > 1 ? definition.above : definition.below, factor, group);
}

// A value that is exactly at a limit, but for rounding, is within it.
constexpr double kRounding = 1 + 1e-9;

bool Harmless(const GroupDefinition& definition, const Conditions& experiment,
              const Conditions& simulation) {
  if (definition.harmless_measure == nullptr) return false;
  const std::optional<double> x = definition.harmless_measure(experiment);
  const std::optional<double> y = definition.harmless_measure(simulation);
  return x && y && std::max(*x, *y) <= definition.harmless_limit * kRounding;
}

// "" or why a difference cannot matter.
std::string ExplainHarmless(const GroupDefinition& definition, const Relevance& relevance,
                            const Conditions& experiment, const Conditions& simulation,
                            double factor, const GroupComparison& group) {
  if (Harmless(definition, experiment, simulation)) {
    return Fill(definition.harmless, factor, group);
  }
  if (relevance.matters) return "";
  return fmt::format("off {} times, but should not matter here: {}", Readable(factor),
                     relevance.source);
}

void Judge(const GroupDefinition& definition, const Relevance& relevance,
           const Conditions& experiment, const Conditions& simulation, GroupComparison* group) {
  if (!group->experiment || !group->simulation) return;
  const double a = *group->experiment;
  const double b = *group->simulation;
  if (a == b) {
    group->ratio = 1;
    group->verdict = Verdict::ok;
    return;
  }
  if (a != 0) group->ratio = b / a;
  if (a == 0 || b == 0) {
    group->verdict = Verdict::violated;
    group->remark = a == 0
                        ? fmt::format("zero in the experiment, {} in the simulation", Readable(b))
                        : fmt::format("zero in the simulation, {} in the experiment", Readable(a));
    return;
  }
  const double factor = std::max(b / a, a / b);
  group->verdict = Verdict::ok;
  if (factor <= relevance.tolerance * kRounding) return;
  group->remark = ExplainHarmless(definition, relevance, experiment, simulation, factor, *group);
  if (!group->remark.empty()) return;
  group->verdict = factor <= kViolationFactor * kRounding ? Verdict::warn : Verdict::violated;
  group->remark = Remark(definition, factor, *group);
}

std::optional<GroupComparison> JudgeNumerical(const NumericalGroup& numerical,
                                              const Conditions& simulation) {
  const std::optional<double> value = numerical.evaluate(simulation);
  if (!value) return std::nullopt;
  GroupComparison group{.symbol = numerical.symbol,
                        .meaning = numerical.meaning,
                        .simulation = value,
                        .verdict = Verdict::ok,
                        .tolerance = numerical.limit,
                        .source = numerical.source,
                        .numerical = true};
  if (*value <= numerical.limit * kRounding) return group;
  group.verdict =
      *value <= numerical.violation_limit * kRounding ? Verdict::warn : Verdict::violated;
  group.remark =
      fmt::format(fmt::runtime(numerical.above), fmt::arg("simulation", Readable(*value)));
  return group;
}

}  // namespace

const std::string& ToString(GroupComparison::Verdict verdict) {
  static const std::array<std::string, 4> kNames = {"ok", "warn", "violated", "unknown"};
  return kNames[static_cast<std::size_t>(verdict)];
}

std::vector<GroupComparison> CompareGroups(const Conditions& experiment,
                                           const Conditions& simulation, const std::string& test) {
  std::vector<GroupComparison> groups;
  for (const GroupDefinition& definition : GroupDefinitions()) {
    const Relevance relevance = RelevanceOf(test, definition.symbol);
    GroupComparison group{.symbol = definition.symbol,
                          .meaning = definition.meaning,
                          .experiment = definition.evaluate(experiment),
                          .simulation = definition.evaluate(simulation),
                          .tolerance = relevance.tolerance,
                          .source = relevance.source};
    if (!group.experiment && !group.simulation) continue;
    Judge(definition, relevance, experiment, simulation, &group);
    groups.push_back(std::move(group));
  }
  for (const NumericalGroup& numerical : NumericalGroups()) {
    if (auto group = JudgeNumerical(numerical, simulation)) groups.push_back(std::move(*group));
  }
  return groups;
}

}  // namespace powdercal

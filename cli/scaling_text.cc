#include "cli/scaling_text.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/text.h"
#include "core/quantity.h"
#include "reports/text.h"

namespace powdercal::cli {
namespace {

std::string Number(const std::optional<double>& value, const char* unknown) {
  return value ? fmt::format("{:.3g}", *value) : unknown;
}

std::string Coloured(GroupComparison::Verdict verdict, bool colours) {
  static constexpr const char* kCodes[] = {"32", "33", "31", "2"};  // green, yellow, red, dim
  const std::string& text = ToString(verdict);
  if (!colours) return text;
  return fmt::format("\x1b[{}m{}\x1b[0m", kCodes[static_cast<int>(verdict)], text);
}

}  // namespace

std::string GroupTable(const ScalingTable& table, bool colours) {
  std::vector<std::vector<std::string>> rows = {
      {"group", "experiment", "simulation", "ratio", "verdict", "meaning"}};
  std::string remarks;
  for (const GroupComparison& group : table.groups) {
    rows.push_back({group.symbol, Number(group.experiment, group.numerical ? "-" : "unknown"),
                    Number(group.simulation, "unknown"), Number(group.ratio, "-"),
                    Coloured(group.verdict, colours), group.meaning});
    if (!group.remark.empty()) {
      remarks += fmt::format("  {}: {}: {}\n", ToString(group.verdict), group.symbol, group.remark);
    }
  }
  return AlignedTable(rows) + (remarks.empty() ? "" : "\n" + remarks);
}

std::string ConditionsTable(const ScalingTable& table) {
  std::vector<std::vector<std::string>> rows = {{"", "laboratory", "simulation"}};
  const auto add = [&](const char* what, std::optional<double> Conditions::*member,
                       const char* unit) {
    const std::optional<double>& a = table.laboratory.*member;
    const std::optional<double>& b = table.simulation.*member;
    if (!a && !b) return;
    const auto text = [unit](const std::optional<double>& value) {
      return value ? HumanQuantity(*value, unit, 3) : std::string("-");
    };
    rows.push_back({what, text(a), text(b)});
  };
  add("Young's modulus", &Conditions::young_modulus, "Pa");
  add("stress", &Conditions::stress, "Pa");
  add("gravity", &Conditions::gravity, "m/s2");
  add("velocity", &Conditions::velocity, "m/s");
  add("shear rate", &Conditions::shear_rate, "1/s");
  add("surface energy", &Conditions::surface_energy, "J/m2");
  add("cohesion energy density", &Conditions::cohesion_energy_density, "J/m3");
  add("time step", &Conditions::time_step, "s");
  if (table.simulation.speed_ratio != 1) {
    rows.push_back({"speeds of the protocol, over the laboratory's", "1",
                    fmt::format("{:.3g}", table.simulation.speed_ratio)});
  }
  return AlignedTable(rows);
}

std::string CohesionText(const std::vector<ScalingTable>& tables) {
  std::vector<PowderCohesion> readings;
  for (const ScalingTable& table : tables) {
    if (table.cohesion) readings.push_back(*table.cohesion);
  }
  std::string text;
  for (const std::string& sentence : Describe(readings)) text += "  " + sentence + "\n";
  return text;
}

std::string ModeTable(const std::vector<ModeCost>& costs) {
  std::vector<std::vector<std::string>> rows = {
      {"mode", "E", "kappa", "steps", "time", "violated"}};
  std::string notes;
  for (const ModeCost& cost : costs) {
    const std::string name = cost.mode + (cost.own ? " (this study)" : "");
    if (!cost.why_not.empty()) {
      notes += fmt::format("  {}: not possible: {}\n", name, cost.why_not);
      continue;
    }
    rows.push_back({name, HumanQuantity(cost.young_modulus, "Pa", 3),
                    cost.kappa ? fmt::format("{:.3g}", *cost.kappa) : "-",
                    fmt::format("{:.2g}", cost.steps),
                    cost.seconds > 0 ? DurationText(cost.seconds) : "-",
                    cost.violated.empty() ? "none" : JoinNames(cost.violated)});
  }
  return AlignedTable(rows) + notes;
}

nlohmann::json ModesToJson(const std::vector<ModeCost>& costs) {
  nlohmann::json list = nlohmann::json::array();
  for (const ModeCost& cost : costs) {
    nlohmann::json kappa;
    if (cost.kappa) kappa = *cost.kappa;
    list.push_back({{"mode", cost.mode},
                    {"own", cost.own},
                    {"problem", cost.why_not},
                    {"young_modulus", cost.young_modulus},
                    {"kappa", kappa},
                    {"steps", cost.steps},
                    {"seconds", cost.seconds},
                    {"violated", cost.violated}});
  }
  return list;
}

}  // namespace powdercal::cli

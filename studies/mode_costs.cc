#include "studies/mode_costs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "studies/planner.h"

namespace powdercal {
namespace {

constexpr double kFloors[] = {1000, 4000, 1e4};

std::unique_ptr<Scaling> ScalingOf(const std::string& options) {
  std::unique_ptr<Scaling> scaling;
  ReadYaml("scaling: " + options, "", [&](Archive& a) { SerializeScaling(a, scaling); });
  return scaling;
}

bool IsCohesive(const std::string& symbol) {
  static const std::array<std::string, 5> kSymbols = {"k/E", "F_c/(sigma d^2)", "Bo", "W/(m g d)",
                                                      "delta_0/d"};
  return std::find(kSymbols.begin(), kSymbols.end(), symbol) != kSymbols.end();
}

bool FreesCohesion(const Study& study) {
  const auto& parameters = study.space.parameters;
  return std::any_of(parameters.begin(), parameters.end(), [](const Parameter& parameter) {
    return parameter.name == "cohesion_energy_density" || parameter.name == "surface_energy";
  });
}

void Estimate(const Study& study, const Scaling& scaling,
              const std::vector<std::size_t>& experiments, ModeCost* result) {
  ModeCost& cost = *result;
  const Planner planner(study, scaling);
  for (const std::size_t i : experiments) {
    cost.why_not = planner.ExplainUnplanned(i);
    if (!cost.why_not.empty()) return;
  }
  std::vector<Conditions> all;
  for (std::size_t i = 0; i < study.experiments.size(); ++i) all.push_back(planner.Laboratory(i));
  cost.why_not = scaling.ExplainWithoutEffect(all);
  if (!cost.why_not.empty()) return;
  std::vector<std::size_t> also;
  for (const std::size_t i : experiments) {
    if (!study.experiments[i].calibrate) also.push_back(i);
  }
  for (const Planner::ExperimentCost& one : planner.EstimateCost(also).experiments) {
    if (std::find(experiments.begin(), experiments.end(), one.experiment) == experiments.end()) {
      continue;
    }
    cost.steps += one.steps;
    cost.seconds += one.seconds;
  }
  // A k belongs to the modulus that it was found for.
  const bool own = &scaling == study.scaling.get();
  const bool leave_out_cohesion =
      FreesCohesion(study) || (!own && study.powder.cohesion_energy_density > 0);
  for (const ScalingTable& table : planner.ScalingTables(experiments, planner.Centre())) {
    cost.young_modulus = table.simulation.young_modulus.value_or(0);
    for (const GroupComparison& group : table.groups) {
      if (group.symbol == "kappa" && group.simulation) {
        cost.kappa = std::min(cost.kappa.value_or(*group.simulation), *group.simulation);
      }
      if (group.verdict != GroupComparison::Verdict::violated) continue;
      if (leave_out_cohesion && IsCohesive(group.symbol)) continue;
      cost.violated.push_back(table.experiment + ": " + group.symbol);
    }
  }
}

ModeCost CostOf(const Study& study, const Scaling& scaling, const std::string& mode,
                const std::vector<std::size_t>& experiments) {
  ModeCost cost{.mode = mode};
  try {
    Estimate(study, scaling, experiments, &cost);
  } catch (const InputError& error) {  // conditions under which an experiment cannot be planned
    cost.why_not = error.what();
  }
  return cost;
}

}  // namespace

std::vector<ModeCost> CompareModes(const Study& study,
                                   const std::vector<std::size_t>& experiments) {
  std::vector<ModeCost> costs;
  costs.push_back(CostOf(study, *study.scaling, study.scaling->name(), experiments));
  costs.back().own = true;
  const auto add = [&](const std::string& options, const std::string& mode) {
    costs.push_back(CostOf(study, *ScalingOf(options), mode, experiments));
  };
  add("none", "none");
  const double modulus = costs.front().young_modulus;
  if (modulus > 0 && modulus < study.powder.young_modulus) {
    for (const char* mode : {"sigma_over_e", "exact"}) {
      if (study.scaling->name() == mode) continue;
      add(fmt::format("{{mode: {}, young_modulus: {} Pa}}", mode, modulus), mode);
    }
  }
  for (const double kappa : kFloors) {
    add(fmt::format("{{mode: rigid_limit, kappa: {}}}", kappa),
        fmt::format("rigid_limit, kappa {:g}", kappa));
  }
  return costs;
}

}  // namespace powdercal

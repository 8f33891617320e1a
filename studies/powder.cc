#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "studies/study.h"

namespace powdercal {
namespace {

void SerializeSizes(Archive& archive, SizeDistribution& sizes) {
  archive.Enumeration("distribution", sizes.kind, "size distribution", SizeDistributionNames());
  archive.Require("mean");
  archive.Quantity("mean", sizes.mean, "m", kPositive);
  const bool monodisperse = sizes.kind == SizeDistribution::Kind::monodisperse;
  if (monodisperse) {
    if (archive.reading()) sizes.min = sizes.max = sizes.mean;
    return;
  }
  for (const char* key : {"sd", "min", "max"}) archive.Require(key);
  archive.Quantity("sd", sizes.standard_deviation, "m", kPositive);
  archive.Quantity("min", sizes.min, "m", kPositive);
  archive.Quantity("max", sizes.max, "m", kPositive);
  if (archive.reading() && !(sizes.min < sizes.max)) {
    throw archive.ErrorAt("max", "the largest diameter must be above the smallest");
  }
  if (archive.reading() && !(sizes.min <= sizes.mean && sizes.mean <= sizes.max)) {
    throw archive.ErrorAt("mean", "the mean diameter must lie between min and max");
  }
}

}  // namespace

void PowderSpecification::Serialize(Archive& archive) {
  archive.Text("name", name);
  for (const char* key :
       {"density", "young_modulus", "poisson_ratio", "restitution", "friction", "sizes"}) {
    archive.Require(key);
  }
  archive.Quantity("density", density, "kg/m3", kPositive);
  archive.Quantity("young_modulus", young_modulus, "Pa", kPositive);
  archive.Quantity("poisson_ratio", poisson_ratio, "1", {.lower = 0, .upper = 0.5});
  archive.Quantity("restitution", restitution, "1", {.lower = 0, .upper = 1, .lower_open = true});
  archive.Section("friction", [this](Archive& friction) {
    friction.Require("particle");
    friction.Require("wall");
    friction.Quantity("particle", particle_friction, "1", kNonNegative);
    friction.Quantity("wall", wall_friction, "1", kNonNegative);
  });
  archive.Quantity("rolling_friction", rolling_friction, "1", kNonNegative);
  archive.Quantity("cohesion_energy_density", cohesion_energy_density, "J/m3", kNonNegative);
  archive.Quantity("surface_energy", surface_energy, "J/m2", kNonNegative);
  archive.Section("sizes", [this](Archive& section) { SerializeSizes(section, sizes); });
}

void SerializeContactLaw(Archive& archive, ContactLaw& law) {
  // The linear law, with constants that stand for no powder, is for comparing engines.
  archive.Enumeration("normal", law.normal, "normal contact law", NormalLawNames().first(1));
  archive.Flag("limit_force", law.limit_force);
  archive.Enumeration("tangential", law.tangential, "tangential contact law", TangentialLawNames());
  archive.Enumeration("shear_update", law.shear_update, "update of the shear force",
                      ShearUpdateNames());
  archive.Enumeration("cohesion", law.cohesion, "cohesion law", CohesionNames());
  archive.Enumeration("rolling", law.rolling, "rolling friction law", RollingNames());
  archive.Flag("torsion", law.torsion);
  archive.Flag("tangential_reduce", law.tangential_reduce);
}

namespace {

struct ParameterRule {
  FreeParameter parameter;
  /// Of a category the index among all that it can be.
  void (*apply)(double value, SimulatedPowder& powder);
};

std::vector<std::string> Names(std::span<const std::string> names) {
  return {names.begin(), names.end()};
}

// Sorted by name.
const std::vector<ParameterRule>& ParameterRules() {
  static const std::vector<ParameterRule> rules = {
      {{"cohesion_energy_density", "J/m3", "k", "SJKR2 cohesion, between particles and at walls"},
       [](double value, SimulatedPowder& powder) {
         powder.materials.particle_particle.cohesion_energy_density = value;
         powder.materials.particle_wall.cohesion_energy_density = value;
       }},
      {{"friction", "1", "mu", "Coulomb friction between particles"},
       [](double value, SimulatedPowder& powder) {
         powder.materials.particle_particle.friction = value;
       }},
      {{"restitution", "1", "e_n", "restitution, between particles and at walls"},
       [](double value, SimulatedPowder& powder) {
         powder.materials.particle_particle.restitution = value;
         powder.materials.particle_wall.restitution = value;
       }},
      {{"rolling_friction", "1", "mu_r", "rolling friction, between particles and at walls"},
       [](double value, SimulatedPowder& powder) {
         powder.materials.particle_particle.rolling_friction = value;
         powder.materials.particle_wall.rolling_friction = value;
       }},
      {{"rolling_model", "1", "rolling", "law of rolling friction", Names(RollingNames())},
       [](double value, SimulatedPowder& powder) {
         powder.law.rolling = static_cast<ContactLaw::Rolling>(std::lround(value));
       }},
      {{"surface_energy", "J/m2", "gamma", "DMT adhesion, between particles and at walls"},
       [](double value, SimulatedPowder& powder) {
         powder.materials.particle_particle.surface_energy = value;
         powder.materials.particle_wall.surface_energy = value;
       }},
      {{"wall_friction", "1", "mu_w", "Coulomb friction at walls"},
       [](double value, SimulatedPowder& powder) {
         powder.materials.particle_wall.friction = value;
       }},
  };
  return rules;
}

}  // namespace

std::span<const FreeParameter> FreeParameters() {
  static const std::vector<FreeParameter> parameters = [] {
    std::vector<FreeParameter> list;
    for (const ParameterRule& rule : ParameterRules()) list.push_back(rule.parameter);
    return list;
  }();
  return parameters;
}

void ApplyParameter(const Parameter& parameter, double value, SimulatedPowder& powder) {
  std::vector<std::string> valid;
  for (const ParameterRule& rule : ParameterRules()) {
    valid.push_back(rule.parameter.name);
    if (rule.parameter.name != parameter.name) continue;
    if (!parameter.categorical()) return rule.apply(value, powder);
    const auto& all = rule.parameter.categories;
    const auto found = std::find(all.begin(), all.end(), parameter.CategoryAt(value));
    return rule.apply(static_cast<double>(found - all.begin()), powder);
  }
  throw UnknownName("parameter", parameter.name, valid);
}

}  // namespace powdercal

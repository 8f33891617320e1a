#include "verification/laws.h"

#include <vector>

#include "core/errors.h"

namespace powdercal::verification {
namespace {

using Cohesion = ContactLaw::Cohesion;
using Rolling = ContactLaw::Rolling;
using Tangential = ContactLaw::Tangential;

struct Entry {
  const char* name;
  const char* description;
  ContactLaw law;
};

// Sorted by name. limit_force is on where YADE, which always clips, shall be able to take part.
const std::vector<Entry>& Entries() {
  static const std::vector<Entry> kEntries = {
      {"hertz_mindlin_history", "Hertz with a tangential spring", {.limit_force = true}},
      {"hertz_mindlin_history_cdt",
       "the same with a constant directional torque",
       {.limit_force = true, .rolling = Rolling::cdt}},
      {"hertz_mindlin_history_dmt",
       "the same with the constant adhesion of DMT",
       {.limit_force = true, .cohesion = Cohesion::dmt}},
      {"hertz_mindlin_history_epsd2",
       "the same with an elastic-plastic rolling spring",
       {.limit_force = true, .rolling = Rolling::epsd2}},
      {"hertz_mindlin_history_sjkr2_epsd2",
       "the law of the shipped studies",
       {.cohesion = Cohesion::sjkr2, .rolling = Rolling::epsd2}},
      {"hertz_no_history", "Hertz with viscous friction", {.tangential = Tangential::no_history}},
      {"linear",
       "linear springs, normal and tangential",
       {.normal = ContactLaw::Normal::linear, .limit_force = true}},
      {"paper",
       "the seed paper's: Hertz, no_history, SJKR2, CDT",
       {.tangential = Tangential::no_history,
        .cohesion = Cohesion::sjkr2,
        .rolling = Rolling::cdt}},
  };
  return kEntries;
}

}  // namespace

std::span<const std::string> LawNames() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names;
    for (const Entry& entry : Entries()) names.emplace_back(entry.name);
    return names;
  }();
  return kNames;
}

Subject ShippedLaw(const std::string& name) {
  for (const Entry& entry : Entries()) {
    if (name != entry.name) continue;
    Subject subject{.name = entry.name, .description = entry.description, .law = entry.law};
    Materials& m = subject.materials;
    m.density = 8220;
    m.young_modulus = 5e6;
    m.poisson_ratio = 0.3;
    m.particle_particle = {.restitution = 0.5, .friction = 0.3};
    if (entry.law.rolling != Rolling::none) m.particle_particle.rolling_friction = 0.2;
    if (entry.law.cohesion == Cohesion::sjkr2) m.particle_particle.cohesion_energy_density = 7000;
    // No surface energy at walls: LIGGGHTS has no DMT there.
    m.particle_wall = m.particle_particle;
    m.particle_wall.friction = 0.2;
    if (entry.law.cohesion == Cohesion::dmt) m.particle_particle.surface_energy = 1e-5;
    m.linear = {.normal = 20, .tangential = 8, .normal_damping = 4e-6, .tangential_damping = 2e-6};
    subject.sizes = {.kind = SizeDistribution::Kind::normal,
                     .mean = 29e-6,
                     .standard_deviation = 6e-6,
                     .min = 12.5e-6,
                     .max = 37.5e-6};
    if (entry.law.cohesion == Cohesion::dmt) {
      // LIGGGHTS has DMT between equal spheres only.
      subject.sizes = {.kind = SizeDistribution::Kind::monodisperse, .mean = 29e-6};
    }
    subject.time_step = 0.2 * RayleighTime(subject.sizes.Quantile(0) / 2, m.density,
                                           m.young_modulus, m.poisson_ratio);
    subject.stress = 900;
    return subject;
  }
  throw UnknownName("contact law", name, LawNames(),
                    {.location = {"command line"}, .key = "--law"});
}

}  // namespace powdercal::verification

#include "backends/liggghts/deck_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "backends/particle_summary.h"
#include "scaling/groups.h"

namespace powdercal::liggghts {
namespace {

std::string OnOff(bool flag) { return flag ? "on" : "off"; }

// The words after `model`. Options stand at the end in pair_style, but behind the geometry in fix
// wall/gran.
std::string ModelWords(const ContactLaw& law) {
  const bool linear = law.normal == ContactLaw::Normal::linear;
  return fmt::format("{} tangential {}", linear ? "hooke/stiffness" : "hertz",
                     TangentialLawNames()[static_cast<std::size_t>(law.tangential)]);
}

std::string RollingWords(const ContactLaw& law) {
  switch (law.rolling) {
    case ContactLaw::Rolling::cdt:
      return " rolling_friction cdt";
    case ContactLaw::Rolling::epsd2:
      return " rolling_friction epsd2";
    case ContactLaw::Rolling::none:
      break;
  }
  return "";
}

std::string ModelOptions(const ContactLaw& law) {
  std::string words = "limitForce " + OnOff(law.limit_force);
  if (law.normal == ContactLaw::Normal::linear) {
    words += " absolute_damping on tangential_damping on";
  }
  if (law.rolling != ContactLaw::Rolling::none) words += " torsionTorque " + OnOff(law.torsion);
  return words;
}

// Liquid bridges leave walls dry.
bool SticksToWalls(const ContactLaw& law) { return law.cohesion == ContactLaw::Cohesion::sjkr2; }

// Known to the models of cohesion only.
std::string CohesionOptions(const ContactLaw& law) {
  return law.tangential_reduce ? " tangential_reduce on" : "";
}

class PropertyWriter {
 public:
  explicit PropertyWriter(const Program& program)
      : types_(TypeCount(program)), pair_(program.materials.particle_particle) {
    wall_ = program.materials.particle_wall;
    frictionless_.restitution = wall_.restitution;
  }

  void PerType(const char* property, double value) {
    Begin(property);
    text_ += "peratomtype";
    for (int i = 0; i < types_; ++i) text_ += fmt::format(" {}", value);
    text_ += '\n';
  }
  void Scalar(const char* property, double value) {
    Begin(property);
    text_ += fmt::format("scalar {}\n", value);
  }
  void SamePair(const char* property, double value) {
    Pairs(property, [value](int, int) { return value; });
  }
  // Walls never meet walls: whatever stands there is not used, but has to be valid.
  void Pair(const char* property, double ContactParameters::*member) {
    Pairs(property, [&](int i, int j) {
      const int wall = std::max(i, j);
      const ContactParameters& contact = wall == kParticleType ? pair_
                                         : wall == kWallType   ? wall_
                                                               : frictionless_;
      return contact.*member;
    });
  }

  std::string Take() { return std::move(text_); }

 private:
  void Begin(const char* property) {
    text_ += fmt::format("fix m{} all property/global {} ", ++count_, property);
  }
  template <typename Value>
  void Pairs(const char* property, Value&& value) {
    Begin(property);
    text_ += fmt::format("peratomtypepair {}", types_);
    for (int i = 1; i <= types_; ++i) {
      for (int j = 1; j <= types_; ++j) text_ += fmt::format(" {}", value(i, j));
    }
    text_ += '\n';
  }

  int types_;
  ContactParameters pair_;
  ContactParameters wall_;
  ContactParameters frictionless_;
  int count_ = 0;
  std::string text_;
};

// DMT adhesion by way of easo/capillary/viscous, the model of a liquid bridge. While two equal
// spheres touch, and with no viscosity and no contact angle, its force is constant, pi Gamma R
// (exp(B) + C), where B and C depend on the bridge's volume over R³ alone; the surface tension
// Gamma makes it 4 pi gamma R* = 2 pi gamma R. The ratio 1 breaks the bridge where contact ends.
// Liquid then flows from the sphere that has more of it: between equal spheres none does.
void AddLiquidBridge(const Program& program, PropertyWriter& properties) {
  const double radius = Summarise(program.particles).smallest_diameter / 2;
  // Volume of the bridge over R³, times 1000, of spheres whose liquid content is 1, in the very
  // figures that LIGGGHTS computes with.
  const double volume =
      1333.333333 * std::numbers::pi * (1 - std::sqrt(1 - radius * radius / (4 * radius * radius)));
  // Bridges below 1e-14 (volume times 1000) are left out. The content is handed on with six digits:
  // a power of ten.
  const double content =
      std::pow(10, std::ceil(std::log10(1e-12 / (volume * radius * radius * radius))));
  const double logarithm = std::log(content * volume * 0.001);
  const double b = -0.0082 * logarithm + 0.48;
  const double c = 0.0018 * logarithm + 0.078;
  properties.Scalar("surfaceLiquidContentInitial", content);
  properties.Scalar("surfaceTension",
                    2 * program.materials.particle_particle.surface_energy / (std::exp(b) + c));
  properties.Scalar("fluidViscosity", 0);
  properties.PerType("contactAngle", 0);
  properties.Scalar("minSeparationDistanceRatio", 0.01);  // without viscosity, of no effect
  properties.Scalar("maxSeparationDistanceRatio", 1);
}

}  // namespace

int TypeCount(const Program& program) {
  int types = program.meshes.empty() ? kParticleType : kWallType;
  for (const PlaneWall& wall : program.walls) types = std::max(types, TypeOf(wall));
  return types;
}

int TypeOf(const PlaneWall& wall) { return wall.frictionless ? kFrictionlessWallType : kWallType; }

std::string PairStyle(const ContactLaw& law) {
  std::string cohesion;
  if (law.cohesion == ContactLaw::Cohesion::sjkr2) cohesion = " cohesion sjkr2";
  if (law.cohesion == ContactLaw::Cohesion::dmt) cohesion = " cohesion easo/capillary/viscous";
  return fmt::format("gran model {}{}{} {}{}", ModelWords(law), cohesion, RollingWords(law),
                     ModelOptions(law), cohesion.empty() ? "" : CohesionOptions(law));
}

std::string WallStyle(const ContactLaw& law) {
  return fmt::format("wall/gran model {}{}{}", ModelWords(law),
                     SticksToWalls(law) ? " cohesion sjkr2" : "", RollingWords(law));
}

std::string WallOptions(const ContactLaw& law) {
  return ModelOptions(law) + (SticksToWalls(law) ? CohesionOptions(law) : "");
}

double StiffnessUnder(const Program& program, double stress) {
  const Materials& m = program.materials;
  if (program.law.normal == ContactLaw::Normal::linear) {
    return m.linear.normal / (stress * Summarise(program.particles).mean_diameter);
  }
  return StiffnessNumber(m.young_modulus, m.poisson_ratio, stress);
}

std::string WriteProperties(const Program& program) {
  const Materials& m = program.materials;
  PropertyWriter properties(program);
  if (program.law.normal == ContactLaw::Normal::linear) {
    properties.SamePair("kn", m.linear.normal);
    properties.SamePair("kt", m.linear.tangential);
    properties.SamePair("gamman_abs", m.linear.normal_damping);
    properties.SamePair("gammat_abs", m.linear.tangential_damping);
  } else {
    properties.PerType("youngsModulus", m.young_modulus);
    properties.PerType("poissonsRatio", m.poisson_ratio);
    properties.Pair("coefficientRestitution", &ContactParameters::restitution);
  }
  properties.Pair("coefficientFriction", &ContactParameters::friction);
  if (program.law.cohesion == ContactLaw::Cohesion::sjkr2) {
    properties.Pair("cohesionEnergyDensity", &ContactParameters::cohesion_energy_density);
  }
  if (program.law.cohesion == ContactLaw::Cohesion::dmt) AddLiquidBridge(program, properties);
  if (program.law.rolling != ContactLaw::Rolling::none) {
    properties.Pair("coefficientRollingFriction", &ContactParameters::rolling_friction);
  }
  return properties.Take();
}

}  // namespace powdercal::liggghts

#include "verification/contact_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace powdercal::verification {
namespace {

using Cohesion = ContactLaw::Cohesion;
using Normal = ContactLaw::Normal;
using Rolling = ContactLaw::Rolling;
using ShearUpdate = ContactLaw::ShearUpdate;
using Tangential = ContactLaw::Tangential;

constexpr double kGap = 1e-3;     // at the start, over the radius
constexpr double kImpacts = 2.5;  // length of a case, in durations of an undamped Hertz impact
constexpr int kFrames = 120;      // packings of a case, about
constexpr double kBox = 24;       // half a domain's edge, over the radius

struct Motion3 {
  Vector3 velocity{};  // over the speed
  Vector3 spin{};      // over speed/radius of the first sphere
};

// A collision in units of radius and speed.
struct Sketch {
  std::string name;
  std::string description;
  Vector3 normal{0, 0, 1};  // from the first sphere to the second, or to the wall
  double ratio = 1;         // radius of the first over that of the second; 0: a wall
  Motion3 first;
  Motion3 second;
  double approach = 1;  // speed of approach along the normal, for the length of the case
  bool slips = false;
  bool twists = false;
  bool rolls = false;  // turns without slipping
  bool turns = false;  // together, about the line of centres
  bool undamped = false;
};

std::vector<Sketch> Sketches() {
  const Vector3 x = {1, 0, 0};
  const Vector3 y = {0, 1, 0};
  const Vector3 z = {0, 0, 1};
  const Vector3 skew = {2 / 3.0, -1 / 3.0, 2 / 3.0};
  return {
      {.name = "head-on",
       .description = "equal spheres meet along their line of centres",
       .first = {z, {}},
       .second = {{0, 0, -1}, {}},
       .approach = 2},
      {.name = "head-on, two sizes",
       .description = "the same with radii of 2 to 1",
       .ratio = 2,
       .first = {z, {}},
       .second = {{0, 0, -1}, {}},
       .approach = 2},
      {.name = "oblique",
       .description = "at 35 degrees to the line of centres",
       .normal = x,
       .first = {{1, 0, 0.7}, {}},
       .second = {{-1, 0, 0}, {}},
       .approach = 2,
       .slips = true},
      {.name = "oblique, two sizes",
       .description = "grazing, with radii of 2 to 1",
       .normal = y,
       .ratio = 2,
       .first = {{1.5, 0.6, 0.8}, {}},
       .second = {{0, -0.4, 0}, {}},
       .slips = true},
      {.name = "spinning",
       .description = "equal spins, which rub against each other",
       .normal = x,
       .first = {{1, 0, 0}, {0, 2, 1}},
       .second = {{-1, 0, 0}, {0, 2, 1}},
       .approach = 2,
       .slips = true},
      {.name = "rolling decay",
       .description = "opposite spins, which roll on each other",
       .normal = x,
       .first = {{1, 0, 0}, {0, 3, 0}},
       .second = {{-1, 0, 0}, {0, -3, 0}},
       .approach = 2,
       .rolls = true},
      {.name = "twisting",
       .description = "opposite spins about the line of centres",
       .normal = x,
       .first = {{1, 0, 0}, {3, 0, 0}},
       .second = {{-1, 0, 0}, {-2, 0, 0}},
       .approach = 2,
       .twists = true,
       .rolls = true},
      {.name = "all at once",
       .description = "oblique in space, opposite spins, two sizes",
       .normal = skew,
       .ratio = 2,
       .first = {{1, 0.2, 0.5}, {2, 1.5, 1}},
       .second = {{-0.5, 0, -1}, {-2, -1.5, -1}},
       .approach = 1.4,
       .slips = true,
       .twists = true,
       .rolls = true},
      {.name = "common twist",
       .description = "oblique, both spinning alike about the line of centres",
       .normal = x,
       .first = {{1, 0, 0.7}, {2, 0, 0}},
       .second = {{-1, 0, 0}, {2, 0, 0}},
       .approach = 2,
       .slips = true,
       .turns = true},
      {.name = "pull-off",
       .description = "slow spheres that adhesion draws together",
       .first = {{0, 0, 0.1}, {}},
       .second = {{0, 0, -0.1}, {}},
       .approach = 0.2},
      {.name = "head-on, undamped",
       .description = "without dashpots",
       .first = {z, {}},
       .second = {{0, 0, -1}, {}},
       .approach = 2,
       .undamped = true},
      {.name = "pull-off, undamped",
       .description = "slow spheres that stick, without dashpots",
       .first = {{0, 0, 0.1}, {}},
       .second = {{0, 0, -0.1}, {}},
       .approach = 0.2,
       .undamped = true},
      {.name = "rolling decay, undamped",
       .description = "the rolling spring at its limit",
       .normal = x,
       .first = {{1, 0, 0}, {0, 3, 0}},
       .second = {{-1, 0, 0}, {0, -3, 0}},
       .approach = 2,
       .rolls = true,
       .undamped = true},
      {.name = "wall, head-on",
       .description = "a sphere falls on a wall",
       .normal = {0, 0, -1},
       .ratio = 0,
       .first = {{0, 0, -1}, {}}},
      {.name = "wall, oblique",
       .description = "at 45 degrees",
       .normal = {0, 0, -1},
       .ratio = 0,
       .first = {{0.8, 0.6, -1}, {}},
       .slips = true},
      {.name = "wall, spinning",
       .description = "with a spin that rubs on the wall",
       .normal = {0, 0, -1},
       .ratio = 0,
       .first = {{0, 0, -1}, {1, 2, 0}},
       .slips = true},
      {.name = "wall, rolling",
       .description = "rolling without slip when it arrives",
       .normal = {0, 0, -1},
       .ratio = 0,
       .first = {{2, 0, -1}, {0, 2, 0}},
       .slips = true,
       .rolls = true},
      {.name = "wall, twisting",
       .description = "spinning about the wall's normal",
       .normal = {0, 0, -1},
       .ratio = 0,
       .first = {{0, 0, -1}, {0, 0, 2}},
       .twists = true,
       .rolls = true},
      {.name = "wall, pull-off",
       .description = "a slow sphere that adhesion draws to the wall",
       .normal = {0, 0, -1},
       .ratio = 0,
       .first = {{0, 0, -0.1}, {}},
       .approach = 0.1},
  };
}

bool Applies(const Sketch& sketch, const Subject& subject) {
  const ContactLaw& law = subject.law;
  const bool one_size = subject.sizes.kind == SizeDistribution::Kind::monodisperse;
  if (sketch.ratio > 1 && one_size) return false;
  if (sketch.approach < 1) {  // slow, for the sake of cohesion
    const ContactParameters& contact =
        sketch.ratio == 0 ? subject.materials.particle_wall : subject.materials.particle_particle;
    const bool sticks = (law.cohesion == Cohesion::sjkr2 && contact.cohesion_energy_density > 0) ||
                        (law.cohesion == Cohesion::dmt && contact.surface_energy > 0);
    if (!sticks) return false;
  }
  if (!sketch.undamped) return true;
  return sketch.rolls ? law.rolling == Rolling::epsd2 : law.cohesion == Cohesion::dmt;
}

std::string LevelOf(const Sketch& sketch, const ContactLaw& law) {
  const bool plain = law.cohesion == Cohesion::none;
  if (sketch.turns && law.tangential == Tangential::history) return "T";
  const bool still = !sketch.slips && !sketch.rolls && !sketch.twists;
  if (law.normal == Normal::linear) return plain && law.rolling == Rolling::none ? "L0" : "X";
  const bool upright = sketch.ratio == 0 && !sketch.slips;
  if (plain && upright && (still || law.rolling == Rolling::none)) return "W";
  if (plain && still) return "L1";
  if (law.tangential == Tangential::history && plain && law.rolling == Rolling::none) return "L2";
  if (law.cohesion == Cohesion::dmt && still && sketch.undamped) return "L3";
  if (plain && law.rolling == Rolling::epsd2 && sketch.undamped) return "L4";
  if (law.tangential == Tangential::no_history && law.cohesion == Cohesion::sjkr2 &&
      law.rolling == Rolling::cdt) {
    return "P";
  }
  return "X";
}

// Johnson, Contact Mechanics (1985), §11.4: 2.94 δ/v, δ = (15 m* v²/(16 √R* E*))^(2/5).
double ImpactDuration(const Materials& m, double radius, double speed) {
  const double young = m.young_modulus / (2 * (1 - m.poisson_ratio * m.poisson_ratio));
  const double mass = m.density * 4 / 3 * std::numbers::pi * std::pow(radius, 3);
  const double overlap =
      std::pow(15 * mass * speed * speed / (16 * std::sqrt(radius) * young), 0.4);
  return 2.94 * overlap / speed;
}

Vector3 Times(double factor, const Vector3& v) {
  return {factor * v[0], factor * v[1], factor * v[2]};
}

Program MakeProgram(const Sketch& sketch, const Subject& subject) {
  const Materials& m = subject.materials;
  const double radius = subject.sizes.Moment(1) / 2;
  // Overlaps of a few hundredths of the radius, whatever the stiffness.
  const double speed = 8e-4 * std::sqrt(m.young_modulus / m.density);
  const double rate = speed / radius;
  Program program;
  program.experiment = "contact";
  program.materials = m;
  program.law = subject.law;
  if (sketch.undamped) {
    program.materials.particle_particle.restitution = 1;
    program.materials.particle_wall.restitution = 1;
    program.materials.linear.normal_damping = 0;
    program.materials.linear.tangential_damping = 0;
  }
  const double half = kBox * radius;
  program.domain = {
      {-half, -half, -half}, {half, half, half}, {Boundary::open, Boundary::open, Boundary::open}};
  program.gravity = {};
  program.time_step = subject.time_step;

  Packing packing = {
      {1, radius, {}, Times(speed, sketch.first.velocity), Times(rate, sketch.first.spin)}};
  const double gap = kGap * radius;
  if (sketch.ratio == 0) {
    program.walls = {{.name = "wall", .axis = 2, .position = -radius - gap}};
  } else {
    const double other = radius / sketch.ratio;
    packing.push_back({2, other, Times(radius + other + gap, sketch.normal),
                       Times(speed, sketch.second.velocity), Times(rate, sketch.second.spin)});
  }
  program.particles.packing = std::move(packing);

  const double approach = sketch.approach * speed;
  const double duration =
      gap / approach +
      kImpacts * ImpactDuration(m, sketch.ratio == 0 ? radius : radius / 2, approach);
  const int every = std::max(1, static_cast<int>(duration / program.time_step / kFrames));
  const double steps = std::ceil(duration / program.time_step / every) * every;
  program.stages = {
      Advance{.name = "contact", .duration = steps * program.time_step, .packing_every = every}};
  return program;
}

}  // namespace

std::vector<ContactCase> ContactCases(const Subject& subject) {
  std::vector<ContactCase> cases;
  for (const Sketch& sketch : Sketches()) {
    if (!Applies(sketch, subject)) continue;
    cases.push_back({.name = sketch.name,
                     .description = sketch.description,
                     .level = LevelOf(sketch, subject.law),
                     .slips = sketch.slips,
                     .twists = sketch.twists,
                     .wall = sketch.ratio == 0,
                     .program = MakeProgram(sketch, subject)});
  }
  return cases;
}

double ContactTolerance(const ContactCase& contact, const ContactLaw& law) {
  const bool hertz = law.normal == Normal::hertz;
  if (contact.level == "T") return 1e-3;
  if (contact.level == "L0") return 1e-7;
  if (contact.level == "L1") return 1e-12;
  const bool incremental = contact.slips && hertz && law.tangential == Tangential::history &&
                           law.shear_update == ShearUpdate::incremental;
  if (incremental) return 1e-6;
  if (contact.level == "W") return 1e-8;
  return contact.level == "X" && contact.wall && hertz && !contact.slips ? 1e-8 : 1e-9;
}

}  // namespace powdercal::verification

#include "scaling/groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "scaling/group_definitions.h"

namespace powdercal {

using std::numbers::pi;

double EffectiveModulus(double young_modulus, double poisson_ratio) {
  return young_modulus / (2 * (1 - poisson_ratio * poisson_ratio));
}

double PullOffForceSjkr2(double cohesion_energy_density, double effective_radius,
                         double effective_modulus) {
  const double softness = cohesion_energy_density / effective_modulus;
  return 16 * pi * pi * pi / 3 * cohesion_energy_density * softness * softness * effective_radius *
         effective_radius;
}

double CohesionOfPullOffSjkr2(double pull_off_force, double effective_radius,
                              double effective_modulus) {
  return std::cbrt(3 * pull_off_force * effective_modulus * effective_modulus /
                   (16 * pi * pi * pi * effective_radius * effective_radius));
}

double PullOffForceDmt(double surface_energy, double effective_radius) {
  return 4 * pi * surface_energy * effective_radius;
}

double EquilibriumOverlapSjkr2(double cohesion_energy_density, double effective_radius,
                               double effective_modulus) {
  const double softness = cohesion_energy_density / effective_modulus;
  return 9 * pi * pi * softness * softness * effective_radius;
}

double StiffnessNumber(double young_modulus, double poisson_ratio, double stress) {
  const double x = std::cbrt(young_modulus / ((1 - poisson_ratio * poisson_ratio) * stress));
  return x * x;
}

namespace {

using Value = std::optional<double>;

// f(values…) where all are known and the result is finite: a division by zero
// gravity or zero stress means that the group has no meaning.
template <typename F, typename... Values>
Value Combine(F f, const Values&... values) {
  if (!(values.has_value() && ...)) return std::nullopt;
  const double result = f(*values...);
  return std::isfinite(result) ? Value(result) : std::nullopt;
}

Value Divide(const Value& numerator, const Value& denominator) {
  return Combine([](double a, double b) { return a / b; }, numerator, denominator);
}

Value Multiply(const Value& first, const Value& second) {
  return Combine([](double a, double b) { return a * b; }, first, second);
}

Value ParticleWeight(const Conditions& c) {
  return Combine([](double rho, double d, double g) { return pi / 6 * rho * d * d * d * g; },
                 c.density, c.diameter, c.gravity);
}

Value ContactModulus(const Conditions& c) {
  return Combine(EffectiveModulus, c.young_modulus, c.poisson_ratio);
}

Value PullOffForce(const Conditions& c) {
  if (c.cohesion_energy_density) {
    return Combine([](double k, double d, double e) { return PullOffForceSjkr2(k, d / 4, e); },
                   c.cohesion_energy_density, c.diameter, ContactModulus(c));
  }
  return Combine([](double gamma, double d) { return PullOffForceDmt(gamma, d / 4); },
                 c.surface_energy, c.diameter);
}

// DMT: the constant attraction F_c against (4/3) E* sqrt(R*) delta^1.5.
Value EquilibriumOverlap(const Conditions& c) {
  if (c.cohesion_energy_density) {
    return Combine(
        [](double k, double d, double e) { return EquilibriumOverlapSjkr2(k, d / 4, e); },
        c.cohesion_energy_density, c.diameter, ContactModulus(c));
  }
  return Combine(
      [](double force, double d, double e) {
        const double x = std::cbrt(3 * force / (4 * e * std::sqrt(d / 4)));
        return x * x;
      },
      PullOffForce(c), c.diameter, ContactModulus(c));
}

// Work to separate two particles from equilibrium. SJKR2: 0.4 pi k R* delta_0²;
// DMT: 0.6 F_c delta_0 (docs/physics.md has the integrals).
Value WellDepth(const Conditions& c) {
  if (c.cohesion_energy_density) {
    return Combine([](double k, double d,
                      double overlap) { return 0.4 * pi * k * (d / 4) * overlap * overlap; },
                   c.cohesion_energy_density, c.diameter, EquilibriumOverlap(c));
  }
  return Combine([](double force, double overlap) { return 0.6 * force * overlap; },
                 PullOffForce(c), EquilibriumOverlap(c));
}

Value BedWeight(const Conditions& c) {
  return Combine([](double rho, double phi, double g, double h) { return rho * phi * g * h; },
                 c.density, c.bulk_solid_fraction, c.gravity, c.bed_height);
}

Value Kappa(const Conditions& c) {
  return Combine(StiffnessNumber, c.young_modulus, c.poisson_ratio, c.stress);
}

Value WeightOverModulus(const Conditions& c) {
  return Combine([](double rho, double g, double d, double e) { return rho * g * d / e; },
                 c.density, c.gravity, c.diameter, c.young_modulus);
}

Value PullOffOverLoad(const Conditions& c) {
  return Combine([](double force, double sigma, double d) { return force / (sigma * d * d); },
                 PullOffForce(c), c.stress, c.diameter);
}

Value InertialNumber(const Conditions& c) {
  return Combine([](double rate, double d, double rho,
                    double sigma) { return rate * d * std::sqrt(rho / sigma); },
                 c.shear_rate, c.diameter, c.density, c.stress);
}

Value FroudeNumber(const Conditions& c) {
  return Combine([](double v, double g, double d) { return v / std::sqrt(g * d); }, c.velocity,
                 c.gravity, c.diameter);
}

// Pull-off force at a wall (R* = r) over that between particles: SJKR2 has half
// the stiffness of cohesion there, DMT twice the radius.
Value WallOverPair(const Conditions& c) {
  if (PullOffForce(c).value_or(0) == 0) return std::nullopt;
  return c.cohesion_energy_density ? 0.5 : 2.0;
}

// Relative overlaps for the rigid-limit exception. The weight's leaves out 1 −
// nu², which errs on the side of a warning.
Value LoadOverlap(const Conditions& c) { return Divide(1.0, Kappa(c)); }
Value WeightOverlap(const Conditions& c) {
  return Combine([](double x) { return std::cbrt(x * x); }, WeightOverModulus(c));
}
Value WeightOverLoad(const Conditions& c) { return Divide(BedWeight(c), c.stress); }
Value CohesionOverlap(const Conditions& c) { return Divide(EquilibriumOverlap(c), c.diameter); }

constexpr char kRigid[] =
    "off {factor} times, but should not matter: on both "
    "sides it makes particles overlap by at "
    "most about a thousandth of their diameter";
constexpr char kWeightless[] =
    "off {factor} times, but should not matter: on both sides the load is at "
    "least ten times the "
    "bed's own weight, which then adds at most 5 % to the stress at mid-height";

constexpr double kRigidOverlap = 1 / kRigidStiffnessNumber;

// The order of the header.
const GroupDefinition kDefinitions[] = {
    {"sigma/E", "applied stress against the particles' stiffness",
     [](const Conditions& c) { return Divide(c.stress, c.young_modulus); },
     "the simulated particles are {factor} times too soft for their load: "
     "overlaps are not the "
     "powder's, and lower the void ratio",
     "the simulated particles are {factor} times too stiff for their load", LoadOverlap,
     kRigidOverlap, kRigid},
    {"kappa",
     "stiffness number, (E/((1-nu^2) sigma))^(2/3); diameter over overlap "
     "under the load",
     Kappa, "overlaps under the load are {factor} times too small",
     "overlaps under the load are {factor} times too large: kappa is "
     "{simulation} instead of "
     "{experiment}, and below about 1000 the void ratio feels it",
     LoadOverlap, kRigidOverlap, kRigid},
    {"k/E", "cohesion energy density against the particles' stiffness",
     [](const Conditions& c) { return Divide(c.cohesion_energy_density, c.young_modulus); },
     "the cohesion energy density is {factor} times too large against the "
     "stiffness",
     "the cohesion energy density is {factor} times too small against the "
     "stiffness"},
    {"rho g d/E", "weight of one layer of particles against their stiffness", WeightOverModulus,
     "the simulated particles are {factor} times too soft for their own weight",
     "the simulated particles are {factor} times too stiff for their own "
     "weight",
     WeightOverlap, kRigidOverlap, kRigid},
    {"sigma/(rho_b g h)", "applied stress against the weight of the bed",
     [](const Conditions& c) { return Divide(c.stress, BedWeight(c)); },
     "the applied stress is {simulation} times the bed's own weight instead of "
     "{experiment} times: "
     "gravity counts {factor} times too little",
     "the applied stress is {simulation} times the bed's own weight instead of "
     "{experiment} times: "
     "gravity counts {factor} times too much",
     WeightOverLoad, 1 / kLoadOverWeight, kWeightless},
    {"F_c/(sigma d^2)", "pull-off force of a contact against the load on a particle",
     PullOffOverLoad,
     "cohesion is {factor} times too strong against the load: the pull-off "
     "force is {simulation} "
     "sigma d^2 instead of {experiment}",
     "cohesion is {factor} times too weak against the load: the pull-off force "
     "is {simulation} "
     "sigma d^2 instead of {experiment}"},
    {"Bo", "granular Bond number, pull-off force against a particle's weight",
     [](const Conditions& c) { return Divide(PullOffForce(c), ParticleWeight(c)); },
     "cohesion is {factor} times too strong against gravity: a contact holds "
     "{simulation} "
     "particles' weight instead of {experiment}",
     "cohesion is {factor} times too weak against gravity: a contact holds "
     "{simulation} particles' "
     "weight instead of {experiment}",
     WeightOverLoad, 1 / kLoadOverWeight, kWeightless},
    {"W/(m g d)", "energy to separate two particles against lifting one by its diameter",
     [](const Conditions& c) {
       return Divide(WellDepth(c), Multiply(ParticleWeight(c), c.diameter));
     },
     "separating two particles costs {factor} times too much energy: they "
     "stick in collisions that "
     "would part the powder's (pouring, spreading); a quasi-static test feels "
     "the force, not this",
     "separating two particles costs {factor} times too little energy: they "
     "part in collisions "
     "where the powder's would stick (pouring, spreading); a quasi-static test "
     "feels the force, "
     "not this"},
    {"I", "inertial number, shear rate d sqrt(rho/sigma)", InertialNumber,
     "the test is {factor} times too fast against the load: I is {simulation} "
     "instead of "
     "{experiment}",
     "the test is {factor} times too slow against the load: I is {simulation} "
     "instead of "
     "{experiment}",
     InertialNumber, kQuasiStaticInertialNumber,
     "off {factor} times, but should not matter: on both sides the test is "
     "quasi-static (I at most "
     "0.001)"},
    {"V/sqrt(g d)",
     "Froude number, speed of the wall or blade against free fall by one "
     "diameter",
     FroudeNumber, "the wall or blade is {factor} times too fast against gravity",
     "the wall or blade is {factor} times too slow against gravity"},
    {"gap/d", "gap under the blade in diameters",
     [](const Conditions& c) { return Divide(c.gap, c.diameter); },
     "the gap under the blade is {factor} times too many diameters high",
     "the gap under the blade is {factor} times too few diameters high"},
    {"L/d", "width of the cell in diameters",
     [](const Conditions& c) { return Divide(c.width, c.diameter); },
     "the cell is {factor} times too many diameters wide",
     "the cell is {factor} times too few diameters wide: a small sample "
     "scatters more, and walls "
     "reach further into it"},
    {"delta_0/d", "overlap of two particles held by cohesion alone, in diameters", CohesionOverlap,
     "cohesion alone presses the particles {factor} times too far into each "
     "other: {simulation} of "
     "a diameter, which shows in the void ratio",
     "cohesion alone presses the particles {factor} times too little into each "
     "other",
     CohesionOverlap, kRigidOverlap, kRigid},
    {"F_w/F_c", "pull-off force at a wall against that between particles", WallOverPair,
     "walls hold particles {factor} times too strongly against what particles "
     "do",
     "walls hold particles {factor} times too weakly against what particles "
     "do: at a wall the law "
     "of the simulation has {simulation} times the pull-off force of a pair, "
     "that of the powder "
     "{experiment} times"},
    {"nu", "Poisson's ratio", [](const Conditions& c) { return c.poisson_ratio; },
     "Poisson's ratio is {simulation} instead of {experiment}",
     "Poisson's ratio is {simulation} instead of {experiment}"},
    {"mu", "coefficient of sliding friction", [](const Conditions& c) { return c.friction; },
     "friction is {simulation} instead of {experiment}",
     "friction is {simulation} instead of {experiment}"},
    {"mu_w", "coefficient of sliding friction at walls",
     [](const Conditions& c) { return c.wall_friction; },
     "wall friction is {simulation} instead of {experiment}",
     "wall friction is {simulation} instead of {experiment}"},
    {"mu_r", "coefficient of rolling friction",
     [](const Conditions& c) { return c.rolling_friction; },
     "rolling friction is {simulation} instead of {experiment}",
     "rolling friction is {simulation} instead of {experiment}"},
    {"e_n", "coefficient of restitution", [](const Conditions& c) { return c.restitution; },
     "restitution is {simulation} instead of {experiment}",
     "restitution is {simulation} instead of {experiment}"},
};

// chi = mu_r (dt/t_i)/I with t_i = d sqrt(rho/sigma) and I = rate t_i.
Value Chatter(const Conditions& c) {
  if (!c.directional_torque) return std::nullopt;
  return Combine([](double mu_r, double dt, double rate, double d, double rho,
                    double sigma) { return mu_r * dt * sigma / (rate * d * d * rho); },
                 c.rolling_friction, c.time_step, c.shear_rate, c.diameter, c.density, c.stress);
}

const NumericalGroup kNumerical[] = {
    {"dt/T_R", "time step against the Rayleigh time of the smallest particle",
     [](const Conditions& c) { return Divide(c.time_step, c.rayleigh_time); }, 0.2, 0.4,
     "the time step is {simulation} Rayleigh times of the smallest particle; "
     "beyond 0.4 runs blow "
     "up",
     "0.2 is the default of powdercal, half of what blows up (docs/physics.md, "
     "section 5)"},
    {"chi", "mu_r (dt/t_i)/I, dithering of the rolling torque of cdt", Chatter, 0.05, 0.5,
     "the rolling torque dithers from step to step: strength and density "
     "depend on time step and "
     "rate instead of mu_r",
     "0.05: docs/physics.md, section 6"},
    {"servo gain", "change of a servo-controlled wall's force in one step against its target",
     [](const Conditions& c) { return c.servo_gain; }, 0.3, 0.8,
     "the servo's gain is {simulation}; beyond about 0.8 the wall rattles and "
     "reads a wrong stress",
     "0.3 is what powdercal sets, 0.8 what was seen to be stable "
     "(docs/physics.md, section 6)"},
};

}  // namespace

std::span<const GroupDefinition> GroupDefinitions() { return kDefinitions; }
std::span<const NumericalGroup> NumericalGroups() { return kNumerical; }

std::vector<std::pair<std::string, double>> EvaluateGroups(const Conditions& conditions) {
  std::vector<std::pair<std::string, double>> values;
  for (const GroupDefinition& definition : kDefinitions) {
    if (const Value value = definition.evaluate(conditions)) {
      values.emplace_back(definition.symbol, *value);
    }
  }
  for (const NumericalGroup& group : kNumerical) {
    if (const Value value = group.evaluate(conditions)) values.emplace_back(group.symbol, *value);
  }
  return values;
}

std::optional<double> EvaluateGroup(const std::string& symbol, const Conditions& conditions) {
  for (const GroupDefinition& definition : kDefinitions) {
    if (symbol == definition.symbol) return definition.evaluate(conditions);
  }
  return std::nullopt;
}

std::vector<std::string> MatchableGroups() {
  // The others change with the material, the cell or the law, not with the conditions; k/E is
  // unknown of the powder.
  return {"sigma/E", "kappa",     "rho g d/E", "sigma/(rho_b g h)", "F_c/(sigma d^2)",
          "Bo",      "W/(m g d)", "I",         "V/sqrt(g d)",       "delta_0/d"};
}

}  // namespace powdercal

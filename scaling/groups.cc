#include "scaling/groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

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

const std::string& ToString(GroupComparison::Verdict verdict) {
  static const std::array<std::string, 4> kNames = {"matched", "off", "violated", "unknown"};
  return kNames[static_cast<std::size_t>(verdict)];
}

namespace {

using Value = std::optional<double>;
using Verdict = GroupComparison::Verdict;

// f(values…) where all are known and the result is finite: a division by zero gravity or zero
// stress means that the group has no meaning.
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

// Work to separate two particles from equilibrium. SJKR2: 0.4 pi k R* delta_0²; DMT: 0.6 F_c
// delta_0 (docs/physics.md has the integrals).
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

// Relative overlaps for the rigid-limit exception. The weight's leaves out 1 − nu², which errs on
// the side of a warning.
Value LoadOverlap(const Conditions& c) { return Divide(1.0, Kappa(c)); }
Value WeightOverlap(const Conditions& c) {
  return Combine([](double x) { return std::cbrt(x * x); }, WeightOverModulus(c));
}
Value CohesionOverlap(const Conditions& c) { return Divide(EquilibriumOverlap(c), c.diameter); }

using Evaluate = Value (*)(const Conditions&);

struct Definition {
  const char* symbol;
  const char* meaning;
  Evaluate evaluate;
  // Remarks on a simulation whose group is too large or too small; {factor} ≥ 1, {simulation} and
  // {experiment} are filled in.
  const char* above;
  const char* below;
  // What must be small on both sides for a difference not to matter; null: it always matters.
  Evaluate harmless_measure = nullptr;
  double harmless_limit = 0;
  const char* harmless = "";
};

constexpr char kRigid[] =
    "off {factor} times, but should not matter: on both sides it makes particles overlap by at "
    "most "
    "about a thousandth of their diameter";

constexpr double kRigidOverlap = 1 / kRigidStiffnessNumber;

// The order of the header.
const Definition kDefinitions[] = {
    {"sigma/E", "applied stress against the particles' stiffness",
     [](const Conditions& c) { return Divide(c.stress, c.young_modulus); },
     "the simulated particles are {factor} times too soft for their load: overlaps are not the "
     "powder's, and lower the void ratio",
     "the simulated particles are {factor} times too stiff for their load", LoadOverlap,
     kRigidOverlap, kRigid},
    {"kappa", "stiffness number, (E/((1-nu^2) sigma))^(2/3); diameter over overlap under the load",
     Kappa, "overlaps under the load are {factor} times too small",
     "overlaps under the load are {factor} times too large: kappa is {simulation} instead of "
     "{experiment}, and below about 1000 the void ratio feels it",
     LoadOverlap, kRigidOverlap, kRigid},
    {"k/E", "cohesion energy density against the particles' stiffness",
     [](const Conditions& c) { return Divide(c.cohesion_energy_density, c.young_modulus); },
     "the cohesion energy density is {factor} times too large against the stiffness",
     "the cohesion energy density is {factor} times too small against the stiffness"},
    {"rho g d/E", "weight of one layer of particles against their stiffness", WeightOverModulus,
     "the simulated particles are {factor} times too soft for their own weight",
     "the simulated particles are {factor} times too stiff for their own weight", WeightOverlap,
     kRigidOverlap, kRigid},
    {"sigma/(rho_b g h)", "applied stress against the weight of the bed",
     [](const Conditions& c) { return Divide(c.stress, BedWeight(c)); },
     "the applied stress is {simulation} times the bed's own weight instead of {experiment} times: "
     "gravity counts {factor} times too little",
     "the applied stress is {simulation} times the bed's own weight instead of {experiment} times: "
     "gravity counts {factor} times too much"},
    {"F_c/(sigma d^2)", "pull-off force of a contact against the load on a particle",
     PullOffOverLoad,
     "cohesion is {factor} times too strong against the load: the pull-off force is {simulation} "
     "sigma d^2 instead of {experiment}",
     "cohesion is {factor} times too weak against the load: the pull-off force is {simulation} "
     "sigma d^2 instead of {experiment}"},
    {"Bo", "granular Bond number, pull-off force against a particle's weight",
     [](const Conditions& c) { return Divide(PullOffForce(c), ParticleWeight(c)); },
     "cohesion is {factor} times too strong against gravity: a contact holds {simulation} "
     "particles' weight instead of {experiment}",
     "cohesion is {factor} times too weak against gravity: a contact holds {simulation} particles' "
     "weight instead of {experiment}"},
    {"W/(m g d)", "energy to separate two particles against lifting one by its diameter",
     [](const Conditions& c) {
       return Divide(WellDepth(c), Multiply(ParticleWeight(c), c.diameter));
     },
     "separating two particles costs {factor} times too much energy: they stick in collisions that "
     "would part the powder's (pouring, spreading); a quasi-static test feels the force, not this",
     "separating two particles costs {factor} times too little energy: they part in collisions "
     "where the powder's would stick (pouring, spreading); a quasi-static test feels the force, "
     "not this"},
    {"I", "inertial number, shear rate d sqrt(rho/sigma)", InertialNumber,
     "the test is {factor} times too fast against the load: I is {simulation} instead of "
     "{experiment}",
     "the test is {factor} times too slow against the load: I is {simulation} instead of "
     "{experiment}",
     InertialNumber, kQuasiStaticInertialNumber,
     "off {factor} times, but should not matter: on both sides the test is quasi-static (I at most "
     "0.001)"},
    {"V/sqrt(g d)", "Froude number, speed of the wall or blade against free fall by one diameter",
     FroudeNumber, "the wall or blade is {factor} times too fast against gravity",
     "the wall or blade is {factor} times too slow against gravity"},
    {"gap/d", "gap under the blade in diameters",
     [](const Conditions& c) { return Divide(c.gap, c.diameter); },
     "the gap under the blade is {factor} times too many diameters high",
     "the gap under the blade is {factor} times too few diameters high"},
    {"L/d", "width of the cell in diameters",
     [](const Conditions& c) { return Divide(c.width, c.diameter); },
     "the cell is {factor} times too many diameters wide",
     "the cell is {factor} times too few diameters wide: a small sample scatters more, and walls "
     "reach further into it"},
    {"delta_0/d", "overlap of two particles held by cohesion alone, in diameters", CohesionOverlap,
     "cohesion alone presses the particles {factor} times too far into each other: {simulation} of "
     "a diameter, which shows in the void ratio",
     "cohesion alone presses the particles {factor} times too little into each other",
     CohesionOverlap, kRigidOverlap, kRigid},
    {"nu", "Poisson's ratio", [](const Conditions& c) { return c.poisson_ratio; },
     "Poisson's ratio is {simulation} instead of {experiment}",
     "Poisson's ratio is {simulation} instead of {experiment}"},
    {"mu", "coefficient of sliding friction", [](const Conditions& c) { return c.friction; },
     "friction is {simulation} instead of {experiment}",
     "friction is {simulation} instead of {experiment}"},
    {"mu_r", "coefficient of rolling friction",
     [](const Conditions& c) { return c.rolling_friction; },
     "rolling friction is {simulation} instead of {experiment}",
     "rolling friction is {simulation} instead of {experiment}"},
    {"e_n", "coefficient of restitution", [](const Conditions& c) { return c.restitution; },
     "restitution is {simulation} instead of {experiment}",
     "restitution is {simulation} instead of {experiment}"},
};

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

std::string Remark(const Definition& definition, double factor, const GroupComparison& group) {
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

bool Harmless(const Definition& definition, const Conditions& experiment,
              const Conditions& simulation) {
  if (definition.harmless_measure == nullptr) return false;
  const Value x = definition.harmless_measure(experiment);
  const Value y = definition.harmless_measure(simulation);
  return x && y && std::max(*x, *y) <= definition.harmless_limit * kRounding;
}

void Judge(const Definition& definition, const Conditions& experiment, const Conditions& simulation,
           GroupComparison* group) {
  if (!group->experiment || !group->simulation) return;
  const double a = *group->experiment;
  const double b = *group->simulation;
  if (a == b) {
    group->ratio = 1;
    group->verdict = Verdict::matched;
    return;
  }
  if (a == 0) {
    group->verdict = Verdict::violated;
    group->remark = fmt::format("zero in the experiment, {} in the simulation", Readable(b));
    return;
  }
  group->ratio = b / a;
  if (b == 0) {
    group->verdict = Verdict::violated;
    group->remark = fmt::format("zero in the simulation, {} in the experiment", Readable(a));
    return;
  }
  const double factor = std::max(b / a, a / b);
  if (factor <= kMatchFactor * kRounding) {
    group->verdict = Verdict::matched;
  } else if (Harmless(definition, experiment, simulation)) {
    group->verdict = Verdict::off;
    group->remark = Fill(definition.harmless, factor, *group);
  } else {
    group->verdict = factor <= kViolationFactor * kRounding ? Verdict::off : Verdict::violated;
    group->remark = Remark(definition, factor, *group);
  }
}

}  // namespace

std::vector<GroupComparison> CompareGroups(const Conditions& experiment,
                                           const Conditions& simulation) {
  std::vector<GroupComparison> groups;
  for (const Definition& definition : kDefinitions) {
    GroupComparison group{.symbol = definition.symbol,
                          .meaning = definition.meaning,
                          .experiment = definition.evaluate(experiment),
                          .simulation = definition.evaluate(simulation)};
    if (!group.experiment && !group.simulation) continue;
    Judge(definition, experiment, simulation, &group);
    groups.push_back(std::move(group));
  }
  return groups;
}

std::vector<std::pair<std::string, double>> EvaluateGroups(const Conditions& conditions) {
  std::vector<std::pair<std::string, double>> values;
  for (const Definition& definition : kDefinitions) {
    if (const Value value = definition.evaluate(conditions)) {
      values.emplace_back(definition.symbol, *value);
    }
  }
  return values;
}

}  // namespace powdercal

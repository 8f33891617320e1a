#include <gtest/gtest.h>

#include <cmath>

#include "studies/planner.h"

namespace powdercal {
namespace {

constexpr const char* kConsolidation =
    "consolidation: {stress: 900 Pa, observed: {void_ratio: {value: 0.8, sd: 0.01}}}";

// A powder of 5 MPa, simulated exactly similarly at another modulus.
std::string StudyAt(const std::string& young_modulus,
                    const std::string& experiment = kConsolidation) {
  return R"(
study: exact-similarity
material:
  density: 8220 kg/m3
  young_modulus: 5 MPa
  poisson_ratio: 0.3
  restitution: 0.4
  friction: {particle: 0.3, wall: 0.3}
  surface_energy: 0.5 mJ/m2
  sizes: {distribution: normal, mean: 29 um, sd: 6 um, min: 12.5 um, max: 37.5 um}
contact_law: {normal: hertz, tangential: history, cohesion: sjkr2, rolling: epsd2}
parameters: {rolling_friction: {range: [0.1, 0.5]}}
scaling: {mode: exact, young_modulus: )" +
         young_modulus + "}\nexperiments:\n  - " + experiment + "\n";
}

struct Simulated {
  Program program;
  Trace trace;
  double factor = 1;  // modulus over the powder's
};

// The whole protocol or, with `steps`, so many of its first ones.
Simulated SimulateAt(const std::string& young_modulus, int steps = 0) {
  const Study study = Study::Parse(StudyAt(young_modulus), "s.yaml", {}, {});
  const Planner planner(study);
  EXPECT_EQ(planner.ExplainUnsupported(), "");
  Simulated run;
  run.program = planner.PlanExperiment(0, {0.2}, 0, 7).program;
  if (steps > 0) {
    run.program.stages.resize(1);
    run.program.stages.push_back(Advance{.duration = steps * run.program.time_step});
  }
  run.factor = run.program.materials.young_modulus / 5e6;
  run.trace = study.backend.backend->Run(run.program, {});
  EXPECT_TRUE(run.trace.outcome.ok()) << run.trace.outcome.message;
  return run;
}

double FastestOf(const Packing& packing) {
  double fastest = 0;
  for (const Sphere& sphere : packing) {
    for (const double v : sphere.velocity) fastest = std::max(fastest, std::abs(v));
  }
  return fastest;
}

// Largest difference of positions over the diameter, and of speeds over the fastest particle's.
double Difference(const Packing& a, const Packing& b, double speed_ratio) {
  const double fastest = FastestOf(a);
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double way = std::abs(a[i].position[axis] - b[i].position[axis]);
      const double speed = std::abs(a[i].velocity[axis] - b[i].velocity[axis] / speed_ratio);
      largest = std::max({largest, way / (2 * a[i].radius), speed / fastest});
    }
  }
  return largest;
}

void ExpectSimilar(const Simulated& reference, const Simulated& run, double tolerance) {
  EXPECT_EQ(run.trace.diagnostics.steps, reference.trace.diagnostics.steps) << run.factor;
  const double speed_ratio = std::sqrt(run.factor / reference.factor);
  ASSERT_EQ(run.trace.moments.size(), reference.trace.moments.size());
  for (std::size_t m = 0; m < run.trace.moments.size(); ++m) {
    const Moment& moment = run.trace.moments[m];
    const Moment& other = reference.trace.moments[m];
    ASSERT_EQ(moment.packing.size(), other.packing.size());
    EXPECT_LE(Difference(other.packing, moment.packing, speed_ratio), tolerance)
        << moment.name << " at " << run.factor;
    EXPECT_NEAR(moment.time * speed_ratio / other.time, 1, 1e-12);
    for (const auto& [name, wall] : moment.walls) {
      EXPECT_NEAR(wall.force[2] / run.factor, other.walls.at(name).force[2] / reference.factor,
                  std::abs(tolerance * other.walls.at(name).force[2]));
    }
  }
}

// Factors of four scale every number by a power of two and leave no rounding error: from the fall
// to the end of the hold, the runs are the same to the last bit.
TEST(ExactSimilarity, WholeProtocolIsTheSameToTheLastBit) {
  const Simulated reference = SimulateAt("5 MPa");
  EXPECT_GT(reference.trace.diagnostics.steps, 10000);
  for (const char* modulus : {"1.25 MPa", "78.125 kPa"}) {
    ExpectSimilar(reference, SimulateAt(modulus), 0);
  }
}

// At any other modulus numbers are rounded differently. A bed of colliding particles amplifies that
// like any other disturbance, so that the comparison must end before that has grown from 1e-16.
TEST(ExactSimilarity, TrajectoriesAreTheSameAtAnyModulus) {
  constexpr int kSteps = 2000;
  const Simulated reference = SimulateAt("5 MPa", kSteps);
  EXPECT_GT(reference.trace.diagnostics.figures.at("contacts"), 100);
  for (const char* modulus : {"4.9 MPa", "2.9 MPa", "370 kPa", "20 kPa"}) {
    ExpectSimilar(reference, SimulateAt(modulus, kSteps), 1e-9);
  }
}

// What is a time, a speed, a stress in a program, in units of the powder's modulus.
struct Units {
  double factor = 1;
  double time(double seconds) const { return seconds * std::sqrt(factor); }
  double speed(double speed) const { return speed / std::sqrt(factor); }
  double rate(double rate) const { return rate / std::sqrt(factor); }
  double stress(double stress) const { return stress / factor; }
};

std::vector<double> NumbersOf(const Stage& stage, const Units& u) {
  if (const auto* s = std::get_if<Insert>(&stage)) {
    return {s->bottom, s->top, u.speed(s->velocity[2])};
  }
  if (const auto* s = std::get_if<Settle>(&stage)) {
    return {s->kinetic_energy_ratio, u.time(s->check_interval), u.time(s->min_duration),
            u.time(s->max_duration)};
  }
  if (const auto* s = std::get_if<Servo>(&stage)) {
    return {u.stress(s->stress), u.speed(s->max_velocity), u.time(s->max_duration)};
  }
  if (const auto* s = std::get_if<Hold>(&stage)) {
    return {s->stress_tolerance, u.rate(s->strain_rate), s->kinetic_energy_ratio, u.time(s->window),
            u.time(s->max_duration)};
  }
  if (const auto* s = std::get_if<Advance>(&stage)) {
    std::vector<double> numbers = {u.time(s->duration)};
    for (const Motion& motion : s->motions) {
      for (const double v : motion.velocity) numbers.push_back(u.speed(v));
    }
    return numbers;
  }
  if (const auto* s = std::get_if<Deform>(&stage)) {
    return {u.time(s->duration), u.stress(s->edges[2].value), u.rate(s->shear_rate),
            u.rate(s->relaxation_rate), s->gain};
  }
  return {};
}

std::vector<double> NumbersOf(const Program& program) {
  const Units u{program.materials.young_modulus / 5e6};
  std::vector<double> numbers = {
      u.time(program.time_step), program.gravity[2] / u.factor,
      program.materials.particle_particle.cohesion_energy_density / u.factor,
      program.materials.density};
  for (const double length : program.domain.Lengths()) numbers.push_back(length);
  if (program.particles.packing) {
    for (const Sphere& sphere : *program.particles.packing) {
      numbers.push_back(sphere.position[2]);
      numbers.push_back(u.speed(sphere.velocity[2]));
    }
  }
  for (const Stage& stage : program.stages) {
    for (const double number : NumbersOf(stage, u)) numbers.push_back(number);
  }
  return numbers;
}

TEST(ExactSimilarity, EveryExperimentIsPlannedSimilarly) {
  for (const std::string experiment :
       {kConsolidation,
        "shear: {preshear: 900 Pa, observed: {steady_state_friction: {value: 0.5, sd: 0.1}}}",
        "shear: {preshear: 900 Pa, cell: platens, observed: {steady_state_friction: {value: 0.5, "
        "sd: 0.1}}}",
        "spreading: {observed: {coverage: {value: 0.9, sd: 0.05}}}",
        "angle_of_repose: {flow_time: 20 ms, observed: {retained_mass: {value: 0.6, sd: 0.05}}}",
        "angle_of_repose: {method: funnel, observed: {retained_mass: {value: 0.6, sd: 0.05}}}"}) {
    std::vector<std::vector<double>> plans;
    for (const char* modulus : {"5 MPa", "1.25 MPa"}) {
      const Study study = Study::Parse(StudyAt(modulus, experiment), "s.yaml", {}, {});
      const Planner planner(study);
      ASSERT_EQ(planner.ExplainUnsupported(), "") << experiment;
      plans.push_back(NumbersOf(planner.PlanExperiment(0, {0.2}, 0, 7).program));
    }
    EXPECT_EQ(plans[0], plans[1]) << experiment;
  }
}

}  // namespace
}  // namespace powdercal

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "backends/embedded/mesh_shapes.h"
#include "core/random.h"
#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

using ::testing::HasSubstr;

// Spheres that fall on a floor, x and y periodic.
Program Pour(int count, double width) {
  Program program = Vacuum({}, 5e-7);
  program.particles.packing.reset();
  program.particles.sizes = {SizeDistribution::Kind::normal, 2 * kRadius, 4e-6, 20e-6, 40e-6};
  program.particles.count = count;
  program.particles.seed = 2;
  SetContact(program, {.restitution = 0.4,
                       .friction = 0.3,
                       .rolling_friction = 0.1,
                       .cohesion_energy_density = 10000});
  program.law.cohesion = ContactLaw::Cohesion::sjkr2;
  program.law.rolling = ContactLaw::Rolling::epsd2;
  const double height = count * std::pow(2 * kRadius, 3) / (0.5 * width * width) + 4 * kRadius;
  program.domain = {{-0.5 * width, -0.5 * width, -kRadius},
                    {0.5 * width, 0.5 * width, height},
                    {Boundary::periodic, Boundary::periodic, Boundary::open}};
  program.gravity = {0, 0, -kGravity};
  program.walls = {Floor()};
  program.stages = {Insert{0, height, {0, 0, -0.3}}};
  return program;
}

TEST(Health, AnAbsurdTimeStepEndsUnstableAndEarly) {
  for (const double rayleigh_times : {3.0, 10.0}) {
    Program program = Pour(200, 10 * kRadius);
    program.time_step = rayleigh_times * RayleighTime(kRadius, kDensity, kYoung, kPoisson);
    program.stages.push_back(Advance{.duration = 1e6 * program.time_step});
    const Trace trace = RunProgram(program);
    EXPECT_EQ(trace.outcome.reason, Reason::unstable)
        << rayleigh_times << " Rayleigh times: " << ToString(trace.outcome.reason) << ", "
        << trace.outcome.message;
    EXPECT_LT(trace.diagnostics.steps, 10000);
    EXPECT_TRUE(std::isfinite(trace.diagnostics.max_overlap));
    EXPECT_FALSE(trace.outcome.message.empty());
  }
}

TEST(Health, CancellationIsHeededAtOnce) {
  Program program = Pour(20000, 50 * kRadius);
  program.stages.push_back(Advance{.duration = 10});
  std::stop_source stop;
  std::chrono::steady_clock::time_point requested;
  Trace trace;
  {
    std::jthread runner([&] {
      RunContext context;
      context.stop = stop.get_token();
      trace = MakeBackend("embedded")->Run(program, context);
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    requested = std::chrono::steady_clock::now();
    stop.request_stop();
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - requested;
  EXPECT_EQ(trace.outcome.reason, Reason::cancelled);
  EXPECT_GT(trace.diagnostics.steps, 0) << "it was still placing particles";
  Measured("seconds from the request to the end, 20 000 particles", took.count());
  EXPECT_LT(took.count(), 2);
}

TEST(Health, TimeLimitEndsTheRun) {
  Program program = Pour(200, 10 * kRadius);
  program.stages.push_back(Advance{.duration = 1000});
  RunContext context;
  context.time_limit = std::chrono::milliseconds(100);
  const Trace trace = MakeBackend("embedded")->Run(program, context);
  EXPECT_EQ(trace.outcome.reason, Reason::timeout);
  EXPECT_GT(trace.diagnostics.steps, 0);
  EXPECT_LT(trace.diagnostics.wall_seconds, 2);
}

// --- Restart ------------------------------------------------------------------------------------

Program Continued(Program program, const Moment& moment) {
  program.particles.packing = moment.packing;
  program.particles.contacts = moment.contacts;
  program.stages.clear();
  return program;
}

double Difference(const Packing& a, const Packing& b) {
  EXPECT_FALSE(a.empty());
  EXPECT_EQ(a.size(), b.size());
  double worst = 0;
  for (std::size_t p = 0; p < a.size(); ++p) {
    EXPECT_EQ(a[p].id, b[p].id);
    worst = std::max({worst, Length(a[p].position - b[p].position) / kRadius,
                      Length(a[p].velocity - b[p].velocity) / 0.1,
                      kRadius * Length(a[p].spin - b[p].spin) / 0.1});
  }
  return worst;
}

// Springs go on from what they remember; what differs is the order in which forces are added, and
// collisions multiply that.
TEST(Restart, UndampedRunGoesOnAsIfNothingHadHappened) {
  Program program = Pour(100, 8 * kRadius);
  program.materials.particle_particle.restitution = 1;
  program.materials.particle_wall.restitution = 1;
  program.stages.push_back(Advance{.name = "way", .duration = 2000 * 5e-7, .packing_every = 20});
  const Trace whole = RunOk(program);
  ASSERT_EQ(whole.moments.size(), 100U);
  const Moment& middle = whole.moments[49];
  ASSERT_GT(middle.contacts.size(), 20U);
  const std::vector<Moment> rest = Trajectory(Continued(program, middle), 1000 * 5e-7, 20);
  ASSERT_EQ(rest.size(), 50U);
  const double soon = Difference(rest[0].packing, whole.moments[50].packing);
  const double late = Difference(rest[49].packing, whole.moments[99].packing);
  Measured("20 steps after a restart against none, undamped", soon);
  Measured("1000 steps after it", late);
  EXPECT_LT(soon, 1e-12);
  EXPECT_LT(late, 1e-6);
}

// A pair in mid-impact, damped: forces see velocities of half a step before, which a packing does
// not hold, so that a restart costs one step's change of the dashpots' force.
TEST(Restart, DampedRunDiffersByOneStepOfDamping) {
  const auto difference = [](double time_step) {
    Program program = Vacuum({Ball(1, kRadius, {}, {}, {0, 300, 0}),
                              Ball(2, kRadius, {2 * kRadius, 0, 0}, {-0.03, 0.02, 0.01})},
                             time_step);
    SetContact(program, {.restitution = 0.4, .friction = 0.3, .rolling_friction = 0.1});
    program.law.rolling = ContactLaw::Rolling::epsd2;
    const double time = 8e-6;
    program.stages = {Advance{.name = "way",
                              .duration = 2 * time,
                              .packing_every = static_cast<int>(std::lround(time / time_step))}};
    const Trace whole = RunOk(program);
    EXPECT_EQ(whole.moments[0].contacts.size(), 1U);
    return Difference(After(Continued(program, whole.moments[0]), time), whole.moments[1].packing);
  };
  const double coarse = difference(1e-7);
  const double fine = difference(1e-8);
  Measured("restart against none, damped, 0.03 Rayleigh times", coarse);
  Measured("the same, 0.003 Rayleigh times", fine);
  EXPECT_LT(coarse, 1e-4);
  EXPECT_LT(fine, 0.05 * coarse) << "of second order in the time step";
}

TEST(Restart, SettledBedStaysSettled) {
  Program program = Pour(200, 10 * kRadius);
  program.stages.push_back(Settle{1e-9, 1e-3, 1e-3, 0.1});
  program.stages.push_back(Advance{.duration = 5e-3});
  const Trace whole = RunOk(program);
  ASSERT_EQ(whole.moments.size(), 2U);
  const Moment& rest = whole.moments[0];
  ASSERT_GT(rest.contacts.size(), 300U);
  const auto way = [&](const Packing& packing) {
    double most = 0;
    for (std::size_t p = 0; p < packing.size(); ++p) {
      most = std::max(most, Length(packing[p].position - rest.packing[p].position) / kRadius);
    }
    return most;
  };
  Program again = Continued(program, rest);
  again.stages = {Advance{.duration = 5e-3}};
  const Trace trace = RunOk(again);
  Measured("largest way of a settled sphere over its radius, after a restart",
           way(trace.moments.back().packing));
  Measured("the same without a restart", way(whole.moments[1].packing));
  Measured("kinetic energy after a restart over that without one",
           trace.diagnostics.kinetic_energy / whole.diagnostics.kinetic_energy);
  EXPECT_LT(way(trace.moments.back().packing), 1e-4);
  EXPECT_NEAR(trace.diagnostics.kinetic_energy / whole.diagnostics.kinetic_energy, 1, 0.1);
  EXPECT_LT(Difference(trace.moments.back().packing, whole.moments[1].packing), 1e-5);
  // Without what the contacts remember the bed gives way.
  again.particles.contacts.clear();
  EXPECT_GT(way(RunOk(again).moments.back().packing), 1e-3);
}

// --- What it refuses ----------------------------------------------------------------------------

struct Refusal {
  std::string message;
  std::function<void(Program&)> spoil;
};

Program Sound() {
  Program program = Vacuum({Ball(1, kRadius, {}), Ball(2, kRadius, {1e-3, 0, 0})});
  program.walls = {Floor(-1e-3), {.name = "lid", .position = 1e-3, .facing_positive = false}};
  program.meshes = {
      embedded::MakeRectangle("blade", {5e-3, 0, 0}, {0, 1e-3, 0}, {0, 0, 1e-3}, 1, 1)};
  program.groups = {{"glued", {2}}};
  program.stages = {Advance{.duration = 1e-5}};
  return program;
}

void MakeCell(Program& program) {
  program.walls.clear();
  program.meshes.clear();
  program.groups.clear();
  program.domain.boundaries = {Boundary::periodic, Boundary::periodic, Boundary::periodic};
}

std::vector<Refusal> BadNumbersAndBodies() {
  return {
      {"time step must be positive", [](Program& p) { p.time_step = 0; }},
      {"density must be positive", [](Program& p) { p.materials.density = -1; }},
      {"Young's modulus must be positive", [](Program& p) { p.materials.young_modulus = 0; }},
      {"Poisson's ratio must be in [0, 1)", [](Program& p) { p.materials.poisson_ratio = 1; }},
      {"restitution must be in (0, 1]",
       [](Program& p) { p.materials.particle_particle.restitution = 0; }},
      {"restitution must be in (0, 1]",
       [](Program& p) { p.materials.particle_wall.restitution = 1.1; }},
      {"needs a positive stiffness", [](Program& p) { p.law.normal = ContactLaw::Normal::linear; }},
      {"no extent along y", [](Program& p) { p.domain.upper[1] = p.domain.lower[1]; }},
      {"periodic along x",
       [](Program& p) {
         p.domain.boundaries[0] = Boundary::periodic;
         p.domain.lower[0] = -2 * kRadius;
         p.domain.upper[0] = 2 * kRadius;
       }},
      {"two bodies are called 'blade'", [](Program& p) { p.walls[0].name = "blade"; }},
      {"axis must be 0, 1 or 2", [](Program& p) { p.walls[0].axis = 3; }},
      {"stands across a periodic axis",
       [](Program& p) { p.domain.boundaries[2] = Boundary::periodic; }},
      {"glued groups need an explicit packing",
       [](Program& p) {
         p.particles.packing.reset();
         p.particles.sizes.mean = 2 * kRadius;
         p.particles.count = 1;
       }},
      {"contact histories need an explicit packing",
       [](Program& p) {
         p.particles.packing.reset();
         p.particles.sizes.mean = 2 * kRadius;
         p.particles.count = 1;
         p.groups.clear();
         p.particles.contacts = {{1, 2, {}, {}}};
       }},
      {"names particle 3, which does not exist", [](Program& p) { p.groups[0].ids = {3}; }},
      {"particle 2 is glued twice",
       [](Program& p) {
         p.groups.push_back({"again", {2}});
       }},
  };
}

std::vector<Refusal> BadStages() {
  const auto deform = [](Program& p) {
    MakeCell(p);
    p.stages = {Deform{.duration = 1e-5, .shear_rate = 1}};
  };
  return {
      {"inserted at the beginning only", [](Program& p) { p.stages.push_back(Insert{}); }},
      {"check interval must be positive", [](Program& p) { p.stages = {Settle{}}; }},
      {"servo: there is no plane, mesh or glued group called 'roof'",
       [](Program& p) {
         p.stages = {Servo{"roof", 900, 0.1, 1}};
       }},
      {"servo: the stress must be positive",
       [](Program& p) {
         p.stages = {Servo{"lid", 0, 0.1, 1}};
       }},
      {"largest velocity must be positive",
       [](Program& p) {
         p.stages = {Servo{"lid", 900, 0, 1}};
       }},
      {"does not face down",
       [](Program& p) {
         p.stages = {Servo{"floor", 900, 0.1, 1}};
       }},
      {"servo: 'lid' has the program's servo, 'glued' cannot have another",
       [](Program& p) {
         p.stages = {Servo{"lid", 900, 0.1, 1}, Servo{"glued", 900, 0.1, 1}};
       }},
      {"no servo stands before it", [](Program& p) { p.stages = {Hold{.window = 1}}; }},
      {"periodic in x, y and z has no stress slab",
       [deform](Program& p) {
         deform(p);
         p.stress_slab = {{0, 1e-4}};
       }},
      {"stress slab from 0.0001 to 0 m has no height",
       [](Program& p) {
         p.stress_slab = {{1e-4, 0}};
       }},
      {"no servo stands before it",
       [](Program& p) {
         p.stages = {Save{"start"}, Servo{"lid", 900, 0.1, 1}, Restore{"start"}, Hold{.window = 1}};
       }},
      {"save: there are two states called 'bed'",
       [](Program& p) {
         p.stages = {Save{"bed"}, Save{"bed"}};
       }},
      {"restore: no state called 'bed' was saved before",
       [](Program& p) {
         p.stages = {Save{"powder"}, Restore{"bed"}, Save{"bed"}};
       }},
      {"remove: there is no plane, mesh or glued group called 'gate'",
       [](Program& p) { p.stages = {Remove{"gate"}}; }},
      {"remove: 'lid' has a servo",
       [](Program& p) {
         p.stages = {Servo{"lid", 900, 0.1, 1}, Remove{"lid"}};
       }},
      {"remove: 'glued' is a glued group", [](Program& p) { p.stages = {Remove{"glued"}}; }},
      {"servo: 'lid' was removed before",
       [](Program& p) {
         p.stages = {Save{"bed"}, Remove{"lid"}, Servo{"lid", 900, 0.1, 1}};
       }},
      {"advance: 'blade' was removed before",
       [](Program& p) {
         p.stages = {Remove{"blade"},
                     Advance{.duration = 1, .motions = {{"blade", {1, 0, 0}, {}, {}}}}};
       }},
      {"hold: the window must be positive",
       [](Program& p) {
         p.stages = {Servo{"lid", 900, 0.1, 1}, Hold{}};
       }},
      {"advance: there is no plane",
       [](Program& p) {
         p.stages = {Advance{.duration = 1, .motions = {{"door", {1, 0, 0}, {}, {}}}}};
       }},
      {"'lid' cannot turn",
       [](Program& p) {
         p.stages = {Advance{.duration = 1, .motions = {{"lid", {}, {1, 0, 0}, {}}}}};
       }},
      {"'glued' cannot turn",
       [](Program& p) {
         p.stages = {Advance{.duration = 1, .motions = {{"glued", {}, {1, 0, 0}, {}}}}};
       }},
      {"'blade' cannot turn",
       [](Program& p) {
         p.stages = {Servo{"blade", 900, 0.1, 1},
                     Advance{.duration = 1, .motions = {{"blade", {}, {1, 0, 0}, {}}}}};
       }},
      {"only a cell that is periodic in x, y and z",
       [](Program& p) { p.stages = {Deform{.duration = 1}}; }},
      {"the cell holds walls",
       [deform](Program& p) {
         deform(p);
         p.groups = {{"glued", {2}}};
       }},
      {"the cell has gravity",
       [deform](Program& p) {
         deform(p);
         p.gravity = {0, 0, -1};
       }},
      {"stresses must be positive",
       [deform](Program& p) {
         deform(p);
         std::get<Deform>(p.stages[0]).edges[0] = {EdgeControl::Kind::stress, 0};
       }},
      {"needs a relaxation rate",
       [deform](Program& p) {
         deform(p);
         p.stages = {Deform{.duration = 1, .edges = {{{EdgeControl::Kind::stress, 900}, {}, {}}}}};
       }},
  };
}

TEST(BadInput, IsRefusedWithItsReason) {
  EXPECT_EQ(RunProgram(Sound()).outcome.reason, Reason::ok);
  for (const std::vector<Refusal>& refusals : {BadNumbersAndBodies(), BadStages()}) {
    for (const Refusal& refusal : refusals) {
      Program program = Sound();
      refusal.spoil(program);
      const Trace trace = RunProgram(program);
      EXPECT_EQ(trace.outcome.reason, Reason::unsupported) << refusal.message;
      EXPECT_THAT(trace.outcome.message, HasSubstr(refusal.message));
      EXPECT_TRUE(trace.moments.empty());
    }
  }
}

TEST(BadInput, PackingsAndMeshesAreLookedAt) {
  const std::vector<Refusal> refusals = {
      {"", [](Program& p) { p.particles.packing->front().radius = -1; }},
      {"", [](Program& p) { p.particles.packing->front().position[1] = NAN; }},
      {"", [](Program& p) { p.particles.packing->front().position[1] = 1; }},
      {"", [](Program& p) { p.particles.packing->front().id = 2; }},
      {"blade", [](Program& p) { p.meshes[0].triangles[0][1] = 99; }},
      {"blade", [](Program& p) { p.meshes[0].vertices[0][0] = INFINITY; }},
      {"blade", [](Program& p) { p.meshes[0].triangles.clear(); }},
  };
  for (const Refusal& refusal : refusals) {
    Program program = Sound();
    refusal.spoil(program);
    const Trace trace = RunProgram(program);
    EXPECT_EQ(trace.outcome.reason, Reason::invalid_input) << trace.outcome.message;
    EXPECT_THAT(trace.outcome.message, HasSubstr(refusal.message));
  }
}

}  // namespace
}  // namespace powdercal::physics

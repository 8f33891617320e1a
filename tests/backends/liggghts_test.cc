#include "backends/liggghts/liggghts.h"

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "backends/liggghts/deck.h"
#include "backends/liggghts/result.h"
#include "backends/liggghts/result_files.h"
#include "core/random.h"
#include "tests/support/program.h"
#include "tests/support/simulators.h"

// The real LIGGGHTS throughout, on beds of 100 particles.

namespace powdercal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Program SmallConsolidation() {
  Program program{.experiment = "consolidation"};
  program.particles = {.sizes = {SizeDistribution::Kind::normal, 29e-6, 6e-6, 12.5e-6, 37.5e-6},
                       .count = 100,
                       .seed = 1};
  const ContactParameters contact = {.restitution = 0.4,
                                     .friction = 0.3,
                                     .rolling_friction = 0.3,
                                     .cohesion_energy_density = 15833};
  program.materials = {8220, 5e6, 0.3, contact, contact};
  program.law.cohesion = ContactLaw::Cohesion::sjkr2;
  program.law.rolling = ContactLaw::Rolling::epsd2;
  program.domain.lower = {0, 0, -1e-5};
  program.domain.upper = {1.5e-4, 1.5e-4, 3.2e-4};
  program.walls = {{.name = "floor"},
                   {.name = "lid", .position = 2.5e-4, .facing_positive = false}};
  program.time_step = 0.2 * RayleighTime(6.25e-6, 8220, 5e6, 0.3);
  program.stages = {Insert{0, 2.5e-4, {0, 0, -0.1}},
                    Settle{.kinetic_energy_ratio = 0.18,
                           .check_interval = 2.7e-4,
                           .min_duration = 5e-4,
                           .max_duration = 0.02},
                    Servo{.wall = "lid", .stress = 900, .max_velocity = 0.1, .max_duration = 0.05},
                    Hold{.stress_tolerance = 0.02,
                         .strain_rate = 0.1,
                         .kinetic_energy_ratio = 1e-3,
                         .window = 5.4e-4,
                         .max_duration = 0.02}};
  return program;
}

Servo& ServoOf(Program& program) { return std::get<Servo>(program.stages[2]); }

Trace Simulate(const Program& program, RunContext context) {
  return MakeLiggghtsBackend()->Run(program, context);
}

TEST(Liggghts, IsTheVersionThatWasVerified) {
  const Availability availability = MakeLiggghtsBackend()->availability();
  ASSERT_TRUE(availability.available) << availability.why_not;
  EXPECT_EQ(availability.version, "3.8.0");
}

TEST(Liggghts, ConsolidatesToTheStressAndLeavesNoFiles) {
  const TemporaryFolder folder;
  const Program program = SmallConsolidation();
  const Trace trace = Simulate(program, {.work_folder = folder / "run"});
  ASSERT_TRUE(trace.outcome.ok()) << trace.outcome.message;
  EXPECT_FALSE(std::filesystem::exists(folder / "run"));
  ASSERT_NE(trace.Find("settle"), nullptr);
  const Moment* hold = trace.Find("hold");
  ASSERT_NE(hold, nullptr);
  EXPECT_EQ(hold->packing.size(), 100u);
  const WallState& lid = hold->walls.at("lid");
  const double area = 1.5e-4 * 1.5e-4;
  EXPECT_NEAR(lid.force[2] / area, 900, 18);
  EXPECT_GT(lid.height, 5e-5);
  EXPECT_LT(lid.height, 2.5e-4);
  for (const Sphere& sphere : hold->packing) {
    EXPECT_GT(sphere.position[2], 0.5 * sphere.radius);
    EXPECT_LT(sphere.position[2], lid.height - 0.5 * sphere.radius);
  }
  ASSERT_EQ(trace.series.size(), 1u);
  EXPECT_GT(trace.series[0].time.size(), 10u);
  EXPECT_NEAR(trace.series[0].normal_force.back() / area, 900, 18);
  EXPECT_EQ(
      trace.diagnostics.law,
      "gran model hertz tangential history cohesion sjkr2 rolling_friction epsd2 limitForce off "
      "torsionTorque on");
  EXPECT_GT(trace.diagnostics.steps, 1000);
}

TEST(Liggghts, SameSeedSameBits) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  const Trace first = Simulate(program, {.work_folder = folder / "a"});
  const Trace second = Simulate(program, {.work_folder = folder / "b"});
  program.particles.seed = 2;
  const Trace other = Simulate(program, {.work_folder = folder / "c"});
  ASSERT_TRUE(first.outcome.ok() && second.outcome.ok() && other.outcome.ok());
  EXPECT_EQ(first.Find("hold")->walls.at("lid").height,
            second.Find("hold")->walls.at("lid").height);
  EXPECT_EQ(first.Find("hold")->packing[7].position, second.Find("hold")->packing[7].position);
  EXPECT_NE(first.Find("hold")->walls.at("lid").height, other.Find("hold")->walls.at("lid").height);
}

TEST(Liggghts, TimeStepThatBlowsUp) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  program.time_step *= 20;
  const Trace trace = Simulate(program, {.work_folder = folder / "run"});
  EXPECT_EQ(trace.outcome.reason, Reason::unstable) << trace.outcome.message;
  EXPECT_THAT(trace.outcome.message, HasSubstr("Rayleigh"));
  EXPECT_TRUE(std::filesystem::exists(folder / "run/outcome.txt"))
      << "a failed run keeps its files";
  EXPECT_TRUE(std::filesystem::exists(folder / "run/in.deck"));
}

TEST(Liggghts, StressThatIsNeverReached) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  ServoOf(program).max_velocity = 1e-6;  // would take minutes of simulated time to arrive
  ServoOf(program).max_duration = 2e-3;
  std::get<Hold>(program.stages[3]).max_duration = 2e-3;
  const Trace trace = Simulate(program, {.work_folder = folder / "run"});
  EXPECT_EQ(trace.outcome.reason, Reason::not_quasi_static) << trace.outcome.message;
  EXPECT_THAT(trace.outcome.message, HasSubstr("instead of 900 Pa"));
}

TEST(Liggghts, BedThatStillMoves) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  std::get<Hold>(program.stages[3]).strain_rate = 1e-12;
  std::get<Hold>(program.stages[3]).max_duration = 3e-3;
  const Trace trace = Simulate(program, {.work_folder = folder / "run"});
  EXPECT_EQ(trace.outcome.reason, Reason::not_quasi_static) << trace.outcome.message;
  EXPECT_THAT(trace.outcome.message, HasSubstr("still moves"));
}

TEST(Liggghts, TimeLimit) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  std::get<Hold>(program.stages[3]).strain_rate = 1e-12;
  std::get<Hold>(program.stages[3]).max_duration = 100;
  const Trace trace = Simulate(
      program, {.work_folder = folder / "run", .time_limit = std::chrono::duration<double>(1.5)});
  EXPECT_EQ(trace.outcome.reason, Reason::timeout) << trace.outcome.message;
}

TEST(Liggghts, SimulatorKilledFromOutside) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  std::get<Hold>(program.stages[3]).strain_rate = 1e-12;
  std::get<Hold>(program.stages[3]).max_duration = 100;
  std::jthread killer([&](std::stop_token done) {
    while (!done.stop_requested()) {
      for (const pid_t pid : SimulatorsIn(folder / "run")) kill(pid, SIGKILL);
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  });
  const Trace trace = Simulate(
      program, {.work_folder = folder / "run", .time_limit = std::chrono::duration<double>(60)});
  EXPECT_EQ(trace.outcome.reason, Reason::crashed) << trace.outcome.message;
  EXPECT_THAT(trace.outcome.message, HasSubstr("signal 9"));
}

TEST(Liggghts, StopRequest) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  std::get<Hold>(program.stages[3]).strain_rate = 1e-12;
  std::get<Hold>(program.stages[3]).max_duration = 100;
  std::stop_source stop;
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    stop.request_stop();
  });
  const Trace trace = Simulate(program, {.work_folder = folder / "run", .stop = stop.get_token()});
  EXPECT_EQ(trace.outcome.reason, Reason::cancelled);
  EXPECT_TRUE(SimulatorsIn(folder / "run").empty()) << "no simulator is left behind";
}

TEST(Liggghts, TooFullASlabIsInvalidInput) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  std::get<Insert>(program.stages[0]).top = 1e-4;
  const Trace trace = Simulate(program, {.work_folder = folder / "run"});
  EXPECT_EQ(trace.outcome.reason, Reason::invalid_input);
  EXPECT_THAT(trace.outcome.message, HasSubstr("solid fraction"));
}

// Spheres of one size in a jittered lattice with gaps, as wide as a box of 5 by 4 diameters.
Packing Lattice(double d, const Vector3& origin) {
  RandomStream random(7);
  Packing packing;
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 4; ++x) {
        const auto along = [&](int i) { return (0.6 + 1.25 * i + 0.2 * random.Uniform()) * d; };
        const Vector3 at = {origin[0] + along(x), origin[1] + along(y), origin[2] + along(z)};
        packing.push_back({static_cast<std::int64_t>(packing.size()) + 1, d / 2, at, {}, {}});
      }
    }
  }
  return packing;
}

// An explicit packing in an open box of six planes, far from the origin; loaded by the servo.
Program SixWalls() {
  const double d = 29e-6;
  const Vector3 lower = {-4e-4, 3e-4, -9e-4};
  const Vector3 upper = {lower[0] + 5 * d, lower[1] + 4 * d, lower[2] + 11 * d};
  Program program = SmallConsolidation();
  program.particles = {.packing = Lattice(d, lower)};
  program.materials.particle_wall.cohesion_energy_density = 0;
  program.domain = {lower, upper, {Boundary::open, Boundary::open, Boundary::open}};
  program.walls.clear();
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name = std::string(1, "xyz"[axis]);
    program.walls.push_back(
        {.name = name + "-", .axis = axis, .position = lower[axis], .frictionless = axis < 2});
    program.walls.push_back({.name = name + "+",
                             .axis = axis,
                             .position = upper[axis],
                             .facing_positive = false,
                             .frictionless = axis < 2});
  }
  program.time_step = 0.2 * RayleighTime(d / 2, 8220, 5e6, 0.3);
  ServoOf(program).wall = "z+";
  return program;
}

TEST(Liggghts, ExplicitPackingInABoxOfSixWalls) {
  for (const Boundary x : {Boundary::open, Boundary::periodic}) {
    const TemporaryFolder folder;
    Program program = SixWalls();
    program.domain.boundaries[0] = x;
    if (x == Boundary::periodic) {
      std::erase_if(program.walls, [](const PlaneWall& wall) { return wall.axis == 0; });
      // The servo needs nothing before it.
      program.stages.erase(program.stages.begin(), program.stages.begin() + 2);
    }
    const Trace trace = Simulate(program, {.work_folder = folder / "run"});
    ASSERT_TRUE(trace.outcome.ok()) << trace.outcome.message;
    const Moment& hold = *trace.Find("hold");
    ASSERT_EQ(hold.packing.size(), 96u);
    const WallState& lid = hold.walls.at("z+");
    EXPECT_NEAR(lid.force[2] / program.domain.BaseArea(), 900, 18);
    EXPECT_LT(lid.height, program.domain.upper[2]);
    EXPECT_LT(lid.displacement[2], 0);
    EXPECT_GT(trace.diagnostics.kinetic_energy_ratio, 0);
    for (const Sphere& sphere : hold.packing) {
      for (const int axis : {0, 1}) {
        const double margin = program.domain.boundaries[axis] == Boundary::open ? 1.2e-5 : 0;
        EXPECT_GE(sphere.position[axis], program.domain.lower[axis] + margin);
        EXPECT_LE(sphere.position[axis], program.domain.upper[axis] - margin);
      }
    }
  }
}

// Stages of a kind more than once, and in another order than a consolidation's.
TEST(Liggghts, StagesInManyOrders) {
  const TemporaryFolder folder;
  Program program = SixWalls();
  const Settle settle = {.kinetic_energy_ratio = 0.18,
                         .check_interval = 2.7e-4,
                         .min_duration = 5e-4,
                         .max_duration = 2e-3};
  const Servo servo = ServoOf(program);
  const Hold hold = std::get<Hold>(program.stages[3]);
  const double step = program.time_step;
  program.stages = {Advance{.name = "first", .duration = 10 * step},
                    settle,
                    settle,
                    servo,
                    Advance{.name = "under load", .duration = 250 * step, .packing_every = 100},
                    hold,
                    settle,
                    hold};
  const Trace trace = Simulate(program, {.work_folder = folder / "run"});
  ASSERT_TRUE(trace.outcome.ok()) << trace.outcome.message;
  std::vector<std::string> names;
  for (const Moment& moment : trace.moments) names.push_back(moment.name);
  EXPECT_THAT(names, ElementsAre("first", "settle", "settle", "servo", "under load", "under load",
                                 "under load", "hold", "settle", "hold"));
  for (std::size_t i = 1; i < trace.moments.size(); ++i) {
    EXPECT_GT(trace.moments[i].time, trace.moments[i - 1].time) << i;
  }
  EXPECT_NEAR(trace.moments[0].time, 10 * step, 1e-3 * step);
  EXPECT_NEAR(trace.moments[4].time - trace.moments[3].time, 100 * step, 1e-3 * step);
  EXPECT_NEAR(trace.moments[6].time - trace.moments[3].time, 250 * step, 1e-3 * step);
  EXPECT_FALSE(trace.moments[2].walls.contains("z+")) << "not there yet";
  EXPECT_EQ(trace.moments[2].walls.at("x-").height, -4e-4);
  for (const std::size_t loaded : {3, 6, 7, 8, 9}) {
    const WallState& lid = trace.moments[loaded].walls.at("z+");
    EXPECT_GT(lid.force[2], 0) << loaded;
    EXPECT_LT(lid.displacement[2], 0) << loaded;
  }
  EXPECT_NEAR(trace.moments[9].walls.at("z+").force[2] / program.domain.BaseArea(), 900, 18);
}

TEST(Liggghts, PackingsOnTheWayAreThoseOfShorterRuns) {
  const TemporaryFolder folder;
  Program program = SixWalls();
  for (Sphere& sphere : *program.particles.packing) {
    sphere.velocity = {0.1 * std::sin(7.0 * static_cast<double>(sphere.id)), 0.05, -0.1};
  }
  const double step = program.time_step;
  program.stages = {Advance{.name = "fly", .duration = 300 * step, .packing_every = 75}};
  const Trace whole = Simulate(program, {.work_folder = folder / "whole"});
  ASSERT_EQ(whole.moments.size(), 4u) << whole.outcome.message;
  program.stages = {Advance{.name = "fly", .duration = 150 * step}};
  const Trace half = Simulate(program, {.work_folder = folder / "half"});
  ASSERT_EQ(half.moments.size(), 1u) << half.outcome.message;
  EXPECT_EQ(whole.moments[1].time, half.moments[0].time);
  for (std::size_t i = 0; i < half.moments[0].packing.size(); ++i) {
    EXPECT_EQ(whole.moments[1].packing[i].position, half.moments[0].packing[i].position);
    EXPECT_EQ(whole.moments[1].packing[i].spin, half.moments[0].packing[i].spin);
  }
}

class LiggghtsUnsupported : public ::testing::Test {
 protected:
  std::string Reason() const { return MakeLiggghtsBackend()->ExplainUnsupported(program_); }
  Program program_ = SmallConsolidation();
};

TEST_F(LiggghtsUnsupported, OtherProgramsAreNot) {
  EXPECT_EQ(Reason(), "");
  program_ = SixWalls();
  EXPECT_EQ(Reason(), "");
  program_.stages = {Advance{.duration = 1e-3}};
  EXPECT_EQ(Reason(), "") << "an explicit packing needs no insertion";
}

TEST_F(LiggghtsUnsupported, RunSaysSo) {
  program_.law.shear_update = ContactLaw::ShearUpdate::incremental;
  EXPECT_EQ(Simulate(program_, {}).outcome.reason, Reason::unsupported);
}

TEST_F(LiggghtsUnsupported, LawsThatItHasNot) {
  program_.law.shear_update = ContactLaw::ShearUpdate::incremental;
  EXPECT_THAT(Reason(), HasSubstr("displacement"));
  program_.law.tangential = ContactLaw::Tangential::no_history;
  EXPECT_EQ(Reason(), "") << "nothing to update";
  program_.materials.particle_wall.restitution = 0.05;
  EXPECT_THAT(Reason(), HasSubstr("above 0.05"));
  program_.law.normal = ContactLaw::Normal::linear;
  EXPECT_EQ(Reason(), "") << "the linear law looks at no restitution";
}

TEST_F(LiggghtsUnsupported, DmtBeyondEqualSpheresAndDryWalls) {
  program_.law.cohesion = ContactLaw::Cohesion::dmt;
  EXPECT_THAT(Reason(), HasSubstr("one size"));
  program_.particles.sizes = {SizeDistribution::Kind::monodisperse, 29e-6};
  EXPECT_EQ(Reason(), "");
  program_.materials.particle_wall.surface_energy = 1e-4;
  EXPECT_THAT(Reason(), HasSubstr("at walls"));
  for (PlaneWall& wall : program_.walls) wall.frictionless = true;
  EXPECT_EQ(Reason(), "") << "frictionless walls do not stick";
  program_.particles.packing = {{1, 1e-5, {}, {}, {}}, {2, 2e-5, {}, {}, {}}};
  EXPECT_THAT(Reason(), HasSubstr("one size"));
}

TEST_F(LiggghtsUnsupported, Domains) {
  program_.domain.boundaries[1] = Boundary::outflow;
  EXPECT_EQ(Reason(), "");
  program_.domain.boundaries[1] = Boundary::periodic;
  program_.domain.upper[0] = 7e-5;
  EXPECT_THAT(Reason(), HasSubstr("less than two particles wide"));
  program_ = SmallConsolidation();
  program_.walls.push_back({.name = "side", .axis = 0});
  EXPECT_THAT(Reason(), AllOf(HasSubstr("'side'"), HasSubstr("periodic")));
  program_ = SixWalls();
  program_.particles.contacts = {{1, 2, {}, {}}};
  EXPECT_THAT(Reason(), HasSubstr("contact history"));
}

Mesh Plate(double size, double z) {
  return {.name = "plate",
          .vertices = {{0, 0, z}, {size, 0, z}, {size, size, z}},
          .triangles = {{0, 1, 2}}};
}

TEST_F(LiggghtsUnsupported, Bodies) {
  program_.meshes = {{.name = "blade"}};
  EXPECT_THAT(Reason(), HasSubstr("'blade' has no triangles"));
  program_.meshes = {Plate(9e-5, 5e-5)};
  EXPECT_THAT(Reason(), HasSubstr("too small for LIGGGHTS"));
  program_.meshes = {Plate(1.1e-4, 5e-5)};
  EXPECT_EQ(Reason(), "");
  program_.groups = {{.name = "base", .ids = {1}}};
  EXPECT_THAT(Reason(), HasSubstr("explicit packing"));
  program_ = SixWalls();
  program_.groups = {{.name = "base", .ids = {1, 2}}, {.name = "top", .ids = {2}}};
  EXPECT_THAT(Reason(), AllOf(HasSubstr("'top'"), HasSubstr("particle 2")));
  program_.groups.pop_back();
  EXPECT_EQ(Reason(), "");
}

TEST_F(LiggghtsUnsupported, SlabsAtWalls) {
  program_.stress_slab = {5e-5, 1e-4};
  EXPECT_EQ(Reason(), "");
  program_.stress_slab = {3e-5, 1e-4};
  EXPECT_THAT(Reason(), HasSubstr("of 'floor'"));
  program_.stress_slab = {5e-5, 1e-4};
  program_.meshes = {Plate(1.2e-4, 1.3e-4)};
  EXPECT_THAT(Reason(), HasSubstr("of 'plate'"));
  program_ = SixWalls();
  program_.stress_slab = {-8e-4, -7.5e-4};
  EXPECT_THAT(Reason(), HasSubstr("of 'x-'"));
}

TEST_F(LiggghtsUnsupported, Stages) {
  program_.meshes = {Plate(1.2e-4, 2e-4)};
  const std::vector<Stage> stages = program_.stages;
  const auto reason_of = [&](std::vector<Stage> other) {
    program_.stages = std::move(other);
    return Reason();
  };
  const Servo& servo = std::get<Servo>(stages[2]);
  EXPECT_THAT(reason_of({stages[1]}), HasSubstr("begin with insert"));
  EXPECT_THAT(reason_of({stages[0]}), HasSubstr("no stage beyond insert"));
  EXPECT_THAT(reason_of({stages[0], Save{}}), HasSubstr("no stage beyond insert"));
  EXPECT_THAT(reason_of({stages[0], stages[1], stages[0]}), HasSubstr("beginning only"));
  EXPECT_THAT(reason_of({stages[0], stages[3]}),
              AllOf(HasSubstr("stage 1 (hold)"), HasSubstr("no servo before it")));
  EXPECT_EQ(reason_of({stages[0], servo, servo}), "");
  Servo other = servo;
  other.wall = "plate";
  EXPECT_THAT(reason_of({stages[0], servo, other}), HasSubstr("only one servo, and 'lid' has it"));
  EXPECT_EQ(reason_of({stages[0], other}), "");
  EXPECT_THAT(reason_of({stages[0], Servo{.wall = "top"}}), HasSubstr("no wall, mesh or group"));
  EXPECT_THAT(reason_of({stages[0], Servo{.wall = "floor"}}), HasSubstr("has to face down"));
  EXPECT_THAT(reason_of({stages[0], Deform{}}), HasSubstr("Lees-Edwards"));
  EXPECT_THAT(reason_of({stages[0], Save{"a"}, Save{"a"}}), HasSubstr("two states 'a'"));
  EXPECT_THAT(reason_of({stages[0], Save{"a"}, Restore{"b"}}), HasSubstr("no state 'b'"));
  EXPECT_EQ(reason_of({stages[0], Save{"a"}, servo, Restore{"a"}, servo}), "");
  EXPECT_THAT(reason_of({stages[0], Save{"a"}, servo, Restore{"a"}, stages[3]}),
              HasSubstr("no servo before it"));
  EXPECT_THAT(reason_of({stages[0], Remove{"plate"}, Remove{"plate"}}),
              HasSubstr("removed before"));
  EXPECT_EQ(reason_of({stages[0], Save{}, Remove{"plate"}, Restore{}, Remove{"plate"}, stages[1]}),
            "");
  EXPECT_THAT(reason_of({stages[0], servo, Remove{"lid"}}), HasSubstr("'lid' has a servo"));
}

TEST_F(LiggghtsUnsupported, Motions) {
  program_.meshes = {Plate(1.2e-4, 2e-4)};
  const auto reason_of = [&](const Motion& motion) {
    program_.stages = {program_.stages[0], Advance{.motions = {motion}}};
    return Reason();
  };
  EXPECT_EQ(reason_of({.body = "plate", .velocity = {1, 2, 3}}), "");
  EXPECT_THAT(reason_of({.body = "plate", .spin = {0, 0, 1}}), HasSubstr("turns"));
  EXPECT_THAT(reason_of({.body = "floor"}), HasSubstr("not 'floor'"));
  EXPECT_THAT(reason_of({.body = "blade"}), HasSubstr("no wall, mesh or group 'blade'"));
  program_ = SmallConsolidation();
  program_.stages.push_back(Advance{.motions = {{.body = "lid"}}});
  EXPECT_THAT(Reason(), HasSubstr("not 'lid'"));
}

TEST(LiggghtsAvailability, AbsentFromPath) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nonexistent", 1);
  const Availability availability = MakeLiggghtsBackend()->availability();
  setenv("PATH", path.c_str(), 1);
  EXPECT_FALSE(availability.available);
  EXPECT_THAT(availability.why_not, HasSubstr("apt-get install liggghts"));
}

// What the reader makes of records that a run cannot easily be made to leave.
class LiggghtsResult : public ::testing::Test {
 protected:
  Trace Read(const std::string& screen,
             ProcessResult process = {.end = ProcessResult::End::exited, .exit_status = 0}) {
    WriteFileAtomically(folder_ / liggghts::kScreenFile, screen);
    return liggghts::ReadTrace(SmallConsolidation(), 100, folder_.path(), process);
  }
  TemporaryFolder folder_;
};

TEST_F(LiggghtsResult, StatusZeroWithoutARecordIsACrash) {
  EXPECT_EQ(Read("PC START n=100\n").outcome.reason, Reason::crashed);
}

TEST_F(LiggghtsResult, ErrorBeforeTheFirstStepIsInvalidInput) {
  const Trace trace =
      Read("ERROR: Illegal fix wall/gran\n", {.end = ProcessResult::End::exited, .exit_status = 1});
  EXPECT_EQ(trace.outcome.reason, Reason::invalid_input);
  EXPECT_THAT(trace.outcome.message, HasSubstr("Illegal fix"));
}

TEST_F(LiggghtsResult, LostAtomsAtAGoodTimeStepAreLostParticles) {
  const Trace trace = Read(
      "PC START n=100\nPC CHECK stage=1 step=100 ke=1e-16\nERROR: Lost atoms: original 100 current "
      "99\n",
      {.end = ProcessResult::End::exited, .exit_status = 1});
  EXPECT_EQ(trace.outcome.reason, Reason::lost_particles);
}

TEST_F(LiggghtsResult, RecordsSkipTheEchoOfTheCommand) {
  const auto records = liggghts::ReadRecords(
      "print \"PC END step=${now}\"\nPC END step=12 p=-9.5e2\n\xff\xfe junk\n");
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].values.at("step"), 12);
  EXPECT_EQ(records[0].values.at("p"), -950);
}

}  // namespace
}  // namespace powdercal

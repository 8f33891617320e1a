#include "backends/yade/yade.h"

#include <gmock/gmock.h>

#include <thread>

#include "backends/yade/driver.h"
#include "backends/yade/job.h"
#include "backends/yade/result.h"
#include "tests/support/program.h"
#include "tests/support/simulators.h"

// The real YADE throughout, on beds of 60 particles.

namespace powdercal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kDiameter = 29e-6;

// Between planes, as the consolidation experiment has it with `sides: walls`.
Program SmallConsolidation() {
  Program program{.experiment = "consolidation"};
  program.particles = {.sizes = {SizeDistribution::Kind::normal, kDiameter, 3e-6, 20e-6, 37.5e-6},
                       .count = 60,
                       .seed = 1};
  const ContactParameters contact = {.restitution = 0.4, .friction = 0.3};
  program.materials = {8220, 5e6, 0.3, contact, contact};
  program.law = {.limit_force = true, .shear_update = ContactLaw::ShearUpdate::incremental};
  const double width = 4 * kDiameter;
  program.domain = {
      {0, 0, -1e-5}, {width, width, 3e-4}, {Boundary::open, Boundary::open, Boundary::open}};
  program.walls = {{.name = "floor"},
                   {.name = "lid", .position = 2.5e-4, .facing_positive = false}};
  for (const int axis : {0, 1}) {
    program.walls.push_back(
        {.name = "low " + std::to_string(axis), .axis = axis, .frictionless = true});
    program.walls.push_back({.name = "high " + std::to_string(axis),
                             .axis = axis,
                             .position = width,
                             .facing_positive = false,
                             .frictionless = true});
  }
  program.time_step = 0.2 * RayleighTime(10e-6, 8220, 5e6, 0.3);
  program.stages = {Insert{0, 2.5e-4, {0, 0, -0.1}},
                    Settle{.kinetic_energy_ratio = 0.18,
                           .check_interval = 2.7e-4,
                           .min_duration = 5e-4,
                           .max_duration = 2e-3},
                    Servo{.wall = "lid", .stress = 900, .max_velocity = 0.1, .max_duration = 0.05},
                    Hold{.stress_tolerance = 0.02,
                         .strain_rate = 0.1,
                         .kinetic_energy_ratio = 1e-3,
                         .window = 5.4e-4,
                         .max_duration = 0.02}};
  return program;
}

Hold& HoldOf(Program& program) { return std::get<Hold>(program.stages[3]); }

// Goes on until it is stopped.
Program Endless() {
  Program program = SmallConsolidation();
  HoldOf(program).strain_rate = 1e-12;
  HoldOf(program).max_duration = 100;
  return program;
}

Program FullyPeriodic() {
  Program program = SmallConsolidation();
  program.walls.clear();
  program.gravity = {};
  program.domain = {{0, 0, 0},
                    {4 * kDiameter, 4 * kDiameter, 5 * kDiameter},
                    {Boundary::periodic, Boundary::periodic, Boundary::periodic}};
  Deform deform{.duration = 1e-4, .shear_rate = 100};
  deform.edges[2] = {EdgeControl::Kind::stress, 900};
  program.stages = {Insert{.bottom = 0, .top = 5 * kDiameter}, deform};
  return program;
}

Trace Simulate(const Program& program, const RunContext& context) {
  return MakeYadeBackend()->Run(program, context);
}

TEST(Yade, IsTheVersionThatWasVerified) {
  const Availability availability = MakeYadeBackend()->availability();
  ASSERT_TRUE(availability.available) << availability.why_not;
  EXPECT_EQ(availability.version, "2023.02a");
}

TEST(Yade, ConsolidatesToTheStressAndLeavesNoFiles) {
  const TemporaryFolder folder;
  const Program program = SmallConsolidation();
  const Trace trace = Simulate(program, {.work_folder = folder / "run"});
  ASSERT_TRUE(trace.outcome.ok()) << trace.outcome.message;
  EXPECT_FALSE(std::filesystem::exists(folder / "run"));
  ASSERT_NE(trace.Find("settle"), nullptr);
  EXPECT_FALSE(trace.Find("settle")->walls.contains("lid")) << "not there yet";
  const Moment* hold = trace.Find("hold");
  ASSERT_NE(hold, nullptr);
  EXPECT_EQ(hold->packing.size(), 60u);
  const WallState& lid = hold->walls.at("lid");
  EXPECT_NEAR(lid.force[2] / program.domain.BaseArea(), 900, 18);
  EXPECT_LT(lid.displacement[2], 0);
  const WallState& floor = hold->walls.at("floor");
  EXPECT_NEAR(floor.force[2] / lid.force[2], -1, 0.05);
  for (const Sphere& sphere : hold->packing) {
    EXPECT_GT(sphere.position[2], 0.5 * sphere.radius);
    EXPECT_LT(sphere.position[2], lid.height - 0.5 * sphere.radius);
  }
  ASSERT_EQ(trace.series.size(), 1u);
  EXPECT_EQ(trace.series[0].wall, "lid");
  EXPECT_GT(trace.series[0].time.size(), 10u);
  EXPECT_NEAR(trace.series[0].normal_force.back(), lid.force[2], 0.02 * lid.force[2]);
  EXPECT_THAT(trace.diagnostics.law, HasSubstr("Mindlin"));
  EXPECT_GT(trace.diagnostics.steps, 1000);
  EXPECT_GT(trace.diagnostics.kinetic_energy_ratio, 0);
  EXPECT_GT(trace.diagnostics.max_overlap, 0);
}

TEST(Yade, SameSeedSameBits) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  program.stages.resize(2);
  const Trace first = Simulate(program, {.work_folder = folder / "a"});
  const Trace second = Simulate(program, {.work_folder = folder / "b"});
  ASSERT_TRUE(first.outcome.ok() && second.outcome.ok());
  for (std::size_t n = 0; n < 60; ++n) {
    EXPECT_EQ(first.moments[0].packing[n].position, second.moments[0].packing[n].position);
    EXPECT_EQ(first.moments[0].packing[n].spin, second.moments[0].packing[n].spin);
  }
}

// --- Ways to fail -------------------------------------------------------------------------------

TEST(Yade, TimeStepThatBlowsUp) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  program.time_step *= 20;
  const Trace trace = Simulate(program, {.work_folder = folder / "run"});
  EXPECT_EQ(trace.outcome.reason, Reason::unstable) << trace.outcome.message;
  EXPECT_TRUE(std::filesystem::exists(folder / "run/outcome.txt"))
      << "a failed run keeps its files";
  EXPECT_TRUE(std::filesystem::exists(folder / "run/job.json"));
}

TEST(Yade, ParticlesThatLeaveAreLost) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  std::erase_if(program.walls, [](const PlaneWall& wall) { return wall.name == "high 0"; });
  const Trace trace = Simulate(program, {.work_folder = folder / "run"});
  EXPECT_EQ(trace.outcome.reason, Reason::lost_particles) << trace.outcome.message;
  EXPECT_GT(trace.diagnostics.lost_particles, 0);
}

TEST(Yade, ParticlesMayLeaveThroughAnOutflowSide) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  std::erase_if(program.walls, [](const PlaneWall& wall) { return wall.name == "high 0"; });
  program.domain.boundaries[0] = Boundary::outflow;
  program.stages.resize(2);
  const Trace trace = Simulate(program, {.work_folder = folder / "run"});
  ASSERT_TRUE(trace.outcome.ok()) << trace.outcome.message;
  EXPECT_GT(trace.diagnostics.leavers, 0);
  EXPECT_EQ(trace.moments[0].packing.size() + static_cast<std::size_t>(trace.diagnostics.leavers),
            60u);
}

TEST(Yade, StressThatIsNeverReached) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  std::get<Servo>(program.stages[2]).max_velocity = 1e-6;
  std::get<Servo>(program.stages[2]).max_duration = 5e-4;
  HoldOf(program).max_duration = 5e-4;
  const Trace trace = Simulate(program, {.work_folder = folder / "run"});
  EXPECT_EQ(trace.outcome.reason, Reason::not_quasi_static) << trace.outcome.message;
  EXPECT_THAT(trace.outcome.message, HasSubstr("instead of 900 Pa"));
}

TEST(Yade, HangEndsAtTheTimeLimit) {
  const TemporaryFolder folder;
  const Trace trace = Simulate(
      Endless(), {.work_folder = folder / "run", .time_limit = std::chrono::duration<double>(4)});
  EXPECT_EQ(trace.outcome.reason, Reason::timeout) << trace.outcome.message;
  EXPECT_TRUE(SimulatorsIn(folder / "run", "python3").empty());
}

TEST(Yade, KilledFromOutsideItIsACrash) {
  const TemporaryFolder folder;
  std::jthread killer([&](std::stop_token done) {
    std::error_code ignored;
    while (!done.stop_requested()) {  // once YADE is at work
      const auto size = std::filesystem::file_size(folder / "run/result.jsonl", ignored);
      if (!ignored && size > 0) {
        for (const pid_t pid : SimulatorsIn(folder / "run", "python3")) kill(pid, SIGSEGV);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  });
  const Trace trace = Simulate(
      Endless(), {.work_folder = folder / "run", .time_limit = std::chrono::duration<double>(100)});
  EXPECT_EQ(trace.outcome.reason, Reason::crashed) << trace.outcome.message;
  EXPECT_THAT(trace.outcome.message, AllOf(HasSubstr("signal 11"), HasSubstr("stage")));
}

TEST(Yade, StopRequest) {
  const TemporaryFolder folder;
  std::stop_source stop;
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    stop.request_stop();
  });
  const Trace trace =
      Simulate(Endless(), {.work_folder = folder / "run", .stop = stop.get_token()});
  EXPECT_EQ(trace.outcome.reason, Reason::cancelled);
  EXPECT_TRUE(SimulatorsIn(folder / "run", "python3").empty()) << "no simulator is left behind";
}

TEST(Yade, TooFullASlabIsInvalidInput) {
  const TemporaryFolder folder;
  Program program = SmallConsolidation();
  std::get<Insert>(program.stages[0]).top = 8e-5;
  const Trace trace = Simulate(program, {.work_folder = folder / "run"});
  EXPECT_EQ(trace.outcome.reason, Reason::invalid_input);
  EXPECT_THAT(trace.outcome.message, HasSubstr("solid fraction"));
}

// What the reader makes of files that a run cannot easily be made to leave.
class YadeResult : public ::testing::Test {
 protected:
  Trace Read(const std::string& text,
             ProcessResult process = {.end = ProcessResult::End::exited, .exit_status = 0}) {
    WriteFileAtomically(folder_ / yade::kResultFile, text);
    return yade::ReadTrace(SmallConsolidation(), folder_ / yade::kResultFile, process);
  }
  TemporaryFolder folder_;
};

TEST_F(YadeResult, StatusZeroWithoutAnEndIsACrash) {
  const Trace trace = Read("{\"record\": \"stage\", \"index\": 1, \"step\": 0}\n");
  EXPECT_EQ(trace.outcome.reason, Reason::crashed);
  EXPECT_THAT(trace.outcome.message, HasSubstr("in stage 1 (settle)"));
}

TEST_F(YadeResult, LinesThatWereCutShortAreNotRead) {
  const Trace trace = Read("{\"record\": \"end\", \"reason\": \"ok\", \"message\": \"\"}");
  EXPECT_EQ(trace.outcome.reason, Reason::crashed);
}

TEST_F(YadeResult, DamagedLinesAreACrash) {
  EXPECT_EQ(Read("{\"record\": \"moment\"}\n").outcome.reason, Reason::crashed);
}

TEST_F(YadeResult, AnExceptionInPythonIsNamed) {
  const Trace trace = Read("", {.end = ProcessResult::End::exited,
                                .exit_status = 1,
                                .output = "Traceback …\nRuntimeError: no such thing\n"});
  EXPECT_EQ(trace.outcome.reason, Reason::crashed);
  EXPECT_THAT(trace.outcome.message, HasSubstr("RuntimeError: no such thing"));
}

// --- Where YADE is ------------------------------------------------------------------------------

TEST(YadeAvailability, WithoutThePackage) {
  const TemporaryFolder folder;
  const Availability availability =
      MakeYadeBackend({.modules = folder / "nothing"})->availability();
  EXPECT_FALSE(availability.available);
  EXPECT_THAT(availability.why_not, HasSubstr("apt-get install yade"));
}

TEST(YadeAvailability, WithoutItsPython) {
  const Availability availability = MakeYadeBackend({.python = "/nonexistent"})->availability();
  EXPECT_FALSE(availability.available);
  EXPECT_THAT(availability.why_not, HasSubstr("/nonexistent"));
}

// An interpreter that refuses to import numpy, as one without it does.
TEST(YadeAvailability, WithAPythonThatLacksNumpy) {
  const TemporaryFolder folder;
  const std::filesystem::path python = folder / "python3";
  std::ofstream(python) << "#!/bin/sh\necho \"ModuleNotFoundError: No module named 'numpy'\" >&2\n"
                           "exit 1\n";
  std::filesystem::permissions(python, std::filesystem::perms::owner_all);
  const Availability availability = MakeYadeBackend({.python = python})->availability();
  EXPECT_FALSE(availability.available);
  EXPECT_THAT(availability.why_not, AllOf(HasSubstr("cannot import"), HasSubstr("'numpy'")));
}

TEST(YadeAvailability, AnotherPythonFirstOnPathIsNotAsked) {
  const TemporaryFolder folder;
  const std::filesystem::path python = folder / "python3";
  std::ofstream(python) << "#!/bin/sh\nexit 1\n";
  std::filesystem::permissions(python, std::filesystem::perms::owner_all);
  const std::string path = std::getenv("PATH");
  setenv("PATH", (folder.path().string() + ":" + path).c_str(), 1);
  setenv("PYTHONHOME", "/nonexistent", 1);
  Program program = SmallConsolidation();
  program.stages = {program.stages[0], Advance{.duration = 10 * program.time_step}};
  const Trace trace = Simulate(program, {.work_folder = folder / "run"});
  setenv("PATH", path.c_str(), 1);
  unsetenv("PYTHONHOME");
  EXPECT_TRUE(trace.outcome.ok()) << trace.outcome.message;
}

// --- What it cannot do --------------------------------------------------------------------------

class YadeUnsupported : public ::testing::Test {
 protected:
  std::string Reason() const { return MakeYadeBackend()->ExplainUnsupported(program_); }
  void OneSize() { program_.particles.sizes = {SizeDistribution::Kind::monodisperse, kDiameter}; }
  ContactParameters& particle() { return program_.materials.particle_particle; }
  ContactParameters& wall() { return program_.materials.particle_wall; }

  Program program_ = SmallConsolidation();
};

TEST_F(YadeUnsupported, OtherProgramsAreNot) {
  EXPECT_EQ(Reason(), "");
  program_ = FullyPeriodic();
  EXPECT_EQ(Reason(), "");
}

TEST_F(YadeUnsupported, RunSaysSo) {
  program_.law.cohesion = ContactLaw::Cohesion::sjkr2;
  particle().cohesion_energy_density = 1000;
  const Trace trace = Simulate(program_, {});
  EXPECT_EQ(trace.outcome.reason, Reason::unsupported);
  EXPECT_THAT(trace.outcome.message, AllOf(HasSubstr("SJKR2"), HasSubstr("dmt")));
}

TEST_F(YadeUnsupported, TangentialLaws) {
  program_.law.shear_update = ContactLaw::ShearUpdate::displacement;
  EXPECT_THAT(Reason(), HasSubstr("use shear_update: incremental"));
  program_.law.normal = ContactLaw::Normal::linear;
  program_.materials.linear = {.normal = 20, .tangential = 8};
  EXPECT_EQ(Reason(), "") << "with a constant stiffness both are one";
  program_.law.tangential = ContactLaw::Tangential::no_history;
  EXPECT_THAT(Reason(), HasSubstr("use tangential: history"));
  particle().friction = wall().friction = 0;
  EXPECT_EQ(Reason(), "") << "nothing to remember";
}

TEST_F(YadeUnsupported, DashpotsThatPull) {
  program_.law.limit_force = false;
  EXPECT_THAT(Reason(), HasSubstr("use limit_force: true"));
  particle().restitution = wall().restitution = 1;
  EXPECT_EQ(Reason(), "") << "no dashpot";
}

TEST_F(YadeUnsupported, Cohesion) {
  program_.law.cohesion = ContactLaw::Cohesion::sjkr2;
  EXPECT_EQ(Reason(), "") << "without an energy density there is none";
  wall().cohesion_energy_density = 1;
  EXPECT_THAT(Reason(), HasSubstr("no SJKR2"));
  program_.law.cohesion = ContactLaw::Cohesion::dmt;
  EXPECT_EQ(Reason(), "");
  particle().surface_energy = 1e-4;
  EXPECT_THAT(Reason(), HasSubstr("at frictionless walls too"));
  for (PlaneWall& plane : program_.walls) plane.frictionless = false;
  EXPECT_THAT(Reason(), HasSubstr("one surface energy"));
  wall().surface_energy = 1e-4;
  EXPECT_EQ(Reason(), "");
  program_.law.tangential_reduce = true;
  EXPECT_THAT(Reason(), HasSubstr("use tangential_reduce: false"));
  program_.law.tangential_reduce = false;
  program_.law.normal = ContactLaw::Normal::linear;
  program_.materials.linear = {.normal = 20, .tangential = 8};
  EXPECT_THAT(Reason(), HasSubstr("with the Hertz law only"));
}

TEST_F(YadeUnsupported, RollingFriction) {
  program_.law.rolling = ContactLaw::Rolling::cdt;
  EXPECT_EQ(Reason(), "") << "without friction there is none";
  particle().rolling_friction = 0.2;
  EXPECT_THAT(Reason(), HasSubstr("no CDT"));
  program_.law.rolling = ContactLaw::Rolling::epsd2;
  EXPECT_THAT(Reason(), HasSubstr("use torsion: false"));
  program_.law.torsion = false;
  EXPECT_THAT(Reason(), HasSubstr("at planes and meshes"));
  const ContactLaw law = program_.law;
  const Materials materials = program_.materials;
  program_ = FullyPeriodic();
  program_.law = law;
  program_.materials = materials;
  EXPECT_THAT(Reason(), HasSubstr("one size"));
  OneSize();
  EXPECT_EQ(Reason(), "");
  program_.law.cohesion = ContactLaw::Cohesion::dmt;
  particle().surface_energy = 1e-4;
  EXPECT_THAT(Reason(), HasSubstr("rolling: none with DMT"));
}

TEST_F(YadeUnsupported, LinearLawInACellThatDeforms) {
  program_ = FullyPeriodic();
  program_.law.normal = ContactLaw::Normal::linear;
  program_.materials.linear = {.normal = 20, .tangential = 8};
  EXPECT_THAT(Reason(), HasSubstr("wrong sign"));
  program_.stages[1] = Advance{.duration = 1e-4};
  EXPECT_EQ(Reason(), "");
}

TEST_F(YadeUnsupported, Domains) {
  program_.domain.boundaries[1] = Boundary::periodic;
  EXPECT_THAT(Reason(), AllOf(HasSubstr("periodic along y"), HasSubstr("sides: walls")));
  program_ = FullyPeriodic();
  program_.walls = {{.name = "floor"}};
  EXPECT_THAT(Reason(), HasSubstr("planes and meshes do not work"));
  program_ = FullyPeriodic();
  program_.domain.upper[0] = 2 * kDiameter;
  EXPECT_THAT(Reason(), HasSubstr("periodic along x"));
  program_ = SmallConsolidation();
  program_.stress_slab = {1e-5, 5e-5};
  EXPECT_THAT(Reason(), HasSubstr("slab"));
}

TEST_F(YadeUnsupported, StagesAndBodies) {
  program_.stages.push_back(Advance{.motions = {{.body = "lid", .spin = {0, 0, 1}}}});
  EXPECT_THAT(Reason(), HasSubstr("turns"));
  program_.stages.back() = Deform{};
  EXPECT_THAT(Reason(), HasSubstr("periodic in x, y and z"));
  program_.stages.back() = Servo{.wall = "floor", .stress = 1, .max_velocity = 1};
  EXPECT_THAT(Reason(), HasSubstr("only one servo, and 'lid' has it"));
  program_.stages.back() = Remove{"lid"};
  EXPECT_THAT(Reason(), HasSubstr("'lid' has a servo"));
  program_.stages.back() = Remove{"gate"};
  EXPECT_THAT(Reason(), HasSubstr("no wall, mesh or group 'gate'"));
  program_.stages.back() = Restore{"state"};
  EXPECT_THAT(Reason(), HasSubstr("no state 'state' was saved"));
  program_.stages.pop_back();
  program_.meshes = {{.name = "blade"}};
  EXPECT_THAT(Reason(), HasSubstr("'blade' has no triangles"));
  program_.meshes.clear();
  program_.groups = {{.name = "base", .ids = {1}}};
  EXPECT_THAT(Reason(), HasSubstr("explicit packing"));
}

TEST(YadeDriver, IsWholeInTheLibrary) {
  bool main = false;
  for (const yade::DriverFile& file : yade::Driver()) {
    EXPECT_EQ(file.text, ReadFile(std::filesystem::path(POWDERCAL_SOURCE_DIR) /
                                  "backends/yade/driver" / file.name));
    main = main || file.name == "main.py";
  }
  EXPECT_TRUE(main);
}

}  // namespace
}  // namespace powdercal

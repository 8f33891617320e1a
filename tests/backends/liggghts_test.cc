#include "backends/liggghts/liggghts.h"

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "backends/liggghts/deck.h"
#include "backends/liggghts/result.h"
#include "tests/support/program.h"
#include "tests/support/simulators.h"

// The real LIGGGHTS throughout, on beds of 100 particles.

namespace powdercal {
namespace {

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

TEST(LiggghtsUnsupported, IsExplained) {
  const auto backend = MakeLiggghtsBackend();
  Program program = SmallConsolidation();
  EXPECT_EQ(backend->ExplainUnsupported(program), "");
  program.law.cohesion = ContactLaw::Cohesion::dmt;
  EXPECT_THAT(backend->ExplainUnsupported(program), HasSubstr("DMT"));
  EXPECT_EQ(Simulate(program, {}).outcome.reason, Reason::unsupported);
  program = SmallConsolidation();
  program.law.shear_update = ContactLaw::ShearUpdate::incremental;
  EXPECT_THAT(backend->ExplainUnsupported(program), HasSubstr("displacement"));
  program = SmallConsolidation();
  program.stages.pop_back();
  EXPECT_THAT(backend->ExplainUnsupported(program), HasSubstr("stages"));
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
      "PC START n=100\nPC HOLD step=100 ke=1e-16\nERROR: Lost atoms: original 100 current 99\n",
      {.end = ProcessResult::End::exited, .exit_status = 1});
  EXPECT_EQ(trace.outcome.reason, Reason::lost_particles);
}

TEST_F(LiggghtsResult, RecordsSkipTheEchoOfTheCommand) {
  const auto records = liggghts::ReadRecords(
      "print \"PC HOLD step=${d3}\"\nPC HOLD step=12 p=-9.5e2\n\xff\xfe junk\n");
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].values.at("step"), 12);
  EXPECT_EQ(records[0].values.at("p"), -950);
}

}  // namespace
}  // namespace powdercal

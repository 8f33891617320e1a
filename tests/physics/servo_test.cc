#include <gtest/gtest.h>

#include "backends/embedded/mesh_shapes.h"
#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

constexpr double kWidth = 5 * 2 * kRadius;
constexpr double kStep = 4e-7;

// 200 spheres under a lid, x and y periodic. The floor can move.
Program Bed(double stress, const std::string& lid) {
  Program program = Vacuum({}, kStep);
  program.particles.packing.reset();
  program.particles.sizes = {SizeDistribution::Kind::normal, 2 * kRadius, 4e-6, 20e-6, 40e-6};
  program.particles.count = 200;
  program.particles.seed = 3;
  SetContact(program, {.restitution = 0.4,
                       .friction = 0.3,
                       .rolling_friction = 0.1,
                       .cohesion_energy_density = 10000});
  program.law.cohesion = ContactLaw::Cohesion::sjkr2;
  program.law.rolling = ContactLaw::Rolling::epsd2;
  program.domain = {{-0.5 * kWidth, -0.5 * kWidth, -3 * kRadius},
                    {0.5 * kWidth, 0.5 * kWidth, 60 * kRadius},
                    {Boundary::periodic, Boundary::periodic, Boundary::open}};
  program.gravity = {0, 0, -kGravity};
  program.walls = {Floor()};
  if (lid == "plane") {
    program.walls.push_back({.name = "lid", .position = 55 * kRadius, .facing_positive = false});
  } else {
    program.meshes = {embedded::MakeRidgedPlate("lid", {-0.5 * kWidth, -0.5 * kWidth, 55 * kRadius},
                                                kWidth, kWidth, kWidth / 5, -0.3 * kRadius, 5)};
  }
  program.stages = {Insert{0, 50 * kRadius, {0, 0, -0.2}}, Settle{1e-3, 2e-4, 1e-3, 0.01},
                    Servo{"lid", stress, 0.1, 0.05},
                    Hold{0.02, 10, 1e-2, 6 * 2 * kRadius * std::sqrt(kDensity / stress), 0.05}};
  return program;
}

// Mean of the servo's stress over its series from `begin` to `end` [s], over the target.
double MeanStress(const Trace& trace, double begin, double end, double stress) {
  const WallSeries& series = *trace.FindSeries("lid");
  double sum = 0;
  int count = 0;
  for (std::size_t n = 0; n < series.time.size(); ++n) {
    if (series.time[n] <= begin || series.time[n] > end) continue;
    sum += series.normal_force[n];
    ++count;
  }
  EXPECT_GT(count, 10);
  return sum / count / (kWidth * kWidth) / stress;
}

class ServoStress : public ::testing::TestWithParam<std::tuple<double, std::string>> {};

// The bed below rises and sinks, as a dilating or compacting one does, and the lid follows.
TEST_P(ServoStress, StaysWithinHalfAPerCent) {
  const auto [stress, lid] = GetParam();
  Program program = Bed(stress, lid);
  const double duration = 0.01;
  // A strain rate of some 1/s, a hundred times that of a quasi-static test.
  const double speed = 1e-3;
  program.stages.push_back(Advance{.name = "rest", .duration = duration});
  program.stages.push_back(
      Advance{.name = "rise", .duration = duration, .motions = {{"floor", {0, 0, speed}, {}, {}}}});
  program.stages.push_back(Advance{
      .name = "sink", .duration = duration, .motions = {{"floor", {0, 0, -speed}, {}, {}}}});
  const Trace trace = RunOk(program);
  ASSERT_EQ(trace.moments.size(), 6U);
  for (const std::string name : {"rest", "rise", "sink"}) {
    const Moment& moment = *trace.Find(name);
    const double mean = MeanStress(trace, moment.time - 0.8 * duration, moment.time, stress);
    Measured(fmt::format("relative error of the stress, {} Pa, {}, {}", stress, lid, name),
             mean - 1);
    EXPECT_NEAR(mean, 1, 0.005) << name;
  }
  const WallState& lid_then = trace.Find("rest")->walls.at("lid");
  const WallState& lid_now = trace.Find("rise")->walls.at("lid");
  EXPECT_NEAR((lid_now.displacement[2] - lid_then.displacement[2]) / (speed * duration), 1, 0.1);
}

// Ridges shear the bed: it rearranges and changes its height, and the stress fluctuates; the mean
// over the strain is what counts.
TEST(ServoOfAShearedBed, MeanStressStaysWithinHalfAPerCent) {
  for (const double stress : {300.0, 900.0, 9000.0}) {
    Program program = Bed(stress, "mesh");
    program.walls.clear();
    program.meshes.push_back(embedded::MakeRidgedPlate("floor", {-0.5 * kWidth, -0.5 * kWidth, 0},
                                                       kWidth, kWidth, kWidth / 5, 0.3 * kRadius));
    const double height = 20 * kRadius;
    const double inertial_number = 5e-3;
    const double rate = inertial_number / (2 * kRadius * std::sqrt(kDensity / stress));
    const Motion shear = {.body = "floor", .velocity = {rate * height, 0, 0}};
    for (const std::string name : {"start", "flow", "end"}) {
      program.stages.push_back(Advance{.name = name, .duration = 0.7 / rate, .motions = {shear}});
    }
    const Trace trace = RunOk(program);
    ASSERT_EQ(trace.moments.size(), 6U);
    double begin = trace.moments[2].time;
    double low = 0;
    for (std::size_t m = 3; m < 6; ++m) {
      const Moment& moment = trace.moments[m];
      Measured(fmt::format("relative error of the stress, {} Pa, sheared, {}", stress, moment.name),
               MeanStress(trace, begin, moment.time, stress) - 1);
      begin = moment.time;
      low = std::max(low, std::abs(moment.walls.at("lid").displacement[2] -
                                   trace.moments[2].walls.at("lid").displacement[2]));
      EXPECT_LT(moment.walls.at("floor").force[0], -0.1 * stress * kWidth * kWidth) << "no shear";
    }
    const double mean = MeanStress(trace, trace.moments[2].time, begin, stress);
    Measured(fmt::format("relative error of the stress, {} Pa, sheared, all", stress), mean - 1);
    EXPECT_NEAR(mean, 1, 0.005) << stress;
    EXPECT_GT(low, 0.1 * kRadius) << "the bed changed its height";
  }
}

// Loads the bed, unloads it and loads it again, where the lid stands.
TEST(ServoOfChangingStress, FollowsFromOneStressToTheNext) {
  for (const std::string lid : {"plane", "mesh"}) {
    Program program = Bed(900, lid);
    const Hold hold = std::get<Hold>(program.stages.back());
    const std::vector<double> stresses = {9000, 300, 900};
    for (const double stress : stresses) {
      program.stages.push_back(Servo{"lid", stress, 0.1, 0.05});
      program.stages.push_back(hold);
    }
    const Trace trace = RunOk(program);
    ASSERT_EQ(trace.moments.size(), 9U);
    ASSERT_EQ(trace.FindSeries("lid")->time.size(), trace.FindSeries("lid")->force.size());
    for (std::size_t n = 0; n < stresses.size(); ++n) {
      const double load = stresses[n] * kWidth * kWidth;
      const Moment& before = trace.moments[2 + 2 * n];
      const Moment& reached = trace.moments[3 + 2 * n];
      const Moment& held = trace.moments[4 + 2 * n];
      EXPECT_EQ(reached.name, "servo");
      EXPECT_LT(reached.time - before.time, 0.01) << "not before its longest duration";
      EXPECT_NEAR(reached.walls.at("lid").force[2] / load, 1, 0.1);
      EXPECT_NEAR(held.walls.at("lid").force[2] / load, 1, 0.02);
      // Elastic, and from 900 to 9000 Pa a bed that gives way.
      const double way =
          held.walls.at("lid").displacement[2] - before.walls.at("lid").displacement[2];
      Measured(fmt::format("way of the lid to {} Pa, {}, in radii", stresses[n], lid),
               way / kRadius);
      EXPECT_EQ(way > 0, n == 1);
      EXPECT_LT(std::abs(way), 5 * kRadius);
      double least = 1e9;
      double most = 0;
      const WallSeries& series = *trace.FindSeries("lid");
      for (std::size_t k = 0; k < series.time.size(); ++k) {
        if (series.time[k] <= reached.time || series.time[k] > held.time) continue;
        least = std::min(least, series.normal_force[k] / load);
        most = std::max(most, series.normal_force[k] / load);
      }
      Measured(fmt::format("least stress on the way to {} Pa, {}", stresses[n], lid), least);
      Measured(fmt::format("largest stress on the way to {} Pa, {}", stresses[n], lid), most);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lids, ServoStress,
                         ::testing::Combine(::testing::Values(300.0, 900.0, 9000.0),
                                            ::testing::Values("plane", "mesh")),
                         [](const auto& instance) {
                           return fmt::format("{}_{:.0f}_Pa", std::get<1>(instance.param),
                                              std::get<0>(instance.param));
                         });

}  // namespace
}  // namespace powdercal::physics

#include <gtest/gtest.h>

#include "backends/embedded/mesh_shapes.h"
#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

// A sphere that leans on a gate at x = 0, pulled along +x.
Program Leaning(const std::string& gate) {
  const double overlap = HertzOverlapUnder(MassOf(kRadius) * kGravity, kRadius);
  Program program = Vacuum({Ball(1, kRadius, {-kRadius + overlap, 0, 0})});
  SetContact(program, {.restitution = 0.3, .friction = 0.3});
  program.gravity = {kGravity, 0, 0};
  if (gate == "plane") {
    program.walls = {{.name = "gate", .axis = 0, .facing_positive = false}};
  } else {
    program.meshes = {
        embedded::MakeRectangle("gate", {0, -1e-3, -1e-3}, {0, 2e-3, 0}, {0, 0, 2e-3}, 3, 3)};
  }
  program.stages = {Advance{.name = "closed", .duration = 1e-3}, Remove{"gate"},
                    Advance{.name = "open", .duration = 5e-3}};
  return program;
}

class Gate : public ::testing::TestWithParam<std::string> {};

TEST_P(Gate, IsOpenOnceItIsRemoved) {
  const Trace trace = RunOk(Leaning(GetParam()));
  ASSERT_EQ(trace.moments.size(), 2U);
  const Moment& closed = trace.moments[0];
  EXPECT_NEAR(closed.walls.at("gate").force[0] / (MassOf(kRadius) * kGravity), 1, 0.01);
  EXPECT_TRUE(trace.moments[1].walls.empty());
  const double way = trace.moments[1].packing[0].position[0] - closed.packing[0].position[0];
  EXPECT_NEAR(way / (0.5 * kGravity * 5e-3 * 5e-3), 1, 1e-4);
  if (GetParam() == "plane") {
    EXPECT_TRUE(trace.series.empty()) << "a plane without a servo";
    return;
  }
  const WallSeries& series = *trace.FindSeries("gate");
  ASSERT_EQ(series.time.size(), 100U);
  EXPECT_NEAR(series.time.back(), closed.time, 1e-12) << "none while it is gone";
  EXPECT_NEAR(series.height.back(), -1e-3, 1e-12);
  EXPECT_NEAR(series.force.back()[0] / (MassOf(kRadius) * kGravity), 1, 0.01);
  EXPECT_NEAR(series.normal_force.back(), 0, 1e-15);
}

TEST_P(Gate, IsBackWithTheStateBeforeItsRemoval) {
  Program program = Leaning(GetParam());
  program.stages = {Advance{.name = "closed", .duration = 1e-3},
                    Save{"closed"},
                    Remove{"gate"},
                    Advance{.name = "open", .duration = 1e-3},
                    Restore{"closed"},
                    Advance{.name = "again", .duration = 5e-3}};
  const Trace trace = RunOk(program);
  const Moment& end = *trace.Find("again");
  EXPECT_LT(end.packing[0].position[0], -0.99 * kRadius);
  EXPECT_NEAR(end.walls.at("gate").force[0] / (MassOf(kRadius) * kGravity), 1, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Bodies, Gate, ::testing::Values("plane", "mesh"),
                         [](const auto& instance) { return instance.param; });

// A mesh that moves, a group, a servo's plane: whose series begins where, and what it holds.
TEST(Series, OfServoMeshesAndGroups) {
  Packing packing = {Ball(1, kRadius, {}), Ball(2, kRadius, {0, 0, 2 * kRadius})};
  Program program = Vacuum(packing);
  SetContact(program, {.restitution = 0.3});
  program.domain = {
      {-2 * kRadius, -2 * kRadius, -2 * kRadius}, {2 * kRadius, 2 * kRadius, 1e-3}, {}};
  program.domain.boundaries = {Boundary::open, Boundary::open, Boundary::open};
  program.groups = {{"foot", {1}}};
  program.walls = {{.name = "lid", .position = 9e-4, .facing_positive = false}};
  program.meshes = {
      embedded::MakeRectangle("far", {0.02, 0.02, 0}, {1e-3, 0, 0}, {0, 1e-3, 0}, 1, 1)};
  const double speed = 0.01;
  const Motion rise = {.body = "far", .velocity = {0, 0, speed}};
  program.stages = {Advance{.name = "rise", .duration = 1e-4, .motions = {rise}},
                    Servo{"lid", 900, 0.01, 0.01}, Advance{.duration = 2e-3}};
  const Trace trace = RunOk(program);
  ASSERT_EQ(trace.series.size(), 3U);
  EXPECT_EQ(trace.series[0].wall, "lid");
  EXPECT_EQ(trace.series[1].wall, "far");
  EXPECT_EQ(trace.series[2].wall, "foot");
  EXPECT_GT(trace.series[0].time.front(), 1e-4) << "from its servo on";
  for (const std::size_t n : {1, 2}) EXPECT_NEAR(trace.series[n].time.front(), 1e-5, 1e-12);
  // Mean over steps 1 … 100 of where the mesh was.
  EXPECT_NEAR(trace.series[1].height.front() / (speed * 50.5 * kTimeStep), 1, 1e-9);
  EXPECT_NEAR(trace.series[1].height.back(), speed * 1e-4, 1e-15);
  const double load = 900 * program.domain.BaseArea();
  EXPECT_NEAR(trace.series[0].force.back()[2] / load, 1, 1e-3);
  EXPECT_NEAR(trace.series[0].normal_force.back() / load, 1, 1e-3);
  EXPECT_NEAR(trace.series[2].normal_force.back() / load, -1, 1e-3);
}

}  // namespace
}  // namespace powdercal::physics

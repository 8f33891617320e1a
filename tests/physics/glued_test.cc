#include <gtest/gtest.h>

#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

// A square floor of n by n overlapping spheres about the origin, ids from 1.
Packing GluedFloor(int n, double spacing) {
  Packing packing;
  for (int k = 0; k < n * n; ++k) {
    packing.push_back(Ball(
        k + 1, kRadius, {spacing * (k % n - 0.5 * (n - 1)), spacing * (k / n - 0.5 * (n - 1)), 0}));
  }
  return packing;
}

GluedGroup GroupOf(const Packing& packing, const std::string& name) {
  GluedGroup group{.name = name};
  for (const Sphere& s : packing) group.ids.push_back(s.id);
  return group;
}

TEST(GluedGroup, KeepsItsShapeAndMovesAsTold) {
  Packing floor = GluedFloor(5, 1.7 * kRadius);
  floor[3].velocity = {1, 2, 3};  // of no meaning to a glued sphere
  floor[3].spin = {1, 2, 3};
  Program program = Vacuum(floor);
  program.groups = {GroupOf(floor, "floor")};
  program.gravity = {0, 0, -kGravity};
  program.particles.packing->push_back(Ball(26, kRadius, {0, 0, 2.5 * kRadius}, {0.01, 0, -0.05}));
  const Vector3 velocity = {0.01, -0.02, 0.03};
  for (const Moment& moment : Trajectory(program, 2e-3, 1000, {{"floor", velocity, {}, {}}})) {
    for (std::size_t p = 0; p < floor.size(); ++p) {
      const Vector3 way = moment.packing[p].position - floor[p].position;
      EXPECT_LT(Length(way - moment.time * velocity), 1e-12 * kRadius * 1e3);
      EXPECT_LT(Length(way - moment.walls.at("floor").displacement), 1e-15);
      EXPECT_EQ(moment.packing[p].velocity, velocity);
      EXPECT_EQ(moment.packing[p].spin, Vector3{});
    }
  }
}

// Contacts within the group carry nothing, those with others their weight.
TEST(GluedGroup, BearsWhatLiesOnIt) {
  const double spacing = 1.9 * kRadius;
  const Packing floor = GluedFloor(2, spacing);
  Program program = Vacuum(floor);
  SetContact(program, {.restitution = 0.3});
  program.groups = {GroupOf(floor, "floor")};
  program.gravity = {0, 0, -kGravity};
  const double weight = MassOf(kRadius) * kGravity;
  // In the pit between four spheres: each bears weight/(4 cos).
  const double height = std::sqrt(4 * kRadius * kRadius - 0.5 * spacing * spacing);
  program.particles.packing->push_back(Ball(5, kRadius, {0, 0, height * 1.001}));
  const Moment end = Trajectory(program, 0.02, 100000).back();
  EXPECT_NEAR(end.walls.at("floor").force[2] / weight, -1, 1e-9);
  EXPECT_LT(std::hypot(end.walls.at("floor").force[0], end.walls.at("floor").force[1]),
            1e-9 * weight);
  const Sphere& top = end.packing[4];
  EXPECT_LT(Length(top.velocity), 1e-12);
  // cos of the contacts' angle at their overlap.
  const double distance = Length(top.position - end.packing[0].position);
  const double force = weight * distance / (4 * top.position[2]);
  const double overlap = 2 * kRadius - distance;
  Measured("relative error of the overlap in a pit",
           overlap / HertzOverlapUnder(force, kRadius / 2) - 1);
  EXPECT_NEAR(overlap / HertzOverlapUnder(force, kRadius / 2), 1, 1e-6);
}

TEST(GluedGroup, HitLikeABodyOfInfiniteMass) {
  for (const double e : {0.5, 1.0}) {
    Program program = Vacuum(
        {Ball(1, kRadius, {}), Ball(2, kRadius, {0, 0, 2.01 * kRadius}, {0, 0, -0.01})}, 1e-8);
    SetContact(program, {.restitution = e});
    program.groups = {{"target", {1}}};
    const Packing end = After(program, 2e-4);
    EXPECT_EQ(end[0].position, Vector3{});
    // m* of the law is still that of two spheres, half the moving mass: the dashpot is √2 weaker
    // than the motion asks for.
    const double zeta = DampingRatio(e) / std::sqrt(2.0);
    const double expected = std::exp(-kPi * zeta / std::sqrt(1 - zeta * zeta));
    Measured(fmt::format("relative error of e against a glued sphere, e_n = {}", e),
             end[1].velocity[2] / (0.01 * expected) - 1);
    EXPECT_NEAR(end[1].velocity[2] / (0.01 * expected), 1, 1e-3);
  }
}

TEST(GluedGroup, ServoOnAGroupKeepsItsStress) {
  const double width = 5 * 2 * kRadius;
  Program program = Vacuum({}, 4e-7);
  SetContact(program, {.restitution = 0.3, .friction = 0.3});
  program.domain = {{-0.5 * width, -0.5 * width, -2 * kRadius},
                    {0.5 * width, 0.5 * width, 30 * kRadius},
                    {Boundary::periodic, Boundary::periodic, Boundary::open}};
  program.gravity = {0, 0, -kGravity};
  program.walls = {Floor()};
  GluedGroup lid{.name = "lid"};
  std::int64_t id = 0;
  for (int layer = 0; layer < 5; ++layer) {
    for (const Sphere& s : GluedFloor(5, 2 * kRadius)) {
      Sphere ball = s;
      ball.id = ++id;
      ball.radius *= layer == 4 ? 1 : 0.97;
      ball.position[2] = kRadius * (1 + 1.8 * layer);
      if (layer % 2 == 1)
        ball.position[0] += kRadius - (ball.position[0] > 3 * kRadius ? width : 0);
      if (layer == 4) lid.ids.push_back(ball.id);
      program.particles.packing->push_back(ball);
    }
  }
  program.groups = {lid};
  const double stress = 900;
  program.stages = {Servo{"lid", stress, 0.1, 0.05}, Hold{0.02, 10, 1e-2, 5e-4, 0.05},
                    Advance{.duration = 5e-3}};
  const Trace trace = RunOk(program);
  ASSERT_EQ(trace.moments.size(), 3U);
  const double mean = trace.moments.back().walls.at("lid").force[2] / (width * width) / stress;
  Measured("relative error of the stress under a glued lid", mean - 1);
  EXPECT_NEAR(mean, 1, 0.005);
}

}  // namespace
}  // namespace powdercal::physics

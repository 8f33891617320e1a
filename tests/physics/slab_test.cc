#include <gtest/gtest.h>

#include <algorithm>

#include "backends/embedded/mesh_shapes.h"
#include "backends/insertion.h"
#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

constexpr double kWidth = 6 * 2 * kRadius;
constexpr double kArea = kWidth * kWidth;
constexpr double kStress = 900;

// 250 spheres between a floor and a lid, x and y periodic. The slab begins
// in the floor's contacts.
Program PressedBed(const std::string& floor, double gravity) {
  Program program = Vacuum({}, 5e-7);
  Particles drawn{.sizes = {SizeDistribution::Kind::normal, 2 * kRadius, 4e-6, 20e-6, 40e-6},
                  .count = 250,
                  .seed = 3};
  SetContact(program, {.restitution = 0.3, .friction = 0.3});
  program.domain = {{-0.5 * kWidth, -0.5 * kWidth, -3 * kRadius},
                    {0.5 * kWidth, 0.5 * kWidth, 60 * kRadius},
                    {Boundary::periodic, Boundary::periodic, Boundary::open}};
  program.gravity = {0, 0, -gravity};
  program.walls = {{.name = "lid", .position = 55 * kRadius, .facing_positive = false}};
  const Insert insert = {kRadius, 36 * kRadius, {0, 0, -0.3}};
  Packing packing = PlaceParticles(drawn, program.domain, insert, {});
  if (floor == "plane") {
    program.walls.push_back(Floor());
  } else if (floor == "mesh") {
    program.meshes = {embedded::MakeRidgedPlate("floor", {-0.5 * kWidth, -0.5 * kWidth, -kRadius},
                                                kWidth, kWidth, kWidth / 4, kRadius)};
  } else {
    GluedGroup group{.name = "floor"};
    for (int k = 0; k < 36; ++k) {
      group.ids.push_back(static_cast<std::int64_t>(packing.size()) + 1);
      packing.push_back(Ball(group.ids.back(), kRadius,
                             {kRadius * (2 * (k % 6) - 5), kRadius * (2 * (k / 6) - 5), 0}));
    }
    program.groups = {group};
  }
  program.particles.packing = packing;
  program.stages = {Servo{"lid", kStress, 0.3, 0.01}, Hold{0.01, 10, 1e-3, 5e-4, 0.05},
                    Advance{.name = "rest", .duration = 5e-4}};
  program.stress_slab = {{0, 8 * kRadius}};
  return program;
}

// Of the windows of the last stage.
std::array<Vector3, 3> MeanStress(const Trace& trace) {
  const double begin = trace.Find("hold")->time;
  std::array<Vector3, 3> sum{};
  int count = 0;
  for (std::size_t n = 0; n < trace.slab.time.size(); ++n) {
    if (trace.slab.time[n] <= begin + 1e-5) continue;
    for (std::size_t a = 0; a < 3; ++a) sum[a] = sum[a] + trace.slab.stress[n][a];
    ++count;
  }
  EXPECT_GE(count, 9);
  for (Vector3& row : sum) row = (1.0 / count) * row;
  return sum;
}

class StressSlab : public ::testing::TestWithParam<std::string> {};

TEST_P(StressSlab, BearsWhatTheWallsBear) {
  const Trace trace = RunOk(PressedBed(GetParam(), 0));
  ASSERT_TRUE(trace.outcome.ok());
  const std::array<Vector3, 3> stress = MeanStress(trace);
  const Moment& end = *trace.Find("rest");
  for (const auto& [wall, sign] : {std::pair("lid", 1), std::pair("floor", -1)}) {
    const Vector3 traction = (sign / kArea) * end.walls.at(wall).force;
    const Vector3 column = {stress[0][2], stress[1][2], stress[2][2]};
    Measured(fmt::format("difference of the slab's stress and that of the {} over the load", wall),
             Length(column - traction) / kStress);
    EXPECT_NEAR(traction[2] / kStress, 1, 0.02);
    EXPECT_LT(Length(column - traction), 0.002 * kStress) << wall;
  }
  EXPECT_GT(stress[0][0], 0.2 * kStress);
  EXPECT_NEAR(stress[0][1] / kStress, stress[1][0] / kStress, 0.02) << "torques balance";
  EXPECT_NEAR(trace.slab.solid_fraction.back(), 0.59, 0.06);
}

INSTANTIATE_TEST_SUITE_P(Floors, StressSlab, ::testing::Values("plane", "mesh", "glued"),
                         [](const auto& instance) { return instance.param; });

// Gravity of 20 g: what the bed weighs above a height adds to the lid's stress.
TEST(StressSlabUnderGravity, BearsTheWeightAbove) {
  const double gravity = 20 * kGravity;
  const Program program = PressedBed("plane", gravity);
  const Trace trace = RunOk(program);
  ASSERT_TRUE(trace.outcome.ok());
  const auto [bottom, top] = *program.stress_slab;
  const Moment& end = *trace.Find("rest");
  double above = 0;   // mean over the slab
  double middle = 0;  // above its middle
  double solid = 0;
  for (const Sphere& s : end.packing) {
    const double z = s.position[2];
    const double weight = gravity * MassOf(s.radius);
    above += weight * std::clamp((z - bottom) / (top - bottom), 0.0, 1.0);
    if (z > 0.5 * (bottom + top)) middle += weight;
    if (z >= bottom && z < top) solid += MassOf(s.radius) / kDensity;
  }
  const double more = MeanStress(trace)[2][2] * kArea - end.walls.at("lid").force[2];
  Measured("weight above the slab over the load", above / kArea / kStress);
  Measured("relative error of the weight above the slab", more / above - 1);
  Measured("the same of the weight above its middle", more / middle - 1);
  EXPECT_NEAR(more / above, 1, 0.005);
  EXPECT_NEAR(more / middle, 1, 0.05);
  EXPECT_NEAR(trace.slab.solid_fraction.back() * kArea * (top - bottom) / solid, 1, 1e-12);
}

// Spheres that fly through the slab, two at v and two at −v along x: the motion is a stress of n m
// v².
TEST(StressSlabOfAGas, IsThatOfTheMotionAboutTheMean) {
  const double speed = 0.01;
  const Vector3 drift = {0.02, 0, 0};
  Packing packing;
  for (int n = 0; n < 4; ++n) {
    const Vector3 own = {n % 2 == 0 ? speed : -speed, 0, 0};
    packing.push_back(Ball(n + 1, kRadius, {0, 4 * n * kRadius, 0}, drift + own));
  }
  packing.push_back(Ball(5, kRadius, {0, 0, 9 * kRadius}, {1, 1, 0}));  // above it
  Program program = Vacuum(packing, 1e-6);
  program.stress_slab = {{-kRadius, 5 * kRadius}};
  program.stages = {Advance{.duration = 2e-4}};
  const Trace trace = RunOk(program);
  ASSERT_EQ(trace.slab.time.size(), 2U);
  const double volume = program.domain.BaseArea() * 6 * kRadius;
  const double expected = 4 * MassOf(kRadius) * speed * speed / volume;
  EXPECT_NEAR(trace.slab.stress[1][0][0] / expected, 1, 1e-9);
  EXPECT_LT(std::abs(trace.slab.stress[1][2][2]), 1e-12 * expected);
  EXPECT_NEAR(trace.slab.solid_fraction[1] * volume / (4 * MassOf(kRadius) / kDensity), 1, 1e-12);
}

}  // namespace
}  // namespace powdercal::physics

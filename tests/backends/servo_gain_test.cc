#include "backends/servo_gain.h"

#include <gtest/gtest.h>

#include "backends/particle_summary.h"

namespace powdercal {
namespace {

constexpr Servo kServo{.wall = "lid", .stress = 900, .max_velocity = 0.1, .max_duration = 1};

Program Bed() {
  Program program;
  program.particles = {.sizes = {SizeDistribution::Kind::normal, 29e-6, 6e-6, 12.5e-6, 37.5e-6},
                       .count = 100,
                       .seed = 1};
  const ContactParameters contact = {
      .restitution = 0.4, .friction = 0.3, .cohesion_energy_density = 15833};
  program.materials = {8220, 5e6, 0.3, contact, contact};
  program.law.cohesion = ContactLaw::Cohesion::sjkr2;
  program.domain.upper = {1.5e-4, 1.5e-4, 3.2e-4};
  program.walls = {{.name = "floor"},
                   {.name = "lid", .position = 2.5e-4, .facing_positive = false}};
  return program;
}

TEST(ServoGain, FollowsTheStabilityRule) {
  const Program program = Bed();
  Servo servo = kServo;
  const double soft = ServoSpeed(program, servo);
  EXPECT_GT(soft, 0.01);
  EXPECT_LT(soft, 0.05);
  servo.stress *= 10;  // a heavier load allows a faster wall, until the limit of the program
  EXPECT_GT(ServoSpeed(program, servo), soft);
  servo.max_velocity = 1e-4;
  EXPECT_EQ(ServoSpeed(program, servo), 1e-4);
}

// Cohesion presses spheres against the wall, where they damp more.
TEST(ServoGain, CohesionSlowsTheServoUnlessItsWallIsFrictionless) {
  Program program = Bed();
  const double cohesive = ServoSpeed(program, kServo);
  program.walls[1].frictionless = true;
  const double frictionless = ServoSpeed(program, kServo);
  EXPECT_GT(frictionless, cohesive);
  program.law.cohesion = ContactLaw::Cohesion::none;
  program.walls[1].frictionless = false;
  EXPECT_EQ(ServoSpeed(program, kServo), frictionless);
  program.law.cohesion = ContactLaw::Cohesion::dmt;
  program.materials.particle_wall.surface_energy = 1e-3;
  EXPECT_LT(ServoSpeed(program, kServo), frictionless);
}

TEST(ServoGain, LinearLawDampsWithItsOwnConstant) {
  Program program = Bed();
  program.law.normal = ContactLaw::Normal::linear;
  EXPECT_EQ(ServoSpeed(program, kServo), kServo.max_velocity) << "no damping, no limit";
  program.materials.linear.normal_damping = 2e-5;
  const double d = program.particles.sizes.Moment(1);
  // 0.3 sigma A/(N gamma_n) with N = A/(2 d²)
  EXPECT_NEAR(ServoSpeed(program, kServo), 0.6 * 900 * d * d / 2e-5, 1e-12);
}

TEST(ParticleSummary, IsThatOfTheDistributionOrOfThePacking) {
  Particles particles = Bed().particles;
  ParticleSummary summary = Summarise(particles);
  EXPECT_EQ(summary.count, 100);
  EXPECT_EQ(summary.smallest_diameter, 12.5e-6);
  EXPECT_EQ(summary.largest_diameter, 37.5e-6);
  EXPECT_EQ(summary.mean_diameter, particles.sizes.Moment(1));
  EXPECT_FALSE(summary.OneSize());
  particles.packing = {{1, 1, {}, {}, {}}, {2, 2, {}, {}, {}}};
  summary = Summarise(particles);
  EXPECT_EQ(summary.count, 2);
  EXPECT_EQ(summary.smallest_diameter, 2);
  EXPECT_EQ(summary.largest_diameter, 4);
  EXPECT_DOUBLE_EQ(summary.mean_diameter, 3);
  EXPECT_DOUBLE_EQ(summary.mean_cube, 36);
  EXPECT_DOUBLE_EQ(summary.Mass(2), 2 * 2 * 3.14159265358979323846 / 6 * 36);
  particles.packing->pop_back();
  EXPECT_TRUE(Summarise(particles).OneSize());
}

}  // namespace
}  // namespace powdercal

#include <gtest/gtest.h>

#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

constexpr double kEnergyDensity = 47500;  // [J/m3]
constexpr double kSurfaceEnergy = 1e-4;   // [J/m2]

// docs/physics.md §2, from F = (4/3) E* √R* δ^1.5 − 4 π k R* δ.
double RestingOverlap(double effective_radius) {
  const double ratio = kEnergyDensity / EffectiveYoung();
  return 9 * kPi * kPi * ratio * ratio * effective_radius;
}
double PullOff(double effective_radius) {
  return 16 * std::pow(kPi, 3) / 3 * std::pow(kEnergyDensity, 3) *
         std::pow(effective_radius / EffectiveYoung(), 2);
}
double SeparationWork(double effective_radius) {
  return 32.4 * std::pow(kPi, 5) * std::pow(kEnergyDensity, 5) * std::pow(effective_radius, 3) /
         std::pow(EffectiveYoung(), 4);
}

Program Cohesive(Packing packing, ContactLaw::Cohesion cohesion, double restitution = 1) {
  Program program = Vacuum(std::move(packing));
  program.law.cohesion = cohesion;
  SetContact(program, {.restitution = restitution,
                       .cohesion_energy_density = kEnergyDensity,
                       .surface_energy = kSurfaceEnergy});
  return program;
}

TEST(Cohesion, TwoSpheresRestAtTheOverlapOfSjkr2) {
  const double other = 25e-6;
  const double radius = Reduced(kRadius, other);
  const Packing end =
      After(Cohesive({Ball(1, kRadius, {}), Ball(2, other, {0, kRadius + other - 1e-9, 0})},
                     ContactLaw::Cohesion::sjkr2, 0.3),
            5e-3);
  const double overlap = kRadius + other - (end[1].position[1] - end[0].position[1]);
  Measured("relative error of the overlap at rest", overlap / RestingOverlap(radius) - 1);
  EXPECT_NEAR(overlap / RestingOverlap(radius), 1, 1e-9);
  EXPECT_NEAR(RestingOverlap(kRadius / 2) / (2 * kRadius),
              22.2 * std::pow(kEnergyDensity / EffectiveYoung(), 2), 2e-6);
}

// Where cohesion and repulsion balance there is nothing left that could hold by friction: with
// tangential_reduce a sphere that clings to a wall keeps on sliding over it, and does not roll.
TEST(Cohesion, TangentialReduceLimitsFrictionByTheNetForce) {
  const double speed = 0.01;
  const double overlap = RestingOverlap(kRadius) / 4;  // the wall's pull is half of 4 pi k R* delta
  for (const auto tangential :
       {ContactLaw::Tangential::history, ContactLaw::Tangential::no_history}) {
    Program program = Cohesive({Ball(1, kRadius, {0, 0, kRadius - overlap}, {speed, 0, 0})},
                               ContactLaw::Cohesion::sjkr2, 0.3);
    program.materials.particle_wall.friction = 0.3;
    program.materials.particle_wall.rolling_friction = 0.3;
    program.law.rolling = ContactLaw::Rolling::epsd2;
    program.law.tangential = tangential;
    program.walls = {Floor()};
    const double without = After(program, 1e-3)[0].velocity[0] / speed;
    program.law.tangential_reduce = true;
    const Sphere with = After(program, 1e-3)[0];
    Measured("velocity that is left without tangential_reduce", without);
    EXPECT_LT(without, 0.8);
    // With history half a step of the dashpot, before the spring has been stretched to its limit.
    const bool history = tangential == ContactLaw::Tangential::history;
    EXPECT_NEAR(with.velocity[0] / speed, 1, history ? 0.01 : 1e-6);
    EXPECT_LT(std::abs(with.spin[1]) * kRadius / speed, history ? 0.025 : 1e-6);
  }
}

// Largest pull on a sphere, glued and drawn from its partner: a glued one (radius `other`), or the
// floor.
double LargestPull(ContactLaw::Cohesion cohesion, double other) {
  const double overlap = cohesion == ContactLaw::Cohesion::dmt ? 1e-3 * kRadius : 0.02 * kRadius;
  const double speed = cohesion == ContactLaw::Cohesion::dmt ? 1e-4 : 1e-3;
  Program program = Cohesive({Ball(1, kRadius, {0, 0, kRadius - overlap})}, cohesion);
  if (other > 0) {
    program.particles.packing->push_back(Ball(2, other, {0, 0, -other}));
    program.groups = {{"lower", {2}}};
  } else {
    program.walls = {Floor()};
  }
  program.groups.push_back({"upper", {1}});
  const Motion up = {.body = "upper", .velocity = {0, 0, speed}};
  double pull = 0;
  for (const Moment& moment : Trajectory(program, 1.1 * overlap / speed, 1, {up})) {
    const WallState& upper = moment.walls.at("upper");
    const WallState& below = moment.walls.at(other > 0 ? "lower" : "floor");
    EXPECT_DOUBLE_EQ(upper.force[2], -below.force[2]);
    pull = std::max(pull, -upper.force[2]);
  }
  return pull;
}

TEST(Cohesion, PullOffForceOfSjkr2) {
  EXPECT_NEAR(16 * std::pow(kPi, 3) / 3, 165.4, 0.05);
  for (const double other : {kRadius, 40e-6}) {
    const double expected = PullOff(Reduced(kRadius, other));
    const double pull = LargestPull(ContactLaw::Cohesion::sjkr2, other);
    Measured("relative error of the pull-off force", pull / expected - 1);
    EXPECT_NEAR(pull / expected, 1, 1e-5);
  }
}

TEST(Cohesion, AWallHoldsHalfOfWhatAnEqualSphereHolds) {
  const double pull = LargestPull(ContactLaw::Cohesion::sjkr2, 0);
  EXPECT_NEAR(pull / (0.5 * PullOff(kRadius / 2)), 1, 1e-5);
}

TEST(Cohesion, PullOffForceOfDmt) {
  const double sphere = LargestPull(ContactLaw::Cohesion::dmt, kRadius);
  const double wall = LargestPull(ContactLaw::Cohesion::dmt, 0);
  const double expected = 4 * kPi * kSurfaceEnergy * kRadius / 2;
  Measured("relative error of DMT's pull-off force", sphere / expected - 1);
  EXPECT_NEAR(sphere / expected, 1, 1e-3);  // at the last touch, a step before parting
  EXPECT_NEAR(wall / (2 * expected), 1, 1e-3);
}

// Spheres at rest in the well leave it with more than its depth, and not with less.
TEST(Cohesion, EscapeTakesTheWorkOfSeparation) {
  const double mass = MassOf(kRadius) / 2;
  const double work = SeparationWork(kRadius / 2);
  const double overlap = RestingOverlap(kRadius / 2);
  const auto way = [&](double energy) {
    const double speed = std::sqrt(2 * energy * work / mass);
    Program program =
        Cohesive({Ball(1, kRadius, {-kRadius + 0.5 * overlap, 0, 0}, {-speed / 2, 0, 0}),
                  Ball(2, kRadius, {kRadius - 0.5 * overlap, 0, 0}, {speed / 2, 0, 0})},
                 ContactLaw::Cohesion::sjkr2);
    program.time_step = 1e-8;
    return After(program, 2e-4);
  };
  const Packing escaped = way(1.5);
  const double left = escaped[1].velocity[0] - escaped[0].velocity[0];
  const double energy = 0.5 * mass * left * left / work;
  Measured("energy left over of 1.5 wells, in wells", energy);
  EXPECT_NEAR(energy, 0.5, 1e-4);
  EXPECT_GT(way(1.001)[1].position[0], kRadius);
  const Packing held = way(0.999);
  EXPECT_LT(held[1].position[0] - held[0].position[0], 2 * kRadius);
}

// Friction does not feel cohesion: a sphere held by it alone has no elastic force to spare beyond
// that of its own overlap.
TEST(Cohesion, FrictionIsLimitedByTheForceWithoutCohesion) {
  const double mu = 0.3;
  Program program =
      OnFloor({.restitution = 0.4, .friction = mu, .cohesion_energy_density = kEnergyDensity});
  program.law.cohesion = ContactLaw::Cohesion::sjkr2;
  program.gravity = {};
  Sphere& sphere = program.particles.packing->front();
  const double ratio =
      kPi * 1.5 * kEnergyDensity / EffectiveYoung();  // 2 π k r δ = (4/3) E* √r δ^1.5
  const double overlap = ratio * ratio * kRadius;
  const double elastic = 2 * kPi * kEnergyDensity * kRadius * overlap;
  sphere.position[2] = kRadius - overlap;
  sphere.velocity = {1, 0, 0};
  const std::vector<Moment> way = Trajectory(program, 2e-4, 100);
  const Sphere& a = way[0].packing[0];
  const Sphere& b = way.back().packing[0];
  const double deceleration = (a.velocity[0] - b.velocity[0]) / (way.back().time - way[0].time);
  EXPECT_NEAR(deceleration * MassOf(kRadius) / (mu * elastic), 1, 1e-3);
  EXPECT_NEAR(b.position[2], sphere.position[2], 1e-6 * kRadius);
}

}  // namespace
}  // namespace powdercal::physics

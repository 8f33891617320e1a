#include <gtest/gtest.h>

#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

const double kWeight = MassOf(kRadius) * kGravity;

// Overlap of OnFloor(), stiffness of the tangential spring there, and the arm of friction.
double Overlap(double slope = 0) { return HertzOverlapUnder(kWeight * std::cos(slope), kRadius); }
double TangentialStiffness() { return 8 * EffectiveShear() * std::sqrt(kRadius * Overlap()); }
double Arm(double slope = 0) { return kRadius - 0.5 * Overlap(slope); }
// m a²/I: 5/2 for a rigid sphere.
double InertiaRatio(double slope = 0) {
  return MassOf(kRadius) * Arm(slope) * Arm(slope) / InertiaOf(kRadius);
}

// A sphere set down with v0 and no spin slides for 2 v0/(7 μ g) and then rolls with 5/7 v0.
TEST(Rolling, SlidingTurnsIntoRolling) {
  const double mu = 0.3;
  const double v0 = 0.01;
  for (const ContactLaw::ShearUpdate update :
       {ContactLaw::ShearUpdate::displacement, ContactLaw::ShearUpdate::incremental}) {
    Program program = OnFloor({.restitution = 0.4, .friction = mu});
    program.law.shear_update = update;
    program.particles.packing->front().velocity = {v0, 0, 0};
    // The spring as sliding keeps it.
    const double force = mu * kWeight;
    const bool displacement = update == ContactLaw::ShearUpdate::displacement;
    program.particles.contacts = {
        {1, -1, {displacement ? force / TangentialStiffness() : -force, 0, 0}, {}}};
    const double until = 2 * v0 / (7 * mu * kGravity);
    double slid = 0;
    double worst = 0;
    double before = v0;
    Sphere end;
    for (const Moment& moment : Trajectory(program, 3 * until, 10)) {
      end = moment.packing[0];
      const double slip = end.velocity[0] - Arm() * end.spin[1];
      if (slid == 0 && slip <= 0) slid = moment.time - 10 * kTimeStep * slip / (slip - before);
      if (slid == 0) {
        worst = std::max(worst, std::abs(end.velocity[0] - v0 + mu * kGravity * moment.time) / v0);
      }
      before = slip;
    }
    const double rolling = v0 * InertiaRatio() / (1 + InertiaRatio());
    EXPECT_NEAR(InertiaRatio(), 2.5, 1e-3);
    EXPECT_NEAR(slid / until, 1, 2e-3);
    EXPECT_LT(worst, 1e-6);
    EXPECT_NEAR(end.velocity[0] / rolling, 1, 1e-7);
    EXPECT_NEAR(Arm() * end.spin[1] / rolling, 1, 1e-7);
    Measured("relative error of the sliding time", slid / until - 1);
    Measured("largest error of v = v0 - mu g t, over v0", worst);
    Measured("relative error of the rolling speed", end.velocity[0] / rolling - 1);
  }
}

// Without a slope, dv/dt = −T R/(I + m R²), T = μ_r R F: 5/7 μ_r g.
TEST(Rolling, RollingFrictionSlowsASphereDown) {
  const double rolling_friction = 0.05;
  for (const auto rolling : {ContactLaw::Rolling::cdt, ContactLaw::Rolling::epsd2}) {
    Program program =
        OnFloor({.restitution = 0.4, .friction = 0.5, .rolling_friction = rolling_friction});
    program.law.rolling = rolling;
    const double v0 = 0.01;
    program.particles.packing->front().velocity = {v0, 0, 0};
    program.particles.packing->front().spin = {0, v0 / Arm(), 0};
    const double rate = rolling_friction * kGravity * InertiaRatio() / (1 + InertiaRatio());
    const double stop = v0 / rate * kRadius / Arm();
    const std::vector<Moment> way = Trajectory(program, 0.8 * stop, 10000);
    const Moment& a = way[way.size() / 2];
    const Moment& b = way.back();
    const double measured =
        (a.packing[0].velocity[0] - b.packing[0].velocity[0]) / (b.time - a.time);
    const double expected = rate * kRadius / Arm();
    Measured(fmt::format("relative error of the deceleration, {}",
                         rolling == ContactLaw::Rolling::cdt ? "cdt" : "epsd2"),
             measured / expected - 1);
    EXPECT_NEAR(measured / expected, 1, 1e-4);
    EXPECT_NEAR(b.packing[0].velocity[0] / (Arm() * b.packing[0].spin[1]), 1, 1e-3);
  }
}

// epsd2 brings a sphere to rest, cdt leaves it dithering by a step's worth of its torque.
TEST(Rolling, OnlyElasticRollingFrictionComesToRest) {
  const double rolling_friction = 0.05;
  const double v0 = 0.001;
  const auto rest = [&](ContactLaw::Rolling rolling) {
    Program program =
        OnFloor({.restitution = 0.4, .friction = 0.5, .rolling_friction = rolling_friction});
    program.law.rolling = rolling;
    program.particles.packing->front().velocity = {v0, 0, 0};
    program.particles.packing->front().spin = {0, v0 / Arm(), 0};
    return Trajectory(program, 0.02, 100000).back().packing[0];
  };
  const double dither =
      rolling_friction * kWeight * kRadius * kTimeStep / InertiaOf(kRadius);  // [rad/s]
  const double elastic = std::abs(rest(ContactLaw::Rolling::epsd2).spin[1]);
  const double constant = std::abs(rest(ContactLaw::Rolling::cdt).spin[1]);
  Measured("spin left by epsd2, over a step's worth of cdt's", elastic / dither);
  Measured("spin left by cdt, over a step's worth of it", constant / dither);
  EXPECT_LT(elastic, 1e-3 * dither);
  EXPECT_GT(constant, 0.1 * dither);
  EXPECT_LT(constant, 2 * dither);
}

struct Slope {
  double angle = 0;  // [rad]
  double friction = 0.5;
  double rolling_friction = 0;
  ContactLaw::Rolling rolling = ContactLaw::Rolling::none;
};

// The acceleration down the slope from 10 ms to 20 ms, over g [-].
double Acceleration(const Slope& slope, Sphere* end = nullptr) {
  Program program = OnFloor(
      {.restitution = 0.4, .friction = slope.friction, .rolling_friction = slope.rolling_friction},
      slope.angle);
  program.law.rolling = slope.rolling;
  const std::vector<Moment> way = Trajectory(program, 0.02, 100000);
  if (end != nullptr) *end = way.back().packing[0];
  return (way[1].packing[0].velocity[0] - way[0].packing[0].velocity[0]) / (0.01 * kGravity);
}

// A free sphere rolls down with 5/7 g sin α while tan α < 7/2 μ, and slides beyond.
TEST(Slope, FreeSphereRollsOrSlides) {
  for (const double angle : {0.1, 0.3, 0.45, 0.7, 0.9}) {
    const double mu = 0.2;
    const bool rolls = std::tan(angle) < 3.5 * mu;
    const double q = InertiaRatio(angle);
    const double expected =
        rolls ? std::sin(angle) * q / (1 + q) : std::sin(angle) - mu * std::cos(angle);
    EXPECT_NEAR(Acceleration({.angle = angle, .friction = mu}), expected, 1e-4) << angle;
  }
}

// Kept from rolling it stays below atan μ and slides above.
TEST(Slope, FrictionWithHistoryHoldsUpToItsAngle) {
  const double mu = 0.4;
  for (const double factor : {0.5, 0.9, 0.99}) {
    Sphere end;
    const double angle = factor * std::atan(mu);
    const Slope slope{angle, mu, 2, ContactLaw::Rolling::epsd2};
    EXPECT_LT(std::abs(Acceleration(slope, &end)), 1e-9) << factor;
    EXPECT_LT(Length(end.velocity), 1e-9);
    EXPECT_LT(std::abs(end.position[0]), 1e-2 * kRadius);  // while springs take up the load
  }
  for (const double factor : {1.01, 1.1, 1.5}) {
    const double angle = factor * std::atan(mu);
    const Slope slope{angle, mu, 2, ContactLaw::Rolling::epsd2};
    EXPECT_NEAR(Acceleration(slope), std::sin(angle) - mu * std::cos(angle), 1e-6) << factor;
  }
}

// Rolling friction holds up to tan α = μ_r (R* = R at a wall) and slows what is steeper.
TEST(Slope, ElasticRollingFrictionHoldsUpToItsAngle) {
  const double rolling_friction = 0.2;
  for (const double factor : {0.5, 0.95, 1.05, 1.5}) {
    const double angle = std::atan(factor * rolling_friction * kRadius / Arm());
    Sphere end;
    const double acceleration =
        Acceleration({angle, 1, rolling_friction, ContactLaw::Rolling::epsd2}, &end);
    if (factor < 1) {
      EXPECT_LT(std::abs(acceleration), 1e-9);
      EXPECT_LT(Length(end.velocity), 1e-9);
      continue;
    }
    const double q = InertiaRatio(angle);
    const double expected =
        (std::sin(angle) - rolling_friction * std::cos(angle) * kRadius / Arm(angle)) * q / (1 + q);
    EXPECT_NEAR(acceleration, expected, 1e-4 * std::sin(angle)) << factor;
  }
}

// cdt cannot stand still: it creeps down a slope that its torque could hold.
TEST(Slope, ConstantTorqueDithers) {
  Sphere end;
  Acceleration({std::atan(0.1), 1, 0.2, ContactLaw::Rolling::cdt}, &end);
  EXPECT_GT(std::abs(end.spin[1]) * kRadius, 1e-7);
}

}  // namespace
}  // namespace powdercal::physics

#include <gtest/gtest.h>

#include "tests/physics/impact_reference.h"
#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

// Steps in one elastic impact: what is left of errors in the time step is then below 1e-3.
constexpr double kStepsPerImpact = 5000;

struct HeadOn {
  double restitution = 1;
  double radius = kRadius;
  double other = kRadius;  // 0: a plane
  double speed = 0.01;
  bool limit_force = false;
};

// Exit over entry speed, along a direction that no axis has anything to do with.
double MeasuredRestitution(const HeadOn& impact) {
  const bool plane = impact.other == 0;
  const Vector3 n = plane ? Vector3{0, 0, 1} : (1 / std::sqrt(14.0)) * Vector3{1, -2, 3};
  const double radius = plane ? impact.radius : Reduced(impact.radius, impact.other);
  const double mass =
      plane ? MassOf(impact.radius) : Reduced(MassOf(impact.radius), MassOf(impact.other));
  const double duration = HertzDuration(radius, mass, impact.speed);
  const double gap = 0.1 * duration * impact.speed;
  Packing packing = {
      Ball(1, impact.radius, (impact.radius + impact.other + gap) * n, -impact.speed * n)};
  if (!plane) packing.push_back(Ball(2, impact.other, {}));
  Program program = Vacuum(packing, duration / kStepsPerImpact);
  SetContact(program, {.restitution = impact.restitution});
  program.law.limit_force = impact.limit_force;
  if (plane) program.walls = {Floor()};
  const Packing end = After(program, 4 * duration);
  const Vector3 other = plane ? Vector3{} : end[1].velocity;
  return Dot(end[0].velocity - other, n) / impact.speed;
}

// The dashpot of Tsuji et al. (1992) makes u = δ^(5/4) a damped linear oscillator (Antypov &
// Elliott 2011): e_n is met exactly where the dashpot may pull. Where it may not, spheres part when
// the force vanishes, u'' = 0: Schwager & Pöschel (2007) have the linear spring's formula, which
// holds here as well.
double ClippedRestitution(double restitution) {
  const double zeta = DampingRatio(restitution);
  return std::exp(-2 * zeta * std::acos(zeta) / std::sqrt(1 - zeta * zeta));
}

TEST(Contact, HeadOnRestitutionIsTheGivenOne) {
  double worst = 0;
  for (const double e : {0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0}) {
    for (const HeadOn& impact : {HeadOn{.restitution = e}, HeadOn{e, kRadius, 0},
                                 HeadOn{e, 10e-6, 35e-6, 0.002}, HeadOn{e, 6e-6, 0, 0.1}}) {
      worst = std::max(worst, RelativeError(MeasuredRestitution(impact), e));
    }
  }
  Measured("worst relative error of e_n", worst);
  EXPECT_LT(worst, 1e-3);
}

TEST(Contact, ClippedForceGivesAHigherRestitution) {
  EXPECT_NEAR(ClippedRestitution(0.4), 0.472, 5e-4);
  double worst = 0;
  for (const double e : {0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0}) {
    for (const HeadOn& impact :
         {HeadOn{.restitution = e, .limit_force = true}, HeadOn{e, 20e-6, 0, 0.03, true},
          HeadOn{e, 8e-6, 30e-6, 0.005, true}}) {
      worst = std::max(worst, RelativeError(MeasuredRestitution(impact), ClippedRestitution(e)));
    }
  }
  Measured("worst relative error of e with limit_force", worst);
  EXPECT_LT(worst, 1e-3);
}

TEST(Contact, RestitutionDoesNotDependOnSpeed) {
  const double slow = MeasuredRestitution({.restitution = 0.5, .speed = 1e-4});
  for (const double speed : {1e-3, 1e-2, 0.1}) {
    EXPECT_NEAR(MeasuredRestitution({.restitution = 0.5, .speed = speed}), slow, 1e-6) << speed;
  }
}

TEST(Contact, RestitutionErrorFallsWithTheTimeStep) {
  // What a study's own step costs: 0.2 Rayleigh times of the smallest sphere.
  const double rayleigh = RayleighTime(kRadius, kDensity, kYoung, kPoisson);
  const double mass = MassOf(kRadius) / 2;
  const double speed = 0.05;
  double before = 1;
  for (const double step : {0.2, 0.1, 0.05}) {
    const double flight = 3 * HertzDuration(kRadius / 2, mass, speed);
    Program program = Vacuum(
        {Ball(1, kRadius, {1e-9, 0, 0}, {-speed, 0, 0}), Ball(2, kRadius, {-2 * kRadius, 0, 0})},
        step * rayleigh);
    SetContact(program, {.restitution = 0.4});
    const Packing end = After(program, flight);
    const double e = (end[0].velocity[0] - end[1].velocity[0]) / speed;
    Measured(fmt::format("error of e_n = 0.4 at {} Rayleigh times", step), e - 0.4);
    EXPECT_LT(std::abs(e - 0.4), 0.8 * before);
    before = std::abs(e - 0.4);
  }
  EXPECT_LT(before, 0.02);
}

TEST(Contact, ElasticImpactLastsAndCompressesAsHertzSays) {
  const double mass = MassOf(kRadius) / 2;
  const double speed = 0.02;
  const double duration = HertzDuration(kRadius / 2, mass, speed);
  Program program =
      Vacuum({Ball(1, kRadius, {0, 0, 0}), Ball(2, kRadius, {2 * kRadius, 0, 0}, {-speed, 0, 0})},
             duration / 2000);
  double most = 0;
  Packing end;
  for (const Moment& moment : Trajectory(program, 1.5 * duration, 1)) {
    end = moment.packing;
    most = std::max(most, 2 * kRadius - (end[1].position[0] - end[0].position[0]));
  }
  // The time they touched is what the way since then leaves.
  const double gap = end[1].position[0] - end[0].position[0] - 2 * kRadius;
  const double lasted = 1.5 * duration - gap / speed;
  EXPECT_NEAR(most / HertzOverlap(kRadius / 2, mass, speed), 1, 1e-5);
  EXPECT_NEAR(lasted / duration, 1, 1e-4);           // 2.9432 has five figures
  EXPECT_NEAR(end[1].velocity[0], 0, 1e-6 * speed);  // equal masses exchange their velocities
  EXPECT_NEAR(end[0].velocity[0], -speed, 1e-6 * speed);
}

// The linear law, k_n = 1 N/m: half a period of a damped oscillator.
TEST(Contact, LinearLawIsADampedOscillator) {
  const double k = 1;
  double worst_time = 0, worst_restitution = 0;
  for (const double zeta : {0.0, 0.05, 0.2, 0.4}) {
    for (const bool plane : {false, true}) {
      const double mass = plane ? MassOf(kRadius) : MassOf(kRadius) / 2;
      const double natural = std::sqrt(k / mass);
      const double damped = natural * std::sqrt(1 - zeta * zeta);
      const double speed = 0.01;
      Packing packing = {Ball(1, kRadius, {0, 0, kRadius}, {0, 0, -speed})};
      if (!plane) packing.push_back(Ball(2, kRadius, {0, 0, -kRadius}));
      Program program = Vacuum(packing, kPi / damped / 5000);
      if (plane) program.walls = {Floor()};
      program.law.normal = ContactLaw::Normal::linear;
      program.materials.linear = {.normal = k, .normal_damping = 2 * zeta * natural * mass};
      const double time = 2 * kPi / damped;
      const Packing end = After(program, time);
      const Vector3 at = plane ? Vector3{0, 0, -kRadius} : end[1].position;
      const Vector3 velocity = end[0].velocity - (plane ? Vector3{} : end[1].velocity);
      const double gap = end[0].position[2] - at[2] - 2 * kRadius;
      const double e = std::exp(-kPi * zeta / std::sqrt(1 - zeta * zeta));
      worst_restitution = std::max(worst_restitution, RelativeError(velocity[2] / speed, e));
      worst_time = std::max(worst_time, RelativeError(time - gap / velocity[2], kPi / damped));
    }
  }
  Measured("worst relative error of the linear law's contact time", worst_time);
  Measured("worst relative error of its restitution", worst_restitution);
  EXPECT_LT(worst_time, 1e-3);
  EXPECT_LT(worst_restitution, 1e-3);
}

// --- Oblique impacts ----------------------------------------------------------------------------

struct Oblique {
  double tangent = 1;  // v_t/v_n
  double spin = 0;     // [rad/s] of the sphere, about y
  double restitution = 1;
  double friction = 0.3;
  bool limit_force = false;
  bool incremental = false;
  double other = 0;      // [m] radius of the partner, 0: a plane
  double speed = 0.002;  // [m/s] along the normal
};

struct Exit {
  Vector3 velocity{};  // of sphere 1
  double spin = 0;
  double slip = 0;  // tangential velocity of the contact [m/s]
};

double DurationOf(const Oblique& impact) {
  const bool plane = impact.other == 0;
  return HertzDuration(plane ? kRadius : Reduced(kRadius, impact.other),
                       plane ? MassOf(kRadius) : Reduced(MassOf(kRadius), MassOf(impact.other)),
                       impact.speed);
}

double SlipOf(const Vector3& velocity, const Vector3& spin) {
  return velocity[0] - kRadius * spin[1];
}

Exit Simulate(const Oblique& impact, double steps_per_impact) {
  const bool plane = impact.other == 0;
  const double duration = DurationOf(impact);
  Packing packing = {Ball(1, kRadius, {0, 0, kRadius},
                          {impact.tangent * impact.speed, 0, -impact.speed}, {0, impact.spin, 0})};
  if (!plane) packing.push_back(Ball(2, impact.other, {0, 0, -impact.other}));
  Program program = Vacuum(packing, duration / steps_per_impact);
  SetContact(program, {.restitution = impact.restitution, .friction = impact.friction});
  program.law.limit_force = impact.limit_force;
  if (impact.incremental) program.law.shear_update = ContactLaw::ShearUpdate::incremental;
  if (plane) program.walls = {Floor()};
  const Packing end = After(program, 2.5 * duration);
  return {end[0].velocity, end[0].spin[1], SlipOf(end[0].velocity, end[0].spin)};
}

Exit Reference(const Oblique& impact) {
  const bool plane = impact.other == 0;
  ReferenceImpact reference;
  reference.a = {.radius = kRadius,
                 .mass = MassOf(kRadius),
                 .z = kRadius,
                 .vx = impact.tangent * impact.speed,
                 .vz = -impact.speed,
                 .spin = impact.spin};
  reference.b = {.radius = plane ? INFINITY : impact.other,
                 .mass = plane ? INFINITY : MassOf(impact.other),
                 .z = -impact.other};
  reference.restitution = impact.restitution;
  reference.friction = impact.friction;
  reference.limit_force = impact.limit_force;
  reference.incremental = impact.incremental;
  reference.Run(2.5 * DurationOf(impact), 200'000);
  const Vector3 velocity = {reference.a.vx, 0, reference.a.vz};
  return {velocity, reference.a.spin, SlipOf(velocity, {0, reference.a.spin, 0})};
}

// Largest difference of velocities and R·spin, in units of the normal speed.
double Difference(const Exit& a, const Exit& b, double normal_speed) {
  return std::max({std::abs(a.velocity[0] - b.velocity[0]), std::abs(a.velocity[2] - b.velocity[2]),
                   kRadius * std::abs(a.spin - b.spin)}) /
         normal_speed;
}

TEST(ObliqueImpact, FollowsTheLawWhateverTheAngle) {
  double worst = 0;
  for (const double restitution : {1.0, 0.6}) {
    for (const double tangent : {0.02, 0.1, 0.3, 0.7, 1.2, 2.0, 4.0}) {
      for (const double other : {0.0, kRadius, 25e-6}) {
        Oblique impact{.tangent = tangent, .restitution = restitution, .other = other};
        impact.incremental = other == kRadius;
        impact.limit_force = tangent > 0.5;
        const double difference =
            Difference(Simulate(impact, 5000), Reference(impact), impact.speed);
        EXPECT_LT(difference, 2e-3 * std::max(1.0, tangent))
            << "e " << restitution << ", tangent " << tangent << ", other radius " << other;
        worst = std::max(worst, difference);
      }
    }
  }
  Measured("largest difference from the reference, over v_n", worst);
}

// Rigid bodies that slide throughout (Walton 1993; Foerster et al. 1994): Coulomb's impulse turns
// the contact's slip by −(7/2) μ (1 + e) v_n against a plane, and as much between equal spheres.
// Rigid means slow: a pair must not turn while it is in contact.
TEST(ObliqueImpact, GrossSlidingIsThatOfRigidBodies) {
  const double mu = 0.1;
  double worst = 0;
  for (const double tangent : {2.0, 4.0, 8.0}) {
    for (const double other : {0.0, kRadius}) {
      const double speed = other == 0 ? 1e-4 : 1e-7;
      const Exit exit =
          Simulate({.tangent = tangent, .friction = mu, .other = other, .speed = speed}, 5000);
      // Equal spheres: half of the slip is the other one's.
      const double change = 2 * mu * (other == 0 ? 1 : 0.5);  // of the velocity, over v_n
      for (const double ratio : {(tangent - exit.velocity[0] / speed) / change,
                                 (tangent - exit.slip / speed) / (3.5 * change)}) {
        EXPECT_NEAR(ratio, 1, 1e-3) << tangent << " " << other;
        worst = std::max(worst, std::abs(ratio - 1));
      }
    }
  }
  Measured("relative error of the changes of velocity and slip", worst);
}

// With a dashpot the law exceeds Coulomb's limit until the spring has grown up to it: 5 % more of
// friction's impulse than rigid bodies have. What counts as 1 + e is the impulse of the force's
// size.
TEST(ObliqueImpact, GrossSlidingOfDampedImpacts) {
  const double mu = 0.1;
  const double e = 0.6;
  const double clipped = ClippedRestitution(e);
  for (const bool limit_force : {true, false}) {
    const double impulse = limit_force ? 1 + clipped : 1 + 2 * clipped - e;
    for (const double tangent : {2.0, 4.0}) {
      const Exit exit = Simulate(
          {.tangent = tangent, .restitution = e, .friction = mu, .limit_force = limit_force}, 5000);
      const double change = tangent - exit.slip / Oblique{}.speed;
      Measured(fmt::format("change of slip over theory, tangent {}, limit_force {}", tangent,
                           limit_force ? "on" : "off"),
               change / (3.5 * mu * impulse));
      EXPECT_NEAR(change / (3.5 * mu * impulse), 1, 0.06);
    }
  }
}

// Maw, Barber & Fawcett (1976), elastic: ψ = 2(1 − ν)/(μ(2 − ν)) · v_t/v_n before and after the
// impact. The contact comes back with less slip than it had, reversed over a range of ψ1; from ψ1 =
// 4χ − 1 on it slides throughout and ψ2 = ψ1 − 4χ, χ = 7(1 − ν)/(2(2 − ν)). The law has Mindlin's
// no-slip stiffness but not his partial slip, so that only the shape is his.
TEST(ObliqueImpact, TakesTheShapeOfMawBarberAndFawcett) {
  const double mu = 0.3;
  const double scale = 2 * (1 - kPoisson) / (mu * (2 - kPoisson));
  const double chi = 3.5 * (1 - kPoisson) / (2 - kPoisson);
  const auto psi2 = [&](double psi1) {
    const Exit exit = Simulate({.tangent = psi1 / scale, .friction = mu, .speed = 1e-4}, 2000);
    return scale * exit.slip / 1e-4;
  };
  double least = 0, least_at = 0;
  for (double psi1 = 0.25; psi1 < 4 * chi - 1; psi1 += 0.25) {
    const double after = psi2(psi1);
    EXPECT_LT(std::abs(after), psi1);
    if (after < least) {
      least = after;
      least_at = psi1;
    }
  }
  Measured("smallest psi2", least);
  Measured("at psi1", least_at);
  EXPECT_GT(least_at, 2.5);
  EXPECT_GT(least, -1.5);
  EXPECT_LT(least, -0.8);
  for (const double psi1 : {4 * chi - 0.5, 4 * chi, 4 * chi + 2}) {
    EXPECT_NEAR(psi2(psi1), psi1 - 4 * chi, 5e-3) << psi1;
  }
}

// A sphere that only spins gets the same as one that only slides with the same slip.
TEST(ObliqueImpact, SlipIsWhatCounts) {
  const double slip = 3 * Oblique{}.speed;
  const Exit sliding = Simulate({.tangent = 3}, 5000);
  const Exit spinning = Simulate({.tangent = 0, .spin = -slip / kRadius}, 5000);
  EXPECT_NEAR(sliding.velocity[0] - slip, spinning.velocity[0], 2e-3 * slip);
  EXPECT_NEAR(sliding.spin, spinning.spin + slip / kRadius, 2e-3 * slip / kRadius);
}

}  // namespace
}  // namespace powdercal::physics

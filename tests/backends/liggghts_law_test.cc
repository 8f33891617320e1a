#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "backends/liggghts/liggghts.h"
#include "scaling/groups.h"
#include "tests/support/program.h"

// One or two spheres in the real LIGGGHTS, against what the canonical law says by hand.

namespace powdercal {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRadius = 1.45e-5;
constexpr double kDensity = 8220;
constexpr double kYoung = 5e6;
constexpr double kPoisson = 0.3;
constexpr double kSpeed = 0.01;

double Mass() { return kDensity * 4 / 3 * kPi * kRadius * kRadius * kRadius; }

Sphere At(std::int64_t id, const Vector3& position, const Vector3& velocity) {
  return {id, kRadius, position, velocity, {}};
}

// In an open box of ten diameters about the origin, without gravity, for one Advance.
Program Spheres(const Packing& packing) {
  Program program{.experiment = "test"};
  program.particles.packing = packing;
  const ContactParameters contact = {.restitution = 0.4, .friction = 0.3};
  program.materials = {.density = kDensity,
                       .young_modulus = kYoung,
                       .poisson_ratio = kPoisson,
                       .particle_particle = contact,
                       .particle_wall = contact};
  program.domain = {
      {-3e-4, -3e-4, -3e-4}, {3e-4, 3e-4, 3e-4}, {Boundary::open, Boundary::open, Boundary::open}};
  program.gravity = {0, 0, 0};
  program.time_step = 0.02 * RayleighTime(kRadius, kDensity, kYoung, kPoisson);
  program.stages = {Advance{.duration = 4e-5}};
  return program;
}

// Two spheres that meet along x, each at half the speed.
Program HeadOn() {
  return Spheres({At(1, {-1.0001 * kRadius, 0, 0}, {0.5 * kSpeed, 0, 0}),
                  At(2, {1.0001 * kRadius, 0, 0}, {-0.5 * kSpeed, 0, 0})});
}

// A sphere thrown against a plane that leaves it on the side of larger coordinates, or of smaller
// ones; with half of that speed along another axis, too.
Program OnPlane(int axis, bool positive, bool frictionless) {
  const double sign = positive ? 1 : -1;
  Sphere sphere = At(1, {}, {});
  sphere.position[axis] = sign * 1.0001 * kRadius;
  sphere.velocity[axis] = -sign * kSpeed;
  sphere.velocity[(axis + 1) % 3] = 0.5 * kSpeed;
  Program program = Spheres({sphere});
  program.walls = {
      {.name = "plane", .axis = axis, .facing_positive = positive, .frictionless = frictionless}};
  return program;
}

Trace Simulate(const Program& program) {
  const TemporaryFolder folder;
  Trace trace = MakeLiggghtsBackend()->Run(program, {.work_folder = folder / "run"});
  EXPECT_TRUE(trace.outcome.ok()) << trace.outcome.message;
  return trace;
}

Packing EndOf(const Program& program) {
  const Trace trace = Simulate(program);
  return trace.moments.empty() ? Packing(2) : trace.moments.back().packing;
}

double Separation(const Packing& packing) {
  const Vector3& a = packing[0].position;
  const Vector3& b = packing[1].position;
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

// physics.md: 0.4 is 0.39997 as measured, but 0.472 with the force limited.
TEST(LiggghtsLaw, HeadOnImpactHasTheRestitution) {
  Program program = HeadOn();
  const Packing free = EndOf(program);
  ASSERT_GT(Separation(free), 2 * kRadius) << "they have parted";
  EXPECT_NEAR(free[1].velocity[0] / (0.5 * kSpeed), 0.4, 1e-3);
  EXPECT_EQ(free[0].velocity[0], -free[1].velocity[0]);
  program.law.limit_force = true;
  EXPECT_NEAR(EndOf(program)[1].velocity[0] / (0.5 * kSpeed), 0.472, 1e-3);
}

TEST(LiggghtsLaw, PlanesOfEveryAxisAreAlike) {
  const Sphere onto_x = EndOf(OnPlane(0, true, false))[0];
  EXPECT_NEAR(onto_x.velocity[0] / kSpeed, 0.4, 5e-4);
  EXPECT_LT(onto_x.velocity[1], 0.5 * kSpeed) << "friction";
  EXPECT_GT(onto_x.spin[2], 1) << "and the spin that it brings";
  for (const int axis : {0, 1, 2}) {
    for (const bool positive : {true, false}) {
      const Sphere s = EndOf(OnPlane(axis, positive, false))[0];
      const double sign = positive ? 1 : -1;
      EXPECT_NEAR(sign * s.velocity[axis], onto_x.velocity[0], 1e-12 * kSpeed) << axis;
      EXPECT_NEAR(s.velocity[(axis + 1) % 3], onto_x.velocity[1], 1e-12 * kSpeed) << axis;
      EXPECT_NEAR(sign * s.spin[(axis + 2) % 3], onto_x.spin[2], 1e-9 * onto_x.spin[2]) << axis;
    }
  }
}

// Friction, rolling friction and cohesion are those of other walls.
TEST(LiggghtsLaw, FrictionlessPlaneGivesTheNormalForceAlone) {
  for (const auto tangential :
       {ContactLaw::Tangential::history, ContactLaw::Tangential::no_history}) {
    Program program = OnPlane(2, true, true);
    program.law.tangential = tangential;
    program.law.rolling = ContactLaw::Rolling::epsd2;
    program.law.cohesion = ContactLaw::Cohesion::sjkr2;
    program.materials.particle_wall.rolling_friction = 0.5;
    program.materials.particle_wall.cohesion_energy_density = 2e5;
    program.particles.packing->front().spin = {100, 200, 300};
    const Sphere s = EndOf(program)[0];
    EXPECT_NEAR(s.velocity[2] / kSpeed, 0.4, 5e-4);
    EXPECT_EQ(s.velocity[0], 0.5 * kSpeed);
    EXPECT_EQ(s.spin, (Vector3{100, 200, 300}));
  }
}

// What the particles' side of a contact keeps: xi, its velocity, or delta and its own, after `time`
// of a free, damped oscillation that begins with `speed`.
double OscillatorSpeed(double stiffness, double damping, double mass, double speed, double time) {
  const double decay = damping / (2 * mass);
  const double omega = std::sqrt(stiffness / mass - decay * decay);
  return speed * std::exp(-decay * time) *
         (std::cos(omega * time) - decay / omega * std::sin(omega * time));
}

Program LinearHeadOn(const LinearStiffness& linear) {
  Program program = HeadOn();
  program.law.normal = ContactLaw::Normal::linear;
  program.materials.linear = linear;
  program.materials.particle_particle.friction = 100;
  (*program.particles.packing)[0].position[0] = -kRadius;  // just touching
  (*program.particles.packing)[1].position[0] = kRadius;
  const double mass = Mass() / 2;
  const double decay = linear.normal_damping / (2 * mass);
  const double half = kPi / std::sqrt(linear.normal / mass - decay * decay);
  program.time_step = half / 4000;
  program.stages = {Advance{.duration = half}};
  return program;
}

TEST(LiggghtsLaw, LinearContactLastsHalfAPeriod) {
  const double mass = Mass() / 2;
  for (const double damping : {0.0, 2e-5}) {
    const LinearStiffness linear = {.normal = 10, .normal_damping = damping};
    const Program program = LinearHeadOn(linear);
    const Packing end = EndOf(program);
    EXPECT_NEAR(Separation(end) / (2 * kRadius), 1, 1e-6) << damping;
    const double expected = OscillatorSpeed(linear.normal, damping, mass, kSpeed,
                                            std::get<Advance>(program.stages[0]).duration);
    EXPECT_LT(expected, -0.2 * kSpeed);
    EXPECT_NEAR(end[0].velocity[0] - end[1].velocity[0], expected, 1e-3 * kSpeed) << damping;
  }
}

// Against rolling, the spring xi moves the mass 2/7 m*: at k_t = 2/7 k_n its half period is that of
// the normal spring, and the surfaces leave one another with the speed reversed.
TEST(LiggghtsLaw, LinearTangentialSpringAndDamper) {
  const double mass = Mass() / 2 * 2 / 7;
  for (const double damping : {0.0, 4e-6}) {
    const LinearStiffness linear = {
        .normal = 10, .tangential = 10 * 2.0 / 7, .tangential_damping = damping};
    Program program = LinearHeadOn(linear);
    const double slip = 0.01 * kSpeed;
    (*program.particles.packing)[0].velocity[1] = slip;
    const Packing end = EndOf(program);
    // Surface of the first against that of the second.
    const double left =
        end[0].velocity[1] - end[1].velocity[1] + kRadius * (end[0].spin[2] + end[1].spin[2]);
    const double expected = OscillatorSpeed(linear.tangential, damping, mass, slip,
                                            std::get<Advance>(program.stages[0]).duration);
    EXPECT_NEAR(left, expected, 5e-3 * slip) << damping;
  }
}

// From rest, one step gives v = F dt/m but for the force's change within the step.
TEST(LiggghtsLaw, DmtPullsWithFourPiGammaRWhileTouching) {
  const double gamma = 1e-4;
  const double reduced = kRadius / 2;
  for (const double overlap : {1e-12, 1e-9, -1e-12}) {
    Program program = Spheres(
        {At(1, {-kRadius + overlap / 2, 0, 0}, {}), At(2, {kRadius - overlap / 2, 0, 0}, {})});
    program.law.cohesion = ContactLaw::Cohesion::dmt;
    program.materials.particle_particle = {.restitution = 1, .surface_energy = gamma};
    program.time_step = 1e-9;
    program.stages = {Advance{.duration = 1e-9}};
    const double pull = overlap < 0 ? 0 : PullOffForceDmt(gamma, reduced);
    const double push = 4.0 / 3 * EffectiveModulus(kYoung, kPoisson) * std::sqrt(reduced) *
                        std::pow(std::max(0.0, overlap), 1.5);
    EXPECT_NEAR(EndOf(program)[0].velocity[0], (pull - push) * 1e-9 / Mass(),
                1e-7 * PullOffForceDmt(gamma, reduced) * 1e-9 / Mass())
        << overlap;
  }
}

// A constant pull does as much work on the way in as on the way out, however often they meet.
TEST(LiggghtsLaw, DmtTakesNoEnergy) {
  Program program = HeadOn();
  program.law.cohesion = ContactLaw::Cohesion::dmt;
  program.materials.particle_particle = {.restitution = 1, .friction = 0.3, .surface_energy = 1e-4};
  program.materials.particle_wall = {.restitution = 1};
  program.walls = {{.name = "left", .axis = 0, .position = -3 * kRadius},
                   {.name = "right", .axis = 0, .position = 3 * kRadius, .facing_positive = false}};
  program.stages = {Advance{.duration = 60 * kRadius / kSpeed, .packing_every = 2000}};
  const Trace trace = Simulate(program);
  int apart = 0;
  for (const Moment& moment : trace.moments) {
    const double separation = Separation(moment.packing);  // 4 R at the walls
    if (separation < 2.001 * kRadius || separation > 3.999 * kRadius) continue;
    ++apart;
    EXPECT_NEAR(std::abs(moment.packing[0].velocity[0]) / (0.5 * kSpeed), 1, 2e-3) << moment.time;
  }
  EXPECT_GT(apart, 10);
}

TEST(LiggghtsLaw, DmtLeavesWallsAlone) {
  Program program = OnPlane(2, true, false);
  const Sphere dry = EndOf(program)[0];
  program.law.cohesion = ContactLaw::Cohesion::dmt;
  program.materials.particle_particle.surface_energy = 1e-4;
  EXPECT_EQ(EndOf(program)[0].velocity, dry.velocity);
}

// A sphere hops on another that rests on the floor, never far enough for a new neighbour list. A
// contact that begins anew must not find the spring of the one before: going on is the same as
// starting again from the packing in the air.
TEST(LiggghtsLaw, ContactsForgetTheirSpringsWhenTheyEnd) {
  Program program = Spheres({At(1, {0, 0, kRadius}, {}), At(2, {0, 0, 3.0002 * kRadius}, {})});
  (*program.particles.packing)[1].spin = {0, 200, 0};
  (*program.particles.packing)[1].velocity[2] = -kSpeed;
  program.materials.particle_particle.restitution = 0.8;
  program.materials.particle_wall.restitution = 1;  // undamped, for an exact start anew
  program.walls = {{.name = "floor", .frictionless = true}};
  program.gravity = {0, 0, -30};
  program.stages = {Advance{.name = "hop", .duration = 3e-3, .packing_every = 50}};
  const Trace trace = Simulate(program);
  // The first packing in the air after the spheres have met, and the next after they met again.
  std::size_t parted = 0;
  std::size_t again = 0;
  bool met = false;
  for (std::size_t i = 0; i < trace.moments.size() && again == 0; ++i) {
    const bool touching = Separation(trace.moments[i].packing) < 2 * kRadius;
    if (!touching && met) (parted == 0 ? parted : again) = i;
    met = touching || (met && parted == 0);
  }
  ASSERT_GT(again, parted);
  ASSERT_GT(parted, 0u);
  const Packing& end = trace.moments[again].packing;
  Program anew = program;
  anew.particles.packing = trace.moments[parted].packing;
  anew.stages = {Advance{.duration = trace.moments[again].time - trace.moments[parted].time}};
  const Packing from_anew = EndOf(anew);
  EXPECT_NEAR(from_anew[1].spin[1], end[1].spin[1], 1e-6 * std::abs(end[1].spin[1]));
  EXPECT_GT(std::abs(end[1].spin[1] - trace.moments[parted].packing[1].spin[1]), 1)
      << "the second contact matters";
}

}  // namespace
}  // namespace powdercal

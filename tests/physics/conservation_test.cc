#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

struct Momenta {
  Vector3 linear{};       // [kg m/s]
  Vector3 angular{};      // [kg m²/s] about the origin, spins included
  double linear_sum = 0;  // of sizes, for scale
  double angular_sum = 0;
};

Momenta MomentaOf(const Packing& packing) {
  Momenta momenta;
  for (const Sphere& s : packing) {
    const Vector3 p = MassOf(s.radius) * s.velocity;
    const Vector3 l = Cross(s.position, p) + InertiaOf(s.radius) * s.spin;
    momenta.linear = momenta.linear + p;
    momenta.angular = momenta.angular + l;
    momenta.linear_sum += Length(p);
    momenta.angular_sum += Length(l);
  }
  return momenta;
}

Vector3 RandomVector(RandomStream& random, double size) {
  return {random.Uniform(-size, size), random.Uniform(-size, size), random.Uniform(-size, size)};
}

// A loose cubic heap of `n`³ spheres of 8 to 15 µm, in motion.
Packing Heap(int n, double speed, double spacing = 2.02 * kRadius) {
  RandomStream random = RandomStream(5);
  Packing packing;
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < n; ++y) {
      for (int z = 0; z < n; ++z) {
        const Vector3 at = {x - 0.5 * (n - 1), y - 0.5 * (n - 1), z - 0.5 * (n - 1)};
        const Vector3 velocity = RandomVector(random, speed) - (speed / n) * at;
        packing.push_back(Ball(static_cast<std::int64_t>(packing.size()) + 1,
                               kRadius * random.Uniform(0.55, 1), spacing * at, velocity,
                               RandomVector(random, speed / kRadius)));
      }
    }
  }
  return packing;
}

struct LawCase {
  std::string name;
  ContactLaw law;
};

std::vector<LawCase> Laws() {
  ContactLaw sticky;
  sticky.cohesion = ContactLaw::Cohesion::sjkr2;
  sticky.rolling = ContactLaw::Rolling::epsd2;
  ContactLaw constant = sticky;
  constant.rolling = ContactLaw::Rolling::cdt;
  constant.cohesion = ContactLaw::Cohesion::dmt;
  constant.torsion = false;
  ContactLaw incremental = sticky;
  incremental.shear_update = ContactLaw::ShearUpdate::incremental;
  incremental.limit_force = true;
  ContactLaw viscous;
  viscous.tangential = ContactLaw::Tangential::no_history;
  ContactLaw linear = sticky;
  linear.normal = ContactLaw::Normal::linear;
  return {{"epsd2, sjkr2", sticky},
          {"cdt without torsion, dmt", constant},
          {"incremental, limit_force", incremental},
          {"no_history", viscous},
          {"linear", linear}};
}

Program InMotion(const Packing& packing, const ContactLaw& law) {
  Program program = Vacuum(packing, 4e-7);
  program.law = law;
  SetContact(program, {.restitution = 0.5,
                       .friction = 0.4,
                       .rolling_friction = 0.2,
                       .cohesion_energy_density = 20000,
                       .surface_energy = 1e-5});
  program.materials.linear = {2, 1, 1e-6, 1e-6};
  return program;
}

TEST(Conservation, FreeClusterKeepsLinearAndAngularMomentum) {
  for (const LawCase& law : Laws()) {
    const Program program = InMotion(Heap(6, 0.02), law.law);
    const Momenta before = MomentaOf(*program.particles.packing);
    const Momenta after = MomentaOf(After(program, 2e-3));
    const double linear = Length(after.linear - before.linear) / before.linear_sum;
    const double angular = Length(after.angular - before.angular) / before.angular_sum;
    Measured("change of linear momentum, " + law.name, linear);
    Measured("change of angular momentum, " + law.name, angular);
    EXPECT_LT(linear, 1e-13) << law.name;
    EXPECT_LT(angular, 1e-12) << law.name;
    EXPECT_LT(after.linear_sum, 0.9 * before.linear_sum) << "they did not meet";
  }
}

TEST(Conservation, PeriodicBoxKeepsLinearMomentum) {
  for (const LawCase& law : Laws()) {
    Program program = InMotion(Heap(6, 0.02), law.law);
    const double edge = 6 * 2.02 * kRadius;
    program.domain = {{-0.5 * edge, -0.5 * edge, -0.5 * edge},
                      {0.5 * edge, 0.5 * edge, 0.5 * edge},
                      {Boundary::periodic, Boundary::periodic, Boundary::periodic}};
    const Momenta before = MomentaOf(*program.particles.packing);
    const Momenta after = MomentaOf(After(program, 2e-3));
    EXPECT_LT(Length(after.linear - before.linear), 1e-13 * before.linear_sum) << law.name;
  }
}

TEST(Conservation, NothingBecomesNotANumber) {
  for (LawCase law : Laws()) {
    // Alike in every motion, at rest, in touch: every "direction of" is that of a null vector.
    for (const Vector3& velocity : {Vector3{}, Vector3{0.01, 0.02, -0.03}}) {
      Packing packing = {Ball(1, kRadius, {}, velocity),
                         Ball(2, kRadius, {1.99 * kRadius, 0, 0}, velocity),
                         Ball(3, kRadius, {0, 2 * kRadius, 0}, velocity),
                         Ball(4, kRadius, {0, 0, 2.1 * kRadius}, velocity)};
      Program program = InMotion(packing, law.law);
      program.walls = {Floor(-0.99 * kRadius)};
      for (const Sphere& s : After(program, 1e-4)) {
        EXPECT_TRUE(std::isfinite(Length(s.position) + Length(s.velocity) + Length(s.spin)))
            << law.name;
      }
    }
  }
}

// 125 spheres in a periodic box, elastic and without friction.
Program Gas(double time_step) {
  Program program = Vacuum(Heap(5, 0.05, 2.5 * kRadius), time_step);
  for (Sphere& s : *program.particles.packing) s.spin = {};
  const double edge = 5 * 2.5 * kRadius;
  program.domain = {{-0.5 * edge, -0.5 * edge, -0.5 * edge},
                    {0.5 * edge, 0.5 * edge, 0.5 * edge},
                    {Boundary::periodic, Boundary::periodic, Boundary::periodic}};
  return program;
}

TEST(Conservation, ElasticGasKeepsItsEnergyForAHundredThousandSteps) {
  const double step = 2e-8;  // a sixtieth of the shortest impact
  Program program = Gas(step);
  double first = 0;
  for (const Sphere& s : *program.particles.packing) {
    first += 0.5 * MassOf(s.radius) * Dot(s.velocity, s.velocity);
  }
  double worst = 0, drift = 0;
  for (const double steps : {1e4, 2e4, 5e4, 1e5}) {
    Program run = program;
    run.stages = {Advance{.duration = steps * step}};
    const Trace trace = RunOk(run);
    const double energy =
        trace.diagnostics.kinetic_energy + trace.diagnostics.figures.at("elastic_energy");
    drift = energy / first - 1;
    worst = std::max(worst, std::abs(drift));
  }
  Measured("drift of the energy over 1e5 steps", drift);
  Measured("largest error of the energy seen", worst);
  EXPECT_LT(worst, 1e-4);
}

TEST(Conservation, FallsAlongAParabola) {
  Program program =
      Vacuum({Ball(1, kRadius, {0.001, -0.002, 0.003}, {0.01, 0.02, 0.03}, {1, 2, 3})}, 1e-6);
  program.gravity = {1, -2, -9.81};
  const double time = 0.01;
  const Sphere start = program.particles.packing->front();
  const Sphere end = After(program, time)[0];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double way = start.velocity[axis] * time + 0.5 * program.gravity[axis] * time * time;
    EXPECT_NEAR(end.position[axis], start.position[axis] + way, 1e-12 * 0.001);
    EXPECT_NEAR(end.velocity[axis], start.velocity[axis] + time * program.gravity[axis],
                1e-12 * 0.1);
  }
  EXPECT_EQ(end.spin, start.spin);
}

}  // namespace
}  // namespace powdercal::physics

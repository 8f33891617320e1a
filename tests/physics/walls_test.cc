#include <gtest/gtest.h>

#include "backends/embedded/mesh_shapes.h"
#include "core/random.h"
#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

using embedded::MakeRectangle;
using embedded::MakeRidgedPlate;

// Largest difference of positions (over the radius), velocities (over `speed`) and spins of two
// runs.
double Difference(const std::vector<Moment>& a, const std::vector<Moment>& b, double speed) {
  EXPECT_FALSE(a.empty());
  EXPECT_EQ(a.size(), b.size());
  double worst = 0;
  for (std::size_t m = 0; m < std::min(a.size(), b.size()); ++m) {
    EXPECT_EQ(a[m].packing.size(), b[m].packing.size());
    for (std::size_t p = 0; p < a[m].packing.size(); ++p) {
      const Sphere& s = a[m].packing[p];
      const Sphere& t = b[m].packing[p];
      worst = std::max({worst, Length(s.position - t.position) / kRadius,
                        Length(s.velocity - t.velocity) / speed,
                        kRadius * Length(s.spin - t.spin) / speed});
    }
  }
  return worst;
}

// A plate at z = 0 of irregular triangles, all sizes from much below the sphere's contact to above.
Mesh ShakenPlate(double size, int cells, std::uint64_t seed) {
  Mesh mesh = MakeRectangle("plate", {-0.5 * size, -0.5 * size, 0}, {size, 0, 0}, {0, size, 0},
                            cells, cells);
  RandomStream random = RandomStream(seed);
  for (Vector3& v : mesh.vertices) {
    if (std::abs(v[0]) > 0.499 * size || std::abs(v[1]) > 0.499 * size) continue;
    v[0] += 0.3 * size / cells * random.Uniform(-1, 1);
    v[1] += 0.3 * size / cells * random.Uniform(-1, 1);
  }
  return mesh;
}

Program RollingBall(ContactLaw::Rolling rolling = ContactLaw::Rolling::epsd2) {
  Program program = OnFloor({.restitution = 0.5, .friction = 0.3, .rolling_friction = 0.01});
  program.law.rolling = rolling;
  program.particles.packing->front().velocity = {0.02, 0.007, 0};
  program.particles.packing->front().spin = {100, -300, 200};
  return program;
}

TEST(MeshWall, SphereRollsOverManyTrianglesAsOverAPlane) {
  for (const ContactLaw::ShearUpdate update :
       {ContactLaw::ShearUpdate::displacement, ContactLaw::ShearUpdate::incremental}) {
    for (const int cells : {1, 30, 100}) {
      Program plane = RollingBall();
      plane.law.shear_update = update;
      Program mesh = plane;
      mesh.walls.clear();
      mesh.meshes = {ShakenPlate(60 * kRadius, cells, 3)};
      const double difference =
          Difference(Trajectory(plane, 0.005, 500), Trajectory(mesh, 0.005, 500), 0.02);
      Measured(fmt::format("plate of {} triangles against a plane", 2 * cells * cells), difference);
      EXPECT_LT(difference, 1e-9);
    }
  }
}

TEST(MeshWall, BedLiesOnAPlateAsOnAPlane) {
  RandomStream random = RandomStream(8);
  Packing packing;
  for (int n = 0; n < 64; ++n) {
    packing.push_back(Ball(n + 1, kRadius * random.Uniform(0.7, 1),
                           {2.1 * kRadius * (n % 4 - 1.5), 2.1 * kRadius * (n / 4 % 4 - 1.5),
                            kRadius * (1.05 + 2.1 * (n / 16))},
                           {random.Uniform(-0.01, 0.01), random.Uniform(-0.01, 0.01), -0.02}));
  }
  Program plane = Vacuum(packing, 5e-7);
  SetContact(plane, {.restitution = 0.5, .friction = 0.3, .cohesion_energy_density = 5000});
  plane.law.cohesion = ContactLaw::Cohesion::sjkr2;
  plane.gravity = {0, 0, -kGravity};
  plane.walls = {Floor()};
  Program mesh = plane;
  mesh.walls.clear();
  mesh.meshes = {ShakenPlate(100 * kRadius, 60, 4)};
  // Chaos multiplies rounding in every collision.
  const double difference =
      Difference(Trajectory(plane, 1e-3, 2000), Trajectory(mesh, 1e-3, 2000), 0.02);
  Measured("64 spheres on a plate against a plane", difference);
  EXPECT_LT(difference, 1e-9);
}

// A plate as wide as the periodic domain has no edge where it meets its own image.
TEST(MeshWall, PlateAcrossAPeriodicSideIsAPlane) {
  const double width = 10 * kRadius;
  for (const bool both : {false, true}) {
    Program plane = RollingBall();
    plane.domain.lower[0] = -0.5 * width;
    plane.domain.upper[0] = 0.5 * width;
    plane.domain.boundaries[0] = Boundary::periodic;
    Vector3 origin = {-0.5 * width, -30 * kRadius, 0};
    Vector3 across = {0, 60 * kRadius, 0};
    if (both) {
      plane.domain.lower[1] = -0.5 * width;
      plane.domain.upper[1] = 0.5 * width;
      plane.domain.boundaries[1] = Boundary::periodic;
      origin[1] = -0.5 * width;
      across[1] = width;
    }
    Program mesh = plane;
    mesh.walls.clear();
    mesh.meshes = {MakeRectangle("plate", origin, {width, 0, 0}, across, 5, 7)};
    // Some dozen crossings of x.
    const double difference =
        Difference(Trajectory(plane, 0.05, 1000), Trajectory(mesh, 0.05, 1000), 0.02);
    Measured("periodic plate against a plane", difference);
    EXPECT_LT(difference, 1e-9);
  }
}

// The plate moves on under its images, by several widths of the domain.
TEST(MeshWall, PeriodicPlateSlidesAsAPlaneDoes) {
  const double width = 10 * kRadius;
  Program plane = RollingBall();
  plane.domain.lower[0] = -0.5 * width;
  plane.domain.upper[0] = 0.5 * width;
  plane.domain.boundaries[0] = Boundary::periodic;
  Program mesh = plane;
  mesh.walls.clear();
  mesh.meshes = {MakeRectangle("floor", {-0.5 * width, -30 * kRadius, 0}, {width, 0, 0},
                               {0, 60 * kRadius, 0}, 5, 7)};
  const Motion slide = {.body = "floor", .velocity = {-0.06, 0.01, 0}};
  const double difference =
      Difference(Trajectory(plane, 0.01, 500, {slide}), Trajectory(mesh, 0.01, 500, {slide}), 0.06);
  Measured("sliding periodic plate against a sliding plane", difference);
  EXPECT_LT(difference, 1e-9);
}

// Ridges that end in a valley at the periodic side go on as those of an endless plate.
TEST(MeshWall, PeriodicRidgesAreEndless) {
  const double width = 12 * kRadius;
  const auto over = [&](bool periodic) {
    Program program = RollingBall();
    program.walls.clear();
    program.particles.packing->front().position = {0.3 * kRadius, 0, 2.5 * kRadius};
    program.particles.packing->front().velocity = {0.05, 0.01, 0};
    const double length = periodic ? width : 41 * width;
    if (periodic) {
      program.domain.lower[0] = -0.5 * width;
      program.domain.upper[0] = 0.5 * width;
      program.domain.boundaries[0] = Boundary::periodic;
    }
    program.meshes = {MakeRidgedPlate("ridges", {-0.5 * length, -100 * kRadius, 0}, length,
                                      200 * kRadius, 4 * kRadius, 0.4 * kRadius, 3)};
    return Trajectory(program, 0.01, 500, {{.body = "ridges", .velocity = {-0.1, 0, 0}}});
  };
  std::vector<Moment> endless = over(false);
  const double way = endless.back().packing[0].position[0];
  EXPECT_GT(std::abs(way + 0.1 * 0.01), width) << "over the seam";
  for (Moment& moment : endless) {
    double& x = moment.packing[0].position[0];
    x -= width * std::floor(x / width + 0.5);
  }
  const double difference = Difference(endless, over(true), 0.05);
  Measured("periodic ridges against endless ones", difference);
  EXPECT_LT(difference, 1e-7);
}

TEST(MeshWall, RidgesDoNotFeelHowTheyAreCut) {
  const auto over = [](int strips) {
    Program program = RollingBall();
    program.walls.clear();
    program.particles.packing->front().position = {0, 0, 2 * kRadius};
    program.particles.packing->front().velocity = {0.05, 0.01, 0};
    program.meshes = {MakeRidgedPlate("ridges", {-100 * kRadius, -100 * kRadius, 0}, 200 * kRadius,
                                      200 * kRadius, 4 * kRadius, kRadius, strips)};
    return Trajectory(program, 5e-3, 200);
  };
  const std::vector<Moment> plain = over(1);
  EXPECT_GT(plain.back().packing[0].position[0], 3 * kRadius);
  for (const int strips : {7, 200}) {
    // Impacts on the flanks multiply rounding.
    const double difference = Difference(plain, over(strips), 0.05);
    Measured(fmt::format("ridges of {} strips against one", strips), difference);
    EXPECT_LT(difference, 1e-9);
  }
}

TEST(MeshWall, FrictionlessRidgeKeepsTheEnergy) {
  Program program = OnFloor({.restitution = 1});
  program.time_step = 2e-8;
  program.walls.clear();
  program.meshes = {MakeRidgedPlate("ridge", {-2 * kRadius, -10 * kRadius, 0}, 4 * kRadius,
                                    20 * kRadius, 4 * kRadius, kRadius)};
  Sphere& start = program.particles.packing->front();
  start.position = {-1.5 * kRadius, 0, 4 * kRadius};
  const auto energy = [&](const Sphere& s) {
    return 0.5 * Dot(s.velocity, s.velocity) + kGravity * s.position[2];
  };
  const double before = energy(start);
  const Sphere end = After(program, 5e-3)[0];
  EXPECT_GT(Length(end.position - start.position), 3 * kRadius);
  Measured("relative change of the energy after a ridge", energy(end) / before - 1);
  EXPECT_NEAR(energy(end) / before, 1, 1e-4);
}

Mesh Blade(double x) {
  return MakeRectangle("blade", {x, -10 * kRadius, -10 * kRadius}, {0, 20 * kRadius, 0},
                       {0, 0, 20 * kRadius}, 3, 3);
}

TEST(MeshWall, BladeGivesItsVelocity) {
  const double speed = 0.025;
  const Motion push = {.body = "blade", .velocity = {speed, 0, 0}};
  for (const double e : {0.3, 1.0}) {
    Program program = Vacuum({Ball(1, kRadius, {1.001 * kRadius, 0, 0})}, 1e-8);
    SetContact(program, {.restitution = e});
    program.meshes = {Blade(0)};
    const std::vector<Moment> way = Trajectory(program, 1e-3, 1000, {push});
    EXPECT_NEAR(way.back().packing[0].velocity[0] / speed, 1 + e, 1e-3);
    EXPECT_NEAR(way.back().walls.at("blade").displacement[0], speed * way.back().time, 1e-12);
  }
}

TEST(MeshWall, BladePushesAcrossAFloor) {
  const double speed = 0.025;
  Program program = OnFloor({.restitution = 0.3, .friction = 0.3, .rolling_friction = 0.1});
  program.law.rolling = ContactLaw::Rolling::epsd2;
  program.meshes = {Blade(-1.001 * kRadius)};
  const std::vector<Moment> way =
      Trajectory(program, 0.02, 100000, {{.body = "blade", .velocity = {speed, 0, 0}}});
  const Sphere& end = way.back().packing[0];
  EXPECT_NEAR(end.velocity[0] / speed, 1, 1e-6);
  // Both walls together bear the weight, and nothing accelerates.
  const Vector3 blade = way.back().walls.at("blade").force;
  const Vector3 floor = way.back().walls.at("floor").force;
  EXPECT_NEAR(blade[0] + floor[0], 0, 1e-6 * MassOf(kRadius) * kGravity);
  EXPECT_NEAR(blade[2] + floor[2], -MassOf(kRadius) * kGravity, 1e-6 * MassOf(kRadius) * kGravity);
}

// A sphere that rolls on a turntable goes round a circle of its own with 2/7 of the table's spin
// (Weltner 1987): its acceleration is (2/7) Ω × v.
TEST(MeshWall, TurntableTakesARollingSphereRoundWithTwoSevenths) {
  const double spin = 400;
  Program program = OnFloor({.restitution = 0.3, .friction = 1});
  program.time_step = 4e-7;
  program.walls.clear();
  program.meshes = {ShakenPlate(60 * kRadius, 10, 6)};
  const double radius = 20 * kRadius;
  const double speed = 2.0 / 7 * spin * radius;
  Sphere& start = program.particles.packing->front();
  // About the origin: v = (2/7) Ω × r rolls with the spin that rolling on a turning table asks for,
  // v − Ω × r = R ω × (−z)·… solved for ω.
  start.position[0] = radius;
  start.velocity = {0, speed, 0};
  const double relative = speed - spin * radius;  // of the centre against the table
  start.spin = {-relative / kRadius, 0, 0};
  const double period = 2 * kPi / (2.0 / 7 * spin);
  const std::vector<Moment> way =
      Trajectory(program, period, 20000, {{.body = "plate", .spin = {0, 0, spin}}});
  double worst = 0;
  for (const Moment& moment : way) {
    const Vector3& x = moment.packing[0].position;
    const double angle = 2.0 / 7 * spin * moment.time;
    worst = std::max(worst,
                     std::hypot(x[0] - radius * std::cos(angle), x[1] - radius * std::sin(angle)));
  }
  Measured("departure from the circle over its radius", worst / radius);
  EXPECT_LT(worst, 0.01 * radius);
}

}  // namespace
}  // namespace powdercal::physics

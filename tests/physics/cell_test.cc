#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

constexpr double kEdge = 12 * kRadius;

void MakePeriodic(Program& program, const Vector3& lengths = {kEdge, kEdge, kEdge}) {
  program.domain = {
      -0.5 * lengths, 0.5 * lengths, {Boundary::periodic, Boundary::periodic, Boundary::periodic}};
}

ContactParameters Sticky() {
  return {.restitution = 0.5,
          .friction = 0.3,
          .rolling_friction = 0.1,
          .cohesion_energy_density = 10000};
}

// Two spheres that collide obliquely, spinning; the first one at `at`.
Packing Colliding(const Vector3& at) {
  return {Ball(1, kRadius, at, {0.02, 0.01, -0.005}, {100, 200, -300}),
          Ball(2, 0.8 * kRadius, at + kRadius * Vector3{1.5, 0.6, 1.0}, {-0.03, -0.01, -0.03},
               {50, -400, 30})};
}

Program Collision(const Packing& packing) {
  Program program = Vacuum(packing, 5e-8);
  SetContact(program, Sticky());
  program.law.cohesion = ContactLaw::Cohesion::sjkr2;
  program.law.rolling = ContactLaw::Rolling::epsd2;
  return program;
}

double Fraction(double x) { return x - std::round(x); }

// How far two sphere pairs differ in relative position, velocities and spins: of the second sphere
// against the first one, at its nearest image in the cell.
double Difference(const Packing& a, const Packing& b) {
  double worst = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double way =
        (a[1].position[axis] - a[0].position[axis]) - (b[1].position[axis] - b[0].position[axis]);
    worst = std::max(worst, std::abs(Fraction(way / kEdge)) * kEdge / kRadius);
  }
  for (std::size_t p = 0; p < 2; ++p) {
    worst = std::max(
        {worst, Length(a[p].velocity - b[p].velocity) / 0.03, Length(a[p].spin - b[p].spin) / 400});
  }
  return worst;
}

TEST(PeriodicCell, CollisionIsTheSameWhereverItIs) {
  Program inside = Collision(Colliding({}));
  MakePeriodic(inside);
  const Packing expected = After(inside, 5e-4);
  EXPECT_GT(Length(expected[0].velocity - inside.particles.packing->front().velocity), 1e-3);
  RandomStream random = RandomStream(1);
  double worst = 0;
  for (int n = 0; n < 40; ++n) {
    Vector3 at;
    for (double& x : at)
      x = 0.5 * kEdge *
          (n < 8 ? (n >> (&x - at.data()) & 1 ? 0.99 : -0.99) : random.Uniform(-1, 1));
    Packing packing = Colliding(at);
    for (Sphere& s : packing) {
      for (double& x : s.position) x = kEdge * Fraction(x / kEdge);
    }
    Program program = Collision(packing);
    MakePeriodic(program);
    worst = std::max(worst, Difference(After(program, 5e-4), expected));
  }
  Measured("collision anywhere in a periodic cell against its middle", worst);
  EXPECT_LT(worst, 1e-10);
}

TEST(OpenDomain, AParticleThatLeavesIsLost) {
  Program program =
      Vacuum({Ball(1, kRadius, {}, {1, 0, 0}), Ball(2, kRadius, {0.001, 0, 0})}, 1e-6);
  program.stages = {Advance{.duration = 0.1}};
  const Trace trace = RunProgram(program);
  EXPECT_EQ(trace.outcome.reason, Reason::lost_particles);
  EXPECT_EQ(trace.diagnostics.lost_particles, 1);
  EXPECT_TRUE(trace.moments.empty());
  EXPECT_LT(static_cast<double>(trace.diagnostics.steps) * 1e-6, 0.011) << "seen at once";
}

TEST(OutflowDomain, LeaversAreCountedAndTheRestGoesOn) {
  Packing packing;
  for (int n = 0; n < 10; ++n) {
    const double way = n < 4 ? 1 : -0.01;
    packing.push_back(Ball(n + 1, kRadius, {0, 1e-4 * n, 0}, {way, 0, 0}));
  }
  Program program = Vacuum(packing, 1e-6);
  program.domain.boundaries[0] = Boundary::outflow;
  program.stages = {Advance{.name = "out", .duration = 0.015}};
  const Trace trace = RunOk(program);
  EXPECT_EQ(trace.diagnostics.leavers, 4);
  const Packing& rest = trace.moments.back().packing;
  ASSERT_EQ(rest.size(), 6U);
  EXPECT_EQ(rest.front().id, 5);
  for (const Sphere& s : rest) EXPECT_NEAR(s.position[0], -0.01 * 0.015, 1e-15);
}

// --- Deformation --------------------------------------------------------------------------------

Deform Strain(const Vector3& rates, double shear_rate, double duration) {
  Deform deform{.duration = duration, .shear_rate = shear_rate};
  for (std::size_t axis = 0; axis < 3; ++axis) deform.edges[axis].value = rates[axis];
  return deform;
}

TEST(DeformedCell, EdgesGrowExponentially) {
  const Vector3 rates = {3, -5, 2};
  const double time = 0.05;
  Program program = Vacuum({Ball(1, kRadius, {})}, 1e-6);
  MakePeriodic(program);
  program.stages = {Strain(rates, 0, time)};
  const Moment moment = RunOk(program).moments.back();
  ASSERT_TRUE(moment.cell);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double edge = moment.cell->upper[axis] - moment.cell->lower[axis];
    EXPECT_NEAR(edge / (kEdge * std::exp(rates[axis] * time)), 1, 2e-6) << axis;
    EXPECT_NEAR(moment.cell->upper[axis] + moment.cell->lower[axis], 0, 1e-12 * kEdge);
  }
}

// Affine velocities: two lone spheres keep their distance in the shear flow's terms.
TEST(DeformedCell, ParticlesTakeTheAffineVelocity) {
  Program program =
      Vacuum({Ball(1, kRadius, {0, 0, 4 * kRadius}), Ball(2, kRadius, {0, 0, -4 * kRadius})});
  MakePeriodic(program);
  const double rate = 100;
  program.stages = {Strain({}, rate, 1e-3)};
  const Moment moment = RunOk(program).moments.back();
  for (std::size_t p = 0; p < 2; ++p) {
    const double z = p == 0 ? 4 * kRadius : -4 * kRadius;
    EXPECT_NEAR(moment.packing[p].velocity[0], rate * z, 1e-15);
    EXPECT_NEAR(moment.packing[p].position[0], rate * z * 1e-3, 1e-15);
    EXPECT_EQ(moment.packing[p].position[2], z);
  }
  EXPECT_NEAR(moment.cell->shear_rate, rate, 0);
  EXPECT_NEAR(moment.cell->shear_offset, Fraction(rate * 1e-3) * kEdge, 1e-9 * kEdge);
}

// A pair that will meet, its first sphere at `at`; far enough from each other that the cell above
// has gone on when they do.
Packing Approaching(const Vector3& at) {
  return {Ball(1, kRadius, at, {0.02, 0.01, 0.03}, {100, 200, -300}),
          Ball(2, kRadius, at + kRadius * Vector3{1.5, 0.6, 2.5}, {-0.01, -0.01, -0.02},
               {50, -400, 30})};
}

// The pair as seen from its first sphere: branch to the nearest image, velocities less the affine
// ones, spins.
struct PairState {
  Vector3 branch{};
  std::array<Vector3, 2> velocity;
  std::array<Vector3, 2> spin;
};

PairState StateOf(const Moment& moment) {
  PairState state;
  for (std::size_t p = 0; p < 2; ++p) {
    const Sphere& s = moment.packing[p];
    state.velocity[p] = s.velocity - Vector3{moment.cell->shear_rate * s.position[2], 0, 0};
    state.spin[p] = s.spin;
  }
  state.branch = moment.packing[1].position - moment.packing[0].position;
  const double up = std::round(state.branch[2] / kEdge);
  state.branch = state.branch - Vector3{up * moment.cell->shear_offset, 0, up * kEdge};
  for (const std::size_t axis : {std::size_t{0}, std::size_t{1}}) {
    state.branch[axis] = kEdge * Fraction(state.branch[axis] / kEdge);
  }
  return state;
}

double Difference(const PairState& a, const PairState& b) {
  double worst = Length(a.branch - b.branch) / kRadius;
  for (std::size_t p = 0; p < 2; ++p) {
    worst = std::max(
        {worst, Length(a.velocity[p] - b.velocity[p]) / 0.03, Length(a.spin[p] - b.spin[p]) / 400});
  }
  return worst;
}

// Two spheres that meet across the sheared boundary move as those that meet inside, while the shear
// goes on and after it has stopped.
TEST(DeformedCell, CollisionAcrossTheShearedBoundary) {
  for (const double sheared : {2e-3, 1e-4}) {
    const auto run = [&](double z) {
      Packing packing = Approaching({0.2 * kRadius, 0, z});
      for (Sphere& s : packing) s.position[2] = kEdge * Fraction(s.position[2] / kEdge);
      Program program = Collision(packing);
      MakePeriodic(program);
      program.stages = {Strain({}, 300, sheared)};
      if (sheared < 1e-3) program.stages.push_back(Advance{.duration = 1e-3});
      return StateOf(RunOk(program).moments.back());
    };
    const PairState inside = run(-kRadius);
    EXPECT_GT(Length(inside.spin[0] - Vector3{100, 200, -300}), 10) << "they did not meet";
    double worst = 0;
    for (const double share : {0.3, 0.4, 0.45, 0.49}) {
      worst = std::max(worst, Difference(run(share * kEdge), inside));
    }
    Measured("collision across the sheared boundary against one inside", worst);
    EXPECT_LT(worst, 1e-9);
  }
}

// Random spheres at a solid fraction of 0.34, in a cubic cell.
Program LooseCell(int count, std::uint64_t seed) {
  const double solid = count * 4.0 / 3 * kPi * kRadius * kRadius * kRadius;
  const double edge = std::cbrt(solid / 0.30);
  Program program = Vacuum({}, 5e-7);
  program.particles.packing.reset();
  program.particles.sizes = {SizeDistribution::Kind::normal, 2 * kRadius, 3e-6, 20e-6, 40e-6};
  program.particles.count = count;
  program.particles.seed = seed;
  SetContact(program, {.restitution = 0.5, .friction = 0.3});
  MakePeriodic(program, {edge, edge, edge});
  program.stages = {Insert{-0.5 * edge, 0.5 * edge, {}}};
  return program;
}

TEST(DeformedCell, IsotropicStressControlReachesItsTarget) {
  Program program = LooseCell(200, 1);
  const double stress = 900;
  Deform press{.name = "press", .duration = 0.02, .relaxation_rate = 30};
  for (EdgeControl& edge : press.edges) edge = {EdgeControl::Kind::stress, stress};
  program.stages.push_back(press);
  const Trace trace = RunOk(program);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double mean = 0;
    const std::size_t windows = 20;
    for (std::size_t n = trace.cell.stress.size() - windows; n < trace.cell.stress.size(); ++n) {
      mean += trace.cell.stress[n][axis][axis] / windows;
    }
    Measured(fmt::format("relative error of the stress along {}", "xyz"[axis]), mean / stress - 1);
    EXPECT_NEAR(mean / stress, 1, 0.01);
  }
}

}  // namespace
}  // namespace powdercal::physics

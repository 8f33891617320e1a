#include <gmock/gmock.h>

#include "backends/embedded/mesh_shapes.h"
#include "backends/insertion.h"
#include "tests/physics/two_engines.h"

// Meshes, glued groups and the stages that change them, in the embedded engine and in LIGGGHTS.

namespace powdercal::physics {
namespace {

using embedded::MakeRectangle;

constexpr double kPlate = 2e-4;    // [m]
constexpr double kHalfBox = 4e-4;  // [m]

// [R] by which positions may differ where bodies start and stop: LIGGGHTS begins each stage with
// forces from the new velocities, the embedded engine with those of the step before, which under
// damping is another kick, and spheres roll on.
constexpr double kOfStarts = 0.03;

// Vacuum in a smaller box: LIGGGHTS bins it all.
Program SmallVacuum(Packing packing, double time_step = kTimeStep) {
  Program program = Vacuum(std::move(packing), time_step);
  program.domain.lower = {-kHalfBox, -kHalfBox, -kHalfBox};
  program.domain.upper = {kHalfBox, kHalfBox, kHalfBox};
  return program;
}

const Sphere& SphereOf(const Moment& moment, std::int64_t id) {
  return *std::find_if(moment.packing.begin(), moment.packing.end(),
                       [&](const Sphere& s) { return s.id == id; });
}

// Largest distance between the same spheres, in radii; x and y may have a period.
double Apart(const Moment& a, const Moment& b, double period = 1) {
  EXPECT_EQ(a.packing.size(), b.packing.size());
  double apart = 0;
  for (std::size_t n = 0; n < std::min(a.packing.size(), b.packing.size()); ++n) {
    Vector3 way = a.packing[n].position - b.packing[n].position;
    for (const std::size_t axis : {0, 1}) way[axis] = std::remainder(way[axis], period);
    apart = std::max(apart, Length(way) / kRadius);
  }
  return apart;
}

TwoTraces RunBothOk(const Program& program) {
  TwoTraces traces = RunBoth(program);
  EXPECT_TRUE(traces.embedded.outcome.ok()) << traces.embedded.outcome.message;
  EXPECT_TRUE(traces.liggghts.outcome.ok()) << traces.liggghts.outcome.message;
  EXPECT_EQ(traces.embedded.moments.size(), traces.liggghts.moments.size());
  return traces;
}

Mesh Plate(double z = 0) {
  return MakeRectangle("plate", {-kPlate, -kPlate, z}, {2 * kPlate, 0, 0}, {0, 2 * kPlate, 0}, 1,
                       1);
}

TEST(MeshInTwoEngines, SphereHitsItObliquely) {
  Program program = SmallVacuum(
      {Ball(1, kRadius, {5e-5, -5e-5, 1.01 * kRadius}, {0.01, 0, -0.02}, {0, 300, 50})}, 1e-8);
  SetContact(program, {.restitution = 0.5, .friction = 0.3, .rolling_friction = 0.1});
  program.law.rolling = ContactLaw::Rolling::epsd2;
  program.meshes = {Plate()};
  program.stages = {Advance{.name = "hit", .duration = 1e-4, .packing_every = 500}};
  const TwoTraces traces = RunBothOk(program);
  ASSERT_GE(traces.liggghts.moments.size(), 10U);
  double apart = 0;
  for (std::size_t n = 0; n < traces.liggghts.moments.size(); ++n) {
    apart = std::max(apart, Apart(traces.liggghts.moments[n], traces.embedded.moments[n]));
  }
  Measured("largest distance over R in an oblique impact on a mesh", apart);
  EXPECT_LT(apart, 1e-5);
  EXPECT_GT(traces.liggghts.moments.back().packing[0].velocity[2], 0.005) << "it came back";
}

TEST(MeshInTwoEngines, BearsAWeight) {
  Program program = SmallVacuum({Ball(1, kRadius, {5e-5, -5e-5, 1.001 * kRadius})});
  SetContact(program, {.restitution = 0.3});
  program.gravity = {0, 0, -kGravity};
  program.meshes = {Plate()};
  program.stages = {Advance{.name = "fall", .duration = 5e-3},
                    Advance{.name = "rest", .duration = 1e-3}};
  const double weight = MassOf(kRadius) * kGravity;
  const TwoTraces traces = RunBothOk(program);
  for (const Trace* trace : {&traces.liggghts, &traces.embedded}) {
    const WallState& plate = trace->moments.back().walls.at("plate");
    EXPECT_NEAR(plate.force[2] / weight, -1, 1e-5);
    EXPECT_EQ(plate.height, 0);
    const WallSeries* series = trace->FindSeries("plate");
    ASSERT_NE(series, nullptr);
    ASSERT_EQ(series->time.size(), 600U);
    EXPECT_NEAR(series->time.front(), 1e-5, 1e-12);
    EXPECT_NEAR(series->force.back()[2] / weight, -1, 1e-5);
    EXPECT_EQ(series->normal_force.back(), series->force.back()[2]);
  }
}

// A blade pushes three spheres up a slope, stops, bears them, and gets out of their way.
TEST(MeshInTwoEngines, BladePushesSpheres) {
  Packing spheres;
  for (int n = 0; n < 3; ++n) {
    spheres.push_back(Ball(n + 1, kRadius, {(2.2 + 2.3 * n) * kRadius, 0, kRadius}));
  }
  Program program = SmallVacuum(spheres);
  SetContact(program, {.restitution = 0.4, .friction = 0.3, .rolling_friction = 0.1});
  program.law.rolling = ContactLaw::Rolling::epsd2;
  program.gravity = {-3, 0, -kGravity};
  program.walls = {Floor()};
  program.meshes = {
      MakeRectangle("blade", {0, -kPlate, 1e-6}, {0, 3 * kPlate, 0}, {0, 0, 2 * kPlate}, 1, 1)};
  program.stages = {
      Advance{.name = "wait", .duration = 1e-4},
      Advance{.name = "push", .duration = 2e-2, .motions = {{"blade", {0.01, 0, 0}, {}, {}}}},
      Advance{.name = "rest", .duration = 1.5e-2},
      Advance{.name = "back", .duration = 1e-3, .motions = {{"blade", {-0.05, 0, 0.1}, {}, {}}}}};
  const TwoTraces traces = RunBothOk(program);
  ASSERT_EQ(traces.liggghts.moments.size(), 4U);
  for (std::size_t n = 0; n < 4; ++n) {
    const Moment& a = traces.liggghts.moments[n];
    const Moment& b = traces.embedded.moments[n];
    Measured(a.name + ": distance over R", Apart(a, b));
    EXPECT_LT(Apart(a, b), kOfStarts) << a.name;
    EXPECT_LT(Length(a.walls.at("blade").displacement - b.walls.at("blade").displacement), 1e-10);
    EXPECT_NEAR(a.walls.at("blade").height, b.walls.at("blade").height, 1e-10);
  }
  const Moment& pushed = traces.liggghts.moments[1];
  EXPECT_GT(pushed.packing[0].position[0], 2e-4 + 0.9 * kRadius);
  EXPECT_NEAR(pushed.walls.at("blade").displacement[0], 2e-4, 1e-10);
  // Rolling friction bears some of it.
  const double load = 3 * MassOf(kRadius) * 3;
  for (const Trace* trace : {&traces.liggghts, &traces.embedded}) {
    const WallSeries& series = *trace->FindSeries("blade");
    const auto end = std::lower_bound(series.time.begin(), series.time.end(),
                                      trace->Find("rest")->time - 0.5 * kTimeStep);
    const double force = series.force[static_cast<std::size_t>(end - series.time.begin())][0];
    Measured("force on a blade at rest over the weight along the slope", -force / load);
    EXPECT_LT(force, -0.5 * load) << "it bears the spheres";
    EXPECT_GT(force, -1.2 * load);
  }
  EXPECT_NEAR(traces.liggghts.FindSeries("blade")->height.back(),
              traces.embedded.FindSeries("blade")->height.back(), 1e-9);
}

// A layer of glued spheres on a floor that it overlaps, with a free one on top.
Program GluedLayer() {
  Program program = SmallVacuum({});
  SetContact(program, {.restitution = 0.3, .friction = 0.4, .cohesion_energy_density = 2e4});
  program.law.cohesion = ContactLaw::Cohesion::sjkr2;
  program.gravity = {0, 0, -kGravity};
  program.walls = {Floor(-0.98 * kRadius)};
  GluedGroup layer{.name = "layer"};
  for (int k = 0; k < 25; ++k) {
    const double spacing = 1.9 * kRadius;
    Sphere ball = Ball(k + 1, kRadius, {spacing * (k % 5 - 2), spacing * (k / 5 - 2), 0});
    ball.velocity = {1, 1, 1};  // of no meaning to a glued sphere
    program.particles.packing->push_back(ball);
    layer.ids.push_back(ball.id);
  }
  program.particles.packing->push_back(
      Ball(26, kRadius, {0.95 * kRadius, 0.95 * kRadius, 1.6 * kRadius}));
  program.groups = {layer};
  return program;
}

TEST(GluedGroupInTwoEngines, FeelsTheFreeParticlesAlone) {
  Program program = GluedLayer();
  program.stages = {Advance{.name = "fall", .duration = 8e-3},
                    Advance{.name = "rest", .duration = 1e-3}};
  const double weight = MassOf(kRadius) * kGravity;
  const TwoTraces traces = RunBothOk(program);
  const Vector3 force = traces.liggghts.moments.back().walls.at("layer").force;
  EXPECT_LT(Length(force - Vector3{0, 0, -weight}), 1e-4 * weight);
  EXPECT_EQ(traces.liggghts.FindSeries("layer")->time.size(), 900U);
  EXPECT_LT(Apart(traces.liggghts.moments.back(), traces.embedded.moments.back()), 1e-4);
}

TEST(GluedGroupInTwoEngines, MovesAsToldAndStops) {
  Program program = GluedLayer();
  const Vector3 velocity = {0.01, -0.005, 0.002};
  program.stages = {Advance{.name = "fall", .duration = 3e-3},
                    Advance{.name = "move",
                            .duration = 2e-3,
                            .motions = {{"layer", velocity, {}, {}}},
                            .packing_every = 5000},
                    Advance{.name = "rest", .duration = 1e-3}};
  const TwoTraces traces = RunBothOk(program);
  ASSERT_EQ(traces.liggghts.moments.size(), 6U);
  const Packing& start = *program.particles.packing;
  for (std::size_t n = 0; n < 6; ++n) {
    const Moment& moment = traces.liggghts.moments[n];
    const Vector3 way = std::clamp(moment.time - 3e-3, 0.0, 2e-3) * velocity;
    EXPECT_LT(Length(moment.walls.at("layer").displacement - way), 1e-12);
    for (std::size_t p = 0; p < 25; ++p) {
      EXPECT_LT(Length(moment.packing[p].position - start[p].position - way), 1e-11);
      EXPECT_EQ(moment.packing[p].spin, Vector3{});
      EXPECT_EQ(moment.packing[p].velocity, moment.name == "move" ? velocity : Vector3{});
    }
    Measured(moment.name + ": distance over R", Apart(moment, traces.embedded.moments[n]));
    EXPECT_LT(Apart(moment, traces.embedded.moments[n]), kOfStarts);
  }
}

// Spheres in a row, some of which fly out sideways.
TEST(OutflowInTwoEngines, LeaversAreCounted) {
  Packing spheres;
  for (int n = 0; n < 8; ++n) {
    const double speed = n < 3 ? 0.51 : (n < 5 ? -0.53 : 0.01);
    spheres.push_back(Ball(n + 1, kRadius, {0, (4 * n - 14) * kRadius, 0}, {speed, 0, 0}));
  }
  Program program = SmallVacuum(spheres, 1e-6);
  const double half = 2e-4;
  program.domain.lower[0] = -half;
  program.domain.upper[0] = half;
  program.domain.boundaries[0] = Boundary::outflow;
  program.stages = {Advance{.name = "fly", .duration = 1e-3, .packing_every = 50}};
  const TwoTraces traces = RunBothOk(program);
  for (const Trace* trace : {&traces.liggghts, &traces.embedded}) {
    EXPECT_EQ(trace->diagnostics.leavers, 5);
    EXPECT_EQ(trace->diagnostics.lost_particles, 0);
    EXPECT_EQ(trace->moments.front().packing.size(), 8U);
    EXPECT_EQ(trace->moments.back().packing.size(), 3U);
    EXPECT_EQ(trace->moments.back().packing.front().id, 6);
  }
  for (const Moment& moment : traces.liggghts.moments) {
    for (const Sphere& s : moment.packing) EXPECT_LE(std::abs(s.position[0]), half);
  }
}

TEST(OutflowInTwoEngines, ButWhoPassesAnOpenSideIsLost) {
  Program program =
      Vacuum({Ball(1, kRadius, {}, {0.5, 0, 0}), Ball(2, kRadius, {0, 1e-4, 0}, {0, 0, 0.5}),
              Ball(3, kRadius, {0, -1e-4, 0})},
             1e-6);
  program.domain.lower = {-2e-4, -3e-4, -2e-4};
  program.domain.upper = {2e-4, 3e-4, 2e-4};
  program.domain.boundaries[0] = Boundary::outflow;
  program.stages = {Advance{.name = "fly", .duration = 1e-3}};
  const TwoTraces traces = RunBoth(program);
  for (const Trace* trace : {&traces.liggghts, &traces.embedded}) {
    EXPECT_EQ(trace->outcome.reason, Reason::lost_particles) << trace->outcome.message;
    EXPECT_EQ(trace->diagnostics.lost_particles, 1);
  }
}

// A sphere rests on a gate, another on a floor; without the gate the first falls.
TEST(RemoveInTwoEngines, OpensAGate) {
  Program program = SmallVacuum(
      {Ball(1, kRadius, {5e-5, -5e-5, 11 * kRadius}), Ball(2, kRadius, {-5e-5, 5e-5, kRadius})});
  SetContact(program, {.restitution = 0.3});
  program.gravity = {0, 0, -kGravity};
  program.walls = {Floor()};
  program.meshes = {Plate(10 * kRadius)};
  program.meshes[0].name = "gate";
  program.meshes.push_back(Plate(20 * kRadius));
  program.stages = {Advance{.name = "closed", .duration = 2e-3}, Remove{"gate"},
                    Advance{.name = "open", .duration = 3e-3}, Remove{"floor"},
                    Advance{.name = "bottomless", .duration = 3e-3}};
  const TwoTraces traces = RunBothOk(program);
  for (const Trace* trace : {&traces.liggghts, &traces.embedded}) {
    ASSERT_EQ(trace->moments.size(), 3U);
    EXPECT_NEAR(SphereOf(trace->moments[0], 1).position[2], 11 * kRadius, 0.1 * kRadius);
    EXPECT_NEAR(SphereOf(trace->moments[1], 1).position[2], 11 * kRadius - 0.5 * kGravity * 9e-6,
                0.1 * kRadius);
    EXPECT_NEAR(SphereOf(trace->moments[1], 2).position[2], kRadius, 0.1 * kRadius);
    EXPECT_LT(SphereOf(trace->moments[2], 2).position[2], 0) << "no floor any more";
    EXPECT_TRUE(trace->moments[0].walls.contains("gate"));
    EXPECT_FALSE(trace->moments[1].walls.contains("gate"));
    EXPECT_TRUE(trace->moments[1].walls.contains("floor"));
    EXPECT_FALSE(trace->moments[2].walls.contains("floor"));
    EXPECT_NEAR(trace->FindSeries("gate")->time.back(), 2e-3, 1e-9);
    EXPECT_NEAR(trace->FindSeries("plate")->time.back(), 8e-3, 1e-9);
  }
  EXPECT_LT(Apart(traces.liggghts.moments[1], traces.embedded.moments[1]), 1e-4);
}

TEST(RestoreInTwoEngines, MeshesStandWhereTheyStood) {
  Program program = SmallVacuum({Ball(1, kRadius, {2.2 * kRadius, 0, kRadius})});
  SetContact(program, {.restitution = 0.4, .friction = 0.3});
  program.gravity = {0, 0, -kGravity};
  program.walls = {Floor()};
  program.meshes = {
      MakeRectangle("blade", {0, -kPlate, 1e-6}, {0, 3 * kPlate, 0}, {0, 0, 1.5 * kPlate}, 1, 1),
      Plate(20 * kRadius)};
  const Motion push = {"blade", {0.05, 0, 0}, {}, {}};
  program.stages = {Advance{.name = "push", .duration = 2e-3, .motions = {push}},
                    Save{},
                    Remove{"plate"},
                    Remove{"floor"},
                    Advance{.name = "on", .duration = 2e-3, .motions = {push}},
                    Restore{},
                    Advance{.name = "again", .duration = 2e-3, .motions = {push}}};
  const TwoTraces traces = RunBothOk(program);
  for (const Trace* trace : {&traces.liggghts, &traces.embedded}) {
    const Moment& on = *trace->Find("on");
    const Moment& again = *trace->Find("again");
    EXPECT_LT(on.packing[0].position[2], 0.5 * kRadius) << "it falls";
    EXPECT_FALSE(on.walls.contains("plate"));
    EXPECT_NEAR(again.packing[0].position[2], kRadius, 0.01 * kRadius);
    EXPECT_GT(again.packing[0].position[0], 2e-4 + 0.9 * kRadius) << "pushed on by the blade";
    EXPECT_TRUE(again.walls.contains("plate"));
    EXPECT_NEAR(again.walls.at("blade").displacement[0], 2e-4, 1e-10);
    EXPECT_NEAR(again.time, 6e-3, 1e-9);
  }
  EXPECT_LT(Apart(*traces.liggghts.Find("again"), *traces.embedded.Find("again")), kOfStarts);
}

// Spheres that fly through the slab, two at v and two at −v along x: the motion is a stress of n m
// v²/V.
TEST(SlabInTwoEngines, MotionAboutTheMeanIsAStress) {
  const double speed = 0.01;
  const Vector3 drift = {0.02, 0, 0.005};
  Packing spheres;
  for (int n = 0; n < 4; ++n) {
    const Vector3 own = {n % 2 == 0 ? speed : -speed, 0, 0};
    spheres.push_back(Ball(n + 1, kRadius, {0, 4 * n * kRadius, 0}, drift + own));
  }
  spheres.push_back(Ball(5, kRadius, {0, 0, 9 * kRadius}, {1, 1, 0}));  // above it
  Program program = SmallVacuum(spheres, 1e-6);
  program.stress_slab = {{-kRadius, 5 * kRadius}};
  program.stages = {Advance{.duration = 2e-4}};
  const TwoTraces traces = RunBothOk(program);
  const double volume = program.domain.BaseArea() * 6 * kRadius;
  const double expected = 4 * MassOf(kRadius) * speed * speed / volume;
  for (const Trace* trace : {&traces.liggghts, &traces.embedded}) {
    ASSERT_EQ(trace->slab.time.size(), 2U);
    EXPECT_NEAR(trace->slab.time[0], 1e-4, 1e-9);
    EXPECT_NEAR(trace->slab.stress[1][0][0] / expected, 1, 1e-4);
    EXPECT_LT(std::abs(trace->slab.stress[1][2][2]), 1e-4 * expected);
    EXPECT_LT(std::abs(trace->slab.stress[1][0][2]), 1e-4 * expected);
    EXPECT_NEAR(trace->slab.solid_fraction[1] * volume / (4 * MassOf(kRadius) / kDensity), 1, 1e-5);
  }
}

// --- A shear cell with platens -------------------------------------------------------------------

constexpr double kWidth = 8 * 2 * kRadius;
constexpr double kArea = kWidth * kWidth;
constexpr double kStress = 900;  // [Pa]
constexpr double kShear = 0.02;  // [m/s]

// 500 spheres between a glued layer, which is driven along x, and a ridged lid with a servo.
Program ShearCell() {
  Program program = Vacuum({}, 3e-7);
  const Particles drawn{.sizes = {SizeDistribution::Kind::normal, 2 * kRadius, 4e-6, 22e-6, 38e-6},
                        .count = 500,
                        .seed = 11};
  SetContact(program, {.restitution = 0.4,
                       .friction = 0.3,
                       .rolling_friction = 0.2,
                       .cohesion_energy_density = 1e4});
  program.law.cohesion = ContactLaw::Cohesion::sjkr2;
  program.law.rolling = ContactLaw::Rolling::epsd2;
  program.domain = {{0, 0, -3 * kRadius},
                    {kWidth, kWidth, 70 * kRadius},
                    {Boundary::periodic, Boundary::periodic, Boundary::open}};
  Packing packing =
      PlaceParticles(drawn, program.domain, {kRadius, 40 * kRadius, {0, 0, -0.1}}, {});
  GluedGroup bottom{.name = "bottom"};
  for (int k = 0; k < 64; ++k) {
    bottom.ids.push_back(static_cast<std::int64_t>(packing.size()) + 1);
    packing.push_back(Ball(bottom.ids.back(), kRadius,
                           {kRadius * (2 * (k % 8) + 1), kRadius * (2 * (k / 8) + 1), 0}));
  }
  program.particles.packing = packing;
  program.groups = {bottom};
  program.meshes = {embedded::MakeRidgedPlate("top", {0, 0, 60 * kRadius}, kWidth, kWidth,
                                              kWidth / 4, -2 * kRadius)};
  program.stress_slab = {{6 * kRadius, 12 * kRadius}};
  const Motion drive = {"bottom", {kShear, 0, 0}, {}, {}};
  program.stages = {Servo{"top", kStress, 0.2, 0.02},
                    Advance{.name = "preshear", .duration = 0.012, .motions = {drive}},
                    Save{"presheared"},
                    Advance{.name = "on", .duration = 0.003, .motions = {drive}},
                    Restore{"presheared"},
                    Advance{.name = "again", .duration = 0.003, .motions = {drive}},
                    Restore{"presheared"},
                    Servo{"top", 300, 0.2, 0.01},
                    Advance{.name = "yield", .duration = 0.003, .motions = {drive}}};
  return program;
}

// Means of the windows between two times: of the force on a body, of the slab's traction.
Vector3 LateForce(const Trace& trace, const std::string& body, double begin, double end) {
  const WallSeries& series = *trace.FindSeries(body);
  Vector3 sum{};
  int count = 0;
  for (std::size_t n = 0; n < series.time.size(); ++n) {
    if (series.time[n] <= begin || series.time[n] > end) continue;
    sum = sum + series.force[n];
    ++count;
  }
  EXPECT_GT(count, 5) << body;
  return (1.0 / count) * sum;
}

Vector3 LateTraction(const Trace& trace, double begin, double end) {
  Vector3 sum{};
  int count = 0;
  for (std::size_t n = 0; n < trace.slab.time.size(); ++n) {
    if (trace.slab.time[n] <= begin || trace.slab.time[n] > end) continue;
    sum = sum + trace.slab.stress[n][2];
    ++count;
  }
  EXPECT_GT(count, 5);
  return (1.0 / count) * sum;
}

TEST(ShearCellInTwoEngines, PlatensAndSlabBearTheSame) {
  const TwoTraces traces = RunBothOk(ShearCell());
  for (const auto& [name, trace] :
       {std::pair("liggghts", &traces.liggghts), std::pair("embedded", &traces.embedded)}) {
    SCOPED_TRACE(name);
    ASSERT_EQ(trace->moments.size(), 6U);
    for (const std::string stage : {"preshear", "on", "again", "yield"}) {
      const double end = trace->Find(stage)->time;
      const double begin = end - (stage == "preshear" ? 0.006 : 0.0015);
      const double target = stage == "yield" ? 300 : kStress;
      const Vector3 top = (1 / kArea) * LateForce(*trace, "top", begin, end);
      const Vector3 bottom = (-1 / kArea) * LateForce(*trace, "bottom", begin, end);
      const Vector3 slab = LateTraction(*trace, begin, end);
      std::printf(
          "[ run ] %s, %s: sigma top %.1f bottom %.1f slab %.1f Pa, tau top %.1f bottom %.1f slab "
          "%.1f Pa\n",
          name, stage.c_str(), top[2], bottom[2], slab[2], top[0], bottom[0], slab[0]);
      EXPECT_NEAR(top[2] / target, 1, 0.05) << stage;
      EXPECT_NEAR(bottom[2] / target, 1, 0.05) << stage;
      EXPECT_NEAR(slab[2] / target, 1, 0.05) << stage;
      EXPECT_NEAR(top[0], bottom[0], 0.05 * target) << stage;
      EXPECT_NEAR(top[0], slab[0], 0.05 * target) << stage;
      EXPECT_GT(top[0], 0.2 * target) << stage;
    }
  }
}

// [1] of the way that particles go: by how much LIGGGHTS' restored beds go astray.
constexpr double kOfRestart = 1e-10;

// The springs of contacts, with meshes as well, are part of a saved state.
TEST(ShearCellInTwoEngines, GoesOnFromASavedState) {
  Program program = ShearCell();
  const Motion drive = {"bottom", {kShear, 0, 0}, {}, {}};
  const double step = program.time_step;
  const auto piece = [&](const std::string& name) {
    return Advance{.name = name, .duration = 300 * step, .motions = {drive}, .packing_every = 100};
  };
  program.stages = {Servo{"top", kStress, 0.2, 0.02},
                    Advance{.name = "preshear", .duration = 0.002, .motions = {drive}},
                    Save{},
                    piece("on"),
                    Restore{},
                    piece("again"),
                    Restore{},
                    Servo{"top", 300, 0.2, 0.005},
                    Restore{},
                    piece("once more")};
  const TwoTraces traces = RunBothOk(program);
  for (const auto& [name, trace] :
       {std::pair("liggghts", &traces.liggghts), std::pair("embedded", &traces.embedded)}) {
    SCOPED_TRACE(name);
    ASSERT_EQ(trace->moments.size(), 12U);
    const double moved = Apart(trace->moments[1], trace->moments[4], kWidth);
    EXPECT_GT(moved, 1e-3);
    for (std::size_t n = 2; n < 5; ++n) {
      const Moment& on = trace->moments[n];
      const Moment& again = trace->moments[n + 3];
      const Moment& more = trace->moments[n + 7];
      Measured(
          fmt::format("{}, frame {}: distance over R of restored and undisturbed", name, n - 2),
          Apart(on, again, kWidth));
      EXPECT_LT(Apart(on, again, kWidth), kOfRestart * moved);
      EXPECT_EQ(Apart(again, more, kWidth), 0) << "every restored state is the same";
      EXPECT_GT(again.time, on.time) << "the clock goes on";
      EXPECT_LT(Length(on.walls.at("bottom").displacement - again.walls.at("bottom").displacement),
                1e-15);
      if (n == 2) continue;  // windows of LIGGGHTS do not begin anew with the stage
      EXPECT_NEAR(on.walls.at("top").height, again.walls.at("top").height, 1e-5 * kRadius);
      EXPECT_LT(Length(again.walls.at("top").force - on.walls.at("top").force),
                1e-3 * kStress * kArea);
    }
  }
}

}  // namespace
}  // namespace powdercal::physics

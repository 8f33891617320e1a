#include "tests/physics/collisions.h"
#include "tests/support/program.h"

// A dozen collisions far apart from one another, in one run of the embedded engine and one of the
// real YADE; compared frame by frame.

namespace powdercal::physics {
namespace {

using Cohesion = ContactLaw::Cohesion;
using Normal = ContactLaw::Normal;
using Rolling = ContactLaw::Rolling;
using ShearUpdate = ContactLaw::ShearUpdate;

Trace RunYade(const Program& program) {
  const TemporaryFolder folder;
  return MakeBackend("yade")->Run(program, {.work_folder = folder / "run"});
}

Difference Worst(const Program& program, const Scene& scene) {
  const Trace embedded = RunProgram(program);
  const Trace yade = RunYade(program);
  EXPECT_TRUE(embedded.outcome.ok()) << embedded.outcome.message;
  EXPECT_TRUE(yade.outcome.ok()) << yade.outcome.message;
  EXPECT_EQ(yade.moments.size(), static_cast<std::size_t>(kFrames));
  if (yade.moments.size() != embedded.moments.size()) return {HUGE_VAL, HUGE_VAL, HUGE_VAL};
  ExpectContacts(program, scene, yade.moments);
  Difference worst;
  for (const auto& [name, d] : Compare(embedded.moments, yade.moments, scene)) {
    std::printf("[ pair ] %-28s %.1e %.1e %.1e\n", name.c_str(), d.position, d.velocity, d.spin);
    worst.position = std::max(worst.position, d.position);
    worst.velocity = std::max(worst.velocity, d.velocity);
    worst.spin = std::max(worst.spin, d.spin);
  }
  std::printf("[ row ] | %s | %.1e | %.1e | %.1e |\n", program.law.ToString().c_str(),
              worst.position, worst.velocity, worst.spin);
  return worst;
}

ContactLaw Incremental() { return {.limit_force = true, .shear_update = ShearUpdate::incremental}; }

// All in planes of their own: no sphere turns about the line of centres.
Scene PlaneCollisions() {
  Scene scene(false);
  const double v = kSpeed;
  const double w = kSpin;
  const double gap = 1e-3 * kRadius;
  const double overlap = -0.02 * kRadius;
  scene.Pair("head-on", 1, gap, {1, 0, 0}, {v, 0, 0}, {-v, 0, 0});
  scene.Pair("nearly head-on", 1, gap, {1, 2, 3}, {v / 3, v / 2, v}, {});
  scene.Pair("oblique", 1, gap, {1, 0, 0}, {v, 0, 0.7 * v}, {-v, 0, 0});
  scene.Pair("grazing", 1.5, gap, {0, 1, 0}, {2 * v, 0.3 * v, v}, {0, -0.3 * v, 0});
  scene.Pair("spinning", 1, gap, {0, 0, 1}, {0, 0, v}, {0, 0, -v}, {w, 0, 0}, {w, 0, 0});
  scene.Pair("sliding spins", 2, gap, {0, 1, 1}, {0, v, v}, {}, {2 * w, 0, 0}, {-w, 0, 0});
  scene.Pair("small on large", 3, gap, {1, -1, 0}, {}, {-v, 2 * v, 0}, {0, 0, 2 * w}, {0, 0, w});
  scene.Pair("pressed, let go", 1, overlap, {0, 0, 1}, {}, {});
  scene.Pair("pressed, sheared", 2.5, overlap, {0, 0, 1}, {0.1 * v, 0, 0}, {});
  for (const std::size_t axis : {0U, 1U, 2U}) {
    for (const int side : {-1, 1}) {
      const std::string plane = std::string(side < 0 ? "lower " : "upper ") + "xyz"[axis];
      Vector3 velocity{};
      velocity[axis] = side * v;
      velocity[(axis + 1) % 3] = 0.6 * v;
      velocity[(axis + 2) % 3] = -0.2 * v;
      scene.AtWall("plane " + plane + ", oblique", axis, side, 1, gap, velocity, {});
      Vector3 spin{};
      spin[(axis + 1) % 3] = 0.5 * w;
      velocity = {};
      velocity[axis] = side * 0.1 * v;
      scene.AtWall("plane " + plane + ", spinning", axis, side, 2, gap, velocity, spin);
    }
  }
  return scene;
}

void ExpectWithin(double tolerance, const Difference& worst) {
  EXPECT_LT(worst.position, tolerance);
  EXPECT_LT(worst.velocity, tolerance);
  EXPECT_LT(worst.spin, tolerance);
}

TEST(ContactsInYade, HertzMindlinHistory) {
  const Scene scene = PlaneCollisions();
  ExpectWithin(1e-6, Worst(SceneProgram(Incremental(), scene.packing()), scene));
}

TEST(ContactsInYade, LinearLaw) {
  const Scene scene = PlaneCollisions();
  ContactLaw law = Incremental();
  law.normal = Normal::linear;
  ExpectWithin(1e-7, Worst(SceneProgram(law, scene.packing()), scene));
}

// Head-on nothing but the normal force acts.
TEST(ContactsInYade, HertzHeadOn) {
  const double v = kSpeed;
  Scene scene(false);
  scene.Pair("equal", 1, 1e-3 * kRadius, {1, 0, 0}, {v, 0, 0}, {-v, 0, 0});
  scene.Pair("unequal", 3, 1e-3 * kRadius, {0, 0, 1}, {0, 0, 2 * v}, {});
  scene.Pair("pressed", 1.5, -0.02 * kRadius, {0, 1, 0}, {}, {});
  Program program = SceneProgram(Incremental(), scene.packing());
  program.gravity = {};
  ExpectWithin(1e-12, Worst(program, scene));
}

// Without a dashpot there is nothing that the two clip in different ways.
TEST(ContactsInYade, DmtUndamped) {
  const double v = kSpeed;
  Scene scene(true);
  scene.Pair("bounces", 1, 1e-3 * kRadius, {1, 0, 0}, {v, 0, 0}, {-v, 0, 0});
  scene.Pair("sticks", 1, 1e-3 * kRadius, {0, 1, 2}, {0, 0.01 * v, 0.02 * v}, {});
  scene.Pair("pressed, let go", 1, -0.02 * kRadius, {0, 0, 1}, {}, {});
  ContactLaw law = Incremental();
  law.cohesion = Cohesion::dmt;
  Program program = SceneProgram(law, scene.packing());
  program.gravity = {};
  program.walls.clear();
  program.materials.particle_particle.restitution = 1;
  ExpectWithin(1e-9, Worst(program, scene));
}

// Equal spheres that collide while they roll on each other: once the springs slide, both engines
// take the same spin away in every step. Before, YADE's spring has a stiffness of its own.
TEST(ContactsInYade, RollingPlateau) {
  const double half = 3 * kRadius;
  const double fast = 20 * kSpin;
  Program program =
      Vacuum({Ball(1, kRadius, {0, 0, -1.001 * kRadius}, {0, 0, kSpeed}, {fast, 0, 0}),
              Ball(2, kRadius, {0, 0, 1.001 * kRadius}, {}, {-fast, 0, 0})});
  program.domain = {{-half, -half, -half},
                    {half, half, half},
                    {Boundary::periodic, Boundary::periodic, Boundary::periodic}};
  SetContact(program, {.restitution = 1, .rolling_friction = 0.2});
  program.law = Incremental();
  program.law.rolling = Rolling::epsd2;
  program.law.torsion = false;
  program.stages = {Advance{.duration = 400 * program.time_step, .packing_every = 1}};
  const Trace embedded = RunOk(program);
  const Trace yade = RunYade(program);
  ASSERT_TRUE(yade.outcome.ok()) << yade.outcome.message;
  ASSERT_EQ(yade.moments.size(), 400U);
  const auto torque = [](const Trace& trace, std::size_t n) {  // in units of I/dt
    return trace.moments[n].packing[0].spin[0] - trace.moments[n - 1].packing[0].spin[0];
  };
  double largest = 0;
  for (std::size_t n = 1; n < 400; ++n) largest = std::max(largest, -torque(embedded, n));
  EXPECT_GT(largest, 0);
  int plateau = 0;
  double worst = 0;
  for (std::size_t n = 1; n < 400; ++n) {
    if (-torque(embedded, n) < 0.5 * largest) continue;
    worst = std::max(worst, std::abs(torque(yade, n) - torque(embedded, n)) / largest);
    ++plateau;
  }
  Measured("torque on the plateau", worst);
  EXPECT_GT(plateau, 50);
  EXPECT_LT(worst, 1e-9);
}

// A plane that rises and slides, the inside of a triangle, and a glued sphere each push a free one.
TEST(ContactsInYade, MovingBodies) {
  const double r = kRadius;
  const double gap = 1e-3 * r;
  const double v = kSpeed;
  Program program =
      Vacuum({Ball(1, r, {-2e-4, 0, r + gap}), Ball(2, r, {r + gap, 0, 1e-4}, {0, 0, 0.3 * v}),
              Ball(3, 0.6 * r, {2e-4, 0, 1e-4}),
              Ball(4, r, {2e-4, 1.6 * r + gap, 1e-4}, {0, 0, 0.2 * v})});
  program.domain = {
      {-4e-4, -4e-4, -4e-4}, {4e-4, 4e-4, 4e-4}, {Boundary::open, Boundary::open, Boundary::open}};
  SetContact(program, {.restitution = 0.6, .friction = 0.3});
  program.law = Incremental();
  program.walls = {Floor()};
  program.meshes = {{.name = "blade",
                     .vertices = {{0, -1.2e-4, 1e-5}, {0, 1.2e-4, 1e-5}, {0, 0, 2.5e-4}},
                     .triangles = {{0, 1, 2}}}};
  program.groups = {{.name = "glued", .ids = {3}}};
  program.stages = {Advance{.duration = kEvery * kFrames * program.time_step,
                            .motions = {{.body = "floor", .velocity = {0.4 * v, 0, v}},
                                        {.body = "blade", .velocity = {v, 0, 0}},
                                        {.body = "glued", .velocity = {0, v, 0}}},
                            .packing_every = kEvery}};
  const Trace embedded = RunOk(program);
  const Trace yade = RunYade(program);
  ASSERT_TRUE(yade.outcome.ok()) << yade.outcome.message;
  ASSERT_EQ(yade.moments.size(), embedded.moments.size());
  double worst = 0;
  double force = 0;
  for (std::size_t n = 0; n < yade.moments.size(); ++n) {
    for (std::size_t p = 0; p < 4; ++p) {
      const Sphere& a = embedded.moments[n].packing[p];
      const Sphere& b = yade.moments[n].packing[p];
      worst = std::max({worst, Length(a.position - b.position) / r,
                        Length(a.velocity - b.velocity) / v, r * Length(a.spin - b.spin) / v});
    }
    for (const char* body : {"floor", "blade", "glued"}) {
      const WallState& a = embedded.moments[n].walls.at(body);
      const WallState& b = yade.moments[n].walls.at(body);
      EXPECT_NEAR(a.height, b.height, 1e-12) << body;
      EXPECT_LT(Length(a.displacement - b.displacement), 1e-12) << body;
      EXPECT_LT(Length(a.force - b.force), 1e-6 * Length(a.force) + 1e-14) << body << ", " << n;
      force = std::max(force, Length(a.force));
    }
  }
  Measured("moving bodies", worst);
  EXPECT_LT(worst, 1e-6);
  EXPECT_GT(force, 1e-8);
  const Packing& end = yade.moments.back().packing;
  for (const std::size_t p : {0U, 1U, 3U}) {
    EXPECT_GT(Length(end[p].velocity - (*program.particles.packing)[p].velocity), 0.5 * v);
  }
}

// What is YADE's own where contacts stick and damp: shown, so that it is known how much it is.
TEST(ContactsInYade, DmtDampedDiffers) {
  Scene scene(true);
  scene.Pair("slow", 1, 1e-3 * kRadius, {1, 0, 0}, {0.1 * kSpeed, 0, 0}, {-0.1 * kSpeed, 0, 0});
  scene.Pair("fast", 1, 1e-3 * kRadius, {1, 0, 0}, {kSpeed, 0, 0}, {-kSpeed, 0, 0});
  scene.Pair("oblique", 1, 1e-3 * kRadius, {1, 0, 0}, {kSpeed, 0, 0.7 * kSpeed}, {});
  ContactLaw law = Incremental();
  law.cohesion = Cohesion::dmt;
  Program program = SceneProgram(law, scene.packing());
  program.gravity = {};
  program.walls.clear();
  const Difference worst = Worst(program, scene);
  EXPECT_LT(worst.velocity, 0.2);
}

}  // namespace
}  // namespace powdercal::physics

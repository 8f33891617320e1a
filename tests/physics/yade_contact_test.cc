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

}  // namespace
}  // namespace powdercal::physics

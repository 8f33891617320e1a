#include <array>
#include <map>

#include "tests/physics/two_engines.h"

// A dozen collisions far apart from one another, in one run of each engine, for every law that both
// have; compared frame by frame.

namespace powdercal::physics {
namespace {

using Normal = ContactLaw::Normal;
using Tangential = ContactLaw::Tangential;
using Cohesion = ContactLaw::Cohesion;
using Rolling = ContactLaw::Rolling;

constexpr double kSpeed = 0.02;          // [m/s]
constexpr double kSpin = kSpeed / kRadius;  // [rad/s]
constexpr double kPlace = 1.5e-4;        // [m] between one collision and the next
constexpr double kHalfBox = 3.2e-4;      // [m] planes all around
constexpr int kEvery = 20;
constexpr int kFrames = 120;

// Collisions, each a named group of spheres.
class Scene {
 public:
  explicit Scene(bool one_size) : one_size_(one_size) {}

  // Two spheres about a place of their own: the second's centre lies off the first's by their
  // distance of contact plus `gap`, in direction `normal`; velocities and spins as given.
  void Pair(const std::string& name, double ratio, double gap, const Vector3& normal,
            const Vector3& velocity1, const Vector3& velocity2, const Vector3& spin1 = {},
            const Vector3& spin2 = {}) {
    const double radius = one_size_ ? kRadius : kRadius / ratio;
    const Vector3 centre = Place();
    const Vector3 n = (1 / Length(normal)) * normal;
    Add(name, Ball(0, kRadius, centre, velocity1, spin1));
    Add(name, Ball(0, radius, centre + (kRadius + radius + gap) * n, velocity2, spin2));
  }

  // A sphere that hits, or rests on, the plane of an axis that is on the given side.
  void AtWall(const std::string& name, std::size_t axis, int side, double ratio, double gap,
              const Vector3& velocity, const Vector3& spin) {
    const double radius = one_size_ ? kRadius : kRadius / ratio;
    const double share = 0.35 * kHalfBox * (static_cast<double>(++walls_ % 4) - 1.5);
    Vector3 at{};
    at[axis] = side * (kHalfBox - radius - gap);
    at[(axis + 1) % 3] = share;
    at[(axis + 2) % 3] = -0.5 * share;
    Add(name, Ball(0, radius, at, velocity, spin));
  }

  const Packing& packing() const { return packing_; }
  const std::string& NameOf(std::int64_t id) const { return names_.at(id); }

 private:
  Vector3 Place() {
    const int n = places_++;
    const auto along = [](int k) { return kPlace * (k - 1); };
    return {along(n % 3), along(n / 3 % 3), along(n / 9)};
  }
  void Add(const std::string& name, Sphere sphere) {
    sphere.id = static_cast<std::int64_t>(packing_.size()) + 1;
    names_[sphere.id] = name;
    packing_.push_back(sphere);
  }

  bool one_size_;
  int places_ = 0;
  int walls_ = 0;
  Packing packing_;
  std::map<std::int64_t, std::string> names_;
};

Scene Collisions(bool one_size) {
  Scene scene(one_size);
  const double v = kSpeed;
  const double w = kSpin;
  const double gap = 1e-3 * kRadius;
  const double overlap = -0.02 * kRadius;
  scene.Pair("head-on", 1, gap, {1, 0, 0}, {v, 0, 0}, {-v, 0, 0});
  scene.Pair("head-on, tilted", 1, gap, {1, 2, 3}, {v / 3, v / 2, v}, {});
  scene.Pair("oblique", 1, gap, {1, 0, 0}, {v, 0, 0.7 * v}, {-v, 0, 0});
  scene.Pair("grazing", 1.5, gap, {0, 1, 0}, {2 * v, 0.3 * v, v}, {0, -0.3 * v, 0});
  scene.Pair("rolling", 1, gap, {0, 0, 1}, {0, 0, v}, {0, 0, -v}, {w, 0, 0}, {-w, 0, 0});
  scene.Pair("sliding spins", 2, gap, {0, 1, 1}, {0, v, v}, {}, {2 * w, w, 0}, {2 * w, -w, 0});
  scene.Pair("twisting", 1, gap, {1, 1, 0}, {v, v, 0}, {}, {3 * w, 3 * w, 0}, {-w, -w, 0});
  scene.Pair("all at once", 3, gap, {-1, 2, 1}, {-v, v, 0.2 * v}, {v, 0, -v}, {w, -2 * w, w},
             {0, 3 * w, 0.5 * w});
  scene.Pair("small on large", 3, gap, {1, -1, 2}, {}, {-v, 2 * v, -v}, {0, 0, 2 * w}, {w, 0, 0});
  scene.Pair("pressed, let go", 1, overlap, {0, 0, 1}, {}, {});
  scene.Pair("pulled off", 2, overlap, {1, 0, 1}, {}, {0.5 * v, 0, 0.5 * v});
  scene.Pair("pressed, rolling", 1, overlap, {0, 1, 0}, {}, {}, {w, 0, 0}, {-w, 0, 0});
  scene.Pair("pressed, twisting", 1.5, overlap, {1, 0, 0}, {}, {}, {w, 0, 0}, {-w, 0.1 * w, 0});
  scene.Pair("pressed, sheared", 2.5, overlap, {0, 0, 1}, {0.1 * v, 0, 0}, {});

  for (const std::size_t axis : {0U, 1U, 2U}) {
    for (const int side : {-1, 1}) {
      const std::string plane = std::string(side < 0 ? "lower " : "upper ") + "xyz"[axis];
      Vector3 velocity{};
      velocity[axis] = side * v;
      velocity[(axis + 1) % 3] = 0.6 * v;
      velocity[(axis + 2) % 3] = -0.2 * v;
      scene.AtWall("plane " + plane + ", oblique", axis, side, 1, gap, velocity, {});
      velocity[(axis + 1) % 3] = 0;
      Vector3 spin = {0.4 * w, 0.5 * w, -0.6 * w};
      spin[axis] = 2 * w;
      scene.AtWall("plane " + plane + ", spinning", axis, side, 2, gap, velocity, spin);
      spin[axis] = 0.1 * w;
      scene.AtWall("plane " + plane + ", rolling", axis, side, 1, -0.005 * kRadius, {}, spin);
    }
  }
  return scene;
}

Program SceneProgram(const ContactLaw& law, const Packing& packing) {
  Program program = Vacuum(packing);
  program.law = law;
  Materials& m = program.materials;
  m.particle_particle = {.restitution = 0.5,
                         .friction = 0.3,
                         .rolling_friction = 0.15,
                         .cohesion_energy_density = 15'000,
                         .surface_energy = 1e-4};
  m.particle_wall = {.restitution = 0.7,
                     .friction = 0.2,
                     .rolling_friction = 0.1,
                     .cohesion_energy_density = 10'000};
  m.linear = {.normal = 20, .tangential = 8, .normal_damping = 4e-6, .tangential_damping = 2e-6};
  program.domain.lower = {-1.1 * kHalfBox, -1.1 * kHalfBox, -1.1 * kHalfBox};
  program.domain.upper = {1.1 * kHalfBox, 1.1 * kHalfBox, 1.1 * kHalfBox};
  for (const int axis : {0, 1, 2}) {
    const std::string letter(1, "xyz"[axis]);
    program.walls.push_back({.name = "lower " + letter, .axis = axis, .position = -kHalfBox});
    program.walls.push_back({.name = "upper " + letter,
                             .axis = axis,
                             .position = kHalfBox,
                             .facing_positive = false,
                             .frictionless = axis == 1});
  }
  program.gravity = {-11, -7, -29};
  program.stages = {
      Advance{.duration = kEvery * kFrames * program.time_step, .packing_every = kEvery}};
  return program;
}

// Largest difference over frames: of a sphere's position over its radius, of its velocity over the
// largest speed that its group's centres or surfaces have, and of its spin times radius over that.
struct Difference {
  double position = 0;
  double velocity = 0;
  double spin = 0;

  double Worst() const { return std::max({position, velocity, spin}); }
};

std::map<std::string, Difference> Compare(const std::vector<Moment>& a,
                                          const std::vector<Moment>& b, const Scene& scene) {
  std::map<std::string, double> speed;
  for (const Moment& moment : a) {
    for (const Sphere& s : moment.packing) {
      double& fastest = speed[scene.NameOf(s.id)];
      fastest = std::max({fastest, Length(s.velocity), s.radius * Length(s.spin)});
    }
  }
  std::map<std::string, Difference> differences;
  for (std::size_t frame = 0; frame < a.size(); ++frame) {
    EXPECT_NEAR(a[frame].time, b[frame].time, 1e-3 * kTimeStep);
    for (std::size_t n = 0; n < a[frame].packing.size(); ++n) {
      const Sphere& p = a[frame].packing[n];
      const Sphere& q = b[frame].packing[n];
      EXPECT_EQ(p.id, q.id);
      const std::string& name = scene.NameOf(p.id);
      Difference& d = differences[name];
      d.position = std::max(d.position, Length(p.position - q.position) / p.radius);
      d.velocity = std::max(d.velocity, Length(p.velocity - q.velocity) / speed[name]);
      d.spin = std::max(d.spin, p.radius * Length(p.spin - q.spin) / speed[name]);
    }
  }
  return differences;
}

void ExpectSameTrajectories(const Program& program, const Scene& scene, double tolerance) {
  const TwoTraces traces = RunBoth(program);
  ASSERT_TRUE(traces.embedded.outcome.ok()) << traces.embedded.outcome.message;
  ASSERT_TRUE(traces.liggghts.outcome.ok()) << traces.liggghts.outcome.message;
  ASSERT_EQ(traces.embedded.moments.size(), traces.liggghts.moments.size());
  ASSERT_EQ(traces.embedded.moments.size(), static_cast<std::size_t>(kFrames));
  const auto differences = Compare(traces.embedded.moments, traces.liggghts.moments, scene);
  Difference worst;
  for (const auto& [name, d] : differences) {
    EXPECT_LT(d.Worst(), tolerance) << name << ": position " << d.position << ", velocity "
                                    << d.velocity << ", spin " << d.spin;
    worst.position = std::max(worst.position, d.position);
    worst.velocity = std::max(worst.velocity, d.velocity);
    worst.spin = std::max(worst.spin, d.spin);
  }
  std::printf("[ row ] | %s | %.1e | %.1e | %.1e |\n", program.law.ToString().c_str(),
              worst.position, worst.velocity, worst.spin);
}

std::vector<ContactLaw> Laws() {
  std::vector<ContactLaw> laws;
  for (const Normal normal : {Normal::hertz, Normal::linear}) {
    for (const Tangential tangential : {Tangential::history, Tangential::no_history}) {
      for (const Cohesion cohesion : {Cohesion::none, Cohesion::sjkr2, Cohesion::dmt}) {
        for (const Rolling rolling : {Rolling::none, Rolling::cdt, Rolling::epsd2}) {
          for (const bool limit : {false, true}) {
            for (const bool torsion : {true, false}) {
              if (rolling == Rolling::none && !torsion) continue;
              laws.push_back({.normal = normal,
                              .limit_force = limit,
                              .tangential = tangential,
                              .cohesion = cohesion,
                              .rolling = rolling,
                              .torsion = torsion});
            }
          }
        }
      }
    }
  }
  return laws;
}

std::string NameOf(const ::testing::TestParamInfo<ContactLaw>& info) {
  const ContactLaw& law = info.param;
  const auto name = [](std::span<const std::string> names, auto value) {
    return names[static_cast<std::size_t>(value)];
  };
  std::string text = name(NormalLawNames(), law.normal) + "_" +
                     name(TangentialLawNames(), law.tangential) + "_" +
                     name(CohesionNames(), law.cohesion) + "_" + name(RollingNames(), law.rolling);
  if (law.rolling != Rolling::none) text += law.torsion ? "_torsion" : "_no_torsion";
  return text + (law.limit_force ? "_limited" : "");
}

class ContactsInTwoEngines : public ::testing::TestWithParam<ContactLaw> {};

TEST_P(ContactsInTwoEngines, MoveAlike) {
  const Scene scene = Collisions(GetParam().cohesion == Cohesion::dmt);
  ExpectSameTrajectories(SceneProgram(GetParam(), scene.packing()), scene, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Liggghts, ContactsInTwoEngines, ::testing::ValuesIn(Laws()), NameOf);

}  // namespace
}  // namespace powdercal::physics

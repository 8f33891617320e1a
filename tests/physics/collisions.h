#pragma once

#include <array>
#include <map>

#include "tests/physics/programs.h"

// Collisions far apart from one another in one run, and how far two engines agree about them.

namespace powdercal::physics {

inline constexpr double kSpeed = 0.02;             // [m/s]
inline constexpr double kSpin = kSpeed / kRadius;  // [rad/s]
inline constexpr double kPlace = 1.5e-4;           // [m] between one collision and the next
inline constexpr double kHalfBox = 3.2e-4;         // [m] planes all around
inline constexpr int kEvery = 20;
inline constexpr int kFrames = 120;

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

// LIGGGHTS divides the whole domain into bins.
inline Program InBox(const Packing& packing) {
  Program program = Vacuum(packing);
  const double half = 1.1 * kHalfBox;
  program.domain.lower = {-half, -half, -half};
  program.domain.upper = {half, half, half};
  return program;
}

inline Program SceneProgram(const ContactLaw& law, const Packing& packing) {
  Program program = InBox(packing);
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
};

inline std::map<std::string, Difference> Compare(const std::vector<Moment>& a,
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

// Something happens to every sphere: at some time its speed, or that of its surface, is not what
// gravity alone would have made of it.
inline void ExpectContacts(const Program& program, const Scene& scene,
                           const std::vector<Moment>& moments) {
  const Packing& start = *program.particles.packing;
  for (std::size_t n = 0; n < start.size(); ++n) {
    double change = 0;
    for (const Moment& moment : moments) {
      const Sphere& s = moment.packing[n];
      const Vector3 free = start[n].velocity + moment.time * program.gravity;
      change =
          std::max(change, Length(s.velocity - free) + s.radius * Length(s.spin - start[n].spin));
    }
    EXPECT_GT(change, 0.02 * kSpeed) << scene.NameOf(start[n].id);
  }
}

}  // namespace powdercal::physics

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "experiments/spreading.h"
#include "tests/experiments/powder_samples.h"
#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

// A program in coordinates that are mirrored or exchanged, and the way back: both are their own
// inverse. The experiment measures in its own coordinates.
using Map = std::function<Vector3(const Vector3&)>;

Vector3 Mirrored(const Vector3& v) { return {-v[0], v[1], v[2]}; }
Vector3 Exchanged(const Vector3& v) { return {v[1], v[0], v[2]}; }

void Transform(const Map& map, Packing* packing) {
  for (Sphere& sphere : *packing) {
    sphere.position = map(sphere.position);
    sphere.velocity = map(sphere.velocity);
  }
}

Program Transformed(Program program, const Map& map) {
  Transform(map, &*program.particles.packing);
  const Vector3 a = map(program.domain.lower);
  const Vector3 b = map(program.domain.upper);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    program.domain.lower[axis] = std::min(a[axis], b[axis]);
    program.domain.upper[axis] = std::max(a[axis], b[axis]);
  }
  if (map({1, 0, 0})[0] == 0) {
    std::swap(program.domain.boundaries[0], program.domain.boundaries[1]);
  }
  for (Mesh& mesh : program.meshes) {
    for (Vector3& vertex : mesh.vertices) vertex = map(vertex);
  }
  for (Stage& stage : program.stages) {
    auto* advance = std::get_if<Advance>(&stage);
    if (advance == nullptr) continue;
    for (Motion& motion : advance->motions) motion.velocity = map(motion.velocity);
  }
  return program;
}

struct Statistics {
  double mean = 0;
  double error = 0;
};

Statistics Over(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double mean = 0;
  double squares = 0;
  for (const double v : values) mean += v / n;
  for (const double v : values) squares += (v - mean) * (v - mean);
  return {mean, std::sqrt(squares / (n - 1) / n)};
}

using Layers = std::map<std::string, std::vector<double>>;

Layers Spread(const Map& map) {
  const auto spreading =
      WithOptions<Spreading>("{sweep: 0.7 mm, width: 0.16 mm, blade_speed: 50 mm/s}");
  SimulatedPowder powder = EqualSpheres();
  powder.law.cohesion = ContactLaw::Cohesion::sjkr2;
  powder.materials.particle_particle.cohesion_energy_density = 15'000;
  powder.materials.particle_wall.cohesion_energy_density = 15'000;
  Layers layers;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Program program = PlanOf(spreading, powder, Fidelity::quick, seed);
    Trace trace = RunOk(Transformed(program, map));
    for (Moment& moment : trace.moments) Transform(map, &moment.packing);
    Outcome outcome;
    const Measurement measured = spreading.Measure(program, trace, &outcome);
    for (const char* response : {"coverage", "packing_density", "swept_share"}) {
      layers[response].push_back(measured.responses.at(response).value);
    }
  }
  return layers;
}

TEST(Symmetry, SpreadingKnowsNeitherLeftNorRightNorTheAxis) {
  const Layers plain = Spread([](const Vector3& v) { return v; });
  for (const auto& [name, map] : {std::pair<std::string, Map>{"mirrored", Mirrored},
                                  std::pair<std::string, Map>{"exchanged", Exchanged}}) {
    const Layers other = Spread(map);
    for (const auto& [response, values] : plain) {
      const Statistics a = Over(values);
      const Statistics b = Over(other.at(response));
      const double error = std::hypot(a.error, b.error);
      Measured(name + " " + response + ", difference in standard errors",
               (b.mean - a.mean) / error);
      // 3.2 is the 99 % quantile of Student's t for ten degrees of freedom.
      EXPECT_LT(std::abs(b.mean - a.mean), 3.2 * error)
          << name << " " << response << ": " << a.mean << " and " << b.mean;
      EXPECT_LT(error, 0.1 * a.mean) << "too much scatter to tell";
    }
  }
}

}  // namespace
}  // namespace powdercal::physics

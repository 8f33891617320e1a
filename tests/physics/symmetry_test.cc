#include <gtest/gtest.h>

#include <array>
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

// Values over seeds, by response.
using Responses = std::map<std::string, std::vector<double>>;

Responses Spread(const Map& map) {
  const auto spreading =
      WithOptions<Spreading>("{sweep: 0.7 mm, width: 0.16 mm, blade_speed: 50 mm/s}");
  SimulatedPowder powder = EqualSpheres();
  powder.law.cohesion = ContactLaw::Cohesion::sjkr2;
  powder.materials.particle_particle.cohesion_energy_density = 15'000;
  powder.materials.particle_wall.cohesion_energy_density = 15'000;
  Responses responses;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Program program = PlanOf(spreading, powder, Fidelity::quick, seed);
    Trace trace = RunOk(Transformed(program, map));
    for (Moment& moment : trace.moments) Transform(map, &moment.packing);
    Outcome outcome;
    const Measurement measured = spreading.Measure(program, trace, &outcome);
    for (const char* response : {"coverage", "packing_density", "swept_share"}) {
      responses[response].push_back(measured.responses.at(response).value);
    }
  }
  return responses;
}

// 3.2 is the 99 % quantile of Student's t for ten degrees of freedom.
void ExpectAlike(const std::string& what, const Responses& plain, const Responses& other) {
  for (const auto& [response, values] : plain) {
    const Statistics a = Over(values);
    const Statistics b = Over(other.at(response));
    const double error = std::hypot(a.error, b.error);
    Measured(what + " " + response + ", difference in standard errors", (b.mean - a.mean) / error);
    EXPECT_LT(std::abs(b.mean - a.mean), 3.2 * error)
        << what << " " << response << ": " << a.mean << " and " << b.mean;
    EXPECT_LT(error, 0.1 * std::abs(a.mean)) << "too much scatter to tell";
  }
}

TEST(Symmetry, SpreadingKnowsNeitherLeftNorRightNorTheAxis) {
  const Responses plain = Spread([](const Vector3& v) { return v; });
  ExpectAlike("mirrored", plain, Spread(Mirrored));
  ExpectAlike("exchanged", plain, Spread(Exchanged));
}

constexpr int kCount = 500;
constexpr double kStress = 900;  // [Pa]

// A periodic cube of cohesive, rolling-resistant spheres; one edge is under stress.
Program Cell(std::uint64_t seed, std::size_t loaded) {
  Program program = Vacuum({}, 4e-7);
  const double edge = std::cbrt(kCount * kPi / 6 * std::pow(2 * kRadius, 3) / 0.32);
  program.particles = {.sizes = {.mean = 2 * kRadius}, .count = kCount, .seed = seed};
  program.law.cohesion = ContactLaw::Cohesion::sjkr2;
  program.law.rolling = ContactLaw::Rolling::epsd2;
  SetContact(program, {.restitution = 0.4,
                       .friction = 0.3,
                       .rolling_friction = 0.2,
                       .cohesion_energy_density = 10'000});
  program.domain = {
      {0, 0, 0}, {edge, edge, edge}, {Boundary::periodic, Boundary::periodic, Boundary::periodic}};
  Deform deform;
  deform.edges[loaded] = {EdgeControl::Kind::stress, kStress};
  program.stages = {Insert{0, edge, {}}, deform};
  return program;
}

double InertialTime() { return 2 * kRadius * std::sqrt(kDensity / kStress); }

double VoidRatio(const Moment& moment) {
  const Vector3 lengths = moment.cell->upper - moment.cell->lower;
  return lengths[0] * lengths[1] * lengths[2] / (kCount * kPi / 6 * std::pow(2 * kRadius, 3)) - 1;
}

// Sheared to a steady state; `sign` turns the direction around.
Responses Sheared(double sign) {
  Responses responses;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Program program = Cell(seed, 2);
    auto& deform = std::get<Deform>(program.stages.back());
    constexpr double kInertialNumber = 0.01;
    constexpr double kStrain = 2;
    deform.shear_rate = sign * kInertialNumber / InertialTime();
    deform.duration = kStrain / std::abs(deform.shear_rate);
    const Trace trace = RunOk(program);
    double shear = 0;
    double normal = 0;
    for (std::size_t i = trace.cell.time.size() / 2; i < trace.cell.time.size(); ++i) {
      shear += trace.cell.stress[i][0][2];
      normal += trace.cell.stress[i][2][2];
    }
    responses["stress ratio"].push_back(-sign * shear / normal);
    responses["void ratio"].push_back(VoidRatio(trace.moments.back()));
  }
  return responses;
}

TEST(Symmetry, ShearKnowsNeitherLeftNorRight) { ExpectAlike("mirrored", Sheared(1), Sheared(-1)); }

// Pressed along one axis, the others kept; without gravity all axes are alike.
Responses Pressed(std::size_t axis) {
  Responses responses;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Program program = Cell(seed, axis);
    auto& deform = std::get<Deform>(program.stages.back());
    deform.relaxation_rate = 4e-3 / InertialTime();
    deform.duration = 80 * InertialTime();
    const Trace trace = RunOk(program);
    const std::array<Vector3, 3>& stress = trace.moments.back().cell->stress;
    EXPECT_NEAR(stress[axis][axis] / kStress, 1, 0.05) << "seed " << seed;
    double lateral = 0;
    for (std::size_t other = 0; other < 3; ++other) {
      if (other != axis) lateral += 0.5 * stress[other][other] / stress[axis][axis];
    }
    responses["void ratio"].push_back(VoidRatio(trace.moments.back()));
    responses["lateral stress ratio"].push_back(lateral);
  }
  return responses;
}

TEST(Symmetry, CompactionKnowsNoAxis) {
  const Responses along_z = Pressed(2);
  ExpectAlike("along x", along_z, Pressed(0));
  ExpectAlike("along y", along_z, Pressed(1));
}

}  // namespace
}  // namespace powdercal::physics

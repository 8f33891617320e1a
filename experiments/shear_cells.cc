#include "experiments/shear_cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "backends/insertion.h"
#include "core/random.h"

namespace powdercal {
namespace {

constexpr double kInitialSolidFraction = 0.34;
constexpr double kTypicalSolidFraction = 0.55;
constexpr double kBumpHeight = 0.8;  // [d] of the glued spheres of the upper layer

// Height [m] of the powder at a solid fraction.
double HeightAt(const ShearProtocol& protocol, const SizeDistribution& sizes,
                double solid_fraction) {
  return protocol.count * std::numbers::pi / 6 * sizes.Moment(3) /
         (protocol.width * protocol.width * solid_fraction);
}

// Adds the stages after the first, which consolidates. `shear` makes the stage of that name that
// shears under a normal stress to a strain.
template <typename Shear>
void AddStages(const ShearProtocol& protocol, const Shear& shear, Program* program) {
  const double piece =
      protocol.repeats > 1 ? 0.5 * protocol.preshear_strain / (protocol.repeats - 1) : 0;
  for (int repeat = 1; repeat <= protocol.repeats; ++repeat) {
    const std::string state = fmt::format("state_{}", repeat);
    double strain = piece;
    if (repeat == 1) strain = protocol.preshear_strain * (protocol.repeats > 1 ? 0.5 : 1);
    if (repeat > 1) program->stages.push_back(Restore{fmt::format("state_{}", repeat - 1)});
    program->stages.push_back(
        shear(fmt::format("{}{}", kPreshearPrefix, repeat), protocol.preshear, strain));
    program->stages.push_back(Save{state});
    for (std::size_t i = 0; i < protocol.normals.size(); ++i) {
      program->stages.push_back(Restore{state});
      if (protocol.cell == ShearCell::platens) {
        Servo servo = std::get<Servo>(program->stages.front());
        servo.stress = protocol.normals[i];
        program->stages.push_back(servo);
      }
      program->stages.push_back(shear(fmt::format("{}{}_{}", kYieldPrefix, repeat, i + 1),
                                      protocol.normals[i], protocol.yield_strain));
    }
  }
}

void PlanPeriodic(const ShearProtocol& protocol, const SimulatedPowder& powder, Program* program) {
  const double height = HeightAt(protocol, powder.sizes, kInitialSolidFraction);
  program->domain = {{0, 0, 0},
                     {protocol.width, protocol.width, height},
                     {Boundary::periodic, Boundary::periodic, Boundary::periodic}};
  program->stages.push_back(Insert{.bottom = 0, .top = height});
  AddStages(
      protocol,
      [&](const std::string& name, double normal, double strain) -> Stage {
        const double rate = protocol.ShearRate(powder, normal);
        Deform deform{.name = name, .duration = strain / rate, .shear_rate = rate};
        deform.edges[2] = {EdgeControl::Kind::stress, normal};
        return deform;
      },
      program);
}

// Spheres of the mean size in two layers. The lower, about z = 0, is a square lattice so close that
// not even half of the smallest particle fits through between its spheres; it is what holds the
// powder. The upper has a sphere over every fourth hollow of the lower, at uneven heights: bumps as
// deep and as wide as the top platen's ridges. The lower layer alone is smoother than the powder,
// which then slides along it in a band of three diameters and hardly shears elsewhere.
Packing GluedLayers(const SizeDistribution& sizes, double width, std::int64_t first_id,
                    std::uint64_t seed) {
  constexpr double kUnevenness = 0.2;  // [d]
  const double d = sizes.Moment(1);
  const double closest = (d + 0.5 * sizes.Quantile(0)) / std::numbers::sqrt2;
  const int along = 2 * static_cast<int>(std::ceil(width / (2 * closest)));
  const double spacing = width / along;
  RandomStream stream = RandomStream(seed).Split("glued layers");
  Packing layers;
  const auto add = [&](double x, double y, double z) {
    layers.push_back({.id = first_id + static_cast<std::int64_t>(layers.size()),
                      .radius = d / 2,
                      .position = {x, y, z + kUnevenness * d * (stream.Uniform() - 0.5)}});
  };
  for (int i = 0; i < along * along; ++i) {
    add((i % along + 0.25) * spacing, (i / along + 0.25) * spacing, 0);
  }
  for (int i = 0; i < along * along / 4; ++i) {
    add((2 * (i % (along / 2)) + 0.75) * spacing, (2 * (i / (along / 2)) + 0.75) * spacing,
        kBumpHeight * d);
  }
  return layers;
}

// Ridges along y with flanks of 45°, as many across the width as make them about 2 d wide; valleys
// at both ends, where the plate meets its periodic image.
Mesh RidgedPlate(const ShearProtocol& protocol, const SizeDistribution& sizes, double height) {
  const double d = sizes.Moment(1);
  const int ridges = std::max(2, static_cast<int>(std::lround(protocol.width / (2 * d))));
  Mesh mesh{.name = kTopPlaten};
  for (int i = 0; i <= 2 * ridges; ++i) {
    const double x = protocol.width * i / (2 * ridges);
    const double z = height + (i % 2 == 0 ? LevelsOf(sizes).ridge_depth : 0);
    mesh.vertices.push_back({x, 0, z});
    mesh.vertices.push_back({x, protocol.width, z});
  }
  for (int i = 0; i < 2 * ridges; ++i) {
    const int v = 2 * i;
    mesh.triangles.push_back({v, v + 2, v + 3});
    mesh.triangles.push_back({v, v + 3, v + 1});
  }
  return mesh;
}

void PlanPlatens(const ShearProtocol& protocol, const SimulatedPowder& powder, std::uint64_t seed,
                 Program* program) {
  const SizeDistribution& sizes = powder.sizes;
  const double d = sizes.Moment(1);
  const double bottom = (kBumpHeight + 0.65) * d;  // clear of the bumps
  const double top = bottom + HeightAt(protocol, sizes, kInitialSolidFraction);
  const double height = HeightAt(protocol, sizes, kTypicalSolidFraction);
  program->domain = {{0, 0, -2 * d},
                     {protocol.width, protocol.width, top + 4 * d},
                     {Boundary::periodic, Boundary::periodic, Boundary::open}};
  Packing packing =
      PlaceParticles(program->particles, program->domain, {.bottom = bottom, .top = top});
  const Packing layers = GluedLayers(sizes, protocol.width, protocol.count + 1, seed);
  GluedGroup group{.name = kBottomPlaten};
  for (const Sphere& sphere : layers) group.ids.push_back(sphere.id);
  packing.insert(packing.end(), layers.begin(), layers.end());
  program->particles.count = static_cast<int>(packing.size());
  program->particles.packing = std::move(packing);
  program->groups = {std::move(group)};
  program->meshes = {RidgedPlate(protocol, sizes, top + 0.5 * d)};
  // Within the bed at any density, and as far from both platens as that allows.
  program->stress_slab = {0.3 * height, 0.65 * height};

  // Slow enough that the powder in its way does not bear the stress by its inertia, rho v².
  const double speed = 0.2 * std::sqrt(protocol.preshear / powder.materials.density);
  program->stages.push_back(Servo{.wall = kTopPlaten,
                                  .stress = protocol.preshear,
                                  .max_velocity = speed,
                                  .max_duration = 20 * top / speed});
  AddStages(
      protocol,
      [&](const std::string& name, double normal, double strain) -> Stage {
        const double rate = protocol.ShearRate(powder, normal);
        return Advance{.name = name,
                       .duration = strain / rate,
                       .motions = {{.body = kBottomPlaten, .velocity = {-rate * height, 0, 0}}}};
      },
      program);
}

}  // namespace

std::span<const std::string> ShearCellNames() {
  static const std::array<std::string, 2> kNames = {"periodic", "platens"};
  return kNames;
}

double ShearProtocol::ShearRate(const SimulatedPowder& powder, double normal) const {
  return inertial_number / (powder.sizes.Moment(1) * std::sqrt(powder.materials.density / normal));
}

PlatenLevels LevelsOf(const SizeDistribution& sizes) {
  const double d = sizes.Moment(1);
  return {.bottom = 0.5 * kBumpHeight * d, .ridge_depth = d};
}

Program PlanShear(const ShearProtocol& protocol, const SimulatedPowder& powder,
                  std::uint64_t seed) {
  Program program;
  program.particles = {.sizes = powder.sizes, .count = protocol.count, .seed = seed};
  program.materials = powder.materials;
  program.law = powder.law;
  program.gravity = {0, 0, 0};
  if (protocol.cell == ShearCell::periodic) {
    PlanPeriodic(protocol, powder, &program);
  } else {
    PlanPlatens(protocol, powder, seed, &program);
  }
  return program;
}

}  // namespace powdercal

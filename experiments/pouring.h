#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "backends/program.h"

namespace powdercal {

// How powder is poured before a test, and the parts of protocols that follow from it. SI units.

/// Time [s] in which something thrown down at `velocity` ≥ 0 [m/s] covers `distance` [m]. Without
/// gravity and velocity, where it never does: 0.
double FallTime(double distance, double velocity, double gravity);

/// Mean solid volume of a sphere [m3], pi/6 E(d³).
double MeanSphereVolume(const SizeDistribution& sizes);

/// What an experiment has at the sides of its domain.
enum class Sides {
  periodic,
  walls,  ///< frictionless planes: for simulators without planes in a periodic domain
};
std::span<const std::string> SidesNames();

/// Puts frictionless planes across `axis` where the domain ends, and opens it there.
void EncloseBetweenWalls(int axis, Program* program);

/// A box in which spheres are placed at random (insertion.h), to fall as one.
struct LooseBox {
  Vector3 lower{};  ///< [m]
  Vector3 upper{};  ///< [m]
  bool periodic_y = true;
  double fall_speed = 0;  ///< [m/s] downwards
};
/// The spheres of `count`, `sizes` and `seed` in that box. Throws InputError if they find no room;
/// a solid fraction of 0.30 always has it.
Packing PourLoose(const Particles& particles, const LooseBox& box);

/// Waits until spheres that fell over `distance` at most are at rest: between twice and 20 times
/// the time of their fall.
Settle SettleAfterFall(double distance, double velocity, double gravity, double diameter);

/// The spheres of a packing with ids up to `last`: the free ones, where glued ones follow.
Packing FreeSpheres(const Packing& packing, std::int64_t last);

/// Kinetic energy over the sum of m g d of the spheres [-], what Settle looks at; 0 for an empty
/// packing or without gravity.
double KineticEnergyRatio(const Packing& packing, double gravity);

}  // namespace powdercal

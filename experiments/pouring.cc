#include "experiments/pouring.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "backends/insertion.h"
#include "experiments/packing_measures.h"

namespace powdercal {

double FallTime(double distance, double velocity, double gravity) {
  if (gravity == 0) return velocity > 0 ? distance / velocity : 0;
  return (std::sqrt(velocity * velocity + 2 * gravity * distance) - velocity) / gravity;
}

double MeanSphereVolume(const SizeDistribution& sizes) {
  return std::numbers::pi / 6 * sizes.Moment(3);
}

std::span<const std::string> SidesNames() {
  static const std::vector<std::string> kNames = {"periodic", "walls"};
  return kNames;
}

void EncloseBetweenWalls(int axis, Program* program) {
  const auto a = static_cast<std::size_t>(axis);
  const std::string letter(1, "xyz"[a]);
  program->domain.boundaries[a] = Boundary::open;
  program->walls.push_back({.name = "side_" + letter + "0",
                            .axis = axis,
                            .position = program->domain.lower[a],
                            .frictionless = true});
  program->walls.push_back({.name = "side_" + letter + "1",
                            .axis = axis,
                            .position = program->domain.upper[a],
                            .facing_positive = false,
                            .frictionless = true});
}

Packing PourLoose(const Particles& particles, const LooseBox& box) {
  const Domain domain{
      box.lower,
      box.upper,
      {Boundary::open, box.periodic_y ? Boundary::periodic : Boundary::open, Boundary::open}};
  return PlaceParticles(
      particles, domain,
      {.bottom = box.lower[2], .top = box.upper[2], .velocity = {0, 0, -box.fall_speed}});
}

Settle SettleAfterFall(double distance, double velocity, double gravity, double diameter) {
  const double fall = FallTime(std::max(distance, diameter), velocity, gravity);
  const double interval = gravity > 0 ? 0.16 * std::sqrt(diameter / gravity) : 0.16 * fall;
  return {.kinetic_energy_ratio = 0.05,
          .check_interval = interval,
          .min_duration = 2 * fall,
          .max_duration = 20 * fall};
}

Packing FreeSpheres(const Packing& packing, std::int64_t last) {
  Packing free;
  free.reserve(packing.size());
  std::copy_if(packing.begin(), packing.end(), std::back_inserter(free),
               [last](const Sphere& sphere) { return sphere.id <= last; });
  return free;
}

double KineticEnergyRatio(const Packing& packing, double gravity) {
  double weight = 0;  // times diameter, over the density
  for (const Sphere& sphere : packing) {
    weight += 4.0 / 3 * std::numbers::pi * std::pow(sphere.radius, 3) * gravity * 2 * sphere.radius;
  }
  return weight > 0 ? KineticEnergy(packing, 1) / weight : 0;
}

}  // namespace powdercal

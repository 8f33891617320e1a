#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "experiments/experiment.h"

namespace powdercal {

/// A metal powder softened to 5 MPa, without cohesion.
inline SimulatedPowder MetalPowder() {
  SimulatedPowder powder;
  powder.sizes = {SizeDistribution::Kind::normal, 29e-6, 6e-6, 12.5e-6, 37.5e-6};
  const ContactParameters contact{.restitution = 0.4, .friction = 0.3, .rolling_friction = 0.2};
  powder.materials = {8220, 5e6, 0.3, contact, contact};
  powder.law.rolling = ContactLaw::Rolling::epsd2;
  return powder;
}

/// The same of equal spheres: longer time steps, for simulations within a test.
inline SimulatedPowder EqualSpheres() {
  SimulatedPowder powder = MetalPowder();
  powder.sizes = {SizeDistribution::Kind::monodisperse, 29e-6, 0, 29e-6, 29e-6};
  return powder;
}

/// An experiment with options, given as YAML.
template <typename T>
T WithOptions(const std::string& options) {
  T experiment;
  ReadYaml(options, "x.yaml", [&](Archive& archive) { experiment.Serialize(archive); });
  return experiment;
}

/// The program of an experiment that is simulated under laboratory conditions.
inline Program PlanOf(const Experiment& experiment, const SimulatedPowder& powder,
                      Fidelity fidelity = Fidelity::quick, std::uint64_t seed = 1) {
  Conditions conditions{.diameter = powder.sizes.Moment(1), .gravity = 9.81};
  experiment.DescribeConditions(fidelity, conditions);
  return experiment.Plan(powder, conditions, {}, fidelity, seed);
}

/// Largest overlap of two spheres of a packing that is periodic along y [m]; negative: a gap.
inline double LargestOverlap(const Packing& packing, double period_y) {
  double largest = -1;
  for (std::size_t i = 0; i < packing.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const auto& a = packing[i];
      const auto& b = packing[j];
      const double x = a.position[0] - b.position[0];
      double y = a.position[1] - b.position[1];
      if (period_y > 0) y -= std::round(y / period_y) * period_y;
      const double z = a.position[2] - b.position[2];
      largest = std::max(largest, a.radius + b.radius - std::sqrt(x * x + y * y + z * z));
    }
  }
  return largest;
}

}  // namespace powdercal

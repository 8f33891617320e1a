#pragma once

#include <optional>

#include "backends/program.h"

namespace powdercal {

/// Figures of the particles that a program asks for: those of the distribution, or of the spheres
/// of an explicit packing.
struct ParticleSummary {
  int count = 0;
  double smallest_diameter = 0;  ///< [m]
  double largest_diameter = 0;   ///< [m]
  double mean_diameter = 0;      ///< [m]
  double mean_cube = 0;          ///< [m3] number mean of d³

  bool OneSize() const { return smallest_diameter == largest_diameter; }
  /// Mass of all particles [kg].
  double Mass(double density) const;
};

/// Requires a valid distribution, or an explicit packing that is not empty.
ParticleSummary Summarise(const Particles& particles);
/// The same where it can be told; else whoever places the particles explains.
std::optional<ParticleSummary> SummariseIfValid(const Particles& particles);

}  // namespace powdercal

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scaling/conditions.h"

namespace powdercal {

/// What the simulation's cohesion says of the powder: the way back from calibrated parameters.
struct PowderCohesion {
  std::string experiment;     ///< the test that was simulated
  double surface_energy = 0;  ///< [J/m2] effective, of the powder (DMT)
  std::string kept;           ///< the group that is taken to be the powder's: "F_c/(sigma d^2)"
  double young_modulus = 0;   ///< [Pa] of the simulation
  std::optional<double> cohesion_energy_density;  ///< [J/m3] of the simulation, SJKR2
  std::optional<double> stated;  ///< [J/m2] the powder's surface energy as the study states it
};

/// The surface energy with which the powder's particles pull, against what loads them in the
/// laboratory, as strongly as the simulated ones against what loads those: the load where the
/// simulation applies one above the bed's own weight (F_c/(sigma d²)), else gravity (Bo). Holds for
/// the mean diameter: F_c goes as R² for SJKR2 and as R for DMT. Empty where the simulation's
/// cohesion or both loads are unknown.
std::optional<PowderCohesion> ReadBack(const std::string& experiment, const Conditions& laboratory,
                                       const Conditions& simulation);

/// A sentence on each, and one more where tests of one calibration stand for different powders.
std::vector<std::string> Describe(const std::vector<PowderCohesion>& readings);

}  // namespace powdercal

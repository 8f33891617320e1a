#pragma once

#include <span>
#include <string>
#include <vector>

#include "backends/program.h"
#include "core/archive.h"
#include "experiments/experiment.h"

namespace powdercal {

/// A declared approximation, for people.
struct ApproximationStatement {
  std::string part;  ///< of the contact law: "cohesion"
  std::string name;  ///< "dmt_pull_off"
  std::string text;  ///< what it does, and how far off it is by itself; sentences
};

/// Parts of the contact law that a study replaces by others, for simulators that do not have them:
/// its section `approximate`. It acts between the study's parameters and the Program, which holds
/// the replacement alone: parameters and results keep to the law that is approximated.
struct Approximations {
  /// dmt_pull_off: SJKR2 by DMT of equal pull-off force between two equal spheres of the mean
  /// diameter, and between such a sphere and a wall (docs/decisions/010).
  enum class Cohesion { none, dmt_pull_off };
  Cohesion cohesion = Cohesion::none;

  bool any() const { return cohesion != Cohesion::none; }
  /// "cohesion: dmt_pull_off"; "" without any.
  std::string ToString() const;
  /// Reads or writes the section. Throws InputError where `law` has not got what is replaced.
  void Serialize(Archive& archive, const ContactLaw& law);

  /// Replaces them in a powder whose parameters have been put in.
  void Apply(SimulatedPowder& powder) const;
  /// One for each, for particles of these sizes.
  std::vector<ApproximationStatement> Describe(const SizeDistribution& sizes) const;
};
std::span<const std::string> CohesionApproximationNames();

/// Surface energy [J/m2] with which DMT has the pull-off force of SJKR2 at one effective radius R*
/// [m]: gamma = F_c/(4 pi R*) = (4 pi²/3) k³ R*/E*² between spheres (docs/physics.md §2). k: SJKR2
/// cohesion energy density [J/m3], at least 0; E*: effective modulus [Pa].
double PullOffSurfaceEnergy(double cohesion_energy_density, double effective_radius,
                            double effective_modulus);
/// The same for a sphere of this radius [m] at a wall, where SJKR2 is half as stiff and R* is the
/// sphere's radius: gamma = (pi²/6) k³ r/E*².
double PullOffSurfaceEnergyAtWall(double cohesion_energy_density, double radius,
                                  double effective_modulus);

}  // namespace powdercal

#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "backends/program.h"
#include "experiments/experiment.h"

namespace powdercal {

// The two cells of the shear test, as programs. In both the powder moves faster along x the higher
// it is (dv_x/dz > 0), and there is no gravity: a sample of some ten layers weighs next to nothing
// against the applied stress, but in a softened simulation it need not, and without it the normal
// stress is the same at the top and at the bottom.

/// periodic: periodic in x, y and z, sheared after Lees & Edwards, with the length of the edge
/// along z controlled by the normal stress: no platens, a homogeneous sample.
/// platens: periodic in x and y, between glued spheres, which move, and a ridged plate, which bears
/// the normal stress.
enum class ShearCell { periodic, platens };
std::span<const std::string> ShearCellNames();

/// What is done to the sample, in the simulation's stresses.
struct ShearProtocol {
  ShearCell cell = ShearCell::periodic;
  int count = 0;                ///< particles that are free to move
  double width = 0;             ///< [m] of the cell along x and y
  double preshear = 0;          ///< [Pa] normal stress
  std::vector<double> normals;  ///< [Pa] at which the powder is made to yield
  /// [-] I = rate · d · √(rho/sigma), d the mean diameter. It is the same at each normal stress, so
  /// that what friction the rate adds is proportional to sigma and does not look like cohesion.
  double inertial_number = 0;
  double preshear_strain = 0;  ///< [-] in all
  double yield_strain = 0;     ///< [-] at each normal stress
  int repeats = 1;             ///< presheared states from which the powder is made to yield

  /// [1/s] at which the powder is sheared under a normal stress.
  double ShearRate(const SimulatedPowder& powder, double normal) const;
};

// Names of bodies and moments.
inline constexpr const char* kTopPlaten = "top";
inline constexpr const char* kBottomPlaten = "bottom";
/// Moments "preshear_1", "preshear_2", …, in the order in which they follow each other from state
/// to state, and "yield_1_2": from the first state, at the second normal stress.
inline constexpr const char* kPreshearPrefix = "preshear_";
inline constexpr const char* kYieldPrefix = "yield_";

/// Where the platens' rough surfaces are, for the height of the powder between them.
struct PlatenLevels {
  double bottom = 0;       ///< [m] z of the middle between the bottom's bumps and hollows
  double ridge_depth = 0;  ///< [m] of the top
};
PlatenLevels LevelsOf(const SizeDistribution& sizes);

/// The program: consolidation, the preshear in `repeats` pieces, the first half as long as the
/// whole (a single one: all of it), each ending in a state that is saved; from each state, every
/// normal stress in turn. Sets particles, domain, bodies, gravity, stages and stress slab; the
/// caller sets the rest, the time step too. Throws InputError as PlaceParticles().
Program PlanShear(const ShearProtocol& protocol, const SimulatedPowder& powder, std::uint64_t seed);

}  // namespace powdercal

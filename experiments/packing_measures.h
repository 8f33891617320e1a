#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "backends/program.h"

namespace powdercal {

// What experiments measure on a packing, whatever backend it comes from. The bed lies in x and y in
// the box of the Domain, along z between two flat walls. Heights are z in m, volumes m³, energies
// J.

// --- Volumes of spheres and of what they share --------------------------------------------------

/// Sum of the spheres' volumes [m3].
double SolidVolume(const Packing& packing);
/// Volume of the part of a sphere below a plane that passes `height` above its centre (negative:
/// below it): pi/3 (r + t)² (2r − t) with t = height limited to [−r, r].
double SphereVolumeBelow(double radius, double height);
/// Volume of the part of a sphere between two heights (spherical segment, exact).
double SphereSlabVolume(const Sphere& sphere, double bottom, double top);
/// Volume common to two spheres whose centres are `distance` > 0 apart: with s = r1 + r2,
/// pi (s − x)² (x² + 2 x s − 3 (r1 − r2)²)/(12 x); the smaller sphere where it lies inside the
/// other.
double LensVolume(double radius1, double radius2, double distance);

// --- Contacts -----------------------------------------------------------------------------------

/// A flat wall perpendicular to z.
struct WallPlane {
  double height = 0;      ///< [m]
  bool facing_up = true;  ///< the side on which the particles are: true for a floor
};

/// Two overlapping spheres, by index in the packing, i < j.
struct PairContact {
  std::uint32_t i = 0;
  std::uint32_t j = 0;
  double distance = 0;        ///< [m] between the centres, of the nearest periodic image
  double overlap = 0;         ///< [m] delta = ri + rj − distance, ≥ 0
  double contact_height = 0;  ///< [m] z of the plane of the lens where it meets the line of centres
};

/// A sphere that overlaps a wall.
struct WallContact {
  std::uint32_t i = 0;
  std::uint32_t wall = 0;  ///< index in the list of walls
  double overlap = 0;      ///< [m] ≥ 0
};

struct Contacts {
  std::vector<PairContact> pairs;  ///< ordered by i, then j
  std::vector<WallContact> walls;  ///< ordered by wall, then i
};

/// All contacts; spheres that just touch count. Requires fewer than 2^32 spheres, each smaller than
/// the periodic widths of the domain, and finite positions. O(n).
Contacts FindContacts(const Packing& packing, const Domain& domain,
                      std::span<const WallPlane> walls);

// --- Void ratio ---------------------------------------------------------------------------------

/// Void ratio e = V_void/V_solid of a slab of the bed, in two estimates of the solid volume: the
/// sum of the spheres, in which overlaps count twice, and the same less the overlap volume. The
/// latter is the volume that the spheres really occupy, but for places where three overlap (third
/// order in delta/d). The difference is of second order, about 3 (1 + e) Z (delta/d)²/4 for equal
/// spheres with Z contacts each; what soft particles do to e in the first order is
/// StiffnessShift().
struct VoidRatio {
  double bottom = 0;             ///< [m]
  double top = 0;                ///< [m]
  double sphere_volume = 0;      ///< [m3]
  double overlap_volume = 0;     ///< [m3]
  double value = 0;              ///< [-] of sphere_volume
  double overlap_corrected = 0;  ///< [-] of sphere_volume − overlap_volume
};

/// Between two heights. Sphere volumes are exact; a lens belongs to the slab, as a whole, that
/// holds its contact_height. Requires bottom < top. Infinite where the slab is empty.
VoidRatio MeasureVoidRatio(const Packing& packing, const Contacts& contacts, const Domain& domain,
                           double bottom, double top);

/// Between 20 % and 80 % of the height between floor and wall: free of the walls' looser layers,
/// the figure to compare with an experiment.
VoidRatio CentralVoidRatio(const Packing& packing, const Contacts& contacts, const Domain& domain,
                           double floor, double wall);

/// From wall to wall. sphere_volume holds the spheres as a whole whose centres lie between the
/// walls; overlap_volume the lenses and the parts of these spheres beyond the wall planes.
VoidRatio WallToWallVoidRatio(const Packing& packing, const Contacts& contacts,
                              const Domain& domain, double floor, double wall);

/// By how much e would be larger if the particles were rigid, to first order: shrinking all
/// distances by the mean relative overlap changes 1 + e = V/V_solid by 3 (1 + e) delta/d.
/// (docs/physics.md, §3: the artefact in e is minus this.) An estimate: rearrangement is left out.
double StiffnessShift(double void_ratio, double mean_relative_overlap);

// --- Contact statistics and energies
// --------------------------------------------------------------

struct ContactStatistics {
  double coordination_number = 0;  ///< mean number of contacts of a particle, walls included
  /// The same over the particles with at least two contacts, counting all of these particles'
  /// contacts (Thornton 2000, Géotechnique 50:43, eq. 5); the others are rattlers. 0 if there are
  /// none.
  double mechanical_coordination_number = 0;
  double rattler_fraction = 0;  ///< particles with fewer than two contacts over all
  double max_overlap = 0;       ///< largest delta/R*, R* = ri rj/(ri + rj), or r at a wall
  double mean_relative_overlap =
      0;  ///< mean of delta/d over the pairs, d = ri + rj; 0 without pairs
};

ContactStatistics MeasureContacts(const Packing& packing, const Contacts& contacts);

/// Elastic energy stored in Hertz contacts [J]: sum of 8/15 E* sqrt(R*) delta^(5/2) over pairs and
/// walls, E* = E/(2 (1 − nu²)), R* as above (walls have the particles' E and nu).
double HertzEnergy(const Packing& packing, const Contacts& contacts, double young_modulus,
                   double poisson_ratio);

/// Translational and rotational kinetic energy [J]: sum of m v²/2 + m r² w²/5.
double KineticEnergy(const Packing& packing, double density);

}  // namespace powdercal

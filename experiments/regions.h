#pragma once

#include <cmath>
#include <cstddef>

#include "backends/program.h"

namespace powdercal {

// The parts of a packing that measures look at, and how much of a sphere lies in them. SI units.

/// An upright rectangle of a plate, on which a layer or a heap lies. What lies there are the
/// spheres with their centres at the plate's height or above.
struct PlateWindow {
  double x0 = 0;        ///< [m]
  double x1 = 0;        ///< [m] > x0
  double y0 = 0;        ///< [m]
  double y1 = 0;        ///< [m] > y0
  double plate = 0;     ///< [m] z of the plate's surface
  double period_y = 0;  ///< [m] of the packing along y, at least y1 − y0; 0: not periodic

  double Area() const { return (x1 - x0) * (y1 - y0); }  ///< [m2]
  bool IsValid() const;
};

/// A box with sides along the axes. Bounds may be infinite.
struct BoxRegion {
  Vector3 lower{};  ///< [m]
  Vector3 upper{};  ///< [m]

  double Volume() const;  ///< [m3]
  /// Half open: lower ≤ point < upper, so that boxes side by side share no point.
  bool Contains(const Vector3& point) const;
};

/// Volume that a sphere and a box have in common [m3]; exact, with a rounding error below
/// 1e-14 r³ wherever faces, edges and corners of the box lie. `radius` > 0.
///
/// Closed form (docs/physics.md, "Layers and heaps"): the volume is a sum, with signs, of those
/// common to the sphere and the eight boxes that the centre spans with each of the corners. Cuts by
/// tilted planes would need the general method of Strobl, Formella & Pöschel (2016), J. Comput.
/// Phys. 311:158.
double SphereBoxVolume(const Vector3& centre, double radius, const BoxRegion& box);

/// How many pieces of at least `size` fit into a length, at least one; a size that divides the
/// length but for rounding does so.
std::size_t CountThatFit(double length, double size);

/// Calls visit(centre, radius) for every sphere on the plate, each of its images along y, whose
/// projection reaches into the window.
template <typename Visit>
void ForEachOnPlate(const Packing& packing, const PlateWindow& window, Visit&& visit) {
  for (const Sphere& sphere : packing) {
    const double r = sphere.radius;
    Vector3 centre = sphere.position;
    if (centre[2] < window.plate) continue;
    if (centre[0] + r <= window.x0 || centre[0] - r >= window.x1) continue;
    if (window.period_y > 0) {
      const double shift = std::floor((window.y0 - r - centre[1]) / window.period_y) + 1;
      centre[1] += shift * window.period_y;
    }
    for (; centre[1] - r < window.y1; centre[1] += window.period_y) {
      if (centre[1] + r > window.y0) visit(centre, r);
      if (window.period_y <= 0) break;
    }
  }
}

}  // namespace powdercal

#pragma once

#include <cstddef>
#include <vector>

#include "backends/program.h"
#include "experiments/regions.h"

namespace powdercal {

// What a spreading test measures on a layer of spheres on a plate. Every function takes the
// rectangle of the plate that it is to look at and requires it to be valid; spheres count up to the
// rectangle's sides, with images along y where it is periodic. An empty layer gives zeros.

/// Number quantile of the diameters of a packing [m], p in [0, 1]; p = 0.1 is d10. 0 for an empty
/// packing.
double DiameterQuantile(const Packing& packing, double p);

// --- Coverage -----------------------------------------------------------------------------------

struct CoverageOptions {
  /// [m] side of the first grid's pixels, at most; 0: d10/4 of the packing. There are at least 16
  /// along each side of the window whatever it says.
  double start_pixel = 0;
  double tolerance = 1e-3;                        ///< [-] > 0, absolute, on the fraction
  std::size_t max_pixels = std::size_t{1} << 26;  ///< memory in bytes; a finer grid is not tried
};

struct Coverage {
  double fraction = 0;  ///< [-] in [0, 1], of the finest grid
  double pixel = 0;     ///< [m] larger side of its pixels; 0 where no sphere is near
  double change = 0;    ///< [-] larger of the last two changes from grid to grid; 1 if there were
                        ///< fewer
  bool converged = false;  ///< change below the tolerance; else max_pixels came first
};

/// Fraction of the window's area beneath the spheres: of the pixels whose centre lies in the
/// projected disc of any. The pixel is halved until the fraction changes by less than the tolerance
/// twice in a row; a single change can be small by chance, and is so in regular layers.
Coverage MeasureCoverage(const Packing& packing, const PlateWindow& window,
                         const CoverageOptions& options = {});

// --- Mass and packing density -------------------------------------------------------------------

/// Mass over the window per area [kg/m2]: `density` [kg/m3] times the exact volume of the spheres
/// between its upright sides, overlaps counted twice.
double MassPerArea(const Packing& packing, const PlateWindow& window, double density);

struct PackingDensity {
  double mean = 0;  ///< [-] over the cells; they are equal, so that it is that of the whole window
  double standard_deviation = 0;  ///< [-] of the cells (divisor count − 1); 0 for a single cell
  std::size_t count = 0;          ///< of cells; the deviation means nothing for a few
  double cell_x = 0;              ///< [m] side of a cell, at least what was asked for
  double cell_y = 0;              ///< [m]
};

/// Packing density phi = solid volume over volume between the plate and `gap` [m] above it, in the
/// cells of a grid that divides the window evenly: as many as fit if they are to be at least
/// `cell_diameters` · `diameter` wide. Where the window is smaller, it is the only cell. Sphere
/// volumes are exact, overlaps count twice. The deviation falls as cells grow, so it goes with
/// their size. Requires gap, diameter, cell_diameters > 0.
PackingDensity MeasurePackingDensity(const Packing& packing, const PlateWindow& window, double gap,
                                     double diameter, double cell_diameters);

// --- Surface ------------------------------------------------------------------------------------

/// Height above the plate at the centres of a grid's pixels.
struct HeightField {
  std::size_t nx = 0;
  std::size_t ny = 0;
  double pixel_x = 0;           ///< [m]
  double pixel_y = 0;           ///< [m]
  std::vector<double> heights;  ///< [m] ≥ 0, x running fastest; 0 where the plate is bare

  double At(std::size_t ix, std::size_t iy) const { return heights[iy * nx + ix]; }
};

/// The upper surface of the spheres, as seen from above. Pixels are at most `pixel` > 0 [m] wide.
HeightField MeasureHeightField(const Packing& packing, const PlateWindow& window, double pixel);

/// What the deviations of a surface are measured from: the horizontal plane at its mean height, or
/// the plane of least squares, which also takes out a tilt.
enum class ReferencePlane { mean, least_squares };

struct SurfaceTexture {
  double thickness = 0;  ///< [m] mean height of the field, bare places included
  double maximum = 0;    ///< [m]
  double sa = 0;         ///< [m] arithmetical mean deviation from the reference plane
  double sq = 0;         ///< [m] root mean square deviation
  double slope_x = 0;    ///< [-] of the reference plane
  double slope_y = 0;    ///< [-]
};

/// Mean thickness and the height parameters Sa and Sq of ISO 25178-2:2021 over the whole field. No
/// filter is applied, so they belong to the window's size. Zeros for a field without pixels.
SurfaceTexture MeasureSurface(const HeightField& field,
                              ReferencePlane reference = ReferencePlane::mean);

}  // namespace powdercal

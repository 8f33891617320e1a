#pragma once

#include <array>
#include <cstddef>
#include <numbers>
#include <optional>
#include <vector>

#include "backends/program.h"
#include "experiments/packing_measures.h"
#include "experiments/regions.h"

namespace powdercal {

// What angle-of-repose tests measure: the draw-down of a bed over an edge, whose face falls along
// x, and the heap under a funnel. Angles in rad. Nothing here gives NaN; where there is nothing to
// measure, the result says so.

// --- Profiles -----------------------------------------------------------------------------------

/// Height of a heap's surface along a line: x, or the distance from an axis.
struct HeightProfile {
  double start = 0;             ///< [m] where the first bin begins
  double bin_width = 0;         ///< [m]
  std::vector<double> heights;  ///< [m] above the plate, ≥ 0; 0 in bins without spheres

  double Position(std::size_t bin) const {  ///< [m] of its middle
    return start + (static_cast<double>(bin) + 0.5) * bin_width;
  }
};

struct ProfileOptions {
  /// [m] > 0. Two to three diameters suit: in narrower bins columns stay empty by chance.
  double bin_width = 0;
  /// Height of a bin from those of its columns: their mean, or this quantile, in [0, 1]; 0.5 does
  /// not see stray particles on top, 1 takes the highest.
  std::optional<double> column_quantile;
};

/// Profile along x. A bin is cut along y into columns about as wide as itself; the height of a
/// column is the highest top of the spheres centred in it, 0 without any, and the bin's height is
/// the columns' mean or quantile. The window is divided into as many bins of at least bin_width as
/// fit. A maximum over a column lies a little above the surface's mean, but as far in every bin, so
/// that slopes keep free of it.
HeightProfile MeasureProfile(const Packing& packing, const PlateWindow& window,
                             const ProfileOptions& options);

/// A round part of a plate.
struct PlateDisc {
  double x = 0;       ///< [m] of the axis
  double y = 0;       ///< [m]
  double radius = 0;  ///< [m]
  double plate = 0;   ///< [m] z of the plate's surface
};

/// Profile over the distance from an axis: as above, with rings for bins, and columns that divide
/// them in azimuth.
HeightProfile MeasureRadialProfile(const Packing& packing, const PlateDisc& disc,
                                   const ProfileOptions& options);

// --- Angle of repose ----------------------------------------------------------------------------

/// The side of the highest bin on which the flank is: falling towards larger positions or rising
/// from smaller ones. The flank of a radial profile falls.
enum class Flank { falling, rising };

struct FlankOptions {
  Flank flank = Flank::falling;
  double lower_fraction = 0.2;  ///< of the drop from the highest bin to the lowest on that side
  double upper_fraction = 0.8;
  /// [m] above the plate, lower and upper; takes the place of the fractions.
  std::optional<std::array<double, 2>> heights;
  double min_drop = 0;                             ///< [m] less is the unevenness of a flat bed
  std::size_t min_bins = 5;                        ///< ≥ 3
  double max_angle = 75 * std::numbers::pi / 180;  ///< [rad] steeper faces are cliffs
};

struct FlankFit {
  enum class State {
    fitted,        ///< the angle is one of repose
    cliff,         ///< the face is steeper than max_angle: cohesion holds it, it has no such angle
    too_few_bins,  ///< the flank is too short for the profile's bins
    no_flank       ///< the profile does not cross both heights, or drops less than min_drop
  };
  State state = State::no_flank;
  // The fit, for any state with at least three bins; else zeros.
  double angle = 0;        ///< [rad] of the straight line with the horizontal
  double angle_error = 0;  ///< [rad] standard error, see below
  double r_squared = 0;    ///< [-] in [0, 1]
  // Where; zeros for no_flank.
  double lower = 0;      ///< [m] above the plate
  double upper = 0;      ///< [m]
  double start = 0;      ///< [m] profile position of the flank's smaller end, edge of its bin
  double end = 0;        ///< [m]
  std::size_t bins = 0;  ///< used in the fit

  bool IsAngleOfRepose() const { return state == State::fitted; }
};

/// Fits a straight line by least squares to the heights of the flank: the bins between the last
/// above the upper height and the first below the lower one, counted from the highest bin. With b
/// the slope, the angle is atan |b| and its error s_b/(1 + b²), s_b² = SSR/((n − 2) S_xx). That
/// takes deviations of neighbouring bins for independent and is a lower bound of the error; the
/// scatter over seeds tells the real one. A flank with fewer than min_bins bins is a cliff if its
/// crossing alone, upper − lower within bins + 1 widths, is steeper than max_angle. Requires
/// heights or fractions in order, fractions in [0, 1].
FlankFit FitFlank(const HeightProfile& profile, const FlankOptions& options = {});

// --- Mass and void ratio ------------------------------------------------------------------------

/// Mass of the spheres with their centres in the region, over that of all spheres poured. `packing`
/// is what is left of `poured`: spheres that left through an outflow boundary count as gone. The
/// density is common. In [0, 1]; 0 if nothing was poured.
double RetainedMassFraction(const Packing& packing, const Packing& poured, const BoxRegion& region);

/// The part of a poured bed that neither walls nor the free surface disturb: the box less a margin
/// at the sides in x and y [m], 20 % to 80 % of its height. `bed` reaches from wall to wall and
/// from the floor to the bed's surface (HeightProfile, SurfaceTexture::thickness). Margins of at
/// least three diameters, 0 along a periodic axis. None where the margins leave no volume.
std::optional<BoxRegion> CentralRegion(const BoxRegion& bed, double margin_x, double margin_y);

/// Void ratio of a region with finite bounds, no wider than the domain's periods, whose periodic
/// images count. Sphere volumes are exact; the volume of an overlap belongs as a whole to the
/// region that holds the middle of its lens. Infinite where the region is empty.
VoidRatio RegionVoidRatio(const Packing& packing, const Contacts& contacts, const Domain& domain,
                          const BoxRegion& region);

}  // namespace powdercal

#include "experiments/heap_measures.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/statistics.h"

namespace powdercal {
namespace {

// Highest tops by bin of a profile and column of the bin.
class ColumnTops {
 public:
  void AddBin(std::size_t columns) { tops_.emplace_back(columns, 0.0); }

  // lateral_fraction: position across the bin, in [0, 1] of its width or circumference.
  void Raise(std::size_t bin, double lateral_fraction, double height) {
    std::vector<double>& columns = tops_[bin];
    const auto count = static_cast<double>(columns.size());
    const auto column =
        static_cast<std::size_t>(std::clamp(std::floor(lateral_fraction * count), 0.0, count - 1));
    columns[column] = std::max(columns[column], height);
  }

  std::vector<double> Heights(const std::optional<double>& quantile) const {
    std::vector<double> heights;
    heights.reserve(tops_.size());
    for (const std::vector<double>& columns : tops_) {
      heights.push_back(quantile ? Quantile(columns, *quantile)
                                 : std::accumulate(columns.begin(), columns.end(), 0.0) /
                                       static_cast<double>(columns.size()));
    }
    return heights;
  }

 private:
  std::vector<std::vector<double>> tops_;
};

[[maybe_unused]] bool IsValid(const ProfileOptions& options) {
  return options.bin_width > 0 && (!options.column_quantile || (*options.column_quantile >= 0 &&
                                                                *options.column_quantile <= 1));
}

// Bins first ≤ i < last of a flank that falls with i.
struct FlankBins {
  std::size_t first = 0;
  std::size_t last = 0;
};

std::optional<FlankBins> FindFlank(const std::vector<double>& heights, std::size_t peak,
                                   double lower, double upper) {
  std::size_t last = peak;
  while (last < heights.size() && heights[last] >= lower) ++last;
  if (last == heights.size()) return std::nullopt;
  std::size_t first = last;
  while (first > peak && heights[first - 1] <= upper) --first;
  if (first == peak) return std::nullopt;
  return FlankBins{first, last};
}

// Straight line through the heights of equidistant bins.
void FitLine(const std::vector<double>& heights, const FlankBins& bins, double bin_width,
             FlankFit* fit) {
  const auto n = static_cast<double>(bins.last - bins.first);
  const double middle = (n - 1) / 2;
  double mean = 0;
  for (std::size_t i = bins.first; i < bins.last; ++i) mean += heights[i] / n;
  double sxx = 0;
  double sxh = 0;
  double shh = 0;
  for (std::size_t i = bins.first; i < bins.last; ++i) {
    const double x = (static_cast<double>(i - bins.first) - middle) * bin_width;
    sxx += x * x;
    sxh += x * (heights[i] - mean);
    shh += (heights[i] - mean) * (heights[i] - mean);
  }
  const double slope = sxh / sxx;
  const double residual = std::max(0.0, shh - slope * sxh);
  fit->angle = std::atan(std::abs(slope));
  fit->angle_error = std::sqrt(residual / ((n - 2) * sxx)) / (1 + slope * slope);
  fit->r_squared = shh > 0 ? 1 - residual / shh : 0;
}

// How many images of the coordinate lie in [lower, upper).
double ImagesBetween(double x, double lower, double upper, double period) {
  if (period == 0) return x >= lower && x < upper ? 1 : 0;
  return std::ceil((upper - x) / period) - std::ceil((lower - x) / period);
}

Vector3 Periods(const Domain& domain) {
  Vector3 periods{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (domain.boundaries[axis] == Boundary::periodic) periods[axis] = domain.Lengths()[axis];
  }
  return periods;
}

// Volume that all images of a sphere share with the region.
double ImageVolume(const Sphere& sphere, const Vector3& periods, const BoxRegion& region) {
  Vector3 first;
  Vector3 last;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    first[axis] = last[axis] = sphere.position[axis];
    if (periods[axis] == 0) continue;
    const double low = region.lower[axis] - sphere.radius - sphere.position[axis];
    const double high = region.upper[axis] + sphere.radius - sphere.position[axis];
    first[axis] += std::ceil(low / periods[axis]) * periods[axis];
    last[axis] += std::floor(high / periods[axis]) * periods[axis];
  }
  const auto images = [&](std::size_t axis) {
    return periods[axis] == 0 ? 1 : std::lround((last[axis] - first[axis]) / periods[axis]) + 1;
  };
  double volume = 0;
  for (long k = 0; k < images(2); ++k) {
    for (long j = 0; j < images(1); ++j) {
      for (long i = 0; i < images(0); ++i) {
        const Vector3 centre = {first[0] + static_cast<double>(i) * periods[0],
                                first[1] + static_cast<double>(j) * periods[1],
                                first[2] + static_cast<double>(k) * periods[2]};
        volume += SphereBoxVolume(centre, sphere.radius, region);
      }
    }
  }
  return volume;
}

// Where the plane of a lens meets the line of centres, next to sphere i.
Vector3 LensMiddle(const Packing& packing, const PairContact& contact, const Vector3& periods) {
  const Sphere& a = packing[contact.i];
  const Sphere& b = packing[contact.j];
  const double x = contact.distance;
  const double arm = (x * x + a.radius * a.radius - b.radius * b.radius) / (2 * x);
  Vector3 middle = a.position;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double d = b.position[axis] - a.position[axis];
    if (periods[axis] > 0) d -= std::round(d / periods[axis]) * periods[axis];
    middle[axis] += d * arm / x;
  }
  return middle;
}

}  // namespace

HeightProfile MeasureProfile(const Packing& packing, const PlateWindow& window,
                             const ProfileOptions& options) {
  assert(window.IsValid() && IsValid(options));
  const std::size_t bins = CountThatFit(window.x1 - window.x0, options.bin_width);
  HeightProfile profile;
  profile.start = window.x0;
  profile.bin_width = (window.x1 - window.x0) / static_cast<double>(bins);
  const double width = window.y1 - window.y0;
  ColumnTops tops;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    tops.AddBin(CountThatFit(width, profile.bin_width));
  }
  for (const Sphere& sphere : packing) {
    const auto& [x, y, z] = sphere.position;
    if (z < window.plate || x < window.x0 || x >= window.x1) continue;
    double from_side = y - window.y0;
    if (window.period_y > 0) {
      from_side -= std::floor(from_side / window.period_y) * window.period_y;
    }
    if (from_side < 0 || from_side > width) continue;
    const auto bin = static_cast<std::size_t>((x - window.x0) / profile.bin_width);
    tops.Raise(std::min(bin, bins - 1), from_side / width, z + sphere.radius - window.plate);
  }
  profile.heights = tops.Heights(options.column_quantile);
  return profile;
}

HeightProfile MeasureRadialProfile(const Packing& packing, const PlateDisc& disc,
                                   const ProfileOptions& options) {
  assert(disc.radius > 0 && IsValid(options));
  constexpr double kTurn = 2 * std::numbers::pi;
  const std::size_t bins = CountThatFit(disc.radius, options.bin_width);
  HeightProfile profile;
  profile.bin_width = disc.radius / static_cast<double>(bins);
  ColumnTops tops;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    tops.AddBin(static_cast<std::size_t>(std::lround(kTurn * (static_cast<double>(bin) + 0.5))));
  }
  for (const Sphere& sphere : packing) {
    const double x = sphere.position[0] - disc.x;
    const double y = sphere.position[1] - disc.y;
    const double distance = std::hypot(x, y);
    if (sphere.position[2] < disc.plate || distance >= disc.radius) continue;
    const auto bin = static_cast<std::size_t>(distance / profile.bin_width);
    tops.Raise(std::min(bin, bins - 1), std::atan2(y, x) / kTurn + 0.5,
               sphere.position[2] + sphere.radius - disc.plate);
  }
  profile.heights = tops.Heights(options.column_quantile);
  return profile;
}

FlankFit FitFlank(const HeightProfile& profile, const FlankOptions& options) {
  assert(options.min_bins >= 3);
  FlankFit fit;
  if (profile.heights.empty()) return fit;
  std::vector<double> heights = profile.heights;
  const bool reversed = options.flank == Flank::rising;
  if (reversed) std::reverse(heights.begin(), heights.end());
  const auto peak = std::max_element(heights.begin(), heights.end());
  const double bottom = *std::min_element(peak, heights.end());
  const double drop = *peak - bottom;
  if (!(drop > 0) || drop < options.min_drop) return fit;

  const double lower =
      options.heights ? (*options.heights)[0] : bottom + options.lower_fraction * drop;
  const double upper =
      options.heights ? (*options.heights)[1] : bottom + options.upper_fraction * drop;
  assert(lower < upper);
  const std::optional<FlankBins> bins =
      FindFlank(heights, static_cast<std::size_t>(peak - heights.begin()), lower, upper);
  if (!bins) return fit;
  fit.lower = lower;
  fit.upper = upper;
  fit.bins = bins->last - bins->first;
  const std::size_t leftmost = reversed ? heights.size() - bins->last : bins->first;
  fit.start = profile.start + static_cast<double>(leftmost) * profile.bin_width;
  fit.end = fit.start + static_cast<double>(fit.bins) * profile.bin_width;
  if (fit.bins >= 3) FitLine(heights, *bins, profile.bin_width, &fit);

  double angle = fit.angle;
  if (fit.bins < options.min_bins) {
    const double widest = static_cast<double>(fit.bins + 1) * profile.bin_width;
    angle = std::atan((upper - lower) / widest);
    fit.state = FlankFit::State::too_few_bins;
  } else {
    fit.state = FlankFit::State::fitted;
  }
  if (angle > options.max_angle) fit.state = FlankFit::State::cliff;
  return fit;
}

double RetainedMassFraction(const Packing& packing, const Packing& poured,
                            const BoxRegion& region) {
  const auto cube = [](double r) { return r * r * r; };
  double total = 0;
  for (const Sphere& sphere : poured) total += cube(sphere.radius);
  if (total == 0) return 0;
  double retained = 0;
  for (const Sphere& sphere : packing) {
    if (region.Contains(sphere.position)) retained += cube(sphere.radius);
  }
  return std::min(1.0, retained / total);
}

std::optional<BoxRegion> CentralRegion(const BoxRegion& bed, double margin_x, double margin_y) {
  const double height = bed.upper[2] - bed.lower[2];
  const BoxRegion region{
      {bed.lower[0] + margin_x, bed.lower[1] + margin_y, bed.lower[2] + 0.2 * height},
      {bed.upper[0] - margin_x, bed.upper[1] - margin_y, bed.lower[2] + 0.8 * height}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(region.lower[axis] < region.upper[axis])) return std::nullopt;
  }
  return region;
}

VoidRatio RegionVoidRatio(const Packing& packing, const Contacts& contacts, const Domain& domain,
                          const BoxRegion& region) {
  const double total = region.Volume();
  assert(total > 0 && std::isfinite(total));
  const Vector3 periods = Periods(domain);
  VoidRatio result;
  result.bottom = region.lower[2];
  result.top = region.upper[2];
  for (const Sphere& sphere : packing) {
    result.sphere_volume += ImageVolume(sphere, periods, region);
  }
  for (const PairContact& contact : contacts.pairs) {
    const Vector3 middle = LensMiddle(packing, contact, periods);
    double images = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      images *= ImagesBetween(middle[axis], region.lower[axis], region.upper[axis], periods[axis]);
    }
    if (images == 0) continue;
    result.overlap_volume +=
        images * LensVolume(packing[contact.i].radius, packing[contact.j].radius, contact.distance);
  }
  const auto ratio = [total](double volume) {
    return volume > 0 ? (total - volume) / volume : std::numeric_limits<double>::infinity();
  };
  result.value = ratio(result.sphere_volume);
  result.overlap_corrected = ratio(result.sphere_volume - result.overlap_volume);
  return result;
}

}  // namespace powdercal

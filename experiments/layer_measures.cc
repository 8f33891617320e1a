#include "experiments/layer_measures.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/statistics.h"

namespace powdercal {
namespace {

struct Disc {
  double x;
  double y;
  double radius;
};

// Pixels first ≤ i ≤ last of a row of `count`, those whose centres lie between two coordinates.
struct PixelRange {
  PixelRange(double from, double to, double start, double pixel, std::size_t count)
      : first(static_cast<std::int64_t>(std::max(0.0, std::ceil((from - start) / pixel - 0.5)))),
        last(static_cast<std::int64_t>(
            std::min(static_cast<double>(count) - 1, std::floor((to - start) / pixel - 0.5)))) {}

  std::int64_t first;
  std::int64_t last;
};

std::size_t CountToFill(double length, double pixel) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(length / pixel - 1e-9)));
}

double CoveredFraction(const std::vector<Disc>& discs, const PlateWindow& window, std::size_t nx,
                       std::size_t ny) {
  std::vector<unsigned char> covered(nx * ny, 0);
  const double pixel_x = (window.x1 - window.x0) / static_cast<double>(nx);
  const double pixel_y = (window.y1 - window.y0) / static_cast<double>(ny);
  for (const Disc& disc : discs) {
    const PixelRange rows(disc.y - disc.radius, disc.y + disc.radius, window.y0, pixel_y, ny);
    for (std::int64_t row = rows.first; row <= rows.last; ++row) {
      const double y = window.y0 + (static_cast<double>(row) + 0.5) * pixel_y - disc.y;
      const double half = std::sqrt(std::max(0.0, disc.radius * disc.radius - y * y));
      const PixelRange run(disc.x - half, disc.x + half, window.x0, pixel_x, nx);
      if (run.first > run.last) continue;
      const auto begin = covered.begin() + row * static_cast<std::int64_t>(nx);
      std::fill(begin + run.first, begin + run.last + 1, 1);
    }
  }
  const auto count = std::count(covered.begin(), covered.end(), 1);
  return static_cast<double>(count) / static_cast<double>(covered.size());
}

}  // namespace

double DiameterQuantile(const Packing& packing, double p) {
  if (packing.empty()) return 0;
  std::vector<double> diameters;
  diameters.reserve(packing.size());
  for (const Sphere& sphere : packing) diameters.push_back(2 * sphere.radius);
  return Quantile(std::move(diameters), p);
}

Coverage MeasureCoverage(const Packing& packing, const PlateWindow& window,
                         const CoverageOptions& options) {
  assert(window.IsValid() && options.tolerance > 0);
  std::vector<Disc> discs;
  ForEachOnPlate(packing, window, [&](const Vector3& centre, double radius) {
    discs.push_back({centre[0], centre[1], radius});
  });
  if (discs.empty()) return {.converged = true};

  const double start =
      options.start_pixel > 0 ? options.start_pixel : DiameterQuantile(packing, 0.1) / 4;
  constexpr std::size_t kFewest = 16;
  std::size_t nx = std::max(kFewest, CountToFill(window.x1 - window.x0, start));
  std::size_t ny = std::max(kFewest, CountToFill(window.y1 - window.y0, start));
  const auto pixel = [&] {
    return std::max((window.x1 - window.x0) / static_cast<double>(nx),
                    (window.y1 - window.y0) / static_cast<double>(ny));
  };
  Coverage coverage{CoveredFraction(discs, window, nx, ny), pixel(), 1, false};
  double last_change = 1;
  while (!coverage.converged && 4 * nx * ny <= options.max_pixels) {
    nx *= 2;
    ny *= 2;
    const double fraction = CoveredFraction(discs, window, nx, ny);
    const double change = std::abs(fraction - coverage.fraction);
    coverage.fraction = fraction;
    coverage.pixel = pixel();
    coverage.change = std::max(change, last_change);
    coverage.converged = coverage.change < options.tolerance;
    last_change = change;
  }
  return coverage;
}

double MassPerArea(const Packing& packing, const PlateWindow& window, double density) {
  assert(window.IsValid());
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const BoxRegion column{{window.x0, window.y0, -kInfinity}, {window.x1, window.y1, kInfinity}};
  double volume = 0;
  ForEachOnPlate(packing, window, [&](const Vector3& centre, double radius) {
    volume += SphereBoxVolume(centre, radius, column);
  });
  return density * volume / window.Area();
}

PackingDensity MeasurePackingDensity(const Packing& packing, const PlateWindow& window, double gap,
                                     double diameter, double cell_diameters) {
  assert(window.IsValid() && gap > 0 && diameter > 0 && cell_diameters > 0);
  const double size = diameter * cell_diameters;
  const std::size_t nx = CountThatFit(window.x1 - window.x0, size);
  const std::size_t ny = CountThatFit(window.y1 - window.y0, size);
  PackingDensity result;
  result.count = nx * ny;
  result.cell_x = (window.x1 - window.x0) / static_cast<double>(nx);
  result.cell_y = (window.y1 - window.y0) / static_cast<double>(ny);

  std::vector<double> densities(nx * ny, 0);
  const double cell_volume = result.cell_x * result.cell_y * gap;
  const auto edge = [](double start, double end, std::size_t i, std::size_t count) {
    return i == count ? end
                      : start + (end - start) * static_cast<double>(i) / static_cast<double>(count);
  };
  const auto cell_of = [](double distance, double cell, std::size_t count) {
    return static_cast<std::size_t>(
        std::clamp(std::floor(distance / cell), 0.0, static_cast<double>(count) - 1));
  };
  ForEachOnPlate(packing, window, [&](const Vector3& centre, double r) {
    const std::size_t last_x = cell_of(centre[0] + r - window.x0, result.cell_x, nx);
    const std::size_t last_y = cell_of(centre[1] + r - window.y0, result.cell_y, ny);
    for (std::size_t iy = cell_of(centre[1] - r - window.y0, result.cell_y, ny); iy <= last_y;
         ++iy) {
      for (std::size_t ix = cell_of(centre[0] - r - window.x0, result.cell_x, nx); ix <= last_x;
           ++ix) {
        const BoxRegion cell{
            {edge(window.x0, window.x1, ix, nx), edge(window.y0, window.y1, iy, ny), window.plate},
            {edge(window.x0, window.x1, ix + 1, nx), edge(window.y0, window.y1, iy + 1, ny),
             window.plate + gap}};
        densities[iy * nx + ix] += SphereBoxVolume(centre, r, cell) / cell_volume;
      }
    }
  });
  for (const double phi : densities) result.mean += phi / static_cast<double>(result.count);
  if (result.count < 2) return result;
  double squares = 0;
  for (const double phi : densities) squares += (phi - result.mean) * (phi - result.mean);
  result.standard_deviation = std::sqrt(squares / static_cast<double>(result.count - 1));
  return result;
}

HeightField MeasureHeightField(const Packing& packing, const PlateWindow& window, double pixel) {
  assert(window.IsValid() && pixel > 0);
  HeightField field;
  field.nx = CountToFill(window.x1 - window.x0, pixel);
  field.ny = CountToFill(window.y1 - window.y0, pixel);
  field.pixel_x = (window.x1 - window.x0) / static_cast<double>(field.nx);
  field.pixel_y = (window.y1 - window.y0) / static_cast<double>(field.ny);
  field.heights.assign(field.nx * field.ny, 0);
  ForEachOnPlate(packing, window, [&](const Vector3& centre, double r) {
    const PixelRange rows(centre[1] - r, centre[1] + r, window.y0, field.pixel_y, field.ny);
    const PixelRange columns(centre[0] - r, centre[0] + r, window.x0, field.pixel_x, field.nx);
    for (std::int64_t iy = rows.first; iy <= rows.last; ++iy) {
      const double y = window.y0 + (static_cast<double>(iy) + 0.5) * field.pixel_y - centre[1];
      for (std::int64_t ix = columns.first; ix <= columns.last; ++ix) {
        const double x = window.x0 + (static_cast<double>(ix) + 0.5) * field.pixel_x - centre[0];
        const double squared = r * r - x * x - y * y;
        if (squared < 0) continue;
        double& height =
            field.heights[static_cast<std::size_t>(iy) * field.nx + static_cast<std::size_t>(ix)];
        height = std::max(height, centre[2] + std::sqrt(squared) - window.plate);
      }
    }
  });
  return field;
}

SurfaceTexture MeasureSurface(const HeightField& field, ReferencePlane reference) {
  SurfaceTexture texture;
  if (field.heights.empty()) return texture;
  const auto pixels = static_cast<double>(field.heights.size());
  for (const double height : field.heights) {
    texture.thickness += height / pixels;
    texture.maximum = std::max(texture.maximum, height);
  }
  // From the field's centre; on a full grid x and y are then orthogonal, and so are their fits.
  const auto x_of = [&](std::size_t ix) {
    return (static_cast<double>(ix) - (static_cast<double>(field.nx) - 1) / 2) * field.pixel_x;
  };
  const auto y_of = [&](std::size_t iy) {
    return (static_cast<double>(iy) - (static_cast<double>(field.ny) - 1) / 2) * field.pixel_y;
  };
  if (reference == ReferencePlane::least_squares) {
    double xx = 0;
    double yy = 0;
    double xh = 0;
    double yh = 0;
    for (std::size_t iy = 0; iy < field.ny; ++iy) {
      for (std::size_t ix = 0; ix < field.nx; ++ix) {
        xx += x_of(ix) * x_of(ix);
        yy += y_of(iy) * y_of(iy);
        xh += x_of(ix) * field.At(ix, iy);
        yh += y_of(iy) * field.At(ix, iy);
      }
    }
    texture.slope_x = xx > 0 ? xh / xx : 0;
    texture.slope_y = yy > 0 ? yh / yy : 0;
  }
  double squares = 0;
  for (std::size_t iy = 0; iy < field.ny; ++iy) {
    for (std::size_t ix = 0; ix < field.nx; ++ix) {
      const double deviation = field.At(ix, iy) - texture.thickness - texture.slope_x * x_of(ix) -
                               texture.slope_y * y_of(iy);
      texture.sa += std::abs(deviation) / pixels;
      squares += deviation * deviation;
    }
  }
  texture.sq = std::sqrt(squares / pixels);
  return texture;
}

}  // namespace powdercal

#include "experiments/layer_measures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.h"

namespace powdercal {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSqrt3 = std::numbers::sqrt3;

Sphere At(double x, double y, double radius = 1, double z = 0) {
  return {1, radius, {x, y, z == 0 ? radius : z}};
}

PlateWindow Square(double width) { return {.x1 = width, .y1 = width}; }

// A layer of touching spheres of radius 1 in a hexagonal order, and a window of whole cells of it.
Packing HexagonalLayer(int nx, int ny) {
  Packing packing;
  for (int i = -1; i <= nx; ++i) {
    for (int j = 0; j < ny; ++j) {
      packing.push_back(At(2 * i, 2 * kSqrt3 * j));
      packing.push_back(At(2 * i + 1, 2 * kSqrt3 * j + kSqrt3));
    }
  }
  return packing;
}

PlateWindow HexagonalWindow(int nx, int ny) {
  return {.x1 = 2.0 * nx, .y1 = 2 * kSqrt3 * ny, .period_y = 2 * kSqrt3 * ny};
}

TEST(DiameterQuantile, IsOfDiametersByNumber) {
  Packing packing;
  for (int i = 10; i >= 0; --i) packing.push_back(At(0, 0, 1 + i));
  EXPECT_DOUBLE_EQ(DiameterQuantile(packing, 0.1), 4);
  EXPECT_EQ(DiameterQuantile({}, 0.1), 0);
}

TEST(Coverage, OfSingleDiscs) {
  const Coverage whole = MeasureCoverage({At(5.1, 4.7)}, Square(10));
  EXPECT_TRUE(whole.converged);
  EXPECT_NEAR(whole.fraction, kPi / 100, 1e-3);
  EXPECT_LE(whole.pixel, 0.25);
  EXPECT_LT(whole.change, 1e-3);
  EXPECT_NEAR(MeasureCoverage({At(0, 10)}, Square(10)).fraction, kPi / 400, 1e-3) << "at a corner";
  EXPECT_NEAR(MeasureCoverage({At(0, 5.2)}, Square(10)).fraction, kPi / 200, 1e-3) << "at a side";
  EXPECT_NEAR(MeasureCoverage({At(5, 5, 20)}, Square(10)).fraction, 1, 0) << "covers the window";
}

TEST(Coverage, CountsOverlapsOnce) {
  const double distance = 0.8;  // of two unit discs
  const double lens =
      2 * std::acos(distance / 2) - distance / 2 * std::sqrt(4 - distance * distance);
  const Packing two = {At(2, 2), At(2.8, 2, 1, 1.6)};
  const CoverageOptions fine{.tolerance = 1e-5};
  EXPECT_NEAR(MeasureCoverage(two, Square(5), fine).fraction, (2 * kPi - lens) / 25, 5e-5);
}

TEST(Coverage, OfAHexagonalLayer) {
  // Its discs all meet the grid in the same few ways, so that errors add up: grids of 1/8 and 1/16
  // of a diameter agree by chance at 0.93.
  const Coverage coverage = MeasureCoverage(HexagonalLayer(4, 3), HexagonalWindow(4, 3));
  EXPECT_TRUE(coverage.converged);
  EXPECT_NEAR(coverage.fraction, kPi / (2 * kSqrt3), 1e-3);
}

TEST(Coverage, WrapsAlongThePeriodicAxisOnly) {
  PlateWindow window = Square(10);
  const Packing packing = {At(5, 10.5)};
  EXPECT_LT(MeasureCoverage(packing, window).fraction, 0.01);
  window.period_y = 10;
  EXPECT_NEAR(MeasureCoverage(packing, window).fraction, kPi / 100, 1e-3);
}

TEST(Coverage, RefinesUntilToleranceOrLimit) {
  const Packing packing = {At(5.1, 4.7), At(2.3, 8.1, 0.7)};
  const Coverage coarse = MeasureCoverage(packing, Square(10), {.tolerance = 1e-2});
  const Coverage fine = MeasureCoverage(packing, Square(10), {.tolerance = 1e-6});
  EXPECT_LT(fine.pixel, coarse.pixel);
  EXPECT_NEAR(fine.fraction, kPi * 1.49 / 100, 1e-5);
  const Coverage limited =
      MeasureCoverage(packing, Square(10), {.tolerance = 1e-12, .max_pixels = 10000});
  EXPECT_FALSE(limited.converged);
  EXPECT_NEAR(limited.fraction, kPi * 1.49 / 100, 1e-2);
}

TEST(Coverage, OfNothingIsZero) {
  const Coverage coverage = MeasureCoverage({}, Square(10));
  EXPECT_EQ(coverage.fraction, 0);
  EXPECT_TRUE(coverage.converged);
  EXPECT_EQ(MeasureCoverage({At(5, 5, 1, -1)}, Square(10)).fraction, 0) << "below the plate";
}

TEST(MassPerArea, CutsSpheresAtTheSides) {
  const double ball = 4 * kPi / 3;
  EXPECT_NEAR(MassPerArea({At(5, 5)}, Square(10), 3), 3 * ball / 100, 1e-13);
  EXPECT_NEAR(MassPerArea({At(0, 5)}, Square(10), 3), 3 * ball / 200, 1e-13);
  EXPECT_NEAR(MassPerArea({At(10, 10)}, Square(10), 3), 3 * ball / 400, 1e-13);
  EXPECT_NEAR(MassPerArea({At(5, 5, 1, 100)}, Square(10), 3), 3 * ball / 100, 1e-13)
      << "any height";
  EXPECT_EQ(MassPerArea({}, Square(10), 3), 0);
  EXPECT_NEAR(MassPerArea(HexagonalLayer(4, 3), HexagonalWindow(4, 3), 1), ball / (2 * kSqrt3),
              1e-12);
}

TEST(PackingDensity, OfAHexagonalLayer) {
  const Packing packing = HexagonalLayer(6, 4);
  const PlateWindow window = HexagonalWindow(6, 4);
  const double whole = 4 * kPi / 3 / (2 * kSqrt3 * 2);
  const PackingDensity density = MeasurePackingDensity(packing, window, 2, 2, 1);
  EXPECT_EQ(density.count, 6u * 6u);
  EXPECT_NEAR(density.cell_x, 2, 1e-12);
  EXPECT_NEAR(density.cell_y, 8 * kSqrt3 / 6, 1e-12);
  EXPECT_NEAR(density.mean, whole, 1e-12);
  EXPECT_GT(density.standard_deviation, 0);
  EXPECT_NEAR(MeasurePackingDensity(packing, window, 1, 2, 1).mean, whole, 1e-12) << "half the gap";
  EXPECT_NEAR(MeasurePackingDensity(packing, window, 4, 2, 1).mean, whole / 2, 1e-12);
  const PackingDensity one = MeasurePackingDensity(packing, window, 2, 2, 50);
  EXPECT_EQ(one.count, 1u);
  EXPECT_NEAR(one.mean, whole, 1e-12);
  EXPECT_EQ(one.standard_deviation, 0);
}

TEST(PackingDensity, HasTheDeviationOfItsCells) {
  // A sphere in one cell of four, another on the edge between two others.
  const Packing packing = {At(2.5, 2.5), At(5, 7.5)};
  const PackingDensity density = MeasurePackingDensity(packing, Square(10), 2, 1, 5);
  const double phi = 4 * kPi / 3 / 50;
  EXPECT_EQ(density.count, 4u);
  EXPECT_NEAR(density.mean, phi / 2, 1e-14);
  EXPECT_NEAR(density.standard_deviation, phi * std::sqrt((0.25 + 0.25) / 3), 1e-14);
}

TEST(PackingDensity, MeanDoesNotDependOnTheCells) {
  RandomStream random(1);
  Packing packing;
  for (int i = 0; i < 300; ++i) {
    packing.push_back(At(random.Uniform(-1, 11), random.Uniform(0, 10), random.Uniform(0.2, 1),
                         random.Uniform(0, 3)));
  }
  PlateWindow window = Square(10);
  window.plate = 0.3;
  window.period_y = 10;
  const double mean = MeasurePackingDensity(packing, window, 1.7, 1, 100).mean;
  for (const double cell : {0.4, 1.0, 3.3, 5.0}) {
    EXPECT_NEAR(MeasurePackingDensity(packing, window, 1.7, 1, cell).mean, mean, 1e-12);
  }
  EXPECT_EQ(MeasurePackingDensity({}, window, 1.7, 1, 2).mean, 0);
}

TEST(HeightField, OfASphere) {
  PlateWindow window = Square(4);
  window.plate = -1;
  const HeightField field = MeasureHeightField({At(2, 2, 1, 0.5)}, window, 0.01);
  ASSERT_EQ(field.nx, 400u);
  ASSERT_EQ(field.ny, 400u);
  EXPECT_EQ(field.At(0, 0), 0) << "bare";
  const double x = 0.005 + 0.01 * 230 - 2;
  const double y = 0.005 + 0.01 * 180 - 2;
  EXPECT_NEAR(field.At(230, 180), 1.5 + std::sqrt(1 - x * x - y * y), 1e-12);
  EXPECT_NEAR(MeasureSurface(field).maximum, 2.5, 1e-4);
}

// The upper surface of spheres of radius 1 on a plate is 1 + s high, s in [0, 1], on an area
// 2 pi s ds each; `area` is that of the plate per sphere.
struct ExactTexture {
  explicit ExactTexture(double area) : mean(5.0 / 3 * kPi / area) {
    sq = std::sqrt(17.0 / 6 * kPi / area - mean * mean);
    const double from = std::max(0.0, mean - 1);  // s of the mean height, where that is on a sphere
    const auto integral = [this](double s) { return s * s * s / 3 + (1 - mean) * s * s / 2; };
    sa = 4 * kPi / area * (integral(1) - integral(from));
  }
  double mean;
  double sa;
  double sq;
};

TEST(Surface, OfASphere) {
  const SurfaceTexture texture = MeasureSurface(MeasureHeightField({At(2, 2)}, Square(4), 0.004));
  const ExactTexture exact(16);
  EXPECT_NEAR(texture.thickness, exact.mean, 1e-3);
  EXPECT_NEAR(texture.maximum, 2, 1e-4);
  EXPECT_NEAR(texture.sa, exact.sa, 1e-3);
  EXPECT_NEAR(texture.sq, exact.sq, 1e-3);
}

TEST(Surface, OfAHexagonalLayer) {
  const SurfaceTexture texture =
      MeasureSurface(MeasureHeightField(HexagonalLayer(3, 2), HexagonalWindow(3, 2), 0.01));
  const ExactTexture exact(2 * kSqrt3);
  EXPECT_NEAR(texture.thickness, exact.mean, 1e-3);
  EXPECT_NEAR(texture.sa, exact.sa, 1e-3);
  EXPECT_NEAR(texture.sq, exact.sq, 1e-3);
}

TEST(Surface, LeastSquaresTakesOutATilt) {
  HeightField field{.nx = 50, .ny = 30, .pixel_x = 0.1, .pixel_y = 0.2};
  for (std::size_t iy = 0; iy < field.ny; ++iy) {
    for (std::size_t ix = 0; ix < field.nx; ++ix) {
      const double wave = (ix + iy) % 2 == 0 ? 0.05 : -0.05;
      field.heights.push_back(5 + 0.3 * 0.1 * static_cast<double>(ix) -
                              0.2 * 0.2 * static_cast<double>(iy) + wave);
    }
  }
  const SurfaceTexture fitted = MeasureSurface(field, ReferencePlane::least_squares);
  EXPECT_NEAR(fitted.slope_x, 0.3, 1e-3);
  EXPECT_NEAR(fitted.slope_y, -0.2, 1e-3);
  EXPECT_NEAR(fitted.sa, 0.05, 1e-4);
  EXPECT_NEAR(fitted.sq, 0.05, 1e-4);
  EXPECT_GT(MeasureSurface(field).sq, 0.3);
}

TEST(Surface, OfNothingIsFlat) {
  const SurfaceTexture bare = MeasureSurface(MeasureHeightField({}, Square(4), 0.1));
  EXPECT_EQ(bare.thickness, 0);
  EXPECT_EQ(bare.sa, 0);
  EXPECT_EQ(bare.sq, 0);
  EXPECT_EQ(MeasureSurface({}).sq, 0);
}

}  // namespace
}  // namespace powdercal

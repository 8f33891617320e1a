#include "experiments/heap_measures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "core/random.h"

namespace powdercal {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kLength = 100;
constexpr double kWidth = 16;
constexpr double kPeak = 30;

// Spheres of diameters 0.8 to 1.2 at random under a surface, two to a unit of volume.
Packing Fill(const std::function<double(double x, double y)>& surface, double length, double width,
             double peak, std::uint64_t seed) {
  RandomStream random(seed);
  Packing packing;
  const auto count = static_cast<std::int64_t>(2 * length * width * peak);
  for (std::int64_t id = 1; id <= count; ++id) {
    const double x = random.Uniform(0, length);
    const double y = random.Uniform(0, width);
    const double z = random.Uniform(0, peak);
    const double r = random.Uniform(0.4, 0.6);
    if (z + r <= surface(x, y)) packing.push_back({id, r, {x, y, z}});
  }
  return packing;
}

// A bed drawn down over an edge: flat up to x = 10, then a face at an angle.
Packing DrawnDown(double angle, std::uint64_t seed = 1) {
  const auto surface = [angle](double x, double) {
    return std::min(kPeak, kPeak - (x - 10) * std::tan(angle));
  };
  return Fill(surface, kLength, kWidth, kPeak, seed);
}

PlateWindow Window() { return {.x1 = kLength, .y1 = kWidth, .period_y = kWidth}; }

class HeapAngle : public testing::TestWithParam<double> {};

TEST_P(HeapAngle, OfADrawnDownFace) {
  const double angle = GetParam() * kDegree;
  const FlankFit fit = FitFlank(MeasureProfile(DrawnDown(angle), Window(), {.bin_width = 2}));
  ASSERT_EQ(fit.state, FlankFit::State::fitted);
  EXPECT_NEAR(fit.angle / kDegree, GetParam(), 0.5);
  EXPECT_LT(fit.angle_error, 0.5 * kDegree);
  EXPECT_GT(fit.r_squared, 0.99);
  EXPECT_NEAR(fit.upper, 0.8 * kPeak, 1);
  EXPECT_GT(fit.start, 10);
  EXPECT_LT(fit.end, 12 + kPeak / std::tan(angle));
}

TEST_P(HeapAngle, OfTheMedianColumn) {
  const double angle = GetParam() * kDegree;
  const FlankFit fit = FitFlank(
      MeasureProfile(DrawnDown(angle), Window(), {.bin_width = 2, .column_quantile = 0.5}));
  ASSERT_TRUE(fit.IsAngleOfRepose());
  EXPECT_NEAR(fit.angle / kDegree, GetParam(), 0.5);
}

TEST_P(HeapAngle, OfARisingFlank) {
  const double angle = GetParam() * kDegree;
  Packing packing = DrawnDown(angle);
  const FlankFit falling = FitFlank(MeasureProfile(packing, Window(), {.bin_width = 2}));
  for (Sphere& sphere : packing) sphere.position[0] = kLength - sphere.position[0];
  const FlankFit rising =
      FitFlank(MeasureProfile(packing, Window(), {.bin_width = 2}), {.flank = Flank::rising});
  EXPECT_NEAR(rising.angle, falling.angle, 1e-9);
  EXPECT_NEAR(rising.start, kLength - falling.end, 1e-9);
  EXPECT_NEAR(rising.end, kLength - falling.start, 1e-9);
}

TEST_P(HeapAngle, OfACone) {
  const double angle = GetParam() * kDegree;
  const double height = 22;
  const double half = 61;
  const auto surface = [&](double x, double y) {
    return height - std::hypot(x - half, y - half) * std::tan(angle);
  };
  Packing packing = Fill(surface, 2 * half, 2 * half, height, 2);
  const FlankFit fit =
      FitFlank(MeasureRadialProfile(packing, {half, half, half, 0}, {.bin_width = 2}));
  ASSERT_EQ(fit.state, FlankFit::State::fitted);
  EXPECT_NEAR(fit.angle / kDegree, GetParam(), 0.5);
}

INSTANTIATE_TEST_SUITE_P(Degrees, HeapAngle, testing::Values(20, 25, 30, 35, 40, 45));

TEST(Profile, HasHeightsAboveThePlate) {
  PlateWindow window{.x0 = 1, .x1 = 5, .y1 = 2, .plate = 10};
  // Two columns in each of the bins [1, 3) and [3, 5).
  window.y1 = 4;
  const Packing packing = {{1, 1, {1.5, 1, 11}}, {2, 1, {2, 3, 13}}, {3, 1, {2, 3, 12}},
                           {4, 1, {4, 1, 9}},    {5, 1, {6, 1, 11}}, {6, 1, {4, 5, 11}}};
  const HeightProfile mean = MeasureProfile(packing, window, {.bin_width = 2});
  ASSERT_EQ(mean.heights.size(), 2u);
  EXPECT_EQ(mean.Position(0), 2);
  EXPECT_EQ(mean.Position(1), 4);
  EXPECT_EQ(mean.heights[0], (2 + 4) / 2.0);
  EXPECT_EQ(mean.heights[1], 0) << "below the plate, beyond the window";
  const HeightProfile highest =
      MeasureProfile(packing, window, {.bin_width = 2, .column_quantile = 1});
  EXPECT_EQ(highest.heights[0], 4);
  window.period_y = 4;
  EXPECT_EQ(MeasureProfile(packing, window, {.bin_width = 2}).heights[1], 1) << "an image";
}

TEST(Profile, DoesNotSeeWhichPeriodASphereIsIn) {
  Packing packing = DrawnDown(30 * kDegree);
  const HeightProfile before = MeasureProfile(packing, Window(), {.bin_width = 2});
  for (Sphere& sphere : packing) sphere.position[1] += kWidth * static_cast<double>(sphere.id % 3);
  const HeightProfile after = MeasureProfile(packing, Window(), {.bin_width = 2});
  for (std::size_t i = 0; i < before.heights.size(); ++i) {
    EXPECT_NEAR(after.heights[i], before.heights[i], 0.5);
  }
}

TEST(FlankFit, IsOrdinaryLeastSquares) {
  const HeightProfile profile{
      .start = -3, .bin_width = 1, .heights = {10, 9.9, 8, 7.2, 5.8, 5.2, 3.8, 0}};
  const FlankFit fit = FitFlank(profile, {.heights = {{2, 9}}});
  ASSERT_EQ(fit.state, FlankFit::State::fitted);
  EXPECT_EQ(fit.bins, 5u);
  EXPECT_EQ(fit.start, -1);
  EXPECT_EQ(fit.end, 4);
  EXPECT_NEAR(fit.angle, std::atan(1.04), 1e-14);
  EXPECT_NEAR(fit.angle_error, std::sqrt(0.0048) / (1 + 1.04 * 1.04), 1e-13);
  EXPECT_NEAR(fit.r_squared, 1 - 0.144 / 10.96, 1e-13);
}

TEST(FlankFit, CallsAVerticalFaceACliff) {
  const auto block = [](double x, double) { return x < 50 ? kPeak : 0; };
  const Packing packing = Fill(block, kLength, kWidth, kPeak, 3);
  const FlankFit fit = FitFlank(MeasureProfile(packing, Window(), {.bin_width = 2}));
  EXPECT_EQ(fit.state, FlankFit::State::cliff);
  EXPECT_FALSE(fit.IsAngleOfRepose());
  EXPECT_NEAR(fit.start, 50, 2);
  EXPECT_EQ(FitFlank(MeasureProfile(DrawnDown(82 * kDegree), Window(), {.bin_width = 0.5})).state,
            FlankFit::State::cliff)
      << "of several bins";
}

TEST(FlankFit, NeedsBins) {
  const HeightProfile profile{.bin_width = 2, .heights = {3, 3, 2, 1, 0, 0}};
  const FlankFit fit = FitFlank(profile);
  EXPECT_EQ(fit.state, FlankFit::State::too_few_bins);
  EXPECT_EQ(fit.bins, 2u);
  EXPECT_EQ(fit.angle, 0);
}

TEST(FlankFit, SaysWhereThereIsNoFlank) {
  using State = FlankFit::State;
  const auto state = [](const HeightProfile& profile, const FlankOptions& options = {}) {
    const FlankFit fit = FitFlank(profile, options);
    EXPECT_EQ(fit.angle, 0);
    EXPECT_EQ(fit.angle_error, 0);
    EXPECT_EQ(fit.r_squared, 0);
    return fit.state;
  };
  EXPECT_EQ(state({}), State::no_flank);
  EXPECT_EQ(state(MeasureProfile({}, Window(), {.bin_width = 2})), State::no_flank);
  EXPECT_EQ(state(MeasureRadialProfile({}, {0, 0, 10, 0}, {.bin_width = 2})), State::no_flank);
  EXPECT_EQ(state({.bin_width = 1, .heights = {2, 2, 2, 2}}), State::no_flank) << "flat";
  EXPECT_EQ(state({.bin_width = 1, .heights = {1, 2, 3, 4, 5}}), State::no_flank) << "other side";
  const HeightProfile uneven{.bin_width = 1, .heights = {5.1, 5, 4.9, 4.8, 4.7, 4.6, 4.5, 4.4}};
  EXPECT_EQ(state(uneven, {.min_drop = 1}), State::no_flank);
  EXPECT_EQ(state(uneven, {.heights = {{4.6, 6}}}), State::no_flank) << "never so high";
  EXPECT_EQ(state(uneven, {.heights = {{1, 5}}}), State::no_flank) << "never so low";
}

TEST(RetainedMass, CountsWhatIsLeftInTheRegion) {
  const Packing poured = {{1, 1, {1, 1, 1}}, {2, 2, {3, 1, 2}}, {3, 1, {9, 1, 1}}};
  const Packing left = {poured[1], poured[2]};
  EXPECT_NEAR(RetainedMassFraction(left, poured, {{0, 0, 0}, {5, 2, 9}}), 0.8, 1e-15);
  EXPECT_NEAR(RetainedMassFraction(left, poured, {{0, 0, 0}, {10, 2, 9}}), 0.9, 1e-15);
  EXPECT_EQ(RetainedMassFraction(left, poured, {{20, 0, 0}, {30, 2, 9}}), 0);
  EXPECT_EQ(RetainedMassFraction({}, {}, {{0, 0, 0}, {5, 2, 9}}), 0);
}

TEST(CentralRegion, KeepsAwayFromWallsAndSurface) {
  const BoxRegion bed{{0, 0, 1}, {20, 10, 11}};
  const std::optional<BoxRegion> region = CentralRegion(bed, 3, 0);
  ASSERT_TRUE(region);
  EXPECT_EQ(region->lower, (Vector3{3, 0, 3}));
  EXPECT_EQ(region->upper, (Vector3{17, 10, 9}));
  EXPECT_FALSE(CentralRegion(bed, 10, 0));
  EXPECT_FALSE(CentralRegion({{0, 0, 1}, {20, 10, 1}}, 3, 0)) << "no bed";
}

// Overlapping spheres at random in a periodic box.
Packing Cloud(const Domain& domain, int count) {
  RandomStream random(4);
  Packing packing;
  for (int id = 1; id <= count; ++id) {
    Sphere sphere{id, random.Uniform(0.3, 0.7)};
    for (int axis = 0; axis < 3; ++axis) {
      sphere.position[axis] = random.Uniform(domain.lower[axis], domain.upper[axis]);
    }
    packing.push_back(sphere);
  }
  return packing;
}

TEST(RegionVoidRatio, OfTheWholeWidthIsThatOfTheSlab) {
  Domain domain;
  domain.upper = {6, 5, 10};
  const Packing packing = Cloud(domain, 150);
  const Contacts contacts = FindContacts(packing, domain, {});
  const VoidRatio slab = MeasureVoidRatio(packing, contacts, domain, 2, 8);
  const VoidRatio region = RegionVoidRatio(packing, contacts, domain, {{0, 0, 2}, {6, 5, 8}});
  EXPECT_NEAR(region.sphere_volume, slab.sphere_volume, 1e-10);
  EXPECT_NEAR(region.overlap_volume, slab.overlap_volume, 1e-10);
  EXPECT_NEAR(region.value, slab.value, 1e-10);
  EXPECT_NEAR(region.overlap_corrected, slab.overlap_corrected, 1e-10);
  const VoidRatio shifted = RegionVoidRatio(packing, contacts, domain, {{9, -3, 2}, {15, 2, 8}});
  EXPECT_NEAR(shifted.value, slab.value, 1e-10) << "one period is as good as another";
}

TEST(RegionVoidRatio, PartsAddUp) {
  Domain domain;
  domain.upper = {6, 5, 10};
  domain.boundaries[0] = Boundary::open;
  const Packing packing = Cloud(domain, 150);
  const Contacts contacts = FindContacts(packing, domain, {});
  const VoidRatio whole = RegionVoidRatio(packing, contacts, domain, {{1, 0, 2}, {5, 5, 8}});
  const VoidRatio left = RegionVoidRatio(packing, contacts, domain, {{1, 0, 2}, {2.7, 5, 8}});
  const VoidRatio right = RegionVoidRatio(packing, contacts, domain, {{2.7, 0, 2}, {5, 5, 8}});
  EXPECT_NEAR(left.sphere_volume + right.sphere_volume, whole.sphere_volume, 1e-10);
  EXPECT_NEAR(left.overlap_volume + right.overlap_volume, whole.overlap_volume, 1e-10);
  EXPECT_EQ(RegionVoidRatio({}, {}, domain, {{1, 0, 2}, {5, 5, 8}}).value,
            std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace powdercal

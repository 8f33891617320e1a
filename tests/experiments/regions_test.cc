#include "experiments/regions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "core/random.h"
#include "experiments/packing_measures.h"

namespace powdercal {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kBall = 4 * kPi / 3;
constexpr double kTolerance = 1e-13;

double UnitBallIn(const Vector3& lower, const Vector3& upper) {
  return SphereBoxVolume({0, 0, 0}, 1, {lower, upper});
}

// Common area of a disc of radius rho about the origin and [0, a] × [0, b], odd in a and b.
double DiscQuarter(double rho, double a, double b) {
  const double sign = (a < 0) == (b < 0) ? 1 : -1;
  a = std::min(std::abs(a), rho);
  b = std::min(std::abs(b), rho);
  if (a * a + b * b <= rho * rho) return sign * a * b;
  const auto half_segment = [rho](double h) {
    return (rho * rho * std::acos(h / rho) - h * std::sqrt(rho * rho - h * h)) / 2;
  };
  return sign * (kPi * rho * rho / 4 - half_segment(a) - half_segment(b));
}

// The volume as an integral of areas of slices over z, piece by piece between the heights where a
// slice begins to meet another edge or corner; the substitution takes the square roots out.
double VolumeBySlices(const Vector3& lower, const Vector3& upper) {
  std::vector<double> cuts;
  const auto add = [&](double squared) {
    if (squared < 0) return;
    cuts.push_back(std::sqrt(squared));
    cuts.push_back(-std::sqrt(squared));
  };
  add(1);
  for (const double x : {lower[0], upper[0]}) {
    add(1 - x * x);
    for (const double y : {lower[1], upper[1]}) add(1 - x * x - y * y);
  }
  for (const double y : {lower[1], upper[1]}) add(1 - y * y);
  for (double& z : cuts) {
    z = std::clamp(z, std::clamp(lower[2], -1.0, 1.0), std::clamp(upper[2], -1.0, 1.0));
  }
  std::sort(cuts.begin(), cuts.end());
  const auto area = [&](double z) {
    const double rho = std::sqrt(std::max(0.0, 1 - z * z));
    if (rho == 0) return 0.0;
    return DiscQuarter(rho, upper[0], upper[1]) - DiscQuarter(rho, lower[0], upper[1]) -
           DiscQuarter(rho, upper[0], lower[1]) + DiscQuarter(rho, lower[0], lower[1]);
  };
  double volume = 0;
  constexpr int kIntervals = 400;  // Simpson's rule
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    const double middle = (cuts[i] + cuts[i - 1]) / 2;
    const double half = (cuts[i] - cuts[i - 1]) / 2;
    for (int k = 0; k <= kIntervals; ++k) {
      const double t = -1 + 2.0 * k / kIntervals;
      const double weight = (k == 0 || k == kIntervals ? 1 : k % 2 == 1 ? 4 : 2) * 2.0 / kIntervals;
      volume +=
          weight / 3 * half * 1.5 * (1 - t * t) * area(middle + half * (3 * t - t * t * t) / 2);
    }
  }
  return volume;
}

TEST(SphereBoxVolume, HasItsClosedForms) {
  EXPECT_EQ(UnitBallIn({-1, -1, -1}, {1, 1, 1}), kBall);
  EXPECT_EQ(UnitBallIn({-kInfinity, -2, -1}, {kInfinity, 2, kInfinity}), kBall);
  EXPECT_EQ(UnitBallIn({1, -1, -1}, {2, 1, 1}), 0);
  EXPECT_EQ(UnitBallIn({0.8, 0.8, 0.8}, {2, 2, 2}), 0) << "cuts the cube about the ball alone";
  EXPECT_NEAR(UnitBallIn({0, -1, -1}, {1, 1, 1}), kBall / 2, kTolerance);
  EXPECT_NEAR(UnitBallIn({0, 0, -1}, {1, 1, 1}), kBall / 4, kTolerance);
  EXPECT_NEAR(UnitBallIn({0, 0, 0}, {1, 1, 1}), kBall / 8, kTolerance);
  EXPECT_NEAR(UnitBallIn({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}), 1, kTolerance) << "within the ball";
  EXPECT_NEAR(UnitBallIn({0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}), 0.027, kTolerance);
  const double h = 0.75;  // faces cut the ball, edges do not
  EXPECT_NEAR(UnitBallIn({-h, -h, -h}, {h, h, h}),
              kBall - 6 * kPi / 3 * (1 - h) * (1 - h) * (2 + h), kTolerance);
}

TEST(SphereBoxVolume, AgreesWithSlabs) {
  for (const double z : {-1.2, -0.9, -0.3, 0.0, 0.2, 0.99}) {
    EXPECT_NEAR(UnitBallIn({-2, -2, z}, {2, 2, z + 0.4}),
                SphereSlabVolume({1, 1, {0, 0, 0}}, z, z + 0.4), kTolerance);
  }
}

TEST(SphereBoxVolume, AgreesWithIntegratedSlices) {
  RandomStream random(5);
  for (int i = 0; i < 200; ++i) {
    Vector3 lower;
    Vector3 upper;
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = random.Uniform(-1.1, 0.9);
      upper[axis] = lower[axis] + random.Uniform(0, 1.2);
    }
    EXPECT_NEAR(UnitBallIn(lower, upper), VolumeBySlices(lower, upper), 1e-9);
  }
}

TEST(SphereBoxVolume, PartsAddUp) {
  RandomStream random(6);
  for (int i = 0; i < 100; ++i) {
    const Vector3 centre = {random.Uniform(-3, 3), random.Uniform(-3, 3), random.Uniform(-3, 3)};
    const double radius = random.Uniform(0.1, 2);
    const BoxRegion whole{{-1, -2, -3}, {2, 1, 2}};
    Vector3 cut;
    for (int axis = 0; axis < 3; ++axis) {
      // Through the centre now and then, where the formulas change.
      cut[axis] = i % 4 == axis ? std::clamp(centre[axis], whole.lower[axis], whole.upper[axis])
                                : random.Uniform(whole.lower[axis], whole.upper[axis]);
    }
    double sum = 0;
    for (int part = 0; part < 8; ++part) {
      BoxRegion box = whole;
      for (int axis = 0; axis < 3; ++axis) {
        ((part >> axis) & 1 ? box.lower : box.upper)[axis] = cut[axis];
      }
      sum += SphereBoxVolume(centre, radius, box);
    }
    EXPECT_NEAR(sum, SphereBoxVolume(centre, radius, whole), 1e-13 * 8);
  }
}

TEST(SphereBoxVolume, ScalesWithTheSphere) {
  const BoxRegion box{{1e-6, -2e-6, -30e-6}, {30e-6, 12e-6, 7e-6}};
  const double volume = SphereBoxVolume({2e-6, 3e-6, 1e-6}, 14.5e-6, box);
  const double scale = 1 / 14.5;
  EXPECT_NEAR(volume / (14.5e-6 * 14.5e-6 * 14.5e-6),
              UnitBallIn({-1 * scale, -5 * scale, -31 * scale}, {28 * scale, 9 * scale, 6 * scale}),
              kTolerance);
}

TEST(BoxRegion, IsHalfOpen) {
  const BoxRegion box{{0, 0, 0}, {1, 1, 2}};
  EXPECT_EQ(box.Volume(), 2);
  EXPECT_TRUE(box.Contains({0, 0.5, 1.9}));
  EXPECT_FALSE(box.Contains({1, 0.5, 1}));
  EXPECT_FALSE(box.Contains({0.5, 0.5, 2}));
}

TEST(ForEachOnPlate, FindsWhatReachesIntoTheWindow) {
  const auto count = [](const Vector3& centre, double period_y) {
    int n = 0;
    const PlateWindow window{.x0 = 0, .x1 = 4, .y0 = 0, .y1 = 4, .plate = 1, .period_y = period_y};
    ForEachOnPlate({{1, 0.5, centre}}, window, [&n](const Vector3&, double) { ++n; });
    return n;
  };
  EXPECT_EQ(count({2, 2, 1.5}, 0), 1);
  EXPECT_EQ(count({2, 2, 0.5}, 0), 0) << "below the plate";
  EXPECT_EQ(count({-0.4, 2, 1.5}, 0), 1);
  EXPECT_EQ(count({-0.6, 2, 1.5}, 0), 0);
  EXPECT_EQ(count({2, 4.6, 1.5}, 0), 0);
  EXPECT_EQ(count({2, 4.6, 1.5}, 4), 1) << "another period's image";
  EXPECT_EQ(count({2, -39.8, 1.5}, 4), 2) << "images on both sides of the seam";
  EXPECT_EQ(count({2, 4.6, 1.5}, 6), 0) << "in the part of the period beside the window";
}

}  // namespace
}  // namespace powdercal

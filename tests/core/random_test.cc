#include "core/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace powdercal {
namespace {

// From an independent implementation; the first one is also the known answer of the reference
// implementation of xoshiro256** with the state that SplitMix64 gives for the seed 0.
TEST(RandomStream, GoldenBits) {
  RandomStream zero(0);
  EXPECT_EQ(zero.Bits(), 0x99ec5f36cb75f2b4U);
  EXPECT_EQ(zero.Bits(), 0xbf6e1f784956452aU);
  EXPECT_EQ(zero.Bits(), 0x1a5f849d4933e6e0U);
  EXPECT_EQ(zero.Bits(), 0x6aa594f1262d2d2cU);
  RandomStream other(42);
  EXPECT_EQ(other.Bits(), 0x15780b2e0c2ec716U);
  EXPECT_EQ(other.Bits(), 0x6104d9866d113a7eU);
}

TEST(RandomStream, GoldenUniforms) {
  RandomStream random(42);
  EXPECT_EQ(random.Uniform(), 0.08386297105988216);
  EXPECT_EQ(random.Uniform(), 0.3789802506626686);
  EXPECT_EQ(random.Uniform(), 0.6800434110281394);
}

// Exact, not nearly: a packing is drawn from these, and its hash is a cache key.
TEST(RandomStream, GoldenNormals) {
  RandomStream random(42);
  EXPECT_EQ(random.Normal(), -1.3795477253060319);
  EXPECT_EQ(random.Normal(), -0.30816011350378950);
  EXPECT_EQ(random.Normal(), 0.46782019433652506);
  EXPECT_EQ(random.Normal(), 1.4373657007633576);
}

TEST(RandomStream, GoldenSplits) {
  const RandomStream random(42);
  EXPECT_EQ(random.Split("packing").seed(), 0xb328bff323ff8d52U);
  EXPECT_EQ(random.Split(7).seed(), 0x540da6a7cc183f06U);
}

TEST(RandomStream, SplitsDoNotDependOnWhatWasDrawn) {
  RandomStream random(5);
  const std::uint64_t before = random.Split("noise").Bits();
  for (int i = 0; i < 100; ++i) random.Bits();
  EXPECT_EQ(random.Split("noise").Bits(), before);
}

TEST(RandomStream, SplitsDifferFromEachOtherAndFromTheParent) {
  const RandomStream random(5);
  std::vector<std::uint64_t> first = {RandomStream(5).Bits(),
                                      random.Split("").Bits(),
                                      random.Split("a").Bits(),
                                      random.Split("b").Bits(),
                                      random.Split("a").Split("b").Bits(),
                                      random.Split("b").Split("a").Bits()};
  for (std::uint64_t i = 0; i < 100; ++i) first.push_back(random.Split(i).Bits());
  std::sort(first.begin(), first.end());
  EXPECT_EQ(std::adjacent_find(first.begin(), first.end()), first.end());
}

TEST(RandomStream, NeighbouringStreamsAreUncorrelated) {
  const RandomStream root(11);
  constexpr int kCount = 20000;
  double product = 0;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    product += root.Split(i).Normal() * root.Split(i + 1).Normal();
  }
  EXPECT_LT(std::abs(product / kCount), 4 / std::sqrt(kCount));
}

TEST(RandomStream, UniformMoments) {
  RandomStream random(1);
  constexpr int kCount = 100000;
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < kCount; ++i) {
    const double u = random.Uniform();
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    sum += u;
    squares += u * u;
  }
  // Four standard errors: sd of u is 1/sqrt(12), of u² sqrt(4/45).
  EXPECT_NEAR(sum / kCount, 0.5, 4 * std::sqrt(1.0 / 12 / kCount));
  EXPECT_NEAR(squares / kCount, 1.0 / 3, 4 * std::sqrt(4.0 / 45 / kCount));
}

TEST(RandomStream, UniformStaysBelowTheUpperEnd) {
  RandomStream random(2);
  const double lower = 1;
  const double upper = std::nextafter(1.0, 2.0);  // rounding reaches the end half of the time
  for (int i = 0; i < 100; ++i) ASSERT_EQ(random.Uniform(lower, upper), lower);
  for (int i = 0; i < 1000; ++i) {
    const double value = random.Uniform(-3, 5);
    ASSERT_GE(value, -3);
    ASSERT_LT(value, 5);
  }
}

TEST(RandomStream, NormalMoments) {
  RandomStream random(3);
  constexpr int kCount = 100000;
  double sum = 0;
  double squares = 0;
  double fourths = 0;
  for (int i = 0; i < kCount; ++i) {
    const double z = random.Normal();
    sum += z;
    squares += z * z;
    fourths += z * z * z * z;
  }
  EXPECT_NEAR(sum / kCount, 0, 4 / std::sqrt(kCount));
  EXPECT_NEAR(squares / kCount, 1, 4 * std::sqrt(2.0 / kCount));
  EXPECT_NEAR(fourths / kCount, 3, 4 * std::sqrt(96.0 / kCount));
}

TEST(RandomStream, BelowIsUniform) {
  RandomStream random(4);
  constexpr int kCount = 60000;
  std::vector<int> counts(6);
  for (int i = 0; i < kCount; ++i) ++counts.at(random.Below(6));
  double chi2 = 0;
  for (const int count : counts) chi2 += std::pow(count - 10000.0, 2) / 10000;
  EXPECT_LT(chi2, 20.5);  // 99.9 % of chi² with 5 degrees of freedom
  EXPECT_EQ(random.Below(1), 0U);
}

TEST(RandomStream, BelowHasNoBiasForLargeCounts) {
  // With bits modulo 3·2^62, a third of the numbers would come up twice as often as the others.
  RandomStream random(4);
  constexpr std::uint64_t kThird = std::uint64_t{1} << 62;
  int low = 0;
  for (int i = 0; i < 30000; ++i) low += random.Below(3 * kThird) < kThird ? 1 : 0;
  EXPECT_NEAR(low, 10000, 4 * std::sqrt(30000 * 2.0 / 9));
}

TEST(RandomStream, ShuffleKeepsTheItemsAndReachesEveryOrder) {
  RandomStream random(6);
  std::vector<int> seen(6);
  for (int i = 0; i < 6000; ++i) {
    std::vector<int> items = {0, 1, 2};
    random.Shuffle(std::span(items));
    ++seen.at(static_cast<std::size_t>(items[0] * 2 + (items[1] > items[2] ? 1 : 0)));
    std::sort(items.begin(), items.end());
    ASSERT_EQ(items, (std::vector<int>{0, 1, 2}));
  }
  for (const int count : seen) EXPECT_NEAR(count, 1000, 4 * std::sqrt(1000 * 5.0 / 6));
}

TEST(PortableLog, IsAccurate) {
  RandomStream random(7);
  std::vector<double> values = {1.0,
                                2.0,
                                0.5,
                                5e-324,
                                1e-308,
                                1.7976931348623157e308,
                                0.70710678118654752,
                                0.7071067811865476,
                                1 + 0x1p-52,
                                1 - 0x1p-53};
  for (int i = 0; i < 20000; ++i) {
    values.push_back(random.Uniform(0.5, 2));
    values.push_back(
        std::ldexp(random.Uniform(0.5, 1), static_cast<int>(random.Below(2000)) - 1000));
  }
  for (const double x : values) {
    const long double exact = std::log(static_cast<long double>(x));
    ASSERT_LE(std::abs(PortableLog(x) - exact), 4e-16L * std::abs(exact)) << x;
  }
}

// To 20 digits by mpmath.
TEST(NormalQuantile, KnownValues) {
  const std::pair<double, double> known[] = {
      {0.5, 0},
      {0.6, 0.25334710313579974132},
      {0.075, -1.4395314709384559349},
      {0.9, 1.2815515655446005935},
      {0.975, 1.9599639845400538556},
      {0.001, -3.0902323061678135354},
      {1e-10, -6.3613409024040561991},
      {1e-15, -7.9413453261709967713},
      {0x1p-53, -8.2095361516013868556},
      {1 - 0x1p-53, 8.2095361516013868556},
      {1e-300, -37.047096299361199237},
  };
  for (const auto& [p, quantile] : known) {
    EXPECT_NEAR(NormalQuantile(p), quantile, 6e-16 * std::abs(quantile)) << p;
  }
}

TEST(NormalQuantile, IsMonotonicAcrossItsBranches) {
  for (const double joint : {0.075, 0.925, std::exp(-25.0)}) {  // |q| = 0.425, r = 5
    const double below = std::nextafter(joint, 0.0);
    EXPECT_LT(NormalQuantile(joint * (1 - 1e-12)), NormalQuantile(joint * (1 + 1e-12)));
    EXPECT_NEAR(NormalQuantile(below), NormalQuantile(joint), 1e-14);
  }
}

}  // namespace
}  // namespace powdercal

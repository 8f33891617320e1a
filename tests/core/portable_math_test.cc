#include "core/portable_math.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/random.h"

namespace powdercal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(PortableExp, IsAccurate) {
  RandomStream random(1);
  for (int i = 0; i < 20000; ++i) {
    const double x = i % 2 == 0 ? random.Uniform(-2, 2) : random.Uniform(-708, 709);
    const long double exact = std::exp(static_cast<long double>(x));
    ASSERT_LE(std::abs(PortableExp(x) - exact), 4e-16L * exact) << x;
  }
}

TEST(PortableExp, Ends) {
  EXPECT_EQ(PortableExp(0), 1);
  EXPECT_EQ(PortableExp(1000), kInfinity);
  EXPECT_EQ(PortableExp(kInfinity), kInfinity);
  EXPECT_EQ(PortableExp(-1000), 0);
  EXPECT_EQ(PortableExp(-kInfinity), 0);
  EXPECT_GT(PortableExp(-745), 0);  // a subnormal number
  EXPECT_TRUE(std::isnan(PortableExp(std::nan(""))));
}

TEST(PortableNormalDensity, IsAccurate) {
  for (double z = -8; z <= 8; z += 0.37) {
    const long double exact = std::exp(-0.5L * z * z) / std::sqrt(2 * std::acos(-1.0L));
    EXPECT_LE(std::abs(PortableNormalDensity(z) - exact), (1 + z * z) * 4e-16L * exact) << z;
  }
}

TEST(PortableNormalCdf, IsAccurate) {
  for (double z = -8; z <= 8; z += 0.01) {
    const long double exact = 0.5L * std::erfc(-z / std::sqrt(2.0L));
    ASSERT_LE(std::abs(PortableNormalCdf(z) - exact), 2e-14L * exact) << z;
  }
}

// To 20 digits by mpmath.
TEST(PortableNormalCdf, KnownValues) {
  const std::pair<double, double> known[] = {
      {-8, 6.2209605742717841235e-16}, {-3, 0.0013498980316300945267},
      {-1, 0.15865525393145705141},    {0, 0.5},
      {0.5, 0.69146246127401310364},   {2, 0.9772498680518207928},
      {6, 0.99999999901341235496},
  };
  for (const auto& [z, probability] : known) {
    EXPECT_NEAR(PortableNormalCdf(z), probability, 2e-14 * probability) << z;
  }
  EXPECT_EQ(PortableNormalCdf(-kInfinity), 0);
  EXPECT_EQ(PortableNormalCdf(kInfinity), 1);
  EXPECT_TRUE(std::isnan(PortableNormalCdf(std::nan(""))));
}

TEST(PortableNormalCdf, InvertsTheQuantile) {
  for (double p = 0.001; p < 1; p += 0.0173) {
    EXPECT_NEAR(PortableNormalCdf(NormalQuantile(p)), p, 1e-14);
  }
}

}  // namespace
}  // namespace powdercal

#include "core/archive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace powdercal {
namespace {

TEST(Range, BoundsAreClosedUnlessOpen) {
  EXPECT_TRUE(kUnitInterval.Contains(0));
  EXPECT_TRUE(kUnitInterval.Contains(1));
  EXPECT_FALSE(kUnitInterval.Contains(std::nextafter(1.0, 2.0)));
  EXPECT_FALSE(kPositive.Contains(0));
  EXPECT_TRUE(kPositive.Contains(5e-324));
  EXPECT_TRUE(kNonNegative.Contains(0));
  const Range below_one{.upper = 1, .upper_open = true};
  EXPECT_FALSE(below_one.Contains(1));
  EXPECT_TRUE(below_one.Contains(-1e300));
}

TEST(Range, NeverContainsNan) {
  EXPECT_FALSE(Range{}.Contains(std::nan("")));
  EXPECT_TRUE(Range{}.Contains(std::numeric_limits<double>::infinity()));
}

TEST(Archive, AnIntegerMustFitIntoTheMember) {
  int count = 0;
  const auto visit = [&](Archive& archive) { archive.Integer("count", count, {.lower = -5e9}); };
  ReadYaml("count: -2147483648", "f", visit);
  EXPECT_EQ(count, std::numeric_limits<int>::min());
  EXPECT_THROW(ReadYaml("count: -2147483649", "f", visit), InputError);
  EXPECT_THROW(ReadYaml("count: 2147483648", "f", visit), InputError);
  EXPECT_EQ(count, std::numeric_limits<int>::min());
}

enum class Spacing { linear, log };
const std::vector<std::string> kSpacings = {"linear", "log"};

TEST(Archive, EnumerationsAreReadAndWrittenByName) {
  Spacing spacing = Spacing::linear;
  const auto visit = [&](Archive& archive) {
    archive.Enumeration("spacing", spacing, "spacing", kSpacings);
  };
  ReadYaml("spacing: log", "f", visit);
  EXPECT_EQ(spacing, Spacing::log);
  EXPECT_EQ(WriteYaml(visit), "spacing: log\n");
  EXPECT_THROW(ReadYaml("spacing: loog", "f", visit), InputError);
  EXPECT_EQ(spacing, Spacing::log);
}

}  // namespace
}  // namespace powdercal

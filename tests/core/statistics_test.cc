#include "core/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace powdercal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(QuantileTest, IsLinearBetweenOrderStatistics) {
  EXPECT_EQ(Quantile({3, 1, 2}, 0), 1);
  EXPECT_EQ(Quantile({3, 1, 2}, 1), 3);
  EXPECT_EQ(Quantile({3, 1, 2}, 0.75), 2.5);
  EXPECT_EQ(Quantile({7}, 0.3), 7);
  // R: quantile(c(1, 2, 4, 8), 0.25) is 1.75.
  EXPECT_EQ(Quantile({8, 1, 4, 2}, 0.25), 1.75);
  EXPECT_TRUE(std::isnan(Quantile({}, 0.5)));
}

TEST(QuantileTest, IsInfiniteWhereAnInfiniteValueIsInvolved) {
  EXPECT_EQ(Quantile({3, kInfinity}, 0), 3);
  EXPECT_EQ(Quantile({3, kInfinity}, 0.5), kInfinity);
  EXPECT_EQ(Quantile({3, 5, kInfinity}, 0.5), 5);
  EXPECT_EQ(Quantile({kInfinity, kInfinity}, 0.5), kInfinity);
}

TEST(MedianTest, OfAnEvenNumberTakesTheMiddleOrTheUpperOne) {
  EXPECT_EQ(Median({4, 1, 2, 8}), 3);
  EXPECT_EQ(UpperMedian({4, 1, 2, 8}), 4);
  EXPECT_EQ(Median({4, 1, 2}), 2);
  EXPECT_EQ(UpperMedian({4, 1, 2}), 2);
  EXPECT_TRUE(std::isnan(Median({})));
  EXPECT_TRUE(std::isnan(UpperMedian({})));
}

TEST(StandardDeviationTest, HasTheDivisorOfASample) {
  const double values[] = {2, 4, 4, 4, 5, 5, 7, 9};  // squares about the mean 5: 32
  EXPECT_EQ(Mean(values), 5);
  EXPECT_EQ(SquaresAboutMean(values), 32);
  EXPECT_DOUBLE_EQ(StandardDeviation(values), std::sqrt(32.0 / 7));
  EXPECT_EQ(StandardDeviation({}), 0);
}

}  // namespace
}  // namespace powdercal

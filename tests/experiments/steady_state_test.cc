#include "experiments/steady_state.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/random.h"

namespace powdercal {
namespace {

// x_i = a x_{i−1} + noise, with mean 0 and variance 1: g = (1 + a)/(1 − a).
std::vector<double> Correlated(std::size_t count, double a, std::uint64_t seed) {
  RandomStream stream(seed);
  std::vector<double> values;
  double x = stream.Normal();
  for (std::size_t i = 0; i < count; ++i) {
    values.push_back(x);
    x = a * x + std::sqrt(1 - a * a) * stream.Normal();
  }
  return values;
}

// 100 + 5 times the noise above, with a trend in units of the mean from the first to the last
// sample, and a beginning at 0 that is forgotten after some 50 samples.
std::vector<double> Shearing(double trend, std::uint64_t seed) {
  std::vector<double> values = Correlated(1500, 0.97, seed);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto t = static_cast<double>(i);
    values[i] = 100 + 5 * values[i] + 100 * trend * t / 1500 - 100 * std::exp(-t / 50);
  }
  return values;
}

TEST(SeriesMean, IndependentSamplesCountInFull) {
  const SeriesMean mean = MeanOf(Correlated(4000, 0, 1));
  EXPECT_NEAR(mean.inefficiency, 1, 0.15);
  EXPECT_NEAR(mean.variance * 4000, 1, 0.15);
}

TEST(SeriesMean, CorrelatedSamplesCountForLess) {
  const SeriesMean mean = MeanOf(Correlated(20'000, 0.9, 2));
  EXPECT_NEAR(mean.inefficiency, 19, 5);
}

TEST(SeriesMean, ItsVarianceIsThatOfRepeatedMeans) {
  double squares = 0;
  double claimed = 0;
  constexpr int kRepeats = 300;
  for (int r = 0; r < kRepeats; ++r) {
    const SeriesMean mean = MeanOf(Correlated(800, 0.9, 100 + static_cast<std::uint64_t>(r)));
    squares += mean.mean * mean.mean / kRepeats;
    claimed += mean.variance / kRepeats;
  }
  EXPECT_NEAR(claimed / squares, 1, 0.25);
}

TEST(SeriesMean, ConstantSeriesIsExact) {
  const SeriesMean mean = MeanOf(std::vector<double>(10, 3.0));
  EXPECT_EQ(mean.mean, 3);
  EXPECT_EQ(mean.variance, 0);
}

TEST(SteadyState, FindsTheEndOfTheBeginning) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SteadyState state = DetectSteadyState(Shearing(0, seed));
    EXPECT_TRUE(state.found) << "seed " << seed << ", drift " << state.drift;
    EXPECT_GE(state.start, 80U) << "the first value is off by 20 sds at 0, by 4 at 80";
    EXPECT_LE(state.start, 750U);
  }
}

TEST(SteadyState, RefusesADrift) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SteadyState state = DetectSteadyState(Shearing(0.6, seed));
    EXPECT_FALSE(state.found) << "seed " << seed << ", drift " << state.drift << " ± "
                              << state.drift_error;
  }
}

TEST(SteadyState, ToleratesADriftThatDoesNotMatter) {
  std::vector<double> values;
  for (int i = 0; i < 400; ++i) values.push_back(1 + 0.02 * i / 400.0);
  const SteadyState state = DetectSteadyState(values);
  EXPECT_TRUE(state.found);
  EXPECT_GT(state.drift, 0);
  EXPECT_FALSE(DetectSteadyState(values, {.tolerance = 0.001}).found);
}

TEST(SteadyState, ABeginningBeyondTheFirstHalfIsNoSteadyState) {
  std::vector<double> values(400, 1.0);
  for (std::size_t i = 0; i < 300; ++i) values[i] = static_cast<double>(i) / 300;
  EXPECT_FALSE(DetectSteadyState(values).found);
}

}  // namespace
}  // namespace powdercal

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

std::span<const double> Steady(const std::vector<double>& values) {
  return std::span<const double>(values).subspan(FindTruncation(values));
}

TEST(SteadyState, FindsTheEndOfTheBeginning) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::vector<double> values = Shearing(0, seed);
    const std::size_t start = FindTruncation(values);
    EXPECT_GE(start, 80U) << "the first value is off by 20 sds at 0, by 4 at 80";
    EXPECT_LE(start, 750U);
  }
}

TEST(SteadyState, TakesNoFluctuationForADrift) {
  int refused = 0;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    if (!MeasureDrift(Steady(Shearing(0, seed))).steady) ++refused;
  }
  EXPECT_LE(refused, 5) << "of 500; each would be a lost evaluation";
}

TEST(SteadyState, RefusesADrift) {
  int refused = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    if (!MeasureDrift(Steady(Shearing(1, seed))).steady) ++refused;
  }
  EXPECT_GE(refused, 90);
}

TEST(SteadyState, AKnownMemoryWidensTheError) {
  const std::vector<double> values = Shearing(0, 1);
  const double plain = MeasureDrift(Steady(values)).error;
  EXPECT_EQ(MeasureDrift(Steady(values), {.memory = 2}).error, plain) << "it is longer already";
  EXPECT_GT(MeasureDrift(Steady(values), {.memory = 300}).error, 1.5 * plain);
}

TEST(SteadyState, ErrorOfTheDriftIsThatOfRepeatedDrifts) {
  double squares = 0;
  double claimed = 0;
  constexpr int kRepeats = 300;
  for (std::uint64_t seed = 1; seed <= kRepeats; ++seed) {
    std::vector<double> values = Correlated(2000, 0.9, seed);
    for (double& value : values) value += 100;
    const Drift drift = MeasureDrift(values);
    squares += drift.value * drift.value / kRepeats;
    claimed += drift.error * drift.error / kRepeats;
  }
  EXPECT_NEAR(claimed / squares, 1, 0.25);
}

TEST(SteadyState, ToleratesADriftThatDoesNotMatter) {
  std::vector<double> values;
  for (int i = 0; i < 400; ++i) values.push_back(1 + 0.02 * i / 400.0);
  const Drift drift = MeasureDrift(values);
  EXPECT_TRUE(drift.steady);
  EXPECT_NEAR(drift.value, 0.01 / 1.01, 1e-4);
  EXPECT_FALSE(MeasureDrift(values, {.tolerance = 0.001}).steady);
}

TEST(SteadyState, ABeginningBeyondTheFirstHalfIsNoSteadyState) {
  std::vector<double> values(400, 1.0);
  for (std::size_t i = 0; i < 300; ++i) values[i] = static_cast<double>(i) / 300;
  EXPECT_FALSE(MeasureDrift(Steady(values)).steady);
}

}  // namespace
}  // namespace powdercal

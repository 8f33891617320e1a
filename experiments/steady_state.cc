#include "experiments/steady_state.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

namespace powdercal {
namespace {

double PlainMean(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// Index within the first half at which MSER is smallest.
std::size_t Truncation(std::span<const double> values) {
  std::vector<double> criterion(values.size());
  double mean = 0;
  double squares = 0;  // about the mean, of the samples from `i` on (Welford 1962, Technometrics 4)
  for (std::size_t i = values.size(); i-- > 0;) {
    const auto n = static_cast<double>(values.size() - i);
    const double deviation = values[i] - mean;
    mean += deviation / n;
    squares += deviation * (values[i] - mean);
    criterion[i] = squares / (n * n);
  }
  const auto half = criterion.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  return static_cast<std::size_t>(std::min_element(criterion.begin(), half + 1) -
                                  criterion.begin());
}

}  // namespace

SeriesMean MeanOf(std::span<const double> values) {
  assert(!values.empty());
  constexpr double kWindow = 5;
  const std::size_t n = values.size();
  SeriesMean result{.mean = PlainMean(values)};
  std::vector<double> deviations(values.begin(), values.end());
  for (double& deviation : deviations) deviation -= result.mean;
  const auto covariance = [&](std::size_t lag) {
    double sum = 0;
    for (std::size_t i = 0; i + lag < n; ++i) sum += deviations[i] * deviations[i + lag];
    return sum / static_cast<double>(n);
  };
  const double variance = covariance(0);
  if (variance > 0) {
    double time = 0.5;
    for (std::size_t lag = 1; lag < n && static_cast<double>(lag) <= kWindow * time; ++lag) {
      time = std::max(0.5, time + covariance(lag) / variance);
    }
    result.inefficiency = 2 * time;
  }
  const double independent = static_cast<double>(n) / result.inefficiency;
  result.variance =
      independent > 1 ? variance / (independent - 1) : std::numeric_limits<double>::infinity();
  return result;
}

SteadyState DetectSteadyState(std::span<const double> values, const SteadyStateOptions& options) {
  assert(values.size() >= 8);
  SteadyState state{.start = Truncation(values)};
  const std::span<const double> rest = values.subspan(state.start);
  const SeriesMean first = MeanOf(rest.first(rest.size() / 2));
  const SeriesMean second = MeanOf(rest.subspan(rest.size() / 2));
  const double mean = std::abs(PlainMean(rest));
  const double difference = second.mean - first.mean;
  const double error = std::sqrt(first.variance + second.variance);
  state.found = std::abs(difference) <= options.tolerance * mean ||
                std::abs(difference) <= options.significance * error;
  if (mean > 0) {
    state.drift = difference / mean;
    state.drift_error = error / mean;
  }
  return state;
}

}  // namespace powdercal

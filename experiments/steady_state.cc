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

std::size_t FindTruncation(std::span<const double> values) {
  assert(values.size() >= 2);
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

Drift MeasureDrift(std::span<const double> values, const DriftOptions& options) {
  assert(values.size() >= 8);
  const auto n = static_cast<double>(values.size());
  const double mean = PlainMean(values);
  const auto place = [&](std::size_t i) { return (static_cast<double>(i) + 0.5) / n - 0.5; };
  double spread = 0;
  double product = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    spread += place(i) * place(i);
    product += place(i) * (values[i] - mean);
  }
  const double slope = product / spread;  // over the whole length
  std::vector<double> residuals(values.begin(), values.end());
  for (std::size_t i = 0; i < values.size(); ++i) residuals[i] -= slope * place(i);
  const SeriesMean noise = MeanOf(residuals);
  const double longer = std::max(1.0, options.memory / noise.inefficiency);
  const double error = std::sqrt(longer * noise.variance * n / spread);
  Drift drift;
  drift.value = mean != 0 ? 0.5 * slope / mean : 0;
  drift.error = mean != 0 ? 0.5 * error / std::abs(mean) : 0;
  drift.steady = std::abs(drift.value) <= options.tolerance ||
                 std::abs(drift.value) <= options.significance * drift.error;
  return drift;
}

}  // namespace powdercal

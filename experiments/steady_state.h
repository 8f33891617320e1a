#pragma once

#include <cstddef>
#include <span>

namespace powdercal {

// Means of the noisy series that a flowing powder gives, and where its steady state begins.
// Samples at even intervals.

/// Mean of a correlated series.
struct SeriesMean {
  double mean = 0;
  double variance = 0;  ///< of the mean; infinite if the series is hardly longer than its memory
  double inefficiency = 1;  ///< [samples] g ≥ 1: that many count as one independent sample
};

/// With the integrated autocorrelation time tau, g = 2 tau, and n_eff = n/g, the variance of the
/// mean is that of the samples over n_eff − 1. The sum of autocorrelations ends at the first lag
/// beyond 5 tau (Sokal 1997, in Functional Integration, Plenum, p. 131, §3). Requires a sample.
SeriesMean MeanOf(std::span<const double> values);

struct SteadyStateOptions {
  double significance = 3;  ///< [-] standard errors by which the halves of a drifting series differ
  double tolerance = 0.05;  ///< [-] of the mean: a smaller difference is no drift that matters
};

struct SteadyState {
  bool found = false;
  std::size_t start = 0;   ///< index of its first sample, at most half of all
  double drift = 0;        ///< [-] mean of its second half less that of its first, over the mean
  double drift_error = 0;  ///< [-] standard error of that
};

/// Where a series has forgotten its beginning. The start is the truncation, within the first half,
/// that gives the mean the smallest marginal standard error (MSER; White 1997, Simulation 69:323);
/// what remains is steady if its two halves agree (after Geweke 1992, Bayesian Statistics 4:169):
/// their means may differ significantly or by more than the tolerance, but not both. Requires 8
/// samples.
SteadyState DetectSteadyState(std::span<const double> values,
                              const SteadyStateOptions& options = {});

}  // namespace powdercal

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

/// Where the mean of a series is no longer burdened by its beginning: the truncation, within the
/// first half, that gives the mean the smallest marginal standard error (MSER; White 1997,
/// Simulation 69:323). Requires two samples.
std::size_t FindTruncation(std::span<const double> values);

struct DriftOptions {
  double significance = 4;  ///< [-] standard errors that a drift must exceed
  double tolerance = 0.05;  ///< [-] of the mean: a smaller drift does not matter
  double memory = 1;        ///< [samples] as many as count as one independent sample, at least
};

struct Drift {
  bool steady = false;  ///< the drift is insignificant or does not matter
  double value = 0;     ///< [-] the trend from the first quarter to the third, over the mean
  double error = 0;     ///< [-] standard error of that
};

/// Whether a truncated series is steady: its linear trend, with a standard error that allows for
/// the autocorrelation of the residuals (Santer et al. 2000, J. Geophys. Res. 105:7337), about as
/// large as the difference of the means of its halves. The error is underestimated where the series
/// is only some ten times as long as its memory, hence the four standard errors. Requires 8
/// samples.
Drift MeasureDrift(std::span<const double> values, const DriftOptions& options = {});

}  // namespace powdercal

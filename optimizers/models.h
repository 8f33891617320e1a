#pragma once

#include <Eigen/Core>
#include <vector>

#include "optimizers/observations.h"
#include "optimizers/optimizer.h"
#include "surrogates/gaussian_process.h"

namespace powdercal {

struct ModelOptions {
  Kernel kernel = Kernel::matern52;
  bool warp = false;
  /// Prior LogNormal(location, scale) of the variance of noise that nobody told of, and its least
  /// value, in units of the variance of what is observed. Known variances come with the
  /// observations; what is learned besides is often nothing, which a handful of points cannot show.
  /// The process's own prior, LogNormal(−4, 1), makes a search miss targets by a tenth of the
  /// spread of the responses. This one is lower, and wide enough for noise that nobody told of: on
  /// the environmental model of 4 parameters, without noise, medians of chi² of `bayesian` after 20
  /// evaluations fall from 3e-5, with LogNormal(−6, 2), to 7e-8, and noisy ones stay as they were
  /// (benchmarks/optimizer_suite).
  double noise_location = -9;
  double noise_scale = 3;
  double noise_floor = 1e-8;
};

/// What processes over the space see: categories apart from each other.
InputMap InputsOf(const SearchSpace& space);

/// Gaussian processes of what was observed.
struct Models {
  std::vector<GaussianProcess> processes;
  std::vector<std::size_t> targets;  ///< the target each belongs to; empty: one, of the objective
  Eigen::ArrayXd noise_variances;    ///< of each, typical among the observations' known ones
};

/// A process for each response that was seen at least twice. None where an objective has no such
/// response: nothing can be weighed against what is unknown. Throws std::exception where a fit
/// fails.
Models FitResponses(const SearchSpace& space, const Objectives& objectives,
                    const ObservationsById& observations, const ModelOptions& options);

/// One process of the single objective itself, with the variance that those of the responses give
/// it. None with fewer than two complete observations. Throws std::exception where the fit fails.
Models FitObjective(const SearchSpace& space, const Objectives& objectives,
                    const ObservationsById& observations, const ModelOptions& options);

}  // namespace powdercal

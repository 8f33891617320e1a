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
};

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

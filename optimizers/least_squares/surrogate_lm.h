#pragma once

#include <memory>

#include "optimizers/designs/design.h"
#include "optimizers/optimizer.h"
#include "surrogates/kernel.h"

namespace powdercal {

/// `surrogate_lm`: an initial design, then in each round the minimum of the χ² that the means of
/// Gaussian processes, one for each response, give. No simulation is spent on derivatives.
struct SurrogateLmOptions {
  DesignOptions initial_design{.name = "sobol"};
  Kernel kernel = Kernel::matern52;

  /// Throws InputError.
  void Serialize(Archive& archive, const SearchSpace& space);
};

/// Each proposal is made from all observations anew: the processes are fitted (known variances and
/// a learned noise), Levenberg–Marquardt with their exact Jacobian runs from the best evaluations
/// and from the best of a Sobol' set, and of the minima found
///  1. the lowest is proposed, unless it is within 1e-6 of the box of an evaluated or pending
///     point; then
///  2. the next that may be lower than the lowest: its optimistic χ² (means moved towards the
///     targets by up to two posterior standard deviations) is below the lowest χ²; then
///  3. the point of the valley about which most is unknown: of points scattered around the lowest
///     minimum, in the shape of the model's valley, and over the box, that with the largest
///     Σ_j v_j/s_j² (v_j the posterior variance given the pending points, s_j the weight of the
///     residual) among those whose optimistic χ² is at most the lowest χ² + 1.
/// Points where evaluations are likelier to fail than not (Feasibility) are passed over; where that
/// is the whole valley, the lowest optimistic χ² elsewhere is proposed. Without a model the point
/// farthest from all others is proposed. Never waits, never finishes; status().message says where
/// the lowest minimum is flat, at a bound, or without an influence of a parameter.
std::unique_ptr<Optimizer> MakeSurrogateLm(const SurrogateLmOptions& options,
                                           const SearchSpace& space, const Objectives& objectives,
                                           std::uint64_t seed);

std::unique_ptr<OptimizerFactory> MakeSurrogateLmFactory();

}  // namespace powdercal

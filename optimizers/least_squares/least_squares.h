#pragma once

#include <memory>
#include <optional>

#include "optimizers/designs/design.h"
#include "optimizers/optimizer.h"

namespace powdercal {

/// `least_squares`: an initial design, then Levenberg–Marquardt (SearchLocally) from its best
/// point, and from the next best when that search has ended.
struct LeastSquaresOptions {
  DesignOptions initial_design{.name = "sobol"};
  int starts = 5;           ///< searches, 1 … 1000; no more than there are initial points
  double tolerance = 1e-8;  ///< of χ², relative: where a search has converged, in (0, 0.1]
  /// To which responses without known variance can be trusted, relative, [1e-16, 0.01].
  double precision = 1e-8;
  /// Of the finite differences, in the unit box, [1e-8, 0.5]; empty: by the noise (StepRule).
  std::optional<double> step;

  /// Throws InputError.
  void Serialize(Archive& archive, const SearchSpace& space);
};

/// Asks for the initial design, for the whole stencil of a Jacobian (d points, 2 d where it is
/// central) and for one trial point, in turns; each batch may be evaluated in parallel and the next
/// one waits for all of it. Points that were told of before are not asked for again, and may be
/// starts. A start within 0.05 of the end of an earlier search is passed over. Finished when all
/// starts are used, when every residual is below 1e-3 standard deviations, or when no start can be
/// used. status().message says of the best search what it found: convergence, flat valleys, dead
/// parameters, parameters at their bounds, noise; and which responses were missing.
///
/// A response that a start lacks does not count in the search from there; a later point that lacks
/// a response which counts has failed. Starts with all responses come first.
std::unique_ptr<Optimizer> MakeLeastSquares(const LeastSquaresOptions& options,
                                            const SearchSpace& space, const Objectives& objectives,
                                            std::uint64_t seed);

std::unique_ptr<OptimizerFactory> MakeLeastSquaresFactory();

}  // namespace powdercal

#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/random.h"

namespace powdercal {

/// One objective made of several, anew for every proposal, so that the proposals spread along the
/// Pareto front (ParEGO: Knowles 2006, IEEE Trans. Evol. Comput. 10:50):
///   c = Σ_o weights_o chi²_o,   weights_o ∝ shares_o / range_o.
/// The shares lie on the simplex. Of every 3 m proposals for m objectives, the first m stand at its
/// corners, one for each objective alone; the others are uniform over it. A corner leaves 1 % to
/// the objectives together: among points that serve its own objective alike it prefers those that
/// serve the others.
///
/// ParEGO's augmented Chebyshev norm reaches every part of a front. This sum reaches only its
/// convex part, and is used because its expected improvement is exact
/// (CompositeLogExpectedImprovement). Where the responses are nearly linear in the parameters the
/// front is convex; points in a hollow of it are met by chance alone.
struct Scalarisation {
  Eigen::ArrayXd shares;   ///< λ, sum 1, each > 0
  Eigen::ArrayXd weights;  ///< of the objectives; the largest is 1
};

/// proposal: number of the proposal, ≥ 0. chi2: what is known, evaluations × objectives; rows that
/// are not finite do not count. range_o is that of the objective along the non-dominated of them;
/// at least 1, below which chi² tells nothing.
Scalarisation MakeScalarisation(const Eigen::MatrixXd& chi2, std::int64_t proposal,
                                RandomStream random);

}  // namespace powdercal

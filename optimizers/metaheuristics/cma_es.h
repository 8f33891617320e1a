#pragma once

#include <memory>

#include "optimizers/metaheuristics/metaheuristic.h"

namespace powdercal {

/// `cma_es`: covariance matrix adaptation (Hansen 2016, arXiv:1604.00772) with restarts from
/// uniform random points with a growing population (Auger & Hansen 2005).
struct CmaEsOptions {
  Implementation implementation = Implementation::own;
  double initial_step = 0.3;     ///< σ in the unit box, 0 < σ ≤ 1
  double population_factor = 2;  ///< own: at each restart, 1 … 10
  double smallest_step = 1e-5;   ///< own: restart when no standard deviation exceeds it, > 0
};

/// The own strategy: full covariance, cumulative step-size adaptation, negative weights for the
/// worse half. It starts at the best of the initial population. Samples beyond the box are moved to
/// its surface. Mean, paths and positive weights see them as moved, negative weights as drawn.
/// (Tried and worse on problems with optima inside, at a side or in a corner: reflection
/// at the bounds, with and without telling the distribution; drawing again.) Standard deviations of
/// discrete parameters stay above 0.3 of a level. Failed points take no part in the update, for
/// which weights and rates are those of as many points as succeeded; when all of a generation
/// failed the step is halved, or, if nothing has succeeded since the restart, the next restart is
/// due.
/// Restarts: `smallest_step`; the best values of the last 10 + 30 d/λ generations and all of the
/// last differ by less than 1e-12 (relative, at least absolute); condition number above 1e14.
std::unique_ptr<Strategy> MakeCmaEs(const CmaEsOptions& options, const SearchProblem& problem);

std::unique_ptr<Method> MakeCmaEsMethod();

}  // namespace powdercal

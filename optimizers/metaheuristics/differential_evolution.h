#pragma once

#include <memory>

#include "optimizers/metaheuristics/metaheuristic.h"

namespace powdercal {

/// `differential_evolution`.
struct DifferentialEvolutionOptions {
  Implementation implementation = Implementation::own;
  double best_share = 0.2;  ///< own: a trial moves towards one of this share of the best, 0 < p ≤ 1
};

/// The own strategy: current-to-pbest/1/bin with an archive of former members (Zhang & Sanderson
/// 2009), F and CR drawn about a memory of what was successful (SHADE, Tanabe & Fukunaga 2013). A
/// coordinate that would leave the box is put half-way between its origin and the bound. Each
/// generation has one trial for each member. A failed trial never replaces a member; any trial that
/// succeeded replaces a failed one. Discrete parameters are searched as continuous ones, and
/// snapped for the evaluation.
std::unique_ptr<Strategy> MakeDifferentialEvolution(const DifferentialEvolutionOptions& options,
                                                    const SearchProblem& problem);

std::unique_ptr<Method> MakeDifferentialEvolutionMethod();

}  // namespace powdercal

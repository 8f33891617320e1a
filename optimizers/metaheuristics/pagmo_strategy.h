#pragma once

#include <pagmo/algorithm.hpp>

#include "optimizers/metaheuristics/strategy.h"

namespace powdercal {

/// Runs a pagmo algorithm in a thread, which starts with Begin. The algorithm may call for single
/// points or for batches (member_bfe).
std::unique_ptr<Strategy> MakePagmoStrategy(pagmo::algorithm algorithm,
                                            const SearchProblem& problem);

/// Seed for an algorithm.
unsigned PagmoSeed(const SearchProblem& problem);

}  // namespace powdercal

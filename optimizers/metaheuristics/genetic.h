#pragma once

#include <memory>

#include "optimizers/metaheuristics/metaheuristic.h"
#include "optimizers/metaheuristics/variation.h"

namespace powdercal {

/// `genetic`: a real-coded genetic algorithm with discrete genes.
struct GeneticOptions {
  Implementation implementation = Implementation::own;
  VariationOptions variation{.crossover_index = 10, .mutation_index = 30};
  int tournament = 2;  ///< 2 … 100, at most the population: contestants for each place as a parent
};

/// The own strategy. Each generation has as many children as the population has members: parents by
/// tournament, then Variation; a child equal to a member or to another child has one more parameter
/// mutated, a few times if need be. Parents and children compete; the best stay. Failed members are
/// no parents as long as there are others in their tournament.
std::unique_ptr<Strategy> MakeGenetic(const GeneticOptions& options, const SearchProblem& problem);

std::unique_ptr<Method> MakeGeneticMethod();

}  // namespace powdercal

#pragma once

#include <memory>

#include "optimizers/metaheuristics/genetic.h"
#include "optimizers/metaheuristics/metaheuristic.h"
#include "optimizers/metaheuristics/moead.h"

// Algorithms of pagmo (Biscani & Izzo 2020, doi:10.21105/joss.02338). Each runs in a thread of its
// own, whose problem waits in a BlockingSolver for values; the thread ends with the strategy, at any
// moment. The evaluated initial population is handed over, so that nothing is evaluated twice.
//
// pagmo knows numbers only. A value that is missing is handed over as the worst one of its
// objective seen so far plus 1000 times (its range + 1). All of these algorithms only compare
// values, except for crowding distances (nsga2, nspso), where such points lie in the last fronts,
// and for weighted ones (moead); a success that is worse still would rank below the failure.

namespace powdercal {

/// pso_gen: canonical swarm with constriction (Clerc & Kennedy 2002), ring of neighbours.
struct ParticleSwarmOptions {
  double inertia = 0.7298;    ///< 0 … 1, factor on the new velocity
  double cognitive = 2.05;    ///< 0 … 4, pull of the particle's own best
  double social = 2.05;       ///< 0 … 4, pull of its neighbours' best
  double max_velocity = 0.5;  ///< sides of the box per generation, 0 < v ≤ 1
  int neighbours = 4;         ///< 2 … 100
};

/// gaco: extended ant colony (Schlüter, Egea & Banga 2009).
struct AntColonyOptions {
  int kernels = 0;  ///< solutions that guide the ants, 2 … population; 0: as many
  double q = 0.1;   ///< 0 < q ≤ 10: the smaller, the more do the best of these count
};

/// nsga2: Deb et al. 2002.
struct Nsga2Options {
  VariationOptions variation{.crossover = 0.95, .crossover_index = 10, .mutation_index = 50};
};

/// nspso: Li 2003, leaders by crowding distance.
struct NspsoOptions {
  double inertia = 0.6;       ///< 0 … 1
  double cognitive = 2;       ///< 0 < c ≤ 4
  double social = 2;          ///< 0 < c ≤ 4
  double max_velocity = 0.5;  ///< sides of the box per generation, 0 < v ≤ 1
};

std::unique_ptr<Method> MakeAntColonyMethod();
std::unique_ptr<Method> MakeNsga2Method();
std::unique_ptr<Method> MakeNspsoMethod();
std::unique_ptr<Method> MakeParticleSwarmMethod();

// The counterparts of own strategies. They propose one point at a time.

/// cmaes, samples beyond the box moved to its surface, no restarts.
std::unique_ptr<Strategy> MakePagmoCmaEs(double initial_step, const SearchProblem& problem);
/// sga with simulated binary crossover and polynomial mutation.
std::unique_ptr<Strategy> MakePagmoGenetic(const GeneticOptions& options,
                                           const SearchProblem& problem);
/// sade with the self-adaptation of Brest et al. 2006 (jDE), rand/1/exp.
std::unique_ptr<Strategy> MakePagmoDifferentialEvolution(const SearchProblem& problem);
/// moead with its operator of differential evolution; the lattice's weights if there is one.
std::unique_ptr<Strategy> MakePagmoMoead(const MoeadOptions& options, const SearchProblem& problem);

}  // namespace powdercal

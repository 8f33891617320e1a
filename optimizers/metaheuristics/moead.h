#pragma once

#include <memory>
#include <vector>

#include "optimizers/metaheuristics/metaheuristic.h"
#include "optimizers/metaheuristics/variation.h"

namespace powdercal {

/// `moead`: decomposition into as many single objectives as the population has members (Zhang & Li
/// 2007).
struct MoeadOptions {
  Implementation implementation = Implementation::own;
  VariationOptions variation{.crossover = 1, .crossover_index = 20};
  double differential = 0.5;  ///< own: probability that a child is made of differences, 0 … 1
  int neighbours = 0;         ///< 2 … population − 1; 0: 3 in 10 of the population, at least 4
  double neighbour_probability = 0.9;  ///< that parents are neighbours, 0 … 1, otherwise any
  int replacements = 2;  ///< members that one child may replace, 1 … 1000 (Li & Zhang 2009)
};

/// The own strategy. Each generation has one child for each weight vector, of two parents of its
/// neighbourhood or, rarely, of the whole population: by crossover, or, as often, the member itself
/// moved by half the difference of the parents (Li & Zhang 2009; its discrete parameters crossed);
/// then mutated. (Crossover alone needs more evaluations where the front is smooth and parameters
/// are few, differences alone fail on the 30 parameters of ZDT1.) The children are then offered, in
/// order, to the members that their parents could have come from, in random order: a member with
/// weights w is replaced if the child has a lower max_o w_o (f_o − z_o)/(n_o − z_o), z being the
/// lowest values seen and n the highest along the front of members and children. Failed members are
/// no parents as long as others are found; any child that succeeded is better. Unlike in the
/// original, a child is a parent from the next generation on, so that a generation can be evaluated
/// at a time.
std::unique_ptr<Strategy> MakeMoead(const MoeadOptions& options, const SearchProblem& problem);

std::unique_ptr<Method> MakeMoeadMethod();

/// `count` weight vectors with sum 1, entries ≥ 0: of two objectives evenly spaced; of more the
/// simplex lattice of Das & Dennis (1998) if it has a size of `count`, else one corner for each
/// objective and Sobol' points mapped to the simplex. count ≥ objectives ≥ 2.
std::vector<Eigen::VectorXd> SimplexWeights(int count, int objectives);

/// Whether a simplex lattice of that many weights exists.
bool IsLatticeSize(int count, int objectives);

}  // namespace powdercal

#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "optimizers/designs/design.h"
#include "optimizers/metaheuristics/strategy.h"
#include "optimizers/optimizer.h"

namespace powdercal {

/// Own implementation, or pagmo's (https://esa.github.io/pagmo2) for comparison.
enum class Implementation { own, pagmo };
/// `implementation: own|pagmo`.
void SerializeImplementation(Archive& archive, Implementation& implementation);

/// What a metaheuristic can treat and what it needs.
struct MethodTraits {
  bool pareto = false;       ///< searches for several objectives; otherwise for one
  bool categorical = false;  ///< categorical parameters; integers are no obstacle to any
  bool batches = true;       ///< proposes whole generations; otherwise one point at a time
  int smallest_population = 4;
  int population_multiple = 1;  ///< of which the population has to be one
};

/// A metaheuristic with its own parameters; makes strategies.
class Method {
 public:
  virtual ~Method() = default;
  virtual const std::string& name() const = 0;
  virtual std::string Describe() const = 0;  ///< one line
  virtual MethodTraits traits() const = 0;
  virtual int DefaultPopulation(int dimension, int objectives) const = 0;
  /// Throws InputError.
  virtual void Serialize(Archive& archive) = 0;
  virtual std::unique_ptr<Strategy> MakeStrategy(const SearchProblem& problem) const = 0;
};

/// What all metaheuristics have in common.
struct MetaheuristicOptions {
  int population = 0;   ///< 0: the method's default
  int generations = 0;  ///< after the initial population; 0: until the study's budget ends
  /// Points of the initial population. Fewer than the population: uniform random ones are added;
  /// more: the best ones go on. `sobol` without a number of points: as many as the population.
  DesignOptions initial_design{.name = "sobol"};

  /// Throws InputError.
  void Serialize(Archive& archive, const SearchSpace& space, const MethodTraits& traits);
  /// Whether the initial design is another than that of no choice.
  bool HasDesign() const { return initial_design.name != "sobol" || initial_design.points > 0; }
};

/// Asks for one generation after the other, each as a batch that may be asked for in parts, told in
/// any order. When all of it has been asked and not all been told, Ask gives nothing
/// (Phase::waiting): evaluations of equal length keep w workers busy throughout if the population
/// is a multiple of w. The objectives are those of ChiSquared. Failures are never turned into a
/// number that the own methods see: a failed individual ranks below all others and nothing is
/// learned from where it lies; a response that failed alone fails the objectives it belongs to, and
/// with them the individual in the own methods. While nothing has succeeded, further uniform random
/// populations are asked for. Observations with negative ids may enter the initial population; they
/// are ignored when the search has begun.
std::unique_ptr<Optimizer> MakeMetaheuristic(const Method& method,
                                             const MetaheuristicOptions& options,
                                             const SearchSpace& space, const Objectives& objectives,
                                             std::uint64_t seed);

/// ant_colony, cma_es, differential_evolution, genetic, moead, nsga2, nspso or particle_swarm.
std::unique_ptr<OptimizerFactory> MakeMetaheuristicFactory(const std::string& name);

}  // namespace powdercal

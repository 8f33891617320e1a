#include "optimizers/metaheuristics/pagmo_methods.h"

#include <algorithm>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/algorithms/gaco.hpp>
#include <pagmo/algorithms/moead.hpp>
#include <pagmo/algorithms/nsga2.hpp>
#include <pagmo/algorithms/nspso.hpp>
#include <pagmo/algorithms/pso_gen.hpp>
#include <pagmo/algorithms/sade.hpp>
#include <pagmo/algorithms/sga.hpp>
#include <pagmo/batch_evaluators/member_bfe.hpp>
#include <pagmo/bfe.hpp>

#include "optimizers/metaheuristics/pagmo_strategy.h"

namespace powdercal {
namespace {

constexpr unsigned kEndless = 1000000000;  // generations
constexpr Range kPull{.lower = 0, .upper = 4, .lower_open = true};
constexpr Range kVelocity{.lower = 0, .upper = 1, .lower_open = true};

double MutationProbability(const VariationOptions& variation, const SearchProblem& problem) {
  return variation.mutation > 0 ? variation.mutation : 1.0 / problem.dimension();
}

template <typename UserAlgorithm>
std::unique_ptr<Strategy> InBatches(UserAlgorithm algorithm, const SearchProblem& problem) {
  algorithm.set_bfe(pagmo::bfe(pagmo::member_bfe()));
  return MakePagmoStrategy(pagmo::algorithm(std::move(algorithm)), problem);
}

class AntColonyMethod final : public Method {
 public:
  const std::string& name() const override {
    static const std::string name = "ant_colony";
    return name;
  }
  std::string Describe() const override {
    return "ant colony in continuous space (pagmo's gaco); one objective";
  }
  MethodTraits traits() const override {
    return {.smallest_population = std::max(4, options_.kernels)};
  }
  int DefaultPopulation(int, int) const override { return std::max(16, options_.kernels); }
  void Serialize(Archive& archive) override {
    archive.Integer("kernels", options_.kernels, {.lower = 0, .upper = 100000});
    if (options_.kernels == 1) throw archive.ErrorAt("kernels", "must be 0 or at least 2");
    archive.Number("q", options_.q, {.lower = 0, .upper = 10, .lower_open = true});
  }
  std::unique_ptr<Strategy> MakeStrategy(const SearchProblem& problem) const override {
    const int kernels = options_.kernels > 0 ? options_.kernels : problem.population;
    // From the generation `threshold` on gaco sets q to 0.01 by itself; and it would end after many
    // generations without improvement. Neither is wanted.
    const unsigned threshold = kEndless;
    return InBatches(pagmo::gaco(kEndless, static_cast<unsigned>(kernels), options_.q, 0, 0.01,
                                 threshold, 7, 0, 0, 0, false, PagmoSeed(problem)),
                     problem);
  }

 private:
  AntColonyOptions options_;
};

class Nsga2Method final : public Method {
 public:
  const std::string& name() const override {
    static const std::string name = "nsga2";
    return name;
  }
  std::string Describe() const override {
    return "genetic algorithm by non-dominated sorting (pagmo's nsga2); several objectives";
  }
  MethodTraits traits() const override {
    return {.pareto = true, .smallest_population = 8, .population_multiple = 4};
  }
  int DefaultPopulation(int, int objectives) const override { return objectives == 2 ? 40 : 60; }
  void Serialize(Archive& archive) override { options_.variation.Serialize(archive); }
  std::unique_ptr<Strategy> MakeStrategy(const SearchProblem& problem) const override {
    const VariationOptions& v = options_.variation;
    return InBatches(
        pagmo::nsga2(kEndless, v.crossover, v.crossover_index, MutationProbability(v, problem),
                     v.mutation_index, PagmoSeed(problem)),
        problem);
  }

 private:
  Nsga2Options options_;
};

class NspsoMethod final : public Method {
 public:
  const std::string& name() const override {
    static const std::string name = "nspso";
    return name;
  }
  std::string Describe() const override {
    return "particle swarm by non-dominated sorting (pagmo's nspso); several objectives";
  }
  MethodTraits traits() const override { return {.pareto = true}; }
  int DefaultPopulation(int, int objectives) const override { return objectives == 2 ? 40 : 60; }
  void Serialize(Archive& archive) override {
    archive.Number("inertia", options_.inertia, kUnitInterval);
    archive.Number("cognitive", options_.cognitive, kPull);
    archive.Number("social", options_.social, kPull);
    archive.Number("max_velocity", options_.max_velocity, kVelocity);
  }
  std::unique_ptr<Strategy> MakeStrategy(const SearchProblem& problem) const override {
    return InBatches(
        pagmo::nspso(kEndless, options_.inertia, options_.cognitive, options_.social, 1,
                     options_.max_velocity, 60, "crowding distance", false, PagmoSeed(problem)),
        problem);
  }

 private:
  NspsoOptions options_;
};

class ParticleSwarmMethod final : public Method {
 public:
  const std::string& name() const override {
    static const std::string name = "particle_swarm";
    return name;
  }
  std::string Describe() const override {
    return "particle swarm (pagmo's pso_gen); one objective";
  }
  MethodTraits traits() const override { return {}; }
  int DefaultPopulation(int, int) const override { return 16; }
  void Serialize(Archive& archive) override {
    const Range pull{.lower = 0, .upper = 4};
    archive.Number("inertia", options_.inertia, kUnitInterval);
    archive.Number("cognitive", options_.cognitive, pull);
    archive.Number("social", options_.social, pull);
    archive.Number("max_velocity", options_.max_velocity, kVelocity);
    archive.Integer("neighbours", options_.neighbours, {.lower = 2, .upper = 100});
  }
  std::unique_ptr<Strategy> MakeStrategy(const SearchProblem& problem) const override {
    constexpr unsigned kConstriction = 5;
    constexpr unsigned kRing = 2;
    return InBatches(
        pagmo::pso_gen(kEndless, options_.inertia, options_.cognitive, options_.social,
                       options_.max_velocity, kConstriction, kRing,
                       static_cast<unsigned>(options_.neighbours), false, PagmoSeed(problem)),
        problem);
  }

 private:
  ParticleSwarmOptions options_;
};

}  // namespace

std::unique_ptr<Method> MakeAntColonyMethod() { return std::make_unique<AntColonyMethod>(); }
std::unique_ptr<Method> MakeNsga2Method() { return std::make_unique<Nsga2Method>(); }
std::unique_ptr<Method> MakeNspsoMethod() { return std::make_unique<NspsoMethod>(); }
std::unique_ptr<Method> MakeParticleSwarmMethod() {
  return std::make_unique<ParticleSwarmMethod>();
}

std::unique_ptr<Strategy> MakePagmoCmaEs(double initial_step, const SearchProblem& problem) {
  constexpr double kDefault = -1;
  return MakePagmoStrategy(
      pagmo::algorithm(pagmo::cmaes(kEndless, kDefault, kDefault, kDefault, kDefault, initial_step,
                                    0, 0, false, true, PagmoSeed(problem))),
      problem);
}

std::unique_ptr<Strategy> MakePagmoGenetic(const GeneticOptions& options,
                                           const SearchProblem& problem) {
  const VariationOptions& v = options.variation;
  return MakePagmoStrategy(
      pagmo::algorithm(pagmo::sga(kEndless, v.crossover, v.crossover_index,
                                  MutationProbability(v, problem), v.mutation_index,
                                  static_cast<unsigned>(options.tournament), "sbx", "polynomial",
                                  "tournament", PagmoSeed(problem))),
      problem);
}

std::unique_ptr<Strategy> MakePagmoDifferentialEvolution(const SearchProblem& problem) {
  constexpr unsigned kRand1Exp = 2;
  constexpr unsigned kBrest = 1;
  return MakePagmoStrategy(
      pagmo::algorithm(pagmo::sade(kEndless, kRand1Exp, kBrest, 0, 0, false, PagmoSeed(problem))),
      problem);
}

std::unique_ptr<Strategy> MakePagmoMoead(const MoeadOptions& options,
                                         const SearchProblem& problem) {
  const int neighbours =
      options.neighbours > 0 ? options.neighbours : std::min(20, problem.population - 1);
  const char* weights =
      IsLatticeSize(problem.population, problem.objectives) ? "grid" : "low discrepancy";
  return MakePagmoStrategy(
      pagmo::algorithm(
          pagmo::moead(kEndless, weights, "tchebycheff", static_cast<unsigned>(neighbours), 1.0,
                       0.5, 20, options.neighbour_probability,
                       static_cast<unsigned>(options.replacements), true, PagmoSeed(problem))),
      problem);
}

}  // namespace powdercal

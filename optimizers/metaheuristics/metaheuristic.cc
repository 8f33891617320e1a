#include "optimizers/metaheuristics/metaheuristic.h"

#include <fmt/format.h>

#include <array>
#include <stdexcept>
#include <utility>

#include "optimizers/metaheuristics/cma_es.h"
#include "optimizers/metaheuristics/differential_evolution.h"
#include "optimizers/metaheuristics/genetic.h"
#include "optimizers/metaheuristics/moead.h"
#include "optimizers/metaheuristics/pagmo_methods.h"

namespace powdercal {
namespace {

const std::array<std::string, 2> kImplementationNames = {"own", "pagmo"};
constexpr int kLargestPopulation = 100000;

using MethodMaker = std::unique_ptr<Method> (*)();

constexpr std::array<std::pair<const char*, MethodMaker>, 8> kMethods = {{
    {"ant_colony", MakeAntColonyMethod},
    {"cma_es", MakeCmaEsMethod},
    {"differential_evolution", MakeDifferentialEvolutionMethod},
    {"genetic", MakeGeneticMethod},
    {"moead", MakeMoeadMethod},
    {"nsga2", MakeNsga2Method},
    {"nspso", MakeNspsoMethod},
    {"particle_swarm", MakeParticleSwarmMethod},
}};

std::unique_ptr<Method> MakeMethod(const std::string& name) {
  for (const auto& [known, make] : kMethods) {
    if (name == known) return make();
  }
  throw std::invalid_argument("MakeMetaheuristicFactory: unknown method " + name);
}

class MetaheuristicFactory final : public OptimizerFactory {
 public:
  explicit MetaheuristicFactory(const std::string& name) : method_(MakeMethod(name)) {}

  const std::string& name() const override { return method_->name(); }
  std::string Describe() const override { return method_->Describe(); }
  void Serialize(Archive& archive, const SearchSpace& space) override {
    method_->Serialize(archive);
    options_.Serialize(archive, space, method_->traits());
  }
  std::unique_ptr<Optimizer> Make(const SearchSpace& space, const Objectives& objectives,
                                  std::uint64_t seed) const override {
    return MakeMetaheuristic(*method_, options_, space, objectives, seed);
  }
  DesignOptions* initial_design() override { return &options_.initial_design; }

 private:
  std::unique_ptr<Method> method_;
  MetaheuristicOptions options_;
};

}  // namespace

void SerializeImplementation(Archive& archive, Implementation& implementation) {
  archive.Enumeration("implementation", implementation, "implementation", kImplementationNames);
}

void MetaheuristicOptions::Serialize(Archive& archive, const SearchSpace& space,
                                     const MethodTraits& traits) {
  archive.Integer("population", population, {.lower = 0, .upper = kLargestPopulation});
  const int smallest = traits.smallest_population;
  const int multiple = traits.population_multiple;
  if (population != 0 && (population < smallest || population % multiple != 0)) {
    throw archive.ErrorAt(
        "population", multiple == 1
                          ? fmt::format("must be at least {}, or 0 for the default", smallest)
                          : fmt::format("must be a multiple of {} and at least {}, or 0 for the "
                                        "default",
                                        multiple, smallest));
  }
  archive.Integer("generations", generations, {.lower = 0});
  const bool given = archive.Has("initial_design");
  if (archive.reading() || HasDesign()) {
    initial_design.SerializeSection(archive, "initial_design", space);
  }
  if (archive.reading() && !given) initial_design = {.name = "sobol"};
}

std::unique_ptr<OptimizerFactory> MakeMetaheuristicFactory(const std::string& name) {
  return std::make_unique<MetaheuristicFactory>(name);
}

}  // namespace powdercal

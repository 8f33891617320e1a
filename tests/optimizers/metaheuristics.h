#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/archive.h"
#include "optimizers/optimizer.h"
#include "tests/optimizers/problems.h"

namespace powdercal {

/// A metaheuristic with options as in a study file.
struct MetaheuristicCase {
  std::string name;
  std::string options = "{}";  ///< YAML
  int objectives = 1;          ///< how many it is tested with
  bool batches = true;

  friend std::ostream& operator<<(std::ostream& out, const MetaheuristicCase& c) {
    return out << c.name << " " << c.options;
  }
};

/// All methods, in both implementations where there are two.
inline std::vector<MetaheuristicCase> AllMetaheuristics() {
  const std::string pagmo = "implementation: pagmo";
  return {{"ant_colony"},
          {"cma_es"},
          {"cma_es", pagmo, 1, false},
          {"differential_evolution"},
          {"differential_evolution", pagmo, 1, false},
          {"genetic"},
          {"genetic", pagmo, 1, false},
          {"moead", "{}", 2},
          {"moead", pagmo, 2, false},
          {"nsga2", "{}", 2},
          {"nspso", "{}", 2},
          {"particle_swarm"}};
}

/// "cma_es", "cma_es_pagmo", for names of tests.
inline std::string CaseName(const MetaheuristicCase& c) {
  return c.options == "{}" ? c.name : c.name + "_pagmo";
}

inline std::unique_ptr<Optimizer> MakeFrom(const std::string& name, const std::string& options,
                                           const SearchSpace& space, const Objectives& objectives,
                                           std::uint64_t seed) {
  const std::unique_ptr<OptimizerFactory> factory = MakeOptimizerFactory(name);
  ReadYaml(options, "study.yaml", [&](Archive& archive) { factory->Serialize(archive, space); });
  return factory->Make(space, objectives, seed);
}

/// `count` objectives, each a response to be minimised.
inline Objectives Minimised(int count) {
  Objectives objectives;
  if (count > 1) objectives.kind = Objectives::Kind::pareto;
  for (int o = 0; o < count; ++o) {
    objectives.targets.push_back({.response = fmt::format("f{}", o),
                                  .unit = "1",
                                  .sd = 1,
                                  .objective = o,
                                  .minimise = true});
  }
  return objectives;
}

/// Asks for all that there is, tells all of it, until so many have been evaluated. An empty vector
/// of responses is a failure.
inline std::vector<Observation> RunInBatches(Optimizer* optimizer, const Responses& responses,
                                             int evaluations) {
  std::vector<Observation> history;
  while (static_cast<int>(history.size()) < evaluations) {
    const std::vector<Candidate> batch =
        optimizer->Ask(evaluations - static_cast<int>(history.size()));
    if (batch.empty()) break;
    const std::size_t begin = history.size();
    for (const Candidate& candidate : batch) {
      const Eigen::VectorXd values = responses(candidate.point);
      history.push_back(values.size() > 0 ? Succeeded(candidate, values) : Failed(candidate));
    }
    optimizer->Tell(std::span(history).subspan(begin));
  }
  return history;
}

/// The lowest first response of those that succeeded; 1e300 if none has.
inline double LowestFirst(const std::vector<Observation>& history) {
  double lowest = 1e300;
  for (const Observation& observation : history) {
    if (!observation.failed) lowest = std::min(lowest, observation.responses[0]);
  }
  return lowest;
}

}  // namespace powdercal

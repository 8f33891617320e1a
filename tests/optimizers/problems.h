#pragma once

#include <fmt/format.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "optimizers/optimizer.h"

namespace powdercal {

/// A box of `dimension` pure numbers x0, x1, … in [0, 1].
inline SearchSpace UnitBox(int dimension) {
  SearchSpace space;
  for (int k = 0; k < dimension; ++k) {
    const std::string name = fmt::format("x{}", k);
    space.parameters.push_back({.name = name, .symbol = name, .unit = "1"});
  }
  return space;
}

/// The paper's two parameters.
inline SearchSpace HastelloySpace() {
  SearchSpace space;
  space.parameters.push_back({.name = "cohesion_energy_density",
                              .symbol = "k",
                              .unit = "J/m3",
                              .lower = 1e2,
                              .upper = 1e5});
  space.parameters.push_back(
      {.name = "rolling_friction", .symbol = "mu_r", .unit = "1", .lower = 0.05, .upper = 0.7});
  return space;
}

/// Joint objectives with these target values and one standard deviation.
inline Objectives JointTargets(const std::vector<double>& values, double sd) {
  Objectives objectives;
  for (const double value : values) {
    objectives.targets.push_back({.response = fmt::format("response{}", objectives.targets.size()),
                                  .unit = "1",
                                  .value = value,
                                  .sd = sd});
  }
  return objectives;
}

using Responses = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

inline Observation Succeeded(const Candidate& candidate, const Eigen::VectorXd& responses) {
  return {.id = candidate.id,
          .point = candidate.point,
          .responses = responses,
          .variances = Eigen::VectorXd::Zero(responses.size())};
}

inline Observation Failed(const Candidate& candidate) {
  return {.id = candidate.id, .point = candidate.point, .failed = true, .failure = "unstable"};
}

/// Asks and tells one at a time; an empty vector of responses is a failure.
inline std::vector<Observation> RunSerially(Optimizer* optimizer, const Responses& responses,
                                            int evaluations) {
  std::vector<Observation> history;
  while (static_cast<int>(history.size()) < evaluations) {
    const std::vector<Candidate> candidates = optimizer->Ask(1);
    if (candidates.empty()) break;
    const Eigen::VectorXd values = responses(candidates[0].point);
    history.push_back(values.size() > 0 ? Succeeded(candidates[0], values) : Failed(candidates[0]));
    optimizer->Tell(std::span(&history.back(), 1));
  }
  return history;
}

}  // namespace powdercal

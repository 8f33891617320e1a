#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
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

inline const double kNaN = std::numeric_limits<double>::quiet_NaN();

inline Eigen::VectorXd Scalar(double value) { return Eigen::VectorXd::Constant(1, value); }

/// Two responses that determine a point: (0.3, 0.6) gives (0.48, 0.51).
inline Eigen::VectorXd TwoResponses(const Eigen::VectorXd& x) {
  return Eigen::Vector2d(x[0] + 0.5 * x[1] * x[1], x[1] - 0.3 * x[0]);
}
inline const Objectives kTwo = JointTargets({0.48, 0.51}, 0.01);
inline const Eigen::Vector2d kTwoAnswer(0.3, 0.6);

/// Between any two of the points; 1e300 of fewer than two.
inline double SmallestDistance(const std::vector<Eigen::VectorXd>& points) {
  double smallest = 1e300;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      smallest = std::min(smallest, (points[i] - points[j]).norm());
    }
  }
  return smallest;
}
inline double SmallestDistance(const std::vector<Observation>& history) {
  std::vector<Eigen::VectorXd> points;
  for (const Observation& observation : history) points.push_back(observation.point);
  return SmallestDistance(points);
}

}  // namespace powdercal

#pragma once

#include <cmath>
#include <numbers>

#include "optimizers/optimizer.h"

namespace powdercal {

/// Concentrations after two spills into a channel (Bliznyuk, Ruppert, Shoemaker, Regis, Wild &
/// Mugunthan 2008, as posed by Astudillo & Frazier 2019): mass M, diffusion D, place L and time τ
/// of the second spill are to be found from 12 concentrations. Everything is a pure number.
inline SearchSpace EnvironmentalSpace() {
  SearchSpace space;
  const auto add = [&](const char* name, double lower, double upper) {
    space.parameters.push_back(
        {.name = name, .symbol = name, .unit = "1", .lower = lower, .upper = upper});
  };
  add("M", 7, 13);
  add("D", 0.02, 0.12);
  add("L", 0.01, 3);
  add("tau", 30.01, 30.295);
  return space;
}

inline Eigen::VectorXd EnvironmentalResponses(const Eigen::VectorXd& values) {
  const double mass = values[0];
  const double diffusion = values[1];
  const double place = values[2];
  const double time = values[3];
  const auto spill = [&](double distance, double age) {
    if (age <= 0) return 0.0;
    const double spread = 4 * diffusion * age;
    return mass / std::sqrt(std::numbers::pi * spread) * std::exp(-distance * distance / spread);
  };
  Eigen::VectorXd responses(12);
  Eigen::Index i = 0;
  for (const double s : {0.0, 1.0, 2.5}) {
    for (const double t : {15.0, 30.0, 45.0, 60.0}) {
      responses[i++] = spill(s, t) + spill(s - place, t - time);
    }
  }
  return responses;
}

inline Eigen::VectorXd EnvironmentalTruth() { return Eigen::Vector4d(10, 0.07, 1.505, 30.1525); }

inline Objectives EnvironmentalObjectives(double sd) {
  Objectives objectives;
  for (const double value : EnvironmentalResponses(EnvironmentalTruth())) {
    objectives.targets.push_back(
        {.response = "concentration" + std::to_string(objectives.targets.size()),
         .unit = "1",
         .value = value,
         .sd = sd});
  }
  return objectives;
}

}  // namespace powdercal

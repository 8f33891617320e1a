#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace powdercal {

/// An evaluated point.
struct Individual {
  std::int64_t id = 0;     ///< Candidate::id; negative: told without having been asked for
  Eigen::VectorXd point;   ///< in the unit box, as it was evaluated
  Eigen::VectorXd values;  ///< of the objectives, to be minimised; NaN where an evaluation failed

  bool Complete() const { return values.allFinite(); }
};

/// One objective: complete before failed, then by value. Failed ones are equal to each other.
bool Better(const Individual& a, const Individual& b);

/// Indices from best to worst; equals stay in their order. One objective: by Better. Several: front
/// by front, within a front by descending crowding distance (Deb et al. 2002, section III); failed
/// individuals last.
std::vector<std::size_t> Ranking(std::span<const Individual> individuals);

/// The first `count` of the ranking, in its order; all if there are fewer.
std::vector<Individual> SelectBest(std::span<const Individual> individuals, std::size_t count);

}  // namespace powdercal

#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/random.h"
#include "optimizers/metaheuristics/individual.h"
#include "optimizers/optimizer.h"

namespace powdercal {

/// What a strategy searches.
struct SearchProblem {
  SearchSpace space;
  int objectives = 1;
  int population = 0;
  RandomStream random{0};

  int dimension() const { return space.dimension(); }
};

/// A search that goes on in batches, mostly generations. Life: Begin → {Propose → Learn}* until
/// Propose gives nothing. All randomness comes from the SearchProblem's stream.
class Strategy {
 public:
  virtual ~Strategy() = default;

  /// SearchProblem::population evaluated points, the best first (Ranking); one at least is
  /// complete.
  virtual void Begin(std::vector<Individual> population) = 0;
  /// The points of the next batch, in the unit box; discrete entries need not be snapped. Empty:
  /// the search has ended, see Message().
  virtual std::vector<Eigen::VectorXd> Propose() = 0;
  /// What came of them, in the order of Propose.
  virtual void Learn(std::span<const Individual> generation) = 0;
  /// A member of an earlier batch has new values, from more replicates.
  virtual void Revise(const Individual&) {}
  /// For people: why the search ended, or what it is doing ("run 2").
  virtual std::string Message() const { return ""; }
};

/// Of strategies that hold a population: takes over the new values.
inline void ReviseMembers(std::vector<Individual>& population, const Individual& revised) {
  for (Individual& member : population) {
    if (member.id == revised.id) member.values = revised.values;
  }
}

}  // namespace powdercal

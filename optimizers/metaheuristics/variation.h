#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "core/archive.h"
#include "core/random.h"
#include "optimizers/optimizer.h"

namespace powdercal {

/// Parameters of crossover and mutation.
struct VariationOptions {
  double crossover = 0.9;       ///< probability that two parents are crossed at all, 0 … 1
  double crossover_index = 15;  ///< η_c, 1 … 100: the larger, the closer are children to parents
  double mutation = 0;          ///< probability for each parameter, 0 … 1; 0: 1/dimension
  double mutation_index = 20;   ///< η_m, 1 … 100: the larger, the smaller are the steps

  /// Throws InputError.
  void Serialize(Archive& archive);
};

/// How often a child that equals a known point is changed once more.
inline constexpr int kTriesForANewPoint = 10;

/// Crossover and mutation in the unit box. Continuous parameters: simulated binary crossover (Deb &
/// Agrawal 1995), each parameter with probability ½, and polynomial mutation (Deb & Goyal 1996),
/// both in their bounded form, which does not leave the box. Discrete ones: a child has the level
/// of either parent; a mutated integer goes one level up or down, or, as often, to any other; a
/// mutated category becomes any other.
class Variation {
 public:
  Variation(const VariationOptions& options, const SearchSpace& space);

  /// Both children; copies of the parents where these are not crossed.
  std::pair<Eigen::VectorXd, Eigen::VectorXd> Cross(const Eigen::VectorXd& a,
                                                    const Eigen::VectorXd& b,
                                                    RandomStream* random) const;
  void Mutate(Eigen::VectorXd* point, RandomStream* random) const;
  /// Mutates one parameter, chosen at random, whatever the probability.
  void MutateOne(Eigen::VectorXd* point, RandomStream* random) const;

 private:
  double Mutated(Eigen::Index k, double x, RandomStream* random) const;

  VariationOptions options_;
  SearchSpace space_;
};

}  // namespace powdercal

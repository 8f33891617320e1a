#include "optimizers/metaheuristics/differential_evolution.h"

#include <gtest/gtest.h>

#include "tests/optimizers/metaheuristics.h"

namespace powdercal {
namespace {

Eigen::VectorXd Rosenbrock(const Eigen::VectorXd& x) {
  double sum = 0;
  for (Eigen::Index i = 0; i + 1 < x.size(); ++i) {
    const double a = 4 * x[i] - 2;
    const double b = 4 * x[i + 1] - 2;
    sum += 100 * (b - a * a) * (b - a * a) + (1 - a) * (1 - a);
  }
  return Eigen::VectorXd::Constant(1, sum);
}

TEST(DifferentialEvolutionTest, FollowsACurvedValley) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto optimizer =
        MakeFrom("differential_evolution", "population: 24", UnitBox(4), Minimised(1), seed);
    EXPECT_LT(LowestFirst(RunInBatches(optimizer.get(), Rosenbrock, 6000)), 1e-6) << seed;
  }
}

TEST(DifferentialEvolutionTest, ATrialDiffersFromItsMemberAndStaysInTheBox) {
  const auto optimizer =
      MakeFrom("differential_evolution", "population: 10", UnitBox(3), Minimised(1), 1);
  const auto history = RunInBatches(optimizer.get(), Rosenbrock, 20);
  const std::span first(history.data(), 10);
  std::vector<std::size_t> order(10);
  for (std::size_t i = 0; i < 10; ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return first[a].responses[0] < first[b].responses[0];
  });
  // Trials come in the order of the members, the best first.
  for (std::size_t i = 0; i < 10; ++i) {
    const Eigen::VectorXd& trial = history[10 + i].point;
    EXPECT_GT((trial - first[order[i]].point).norm(), 0);
    EXPECT_GE(trial.minCoeff(), 0);
    EXPECT_LE(trial.maxCoeff(), 1);
  }
}

}  // namespace
}  // namespace powdercal

#include "optimizers/metaheuristics/genetic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/optimizers/metaheuristics.h"

namespace powdercal {
namespace {

// A real, an integer and a categorical parameter.
SearchSpace MixedSpace() {
  SearchSpace space = UnitBox(3);
  space.parameters[1] = {.name = "n", .lower = 0, .upper = 10, .kind = Parameter::Kind::integer};
  space.parameters[2] = {.name = "law",
                         .upper = 3,
                         .kind = Parameter::Kind::categorical,
                         .categories = {"a", "b", "c", "d"}};
  return space;
}

TEST(GeneticTest, SolvesAMixedProblem) {
  const SearchSpace space = MixedSpace();
  const auto responses = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    const Eigen::VectorXd values = space.FromUnit(x);
    return Eigen::VectorXd::Constant(
        1, std::abs(values[0] - 0.25) + std::abs(values[1] - 8) / 10 + (values[2] == 2 ? 0 : 1));
  };
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto optimizer = MakeFrom("genetic", "{}", space, Minimised(1), seed);
    EXPECT_LT(LowestFirst(RunInBatches(optimizer.get(), responses, 400)), 0.01) << seed;
  }
}

TEST(GeneticTest, SeesRanksOnly) {
  const auto responses = [](double power) {
    return [power](const Eigen::VectorXd& x) -> Eigen::VectorXd {
      return Eigen::VectorXd::Constant(1, std::pow((x.array() - 0.4).square().sum(), power));
    };
  };
  const auto plain = MakeFrom("genetic", "{}", UnitBox(3), Minimised(1), 4);
  const auto bent = MakeFrom("genetic", "{}", UnitBox(3), Minimised(1), 4);
  const auto points = RunInBatches(plain.get(), responses(1), 200);
  const auto same = RunInBatches(bent.get(), responses(0.5), 200);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(points[i].point, same[i].point);
}

// 44 different points in all.
TEST(GeneticTest, AsksForFewPointsTwice) {
  SearchSpace space = MixedSpace();
  space.parameters.erase(space.parameters.begin());
  const auto optimizer = MakeFrom("genetic", "population: 8", space, Minimised(1), 2);
  const auto responses = [](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return Eigen::VectorXd::Constant(1, x.sum());
  };
  const auto history = RunInBatches(optimizer.get(), responses, 40);
  for (std::size_t begin = 8; begin < history.size(); begin += 8) {
    std::set<std::pair<double, double>> children;
    for (std::size_t i = begin; i < begin + 8; ++i) {
      children.emplace(history[i].point[0], history[i].point[1]);
    }
    EXPECT_EQ(children.size(), 8) << "generation from " << begin;
  }
}

TEST(GeneticTest, TheBestIsNeverLost) {
  const auto optimizer = MakeFrom("genetic", "{population: 8, crossover: 0, mutation: 1e-9}",
                                  UnitBox(2), Minimised(1), 1);
  // Children are members with one parameter changed: they stay close to the best in one of two.
  const auto responses = [](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return Eigen::VectorXd::Constant(1, (x.array() - 0.6).square().sum());
  };
  const auto history = RunInBatches(optimizer.get(), responses, 400);
  const auto best = std::min_element(
      history.begin(), history.end(),
      [](const Observation& a, const Observation& b) { return a.responses[0] < b.responses[0]; });
  int related = 0;
  for (std::size_t i = history.size() - 8; i < history.size(); ++i) {
    related += (history[i].point - best->point).cwiseAbs().minCoeff() < 0.05;
  }
  EXPECT_EQ(related, 8);
}

}  // namespace
}  // namespace powdercal

#include "optimizers/metaheuristics/individual.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/optimizers/problems.h"

namespace powdercal {
namespace {

using testing::ElementsAre;

std::vector<Individual> WithValues(const std::vector<std::vector<double>>& values) {
  std::vector<Individual> individuals;
  for (const std::vector<double>& of_one : values) {
    individuals.push_back({.id = static_cast<std::int64_t>(individuals.size()),
                           .point = Eigen::VectorXd::Zero(1),
                           .values = Eigen::Map<const Eigen::VectorXd>(
                               of_one.data(), static_cast<Eigen::Index>(of_one.size()))});
  }
  return individuals;
}

TEST(IndividualTest, FailuresRankBelowAllValuesAndAreEqual) {
  const std::vector<Individual> all = WithValues({{kNaN}, {3}, {1e300}, {-2}, {kNaN}, {3}});
  EXPECT_THAT(Ranking(all), ElementsAre(3, 1, 5, 2, 0, 4));
  EXPECT_TRUE(Better(all[2], all[0]));
  EXPECT_FALSE(Better(all[0], all[2]));
  EXPECT_FALSE(Better(all[0], all[4]));
  EXPECT_FALSE(Better(all[1], all[5]));
}

TEST(IndividualTest, FrontsComeInOrderTheLeastCrowdedFirst) {
  // First front (0, 10), (1, 4), (2, 3), (10, 0): relative to its extents of 10 and 10 the gaps of
  // the inner two are 0.2 + 0.7 and 0.9 + 0.4. (5, 5) is dominated by both, (6, 6) by that one too.
  const std::vector<Individual> all =
      WithValues({{6, 6}, {1, 4}, {0, kNaN}, {2, 3}, {0, 10}, {5, 5}, {10, 0}});
  EXPECT_THAT(Ranking(all), ElementsAre(4, 6, 3, 1, 5, 0, 2));
}

TEST(IndividualTest, SelectsTheBest) {
  const std::vector<Individual> best = SelectBest(WithValues({{5}, {kNaN}, {1}, {2}}), 2);
  ASSERT_EQ(best.size(), 2);
  EXPECT_EQ(best[0].id, 2);
  EXPECT_EQ(best[1].id, 3);
  EXPECT_EQ(SelectBest(WithValues({{5}, {kNaN}}), 7).size(), 2);
}

}  // namespace
}  // namespace powdercal

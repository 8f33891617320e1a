#include "studies/ranking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/random.h"

namespace powdercal {
namespace {

struct Sample {
  SearchSpace space;
  Objectives objectives;
  std::vector<Eigen::VectorXd> points;
  std::vector<ReducedResponses> reduced;
};

// A line of points, response = coordinate, target 0.3; noise of sd 0.1, one replicate but for the
// last point, which has three.
Sample NoisyLine(int count, bool replicated) {
  Sample sample;
  sample.space.parameters = {{.name = "x", .symbol = "x", .unit = "1"}};
  sample.objectives.targets = {{.response = "y", .unit = "1", .value = 0.3, .sd = 0.1}};
  RandomStream random(8);
  for (int i = 0; i < count; ++i) {
    const double x = (i + 0.5) / count;
    sample.points.push_back(Eigen::VectorXd::Constant(1, x));
    ReducedResponses reduced{Eigen::VectorXd::Constant(1, x + 0.1 * random.Normal()),
                             Eigen::VectorXd::Constant(1, NAN), Eigen::VectorXi::Ones(1)};
    if (replicated && i + 1 == count) {
      reduced.counts[0] = 3;
      reduced.sample_variances[0] = 0.01;
    }
    sample.reduced.push_back(reduced);
  }
  return sample;
}

std::size_t Best(const std::vector<double>& misfits) {
  return static_cast<std::size_t>(std::min_element(misfits.begin(), misfits.end()) -
                                  misfits.begin());
}

TEST(RankingTest, ALuckyPointDoesNotWin) {
  Sample sample = NoisyLine(12, true);
  sample.reduced[10].means[0] = 0.3;  // far from where the others put it
  const Eigen::VectorXd pooled = PooledSeedVariance(sample.reduced, 1);
  std::vector<double> own;
  for (const auto& point : sample.reduced) {
    own.push_back(ExpectedMisfit(sample.objectives, point, pooled));
  }
  EXPECT_EQ(Best(own), 10U);
  const std::vector<double> misfits =
      RankingMisfits(sample.space, sample.objectives, sample.points, sample.reduced);
  const double x = sample.points[Best(misfits)][0];
  EXPECT_NEAR(x, 0.3, 0.13);
}

TEST(RankingTest, WithoutScatterOrWithFewPointsTheirOwnMeansDecide) {
  for (const Sample& sample : {NoisyLine(12, false), NoisyLine(5, true)}) {
    const Eigen::VectorXd pooled = PooledSeedVariance(sample.reduced, 1);
    const std::vector<double> misfits =
        RankingMisfits(sample.space, sample.objectives, sample.points, sample.reduced);
    for (std::size_t i = 0; i < misfits.size(); ++i) {
      EXPECT_EQ(misfits[i], ExpectedMisfit(sample.objectives, sample.reduced[i], pooled));
    }
  }
}

TEST(RankingTest, IncompletePointsAreNeverBest) {
  Sample sample = NoisyLine(12, true);
  sample.reduced[3].counts[0] = 0;
  sample.reduced[3].means[0] = NAN;
  const std::vector<double> misfits =
      RankingMisfits(sample.space, sample.objectives, sample.points, sample.reduced);
  EXPECT_TRUE(std::isinf(misfits[3]));
  EXPECT_NE(Best(misfits), 3U);
  EXPECT_TRUE(RankingMisfits(sample.space, sample.objectives, {}, {}).empty());
}

}  // namespace
}  // namespace powdercal

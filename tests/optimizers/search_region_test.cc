#include "optimizers/bayesian/search_region.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "optimizers/test_problems.h"
#include "tests/optimizers/problems.h"

namespace powdercal {
namespace {

// The best of an initial design, then proposals beside it with these values.
std::vector<SearchStep> Steps(int dimension, const std::vector<double>& values, double offset = 0) {
  std::vector<SearchStep> steps = {{Eigen::VectorXd::Constant(dimension, 0.5), 10, false}};
  for (const double value : values) {
    steps.push_back({Eigen::VectorXd::Constant(dimension, 0.5 + offset), value, true});
  }
  return steps;
}

TEST(TrustRegionTest, GrowsAndShrinks) {
  const Eigen::VectorXd even = Eigen::VectorXd::Ones(12);
  const auto length = [&](const std::vector<double>& values) {
    return FindTrustRegion(Steps(12, values), even).length;
  };
  EXPECT_EQ(length({}), 0.8);
  EXPECT_EQ(length({9, 8, 7}), 1.6);
  EXPECT_EQ(length(std::vector<double>(12, 11)), 0.4);
  EXPECT_EQ(length(std::vector<double>(12, std::numeric_limits<double>::infinity())), 0.4);
  // After seven halvings it is as small as it gets, and starts anew.
  EXPECT_EQ(length(std::vector<double>(12 * 7, 11)), 0.8);
}

TEST(TrustRegionTest, FollowsLengthscalesAndStaysInTheBox) {
  Eigen::VectorXd uneven = Eigen::VectorXd::Ones(12);
  uneven[0] = 4;
  const TrustRegion region = FindTrustRegion(Steps(12, std::vector<double>(24, 11)), uneven);
  const double geometric = std::pow(4.0, 1.0 / 12);
  EXPECT_NEAR(region.upper[1] - region.lower[1], 0.2 / geometric, 1e-12);
  EXPECT_NEAR(region.upper[0] - region.lower[0], 0.8 / geometric, 1e-12);
  uneven[0] = 1000;
  EXPECT_EQ(FindTrustRegion(Steps(12, {}), uneven).lower[0], 0);
}

TEST(CreepTest, IsFiveStepsBesideTheBestPoint) {
  EXPECT_FALSE(FindCreep({}));
  EXPECT_FALSE(FindCreep(Steps(2, {9, 8, 7, 6}, 1e-4)));
  EXPECT_TRUE(FindCreep(Steps(2, {9, 8, 7, 6, 5}, 1e-4)));
  std::vector<SearchStep> steps = Steps(2, {9, 8, 7, 6, 5}, 1e-4);
  steps[3].point[0] = 0.6;
  EXPECT_FALSE(FindCreep(steps));
}

// Seed 1 gets to the edge of the box at a poor place and would stay there for good.
TEST(CreepTest, TheSearchGoesElsewhere) {
  const TestProblem problem =
      MakeTestProblem("failures", POWDERCAL_SOURCE_DIR "/studies/library/hastelloy_x_table3.csv");
  const auto optimizer =
      MakeOptimizerFactory("bayesian")->Make(problem.space, problem.objectives, 1);
  const auto history = RunSerially(
      optimizer.get(),
      [&](const Eigen::VectorXd& point) { return problem.respond(problem.space.FromUnit(point)); },
      problem.evaluations);
  std::vector<Eigen::VectorXd> responses;
  for (const Observation& observation : history) {
    responses.push_back(observation.failed ? Eigen::VectorXd() : observation.responses);
  }
  EXPECT_LE(problem.measure(responses), problem.evaluations);
}

}  // namespace
}  // namespace powdercal

#include "optimizers/metaheuristics/moead.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/optimizers/metaheuristics.h"

namespace powdercal {
namespace {

TEST(SimplexWeightsTest, OfTwoObjectivesEvenlySpaced) {
  const std::vector<Eigen::VectorXd> weights = SimplexWeights(5, 2);
  ASSERT_EQ(weights.size(), 5);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(weights[static_cast<std::size_t>(i)], Eigen::Vector2d(i / 4.0, (4 - i) / 4.0));
  }
}

TEST(SimplexWeightsTest, OfThreeObjectivesALattice) {
  // H = 4: (4 + 2 choose 2) = 15 vectors of fourths.
  EXPECT_TRUE(IsLatticeSize(15, 3));
  EXPECT_FALSE(IsLatticeSize(16, 3));
  EXPECT_TRUE(IsLatticeSize(56, 4) && IsLatticeSize(36, 3) && IsLatticeSize(7, 2));
  std::set<std::vector<double>> distinct;
  for (const Eigen::VectorXd& w : SimplexWeights(15, 3)) {
    EXPECT_EQ(w.sum(), 1);
    EXPECT_EQ(4 * w, (4 * w).array().round().matrix());
    distinct.insert({w.begin(), w.end()});
  }
  EXPECT_EQ(distinct.size(), 15);
}

TEST(SimplexWeightsTest, OtherwiseCornersAndUniformPoints) {
  const std::vector<Eigen::VectorXd> weights = SimplexWeights(200, 3);
  ASSERT_EQ(weights.size(), 200);
  EXPECT_EQ(weights[1], Eigen::Vector3d(0, 1, 0));
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::VectorXd& w : weights) {
    EXPECT_NEAR(w.sum(), 1, 1e-12);
    EXPECT_GE(w.minCoeff(), 0);
    mean += w / 200;
  }
  EXPECT_LT((mean.array() - 1.0 / 3).abs().maxCoeff(), 0.03);
}

// Schaffer's two parabolas along a line, the other parameters to be brought to 1/2.
Responses Parabolas(double scale) {
  return [scale](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    const double off = (x.tail(x.size() - 1).array() - 0.5).square().sum();
    return Eigen::Vector2d(std::pow(x[0] - 0.2, 2) + off, scale * (std::pow(x[0] - 0.8, 2) + off));
  };
}

TEST(MoeadTest, CoversTheFrontFromEndToEnd) {
  const auto optimizer = MakeFrom("moead", "population: 20", UnitBox(4), Minimised(2), 1);
  const auto history = RunInBatches(optimizer.get(), Parabolas(1), 1200);
  // On the front √f0 + √f1 = 0.6.
  for (double wanted = 0.2; wanted <= 0.81; wanted += 0.05) {
    double nearest = 1;
    for (const Observation& o : history) {
      const double roots = std::sqrt(o.responses[0]) + std::sqrt(o.responses[1]);
      if (roots > 0.65) continue;
      nearest = std::min(nearest, std::abs(o.point[0] - wanted));
    }
    EXPECT_LT(nearest, 0.03) << wanted;
  }
}

TEST(MoeadTest, TheUnitsOfObjectivesMakeNoDifference) {
  const auto plain = MakeFrom("moead", "{}", UnitBox(3), Minimised(2), 2);
  const auto scaled = MakeFrom("moead", "{}", UnitBox(3), Minimised(2), 2);
  const auto points = RunInBatches(plain.get(), Parabolas(1), 400);
  const auto same = RunInBatches(scaled.get(), Parabolas(std::ldexp(1, 30)), 400);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(points[i].point, same[i].point);
}

TEST(MoeadTest, SearchesCategories) {
  SearchSpace space = UnitBox(3);
  space.parameters[2] = {.name = "law",
                         .upper = 3,
                         .kind = Parameter::Kind::categorical,
                         .categories = {"a", "b", "c", "d"}};
  const auto optimizer = MakeFrom("moead", "population: 20", space, Minimised(2), 1);
  const auto responses = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    const double off = space.FromUnit(x)[2] == 2 ? 0 : 1;
    return Parabolas(1)(x.head(2)).array() + off;
  };
  const auto history = RunInBatches(optimizer.get(), responses, 500);
  EXPECT_LT(LowestFirst(history), 0.01);
  int right = 0;
  for (std::size_t i = history.size() - 100; i < history.size(); ++i) {
    right += space.FromUnit(history[i].point)[2] == 2;
  }
  EXPECT_GT(right, 50);
}

// An objective that is missing in a part of the box.
TEST(MoeadTest, AMissingObjectiveIsAFailure) {
  const auto optimizer = MakeFrom("moead", "population: 20", UnitBox(3), Minimised(2), 1);
  const auto responses = [](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    Eigen::VectorXd values = Parabolas(1)(x);
    if (x[0] < 0.4) values[1] = std::nan("");
    return values;
  };
  const auto history = RunInBatches(optimizer.get(), responses, 800);
  const auto missing = [](const Observation& o) { return std::isnan(o.responses[1]); };
  EXPECT_LT(std::count_if(history.end() - 200, history.end(), missing), 60);
}

}  // namespace
}  // namespace powdercal

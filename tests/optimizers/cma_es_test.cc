#include "optimizers/metaheuristics/cma_es.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/optimizers/metaheuristics.h"

namespace powdercal {
namespace {

// Rotated ellipsoid of condition 10^4 about 0.4.
double Ellipsoid(const Eigen::VectorXd& x) {
  const Eigen::Index d = x.size();
  double sum = 0;
  for (Eigen::Index i = 0; i < d; ++i) {
    // Rows of the orthogonal discrete cosine transform.
    double along = 0;
    for (Eigen::Index k = 0; k < d; ++k) {
      const double scale = std::sqrt((i == 0 ? 1.0 : 2.0) / static_cast<double>(d));
      along += scale * (x[k] - 0.4) *
               std::cos(std::acos(-1.0) * static_cast<double>(i) * (static_cast<double>(k) + 0.5) /
                        static_cast<double>(d));
    }
    sum += std::pow(1e4, static_cast<double>(i) / static_cast<double>(d - 1)) * along * along;
  }
  return sum;
}

TEST(CmaEsTest, LearnsTheCovarianceOfAnEllipsoid) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto optimizer =
        MakeFrom("cma_es", "smallest_step: 1e-12", UnitBox(5), Minimised(1), seed);
    const auto history = RunInBatches(
        optimizer.get(), [](const Eigen::VectorXd& x) { return Scalar(Ellipsoid(x)); }, 2000);
    EXPECT_LT(LowestFirst(history), 1e-8) << seed;
  }
}

TEST(CmaEsTest, SeesRanksOnly) {
  const auto plain = MakeFrom("cma_es", "{}", UnitBox(3), Minimised(1), 4);
  const auto bent = MakeFrom("cma_es", "{}", UnitBox(3), Minimised(1), 4);
  const auto points = RunInBatches(
      plain.get(), [](const Eigen::VectorXd& x) { return Scalar(Ellipsoid(x)); }, 200);
  const auto same = RunInBatches(
      bent.get(), [](const Eigen::VectorXd& x) { return Scalar(std::cbrt(Ellipsoid(x)) - 7); },
      200);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(points[i].point, same[i].point);
}

TEST(CmaEsTest, FindsAnOptimumInACorner) {
  const auto optimizer = MakeFrom("cma_es", "{}", UnitBox(4), Minimised(1), 1);
  const auto history = RunInBatches(
      optimizer.get(),
      [](const Eigen::VectorXd& x) { return Scalar(x[0] - 2 * x[1] + 3 * x[2] - x[3]); }, 300);
  EXPECT_NEAR(LowestFirst(history), -3, 1e-3);
}

TEST(CmaEsTest, RestartsWithTwiceThePopulation) {
  const auto optimizer = MakeFrom("cma_es", "population: 6", UnitBox(2), Minimised(1), 1);
  std::map<std::string, std::size_t> sizes;  // of generations, by run
  for (int i = 0; i < 60; ++i) {
    const std::vector<Candidate> batch = optimizer->Ask(1000);
    const std::string& origin = batch[0].origin;
    sizes[origin.substr(origin.find(',') + 1)] = batch.size();
    std::vector<Observation> told;
    for (const Candidate& candidate : batch) told.push_back(Succeeded(candidate, Scalar(1)));
    optimizer->Tell(told);
  }
  EXPECT_EQ(sizes.at(" run 1"), 6);
  EXPECT_EQ(sizes.at(" run 2"), 12);
  EXPECT_EQ(sizes.at(" run 3"), 24);
}

TEST(CmaEsTest, RestartsWhereNothingSucceeds) {
  const auto optimizer =
      MakeFrom("cma_es", "{population: 6, initial_step: 0.01}", UnitBox(2), Minimised(1), 1);
  int evaluated = 0;
  RunInBatches(
      optimizer.get(),
      [&](const Eigen::VectorXd& x) { return evaluated++ < 6 ? Scalar(x[0]) : Eigen::VectorXd(); },
      12);
  EXPECT_THAT(optimizer->Ask(1)[0].origin, testing::HasSubstr("run 2"));
}

TEST(CmaEsTest, StaysWhereItHasSucceeded) {
  const auto optimizer =
      MakeFrom("cma_es", "{population: 6, initial_step: 0.01}", UnitBox(2), Minimised(1), 1);
  int evaluated = 0;
  const auto history = RunInBatches(
      optimizer.get(),
      [&](const Eigen::VectorXd& x) { return evaluated++ < 12 ? Scalar(x[0]) : Eigen::VectorXd(); },
      30);
  const std::vector<Candidate> next = optimizer->Ask(1);
  EXPECT_THAT(next[0].origin, testing::HasSubstr("run 1"));
  EXPECT_LT((next[0].point - history[8].point).norm(), 0.1);
}

TEST(CmaEsTest, DefaultPopulationIsHansensRoundedUpToEven) {
  const auto size = [](int dimension) {
    return MakeFrom("cma_es", "{}", UnitBox(dimension), Minimised(1), 1)->Ask(1000).size();
  };
  EXPECT_EQ(size(1), 6);
  EXPECT_EQ(size(2), 6);
  EXPECT_EQ(size(5), 8);
  EXPECT_EQ(size(6), 10);  // 9
  EXPECT_EQ(size(10), 10);
  EXPECT_EQ(size(30), 14);
}

}  // namespace
}  // namespace powdercal

#include "surrogates/nearest_neighbours.h"

#include <algorithm>
#include <numeric>

#include "tests/surrogates/regression_checks.h"

namespace powdercal {
namespace {

// By sorting all distances.
double BruteForce(const Observations& data, const Eigen::Vector2d& at, int k, int power,
                  int left_out = -1) {
  std::vector<int> order;
  for (int i = 0; i < data.values.size(); ++i) {
    if (i != left_out) order.push_back(i);
  }
  const auto distance = [&](int i) { return (data.points.row(i).transpose() - at).norm(); };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return distance(a) < distance(b); });
  double sum = 0;
  double weights = 0;
  for (int i = 0; i < k; ++i) {
    const double weight = std::pow(distance(order[static_cast<std::size_t>(i)]), -power);
    sum += weight * data.values[order[static_cast<std::size_t>(i)]];
    weights += weight;
  }
  return sum / weights;
}

TEST(NearestNeighboursTest, HasGoodManners) {
  ExpectGoodManners([] { return std::make_unique<NearestNeighbours>(); });
}

TEST(NearestNeighboursTest, ChoosesByLeaveOneOutAndPredictsAsBruteForceDoes) {
  const auto noisy = [](double u, double v) { return Wavy(u, v) + 0.3 * std::sin(500 * u * v); };
  const Observations data = Observe(noisy, 60);
  NearestNeighbours neighbours;
  neighbours.Fit(data.points, data.values, {});
  double least = std::numeric_limits<double>::infinity();
  int best_k = 0;
  int best_power = 0;
  for (int k = 1; k <= 10; ++k) {
    for (int power = 0; power <= 2; ++power) {
      double sum = 0;
      for (int i = 0; i < 60; ++i) {
        sum += std::pow(
            BruteForce(data, data.points.row(i).transpose(), k, power, i) - data.values[i], 2);
      }
      if (sum >= least) continue;
      least = sum;
      best_k = k;
      best_power = power;
    }
  }
  EXPECT_EQ(neighbours.neighbours(), best_k);
  EXPECT_EQ(neighbours.power(), best_power);
  EXPECT_GT(best_k, 1);
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(0.2, 0.9), Eigen::Vector2d(0.71, 0.13)}) {
    EXPECT_NEAR(neighbours.Predict(at).mean, BruteForce(data, at, best_k, best_power), 1e-12);
  }
}

TEST(NearestNeighboursTest, RecoversASmoothFunction) {
  const Observations data = Observe(Wavy, 400);
  NearestNeighbours neighbours;
  neighbours.Fit(data.points, data.values, {});
  EXPECT_LT(ErrorOn(neighbours, Wavy), 0.1);  // of a standard deviation of about 1
}

TEST(NearestNeighboursTest, VarianceIsTheNeighboursSpread) {
  // Alternating values: the more neighbours, the nearer to the mean of the others.
  Observations data{Eigen::MatrixXd(6, 1), Eigen::VectorXd(6)};
  data.points << 0, 0.2, 0.4, 0.6, 0.8, 1;
  data.values << 0, 1, 0, 1, 0, 1;
  NearestNeighbours::Options options;
  options.max_neighbours = 2;
  options.max_power = 0;
  NearestNeighbours neighbours(options);
  neighbours.Fit(data.points, data.values, {});
  // One neighbour or two, from inside all are of the other kind; at the ends two are one of each.
  ASSERT_EQ(neighbours.neighbours(), 2);
  const Prediction prediction = neighbours.Predict(Eigen::VectorXd::Constant(1, 0.31));
  EXPECT_NEAR(prediction.mean, 0.5, 1e-12);
  EXPECT_NEAR(prediction.variance, 0.5, 1e-12);  // of 0 and 1, divisor 1
}

TEST(NearestNeighboursTest, WhereOneDecidesTheVarianceIsThatOfLeaveOneOut) {
  NearestNeighbours::Options options;
  options.max_neighbours = 1;
  NearestNeighbours neighbours(options);
  neighbours.Fit(Eigen::Vector3d(0, 0.4, 1), Eigen::Vector3d(1, 2, 5), {});
  // 1 from 2, 2 from 1, 5 from 2: (1 + 1 + 9)/3.
  EXPECT_NEAR(neighbours.Predict(Eigen::VectorXd::Constant(1, 0.1)).variance, 11.0 / 3, 1e-12);
  EXPECT_EQ(neighbours.Predict(Eigen::VectorXd::Constant(1, 0.1)).mean, 1);
}

TEST(NearestNeighboursTest, OnDuplicatesGivesTheirMean) {
  Observations data{Eigen::MatrixXd(4, 1), Eigen::VectorXd(4)};
  data.points << 0, 0.5, 0.5, 1;
  data.values << 0, 1, 3, 8;
  NearestNeighbours neighbours;
  neighbours.Fit(data.points, data.values, {});
  if (neighbours.power() > 0 && neighbours.neighbours() > 1) {
    EXPECT_NEAR(neighbours.Predict(Eigen::VectorXd::Constant(1, 0.5)).mean, 2, 1e-12);
  }
  EXPECT_TRUE(std::isfinite(neighbours.Predict(Eigen::VectorXd::Constant(1, 0.5)).mean));
}

}  // namespace
}  // namespace powdercal

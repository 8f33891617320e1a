#include "surrogates/fitting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <stdexcept>

namespace powdercal {
namespace {

TEST(FittingTest, StandardiseTakesMeanAndStandardDeviation) {
  const Standardisation standard = Standardise(Eigen::Vector3d(1, 2, 6));
  EXPECT_NEAR(standard.offset, 3, 1e-15);
  EXPECT_NEAR(standard.scale, std::sqrt(7.0), 1e-15);
  EXPECT_NEAR(standard.Apply(Eigen::Vector3d(1, 2, 6))[2], 3 / std::sqrt(7.0), 1e-15);
}

TEST(FittingTest, EqualValuesHaveNoScale) {
  EXPECT_EQ(Standardise(Eigen::Vector3d(0.1, 0.1, 0.1)).scale, 1);
  EXPECT_EQ(Standardise(Eigen::VectorXd::Zero(3)).scale, 1);
  EXPECT_EQ(Standardise(Eigen::VectorXd::Ones(1)).scale, 1);
  EXPECT_LT(Standardise(Eigen::Vector3d(1e-100, 2e-100, 3e-100)).scale, 1e-90);
}

TEST(FittingTest, RandomFoldsAreOfEqualSize) {
  RandomStream random(7);
  const std::vector<int> folds = RandomFolds(17, 5, random);
  std::vector<int> sizes(5, 0);
  for (const int fold : folds) ++sizes.at(static_cast<std::size_t>(fold));
  std::sort(sizes.begin(), sizes.end());
  EXPECT_EQ(sizes, (std::vector<int>{3, 3, 3, 4, 4}));
  EXPECT_NE(RandomFolds(17, 5, random), folds);
  RandomStream again(7);
  EXPECT_EQ(RandomFolds(17, 5, again), folds);
}

TEST(FittingTest, SelectionFoldsLeaveOneOutOfFew) {
  EXPECT_EQ(SelectionFolds(4, 10), (std::vector<int>{0, 1, 2, 3}));
  const std::vector<int> many = SelectionFolds(40, 10);
  EXPECT_EQ(std::set<int>(many.begin(), many.end()).size(), 10u);
  EXPECT_EQ(SelectionFolds(40, 10), many);
}

TEST(FittingTest, CrossValidatedErrorsByHand) {
  // Candidates: the mean of the others, and zero. Of 1, 2, 6 the others' means are 4, 3.5, 1.5.
  const CandidateFits fits = [](const Eigen::MatrixXd&, const Eigen::VectorXd& values,
                                const Eigen::MatrixXd& targets) -> Eigen::MatrixXd {
    Eigen::MatrixXd predictions(targets.rows(), 2);
    predictions.col(0).setConstant(values.mean());
    predictions.col(1).setZero();
    return predictions;
  };
  const Eigen::VectorXd errors =
      CrossValidatedErrors({0, 1, 2}, Eigen::Vector3d(0, 0.5, 1), Eigen::Vector3d(1, 2, 6), fits);
  ASSERT_EQ(errors.size(), 2);
  EXPECT_NEAR(errors[0], 31.5 / 3, 1e-12);
  EXPECT_NEAR(errors[1], 41.0 / 3, 1e-12);
}

TEST(FittingTest, RefusalsNameTheSurrogate) {
  try {
    CheckObservations("ridge", Eigen::MatrixXd::Zero(2, 1), Eigen::Vector3d(1, 2, 3), {});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "ridge: 2 points, 3 values, 0 noise variances");
  }
}

}  // namespace
}  // namespace powdercal

#include "optimizers/least_squares/identifiability.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace powdercal {
namespace {

const Eigen::ArrayXd kNoNoise = Eigen::ArrayXd::Zero(2);
const std::vector<std::string> kSymbols = {"k", "mu_r"};
const Eigen::Vector2d kInside(0.4, 0.6);

TEST(IdentifiabilityTest, NothingToSayOfAWellPosedProblem) {
  const Eigen::Matrix2d jacobian{{3, 1}, {1, 2}};
  const Identifiability found = Identify(kInside, jacobian, kNoNoise);
  EXPECT_TRUE(found.clear());
  EXPECT_EQ(Describe(found, kSymbols), "");
}

TEST(IdentifiabilityTest, DeadParametersAreNotCalledValleysAsWell) {
  const Eigen::Matrix2d jacobian{{3, 0.01}, {1, 0.02}};
  const Identifiability found = Identify(kInside, jacobian, kNoNoise);
  EXPECT_EQ(Describe(found, kSymbols), "dead parameter: no response changes with mu_r");
}

TEST(IdentifiabilityTest, AValleyIsTheNullSpace) {
  // Residuals depend on 4 k + 3 mu_r alone.
  const Eigen::MatrixXd jacobian{{4, 3}, {8, 6}, {-4, -3}};
  const Identifiability found = Identify(kInside, jacobian, kNoNoise);
  ASSERT_EQ(found.flat.size(), 1);
  EXPECT_NEAR(std::abs(found.flat[0].dot(Eigen::Vector2d(-0.6, 0.8))), 1, 1e-12);
  EXPECT_EQ(Describe(found, kSymbols),
            "flat valley: direction (k:-0.60, mu_r:+0.80) leaves chi² unchanged");
}

TEST(IdentifiabilityTest, FewerResponsesThanParametersLeaveAValley) {
  const Eigen::MatrixXd jacobian{{5, 5}};
  EXPECT_EQ(Identify(kInside, jacobian, kNoNoise).flat.size(), 1);
}

TEST(IdentifiabilityTest, WhatNoiseAloneWouldGiveCountsAsFlat) {
  const Eigen::Matrix2d jacobian{{3, 1}, {1, 2}};  // singular values 3.6 and 1.4
  EXPECT_TRUE(Identify(kInside, jacobian, Eigen::Array2d(0.5, 0.5)).clear());
  EXPECT_EQ(Identify(kInside, jacobian, Eigen::Array2d(1.2, 1.2)).flat.size(), 1);
  EXPECT_EQ(Identify(kInside, jacobian, Eigen::Array2d(0.1, 4)).dead, std::vector<Eigen::Index>{1});
}

TEST(IdentifiabilityTest, Bounds) {
  const Identifiability found =
      Identify(Eigen::Vector2d(0, 1), Eigen::Matrix2d::Identity(), kNoNoise);
  EXPECT_FALSE(found.clear());
  EXPECT_EQ(Describe(found, kSymbols), "k is at its lower bound; mu_r is at its upper bound");
}

}  // namespace
}  // namespace powdercal

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "studies/comparison/rank_statistics.h"

namespace powdercal::comparison {
namespace {

// Ranks of C4.5, C4.5+m, C4.5+cf and C4.5+m+cf on 14 data sets: Demšar (2006), table 6.
Eigen::MatrixXd DemsarRanks() {
  Eigen::MatrixXd ranks(14, 4);
  ranks << 4, 3, 2, 1,     //
      1, 2, 3, 4,          //
      4, 1, 2, 3,          //
      4, 1, 3, 2,          //
      4, 2, 3, 1,          //
      1, 2.5, 4, 2.5,      //
      3, 2, 4, 1,          //
      2.5, 2.5, 4, 1,      //
      4, 3, 2, 1,          //
      2.5, 2.5, 2.5, 2.5,  //
      4, 2.5, 1, 2.5,      //
      3, 2, 4, 1,          //
      4, 1, 2, 3,          //
      3, 1, 4, 2;
  return ranks;
}

TEST(Ranks, AreThoseOfDemsar) {
  // The ranks of ranks are the ranks.
  const Eigen::VectorXd mean = MeanRanks(DemsarRanks());
  EXPECT_NEAR(mean[0], 3.143, 5e-4);
  EXPECT_NEAR(mean[1], 2.000, 5e-4);
  EXPECT_NEAR(mean[2], 2.893, 5e-4);
  EXPECT_NEAR(mean[3], 1.964, 5e-4);
}

TEST(Friedman, IsThatOfDemsar) {
  const FriedmanTest test = TestMeanRanks(MeanRanks(DemsarRanks()), 14);
  EXPECT_NEAR(test.chi_squared, 9.28, 5e-3);
  EXPECT_NEAR(test.f, 3.69, 5e-3);
  // The critical value of F(3, 39) at 0.05 is 2.85, of chi²(3) 7.81: both reject.
  EXPECT_LT(test.f_p, 0.05);
  EXPECT_GT(test.f_p, 0.01);
  EXPECT_LT(test.chi_squared_p, 0.05);
}

TEST(Friedman, CorrectsForTies) {
  // Rank sums 44, 28, 40.5, 27.5; Σ ranks² − 14·4·25/4 = 10·5 + 3·4.5 + 0 = 63.5.
  const FriedmanTest test = TestFriedman(DemsarRanks());
  EXPECT_NEAR(test.chi_squared, 3 * 216.5 / 63.5, 1e-10);
}

TEST(Friedman, WithoutTiesIsTheSameFromRanksAndValues) {
  Eigen::MatrixXd values(4, 3);
  values << 0.1, 5, 7, 2, 1, 9, 3, 4, 5, 1, 2, 0.5;
  const FriedmanTest a = TestFriedman(values);
  const FriedmanTest b = TestMeanRanks(MeanRanks(values), 4);
  EXPECT_NEAR(a.chi_squared, b.chi_squared, 1e-12);
  EXPECT_NEAR(a.f_p, b.f_p, 1e-12);
}

TEST(Friedman, SaysNothingOfTiesAloneOrASingleBlock) {
  EXPECT_EQ(TestFriedman(Eigen::MatrixXd::Ones(5, 3)).chi_squared_p, 1);
  EXPECT_EQ(TestFriedman(Eigen::MatrixXd::Random(1, 3)).chi_squared_p, 1);
  EXPECT_EQ(TestFriedman(Eigen::MatrixXd::Random(3, 1)).chi_squared_p, 1);
}

TEST(Friedman, PerfectAgreementIsAsLikelyAsItIs) {
  Eigen::MatrixXd values(6, 3);
  for (Eigen::Index i = 0; i < 6; ++i) values.row(i) << 1, 2, 3;
  const FriedmanTest test = TestFriedman(values);
  EXPECT_NEAR(test.chi_squared, 12, 1e-12);  // N (k − 1)
  EXPECT_TRUE(std::isinf(test.f));
  EXPECT_NEAR(test.f_p, std::pow(6, -5), 1e-12);
  EXPECT_NEAR(TestFriedman(values.topLeftCorner(2, 2)).f_p, 0.5, 1e-12);  // a coin
}

TEST(Ranks, WhatWasNotFoundIsLastAndShared) {
  const double infinity = std::numeric_limits<double>::infinity();
  Eigen::MatrixXd values(1, 4);
  values << infinity, 3, std::nan(""), 1;
  const Eigen::VectorXd ranks = MeanRanks(values);
  EXPECT_EQ(ranks[0], 3.5);
  EXPECT_EQ(ranks[1], 2);
  EXPECT_EQ(ranks[2], 3.5);
  EXPECT_EQ(ranks[3], 1);
}

// Upper quantiles of the studentised range, infinite degrees of freedom, to the three decimals of
// the published tables (Harter 1960), and what Demšar (2006, table 5a) makes of them: over √2, and
// cut or rounded in the third.
struct Critical {
  int groups;
  double range_005;
  double range_010;
  double demsar_005;
  double demsar_010;
};
class Nemenyi : public ::testing::TestWithParam<Critical> {};

TEST_P(Nemenyi, QuantilesAreThoseOfTheTables) {
  const Critical& c = GetParam();
  EXPECT_NEAR(NormalRangeQuantile(0.95, c.groups), c.range_005, 6e-4);
  EXPECT_NEAR(NormalRangeQuantile(0.90, c.groups), c.range_010, 6e-4);
  EXPECT_NEAR(NormalRangeQuantile(0.95, c.groups) / std::sqrt(2.0), c.demsar_005, 1e-3);
  EXPECT_NEAR(NormalRangeQuantile(0.90, c.groups) / std::sqrt(2.0), c.demsar_010, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Comparison, Nemenyi,
                         ::testing::Values(Critical{2, 2.772, 2.326, 1.960, 1.645},
                                           Critical{3, 3.314, 2.902, 2.343, 2.052},
                                           Critical{4, 3.633, 3.240, 2.569, 2.291},
                                           Critical{5, 3.858, 3.478, 2.728, 2.459},
                                           Critical{6, 4.030, 3.661, 2.850, 2.589},
                                           Critical{7, 4.170, 3.808, 2.949, 2.693},
                                           Critical{8, 4.286, 3.931, 3.031, 2.780},
                                           Critical{9, 4.387, 4.037, 3.102, 2.855},
                                           Critical{10, 4.474, 4.129, 3.164, 2.920}));

TEST(NormalRange, OfTwoIsKnownInClosedForm) {
  // The difference of two standard normals: P(|Z₁ − Z₂| < q) = erf(q/2).
  for (const double q : {0.1, 1.0, 2.5, 5.0}) {
    EXPECT_NEAR(NormalRangeCdf(q, 2), std::erf(q / 2), 1e-12) << q;
  }
  EXPECT_EQ(NormalRangeCdf(0, 5), 0);
  EXPECT_EQ(NormalRangeCdf(-1, 5), 0);
}

TEST(NemenyiDifference, IsThatOfDemsar) {
  EXPECT_NEAR(NemenyiDifference(4, 14, 0.05), 1.25, 5e-3);
  EXPECT_NEAR(NemenyiDifference(4, 14, 0.10), 1.12, 5e-3);
}

}  // namespace
}  // namespace powdercal::comparison

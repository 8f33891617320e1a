#include "verification/equivalence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace powdercal::verification {
namespace {

std::vector<SeedPair> Pairs(const std::vector<double>& differences, double a = 10) {
  std::vector<SeedPair> pairs;
  for (const double d : differences) pairs.push_back({a, a + d});
  return pairs;
}

Verdict Judge(const std::vector<double>& differences, double margin, SeedStatistics& s,
              double level = 0.05) {
  return TestEquivalence(Pairs(differences), {margin, level}, &s);
}

// Differences 1, 2, 3: mean 2, standard deviation 1, standard error 1/√3. With two degrees of
// freedom Student's distribution is elementary: P(T < t) = 1/2 + t/(2 √(2 + t²)), and its quantile
// is t = c √2/√(1 − c²) with c = 2p − 1.
TEST(Equivalence, IsThatOfTheElementaryDistributionForThreeSeeds) {
  SeedStatistics s;
  const double margin = 6;
  EXPECT_EQ(Judge({1, 2, 3}, margin, s), Verdict::equivalent);
  const double c = 2 * 0.95 - 1;
  const double quantile = c * std::numbers::sqrt2 / std::sqrt(1 - c * c);
  EXPECT_NEAR(quantile, 2.919986, 1e-6);  // as in any table
  const double error = 1 / std::numbers::sqrt3;
  EXPECT_EQ(s.n, 3);
  EXPECT_DOUBLE_EQ(s.mean_a, 10);
  EXPECT_DOUBLE_EQ(s.mean_b, 12);
  EXPECT_DOUBLE_EQ(s.sd_difference, 1);
  EXPECT_NEAR(s.lower, 2 - quantile * error, 1e-12);
  EXPECT_NEAR(s.upper, 2 + quantile * error, 1e-12);
  const double t = (margin - 2) / error;  // of the test that is closer to failing
  EXPECT_NEAR(s.p, 0.5 - t / (2 * std::sqrt(2 + t * t)), 1e-12);
}

// Quantiles of Student's distribution at 0.95 from printed tables.
TEST(Equivalence, IntervalHasTheTabulatedQuantile) {
  struct Row {
    int n;
    double quantile;
  };
  for (const Row row :
       {Row{2, 6.314}, Row{5, 2.132}, Row{6, 2.015}, Row{11, 1.812}, Row{21, 1.725}}) {
    std::vector<double> differences;
    for (int i = 0; i < row.n; ++i) differences.push_back(i % 2 == 0 ? 0.5 : -0.3);
    SeedStatistics s;
    Judge(differences, 100, s);
    const double quantile =
        (s.upper - s.lower) / 2 / (s.sd_difference / std::sqrt(static_cast<double>(row.n)));
    EXPECT_NEAR(quantile, row.quantile, 5e-4) << row.n;
  }
}

TEST(Equivalence, VerdictFollowsTheInterval) {
  SeedStatistics s;
  const std::vector<double> differences = {1, 2, 3};  // interval 2 ± 1.686
  EXPECT_EQ(Judge(differences, 3.7, s), Verdict::equivalent);
  EXPECT_LT(s.p, 0.05);
  EXPECT_EQ(Judge(differences, 3.6, s), Verdict::undecided);
  EXPECT_GT(s.p, 0.05);
  EXPECT_EQ(Judge(differences, 0.32, s), Verdict::undecided);
  EXPECT_EQ(Judge(differences, 0.31, s), Verdict::different);
  EXPECT_EQ(Judge({-1, -2, -3}, 0.31, s), Verdict::different);
  EXPECT_EQ(Judge({-1, -2, -3}, 3.7, s), Verdict::equivalent);
}

TEST(Equivalence, NoSignificantDifferenceIsNotEnough) {
  SeedStatistics s;
  // The mean is zero, but nothing is known of it.
  EXPECT_EQ(Judge({-3, 3, -3, 3}, 1, s), Verdict::undecided);
  EXPECT_GT(s.seeds_needed, 4);
}

TEST(Equivalence, SeedsNeededWouldDecide) {
  SeedStatistics s;
  ASSERT_EQ(Judge({-3, 3, -3, 3}, 2, s), Verdict::undecided);
  // sd = 2 √3: the half width falls below 2 where t(0.95; n − 1) < √(n/3): 11 seeds, 1.812 < 1.915.
  EXPECT_EQ(s.seeds_needed, 11);
  // As large as the margin: no number would.
  ASSERT_EQ(Judge({0.5, 1.5}, 1, s), Verdict::undecided);
  EXPECT_EQ(s.seeds_needed, 0);
  // Beyond the margin: more seeds would show that.
  ASSERT_EQ(Judge({1, 3}, 1, s), Verdict::undecided);
  EXPECT_GT(s.seeds_needed, 2);
}

TEST(Equivalence, WithoutScatterTheMeanDecides) {
  SeedStatistics s;
  EXPECT_EQ(Judge({0, 0, 0}, 1e-9, s), Verdict::equivalent);
  EXPECT_EQ(s.p, 0);
  EXPECT_EQ(Judge({2, 2}, 1, s), Verdict::different);
  EXPECT_EQ(s.p, 1);
}

TEST(Equivalence, PairsDropWhatThePackingHasOfItsOwn) {
  SeedStatistics s;
  // Beds scatter by 1, backends differ by 0.01 in each.
  const std::vector<SeedPair> pairs = {{1, 1.010}, {2, 2.011}, {3, 3.009}, {0, 0.010}};
  EXPECT_EQ(TestEquivalence(pairs, {0.02, 0.05}, &s), Verdict::equivalent);
  EXPECT_GT(s.sd_a, 1);
}

TEST(Equivalence, FewerThanTwoPairsDecideNothing) {
  SeedStatistics s;
  EXPECT_EQ(TestEquivalence({}, {1, 0.05}, &s), Verdict::undecided);
  EXPECT_EQ(Judge({0}, 1, s), Verdict::undecided);
  EXPECT_EQ(s.seeds_needed, 2);
}

TEST(Equivalence, MarginHasToBePositive) {
  SeedStatistics s;
  EXPECT_THROW(Judge({1, 2}, 0, s), std::invalid_argument);
  EXPECT_THROW(Judge({1, 2}, std::nan(""), s), std::invalid_argument);
}

TEST(Overall, IsTheWorstOfWhatCounts) {
  const auto quantity = [](Verdict verdict, bool counts = true) {
    return Quantity{.verdict = verdict, .counts = counts};
  };
  const auto of = [](std::vector<Quantity> quantities) { return Overall(quantities); };
  EXPECT_EQ(of({quantity(Verdict::equivalent)}), Verdict::equivalent);
  EXPECT_EQ(of({quantity(Verdict::equivalent), quantity(Verdict::undecided)}), Verdict::undecided);
  EXPECT_EQ(of({quantity(Verdict::undecided), quantity(Verdict::different)}), Verdict::different);
  EXPECT_EQ(of({quantity(Verdict::equivalent), quantity(Verdict::different, false)}),
            Verdict::equivalent);
}

}  // namespace
}  // namespace powdercal::verification

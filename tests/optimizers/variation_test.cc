#include "optimizers/metaheuristics/variation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/optimizers/problems.h"

namespace powdercal {
namespace {

constexpr int kTrials = 20000;
constexpr double kFourErrors = 4 * 0.5 / 141;  // of a frequency over kTrials

SearchSpace LevelsSpace(Parameter::Kind kind, int levels) {
  SearchSpace space = UnitBox(1);
  space.parameters[0].kind = kind;
  space.parameters[0].upper = levels - 1;
  return space;
}

// Deb & Agrawal 1995: the spread factor β of children to parents has P(β ≤ b) = b^(η+1)/2 up to 1
// and 1 − b^−(η+1)/2 above.
TEST(VariationTest, CrossoverSpreadsChildrenAsPublished) {
  const Variation variation({.crossover = 1, .crossover_index = 2}, UnitBox(1));
  RandomStream random(1);
  int crossed = 0, below_09 = 0, below_1 = 0, below_15 = 0;
  for (int i = 0; i < kTrials; ++i) {
    const auto [one, other] = variation.Cross(Scalar(0.499), Scalar(0.501), &random);
    EXPECT_NEAR(one[0] + other[0], 1, 1e-6);
    const double beta = std::abs(one[0] - other[0]) / 0.002;
    if (std::abs(beta - 1) < 1e-9) continue;  // this parameter was left alone
    ++crossed;
    below_09 += beta < 0.9;
    below_1 += beta < 1;
    below_15 += beta < 1.5;
  }
  EXPECT_NEAR(crossed / double{kTrials}, 0.5, kFourErrors);
  const double error = 4 * 0.5 / std::sqrt(crossed);
  EXPECT_NEAR(below_09 / double(crossed), 0.5 * std::pow(0.9, 3), error);
  EXPECT_NEAR(below_1 / double(crossed), 0.5, error);
  EXPECT_NEAR(below_15 / double(crossed), 1 - 0.5 * std::pow(1.5, -3), error);
}

TEST(VariationTest, WithoutCrossoverChildrenAreTheirParents) {
  const Variation never({.crossover = 0}, UnitBox(2));
  const Variation always({.crossover = 1}, UnitBox(2));
  RandomStream random(2);
  const Eigen::Vector2d a(0.2, 0.7);
  const Eigen::Vector2d b(0.9, 0.1);
  EXPECT_EQ(never.Cross(a, b, &random).first, a);
  EXPECT_EQ(never.Cross(a, b, &random).second, b);
  EXPECT_EQ(always.Cross(a, a, &random).first, a);
}

// Of the middle of the box the lower half of steps has P(step ≤ δ) = ((1 + δ)^(η+1) − q)/2(1 − q)
// with q = (1/2)^(η+1), which is 0 at the bound.
TEST(VariationTest, MutationStepsAsPublished) {
  const Variation variation({.mutation = 1, .mutation_index = 20}, UnitBox(1));
  RandomStream random(3);
  int down = 0, far_down = 0, far_up = 0;
  for (int i = 0; i < kTrials; ++i) {
    Eigen::VectorXd point = Scalar(0.5);
    variation.Mutate(&point, &random);
    down += point[0] < 0.5;
    far_down += point[0] < 0.48;
    far_up += point[0] > 0.52;
  }
  const double q = std::pow(0.5, 21);
  const double expected = (std::pow(0.98, 21) - q) / (2 * (1 - q));
  EXPECT_NEAR(down / double{kTrials}, 0.5, kFourErrors);
  EXPECT_NEAR(far_down / double{kTrials}, expected, kFourErrors);
  EXPECT_NEAR(far_up / double{kTrials}, expected, kFourErrors);
}

TEST(VariationTest, NothingLeavesTheBox) {
  const Variation variation(
      {.crossover = 1, .crossover_index = 1, .mutation = 1, .mutation_index = 1}, UnitBox(3));
  RandomStream random(4);
  for (int i = 0; i < 2000; ++i) {
    auto [one, other] =
        variation.Cross(Eigen::Vector3d(0, 1, 0.01), Eigen::Vector3d(0.3, 0.98, 1), &random);
    for (Eigen::VectorXd* child : {&one, &other}) {
      variation.Mutate(child, &random);
      EXPECT_GE(child->minCoeff(), 0);
      EXPECT_LE(child->maxCoeff(), 1);
    }
  }
}

TEST(VariationTest, EachParameterMutatesWithProbabilityOneOverDimensionByDefault) {
  const Variation variation({}, UnitBox(5));
  RandomStream random(5);
  int mutated = 0;
  for (int i = 0; i < kTrials / 5; ++i) {
    Eigen::VectorXd point = Eigen::VectorXd::Constant(5, 0.3);
    variation.Mutate(&point, &random);
    mutated += static_cast<int>((point.array() != 0.3).count());
  }
  EXPECT_NEAR(mutated / double{kTrials}, 0.2, kFourErrors);
}

TEST(VariationTest, ACategoryBecomesAnyOtherAlike) {
  const SearchSpace space = LevelsSpace(Parameter::Kind::categorical, 4);
  const Variation variation({.mutation = 1}, space);
  RandomStream random(6);
  std::array<int, 4> counts{};
  for (int i = 0; i < kTrials; ++i) {
    Eigen::VectorXd point = Scalar(0.375);
    variation.Mutate(&point, &random);
    EXPECT_EQ(space.Snap(point), point);
    ++counts[static_cast<std::size_t>(space.FromUnit(point)[0])];
  }
  EXPECT_EQ(counts[1], 0);
  for (const std::size_t other : {0, 2, 3}) {
    EXPECT_NEAR(counts[other] / double{kTrials}, 1.0 / 3, kFourErrors);
  }
}

TEST(VariationTest, AnIntegerMostlyGoesOneStep) {
  const SearchSpace space = LevelsSpace(Parameter::Kind::integer, 11);
  const Variation variation({.mutation = 1}, space);
  RandomStream random(7);
  int up = 0, down = 0;
  for (int i = 0; i < kTrials; ++i) {
    Eigen::VectorXd point = Scalar(5.5 / 11);
    variation.Mutate(&point, &random);
    const double level = space.FromUnit(point)[0];
    EXPECT_NE(level, 5);
    up += level == 6;
    down += level == 4;
  }
  EXPECT_NEAR(up / double{kTrials}, 0.25 + 0.5 / 10, kFourErrors);
  EXPECT_NEAR(down / double{kTrials}, 0.25 + 0.5 / 10, kFourErrors);
}

TEST(VariationTest, ChildrenHaveTheLevelsOfTheirParents) {
  const Variation variation({.crossover = 1}, LevelsSpace(Parameter::Kind::categorical, 4));
  RandomStream random(8);
  int swapped = 0;
  for (int i = 0; i < kTrials; ++i) {
    const auto [one, other] = variation.Cross(Scalar(0.125), Scalar(0.875), &random);
    EXPECT_EQ(one[0] + other[0], 1);
    EXPECT_TRUE(one[0] == 0.125 || one[0] == 0.875);
    swapped += one[0] == 0.875;
  }
  EXPECT_NEAR(swapped / double{kTrials}, 0.5, kFourErrors);
}

TEST(VariationTest, MutateOneChangesOneParameter) {
  const Variation variation({}, UnitBox(4));
  RandomStream random(9);
  Eigen::VectorXd point = Eigen::VectorXd::Constant(4, 0.3);
  variation.MutateOne(&point, &random);
  EXPECT_EQ((point.array() != 0.3).count(), 1);
}

}  // namespace
}  // namespace powdercal

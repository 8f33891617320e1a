#include "optimizers/optimizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/optimizers/problems.h"

namespace powdercal {
namespace {

TEST(SearchSpaceTest, LinearAndLogarithmicScales) {
  SearchSpace space = HastelloySpace();
  EXPECT_NEAR(space.FromUnit(Eigen::Vector2d(0.5, 0.5))[0], 50050, 1e-9);
  space.parameters[0].logarithmic = true;
  const Eigen::VectorXd values = space.FromUnit(Eigen::Vector2d(1.0 / 3, 0.25));
  EXPECT_NEAR(values[0], 1e3, 1e-9);
  EXPECT_NEAR(values[1], 0.05 + 0.25 * 0.65, 1e-15);
  EXPECT_TRUE(space.ToUnit(values).isApprox(Eigen::Vector2d(1.0 / 3, 0.25), 1e-12));
}

TEST(SearchSpaceTest, EndsAreExactAndPointsOutsideAreClamped) {
  SearchSpace space = HastelloySpace();
  for (const bool logarithmic : {false, true}) {
    space.parameters[0].logarithmic = logarithmic;
    EXPECT_EQ(space.FromUnit(Eigen::Vector2d(0, 1)), Eigen::Vector2d(1e2, 0.7));
    EXPECT_EQ(space.FromUnit(Eigen::Vector2d(1, 0)), Eigen::Vector2d(1e5, 0.05));
    EXPECT_EQ(space.FromUnit(Eigen::Vector2d(1.2, -0.1)), Eigen::Vector2d(1e5, 0.05));
    EXPECT_EQ(space.ToUnit(Eigen::Vector2d(1e5, 0.05)), Eigen::Vector2d(1, 0));
    EXPECT_EQ(space.ToUnit(Eigen::Vector2d(2e5, 0)), Eigen::Vector2d(1, 0));
  }
}

TEST(SearchSpaceTest, RefusesTheWrongDimension) {
  EXPECT_THROW(HastelloySpace().FromUnit(Eigen::Vector3d::Zero()), std::invalid_argument);
  EXPECT_THROW(HastelloySpace().ToUnit(Eigen::Vector3d::Zero()), std::invalid_argument);
}

TEST(SearchSpaceTest, DiscreteParametersShareTheBoxEqually) {
  SearchSpace space = UnitBox(3);
  space.parameters[0] = {.name = "n", .lower = 2, .upper = 5, .kind = Parameter::Kind::integer};
  space.parameters[1] = {.name = "law",
                         .upper = 1,
                         .kind = Parameter::Kind::categorical,
                         .categories = {"cdt", "epsd2"}};
  EXPECT_TRUE(space.discrete());
  EXPECT_FALSE(UnitBox(2).discrete());
  EXPECT_EQ(space.FromUnit(Eigen::Vector3d(0, 0.49, 0.3)), Eigen::Vector3d(2, 0, 0.3));
  EXPECT_EQ(space.FromUnit(Eigen::Vector3d(1, 0.51, 0.3)), Eigen::Vector3d(5, 1, 0.3));
  EXPECT_EQ(space.ToUnit(Eigen::Vector3d(3, 1, 0.3)), Eigen::Vector3d(0.375, 0.75, 0.3));
  EXPECT_EQ(space.Snap(Eigen::Vector3d(0.3, 1.5, 0.3)), Eigen::Vector3d(0.375, 0.75, 0.3));
  const Eigen::VectorXd snapped = space.Snap(Eigen::Vector3d(0.9, 0.1, 0.7));
  EXPECT_EQ(space.Snap(snapped), snapped);
  for (const char* const name : {"sobol", "latin_hypercube", "random"}) {
    const auto optimizer = MakeOptimizerFactory(name)->Make(space, JointTargets({0}, 1), 3);
    EXPECT_TRUE(optimizer->capabilities().discrete);
    for (const Candidate& candidate : optimizer->Ask(5)) {
      EXPECT_EQ(space.Snap(candidate.point), candidate.point) << name;
    }
  }
}

TEST(ChiSquaredTest, AMinimisedTargetIsLinear) {
  Objectives objectives = JointTargets({1, 2}, 0.5);
  objectives.kind = Objectives::Kind::pareto;
  objectives.targets[1].objective = 1;
  objectives.targets[1].minimise = true;
  EXPECT_NEAR(ChiSquared(objectives, Eigen::Vector2d(2, -1), Eigen::Vector2d(0, 3), 1), -6, 1e-12);
  EXPECT_NEAR(ChiSquared(objectives, Eigen::Vector2d(2, -1), {}, 0), 4, 1e-12);
}

TEST(ChiSquaredTest, AddsUpWhatIsKnown) {
  Objectives objectives = JointTargets({1, 2, 3}, 0.5);
  objectives.targets[2].objective = 1;
  const Eigen::Vector3d responses(2, 2, 5);
  EXPECT_NEAR(ChiSquared(objectives, responses, {}), 4 + 16, 1e-12);
  EXPECT_NEAR(ChiSquared(objectives, responses, Eigen::Vector3d(0.75, 1, 0)), 1 + 16, 1e-12);
  EXPECT_NEAR(ChiSquared(objectives, responses, {}, 0), 4, 1e-12);
  EXPECT_NEAR(ChiSquared(objectives, responses, {}, 1), 16, 1e-12);
  const double nan = std::nan("");
  EXPECT_NEAR(ChiSquared(objectives, Eigen::Vector3d(nan, 2, 5), Eigen::Vector3d(0, 0, nan)), 16,
              1e-12);
  EXPECT_THROW(ChiSquared(objectives, Eigen::Vector2d(1, 2), {}), std::invalid_argument);
  EXPECT_THROW(ChiSquared(objectives, responses, Eigen::Vector2d(1, 2)), std::invalid_argument);
}

TEST(RegistryTest, EveryNameMakesAFactoryOfThatName) {
  EXPECT_THAT(
      std::vector<std::string>(OptimizerNames().begin(), OptimizerNames().end()),
      testing::ElementsAre("ant_colony", "bayesian", "cma_es", "corners_and_centre",
                           "differential_evolution", "genetic", "grid", "latin_hypercube",
                           "least_squares", "list", "moead", "nsga2", "nspso", "orthogonal_array",
                           "particle_swarm", "random", "sobol", "surrogate_lm"));
  for (const std::string& name : OptimizerNames()) {
    const std::unique_ptr<OptimizerFactory> factory = MakeOptimizerFactory(name);
    EXPECT_EQ(factory->name(), name);
    EXPECT_FALSE(factory->Describe().empty());
  }
}

TEST(RegistryTest, AnUnknownNameIsAnErrorWithTheNearestName) {
  try {
    MakeOptimizerFactory("baysian");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.details().suggestion, "bayesian");
  }
}

TEST(RandomSearchTest, FillsTheBoxAndDependsOnTheSeedAlone) {
  const std::unique_ptr<OptimizerFactory> factory = MakeOptimizerFactory("random");
  const Objectives objectives = JointTargets({0}, 1);
  const auto one_by_one = factory->Make(UnitBox(3), objectives, 7);
  const auto together = factory->Make(UnitBox(3), objectives, 7);
  const auto other = factory->Make(UnitBox(3), objectives, 8);
  const std::vector<Candidate> batch = together->Ask(400);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const std::vector<Candidate> single = one_by_one->Ask(1);
    ASSERT_EQ(single.size(), 1);
    EXPECT_EQ(single[0].id, static_cast<std::int64_t>(i));
    EXPECT_EQ(single[0].point, batch[i].point);
    EXPECT_GE(batch[i].point.minCoeff(), 0);
    EXPECT_LT(batch[i].point.maxCoeff(), 1);
    mean += batch[i].point / 400;
  }
  EXPECT_LT((mean.array() - 0.5).abs().maxCoeff(), 0.06);  // four standard errors
  EXPECT_NE(other->Ask(1)[0].point, batch[0].point);
  EXPECT_EQ(together->status().phase, Status::Phase::ready);
  EXPECT_EQ(together->ExplainUnsupported(UnitBox(3), objectives), "");
}

}  // namespace
}  // namespace powdercal

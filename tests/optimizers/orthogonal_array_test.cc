#include "optimizers/designs/orthogonal_array.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "core/errors.h"
#include "optimizers/designs/design.h"
#include "tests/optimizers/problems.h"

namespace powdercal {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class OrthogonalArrayTest : public testing::TestWithParam<int> {};

TEST_P(OrthogonalArrayTest, EveryPairOfColumnsHasEachPairOfLevelsOnce) {
  const int levels = GetParam();
  const Eigen::MatrixXi array = OrthogonalArray(levels);
  ASSERT_EQ(array.rows(), levels * levels);
  ASSERT_EQ(array.cols(), levels + 1);
  EXPECT_EQ(array.minCoeff(), 0);
  EXPECT_EQ(array.maxCoeff(), levels - 1);
  for (Eigen::Index a = 0; a < array.cols(); ++a) {
    for (Eigen::Index b = 0; b < a; ++b) {
      std::set<std::pair<int, int>> pairs;
      for (Eigen::Index i = 0; i < array.rows(); ++i) pairs.emplace(array(i, a), array(i, b));
      EXPECT_EQ(pairs.size(), static_cast<std::size_t>(levels * levels)) << a << " " << b;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Levels, OrthogonalArrayTest,
                         testing::ValuesIn(OrthogonalArrayLevels().begin(),
                                           OrthogonalArrayLevels().end()));

TEST(OrthogonalArrayTest, ThereIsOneForEachPrimeAndPowerOfOne) {
  EXPECT_THAT(std::vector<int>(OrthogonalArrayLevels().begin(), OrthogonalArrayLevels().end()),
              testing::ElementsAre(2, 3, 4, 5, 7, 8, 9, 11, 13, 16));
  for (const int levels : {-1, 0, 1, 6, 10, 12, 17}) {
    EXPECT_THROW(OrthogonalArray(levels), std::invalid_argument) << levels;
  }
}

// Levels are spread over each parameter's own scale: 1, 10, 100 of a logarithmic one.
TEST(OrthogonalDesignTest, HasTheEndsOfEveryRangeAndTheMiddleOfItsScale) {
  SearchSpace space = UnitBox(4);
  space.parameters[1].lower = 1;
  space.parameters[1].upper = 100;
  space.parameters[1].logarithmic = true;
  space.parameters[3] = {.name = "law",
                         .upper = 2,
                         .kind = Parameter::Kind::categorical,
                         .categories = {"a", "b", "c"}};
  const auto design = MakeDesign({.name = "orthogonal_array", .levels = 3}, space, 1);
  ASSERT_EQ(design.size(), 9);
  EXPECT_EQ(design[8].label, "point 9");
  std::map<double, int> linear;
  std::map<long, int> logarithmic;
  std::map<double, int> categories;
  for (const DesignPoint& point : design) {
    const Eigen::VectorXd values = space.FromUnit(point.point);
    ++linear[values[0]];
    ++logarithmic[std::lround(1e6 * values[1])];
    ++categories[values[3]];
  }
  EXPECT_EQ(linear, (std::map<double, int>{{0, 3}, {0.5, 3}, {1, 3}}));
  EXPECT_EQ(logarithmic, (std::map<long, int>{{1000000, 3}, {10000000, 3}, {100000000, 3}}));
  EXPECT_EQ(categories, (std::map<double, int>{{0, 3}, {1, 3}, {2, 3}}));
}

TEST(OrthogonalDesignTest, SaysWhichArrayIsPossible) {
  const auto explain = [](int levels, int dimension) {
    return DesignOptions{.name = "orthogonal_array", .levels = levels}.ExplainUnsupported(
        UnitBox(dimension));
  };
  EXPECT_EQ(explain(3, 4), "");
  EXPECT_EQ(explain(16, 17), "");
  EXPECT_THAT(explain(3, 5), AllOf(HasSubstr("at most 4 parameters and there are 5"),
                                   HasSubstr("`levels: 4`, which has 16 points")));
  EXPECT_THAT(explain(3, 7), HasSubstr("`levels: 7`"));
  EXPECT_THAT(explain(16, 18), AllOf(HasSubstr("at most 17"), HasSubstr("use sobol")));
  EXPECT_THAT(explain(6, 2), AllOf(HasSubstr("valid: 2, 3, 4, 5, 7"), HasSubstr("nearest has 5")));
  EXPECT_THAT(explain(100, 2), HasSubstr("nearest has 16"));
}

TEST(OrthogonalDesignTest, ReadsItsLevelsAndRefusesOthersWithTheirPlace) {
  const SearchSpace space = UnitBox(2);
  DesignOptions options;
  const auto read = [&](const std::string& text) {
    ReadYaml(text, "study.yaml",
             [&](Archive& archive) { options.SerializeSection(archive, "initial_design", space); });
  };
  read("initial_design: {name: orthogonal_array, levels: 5}\n");
  EXPECT_EQ(options.levels, 5);
  EXPECT_EQ(MakeDesign(options, space, 1).size(), 25);
  try {
    read("initial_design: {name: orthogonal_array, levels: 6}\n");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("study.yaml:1:"), HasSubstr("initial_design.levels"),
                                    HasSubstr("nearest has 5")));
  }
}

// Every design begins the search of every optimizer that takes one.
TEST(InitialDesignTest, AnyDesignBeginsAnyOptimizerThatTakesOne) {
  const SearchSpace space = UnitBox(2);
  for (const std::string& name : OptimizerNames()) {
    const auto factory = MakeOptimizerFactory(name);
    DesignOptions* const own = factory->initial_design();
    if (own == nullptr) continue;
    for (const std::string& design : DesignNames()) {
      *own = {.name = design, .list = {{0.1, 0.2}, {0.7, 0.4}, {0.3, 0.9}}};
      const std::vector<DesignPoint> points = MakeDesign(*own, space, 7);
      Objectives objectives = JointTargets({0.2, 0.4}, 0.1);
      if (!factory->Make(space, objectives, 7)->ExplainUnsupported(space, objectives).empty()) {
        objectives.kind = Objectives::Kind::pareto;
        objectives.targets[1].objective = 1;
      }
      const auto optimizer = factory->Make(space, objectives, 7);
      ASSERT_EQ(optimizer->ExplainUnsupported(space, objectives), "") << name << " " << design;
      const auto asked = optimizer->Ask(static_cast<int>(points.size()));
      ASSERT_EQ(asked.size(), points.size()) << name << " " << design;
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(asked[i].point, points[i].point) << name << " " << design;
        EXPECT_EQ(asked[i].origin, "initial design: " + points[i].label) << name << " " << design;
      }
    }
  }
}

}  // namespace
}  // namespace powdercal

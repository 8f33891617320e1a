#include "optimizers/optimizer_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/archive.h"
#include "tests/optimizers/problems.h"

namespace powdercal {
namespace {

std::string Written(OptimizerFactory& factory) {
  return WriteYaml([&](Archive& archive) { factory.Serialize(archive, HastelloySpace()); });
}

TEST(OptimizerTextTest, NamesOptionsAndDesign) {
  const DesignOptions design{.name = "latin_hypercube", .points = 9};
  const auto plain = ParseOptimizer("bayesian", HastelloySpace(), &design);
  EXPECT_THAT(Written(*plain), testing::HasSubstr("latin_hypercube"));
  const auto options = ParseOptimizer(
      "bayesian:acquisition=ei,jitter=0.2,initial_design.name=sobol,initial_design.points=7",
      HastelloySpace(), &design);
  EXPECT_THAT(Written(*options),
              testing::AllOf(testing::HasSubstr("acquisition: ei"),
                             testing::HasSubstr("jitter: 0.2"), testing::HasSubstr("points: 7")));
  EXPECT_EQ(ParseOptimizer("random", HastelloySpace(), &design)->name(), "random");
}

TEST(OptimizerTextTest, KnowsWhoBeginsWithADesign) {
  for (const char* const name : {"bayesian", "least_squares", "surrogate_lm", "cma_es", "nsga2"}) {
    EXPECT_NE(MakeOptimizerFactory(name)->initial_design(), nullptr) << name;
  }
  for (const char* const name : {"random", "sobol", "grid", "list"}) {
    EXPECT_EQ(MakeOptimizerFactory(name)->initial_design(), nullptr) << name;
  }
}

TEST(OptimizerTextTest, SaysWhatIsWrong) {
  const auto error = [](const std::string& text) {
    try {
      ParseOptimizer(text, HastelloySpace(), nullptr);
    } catch (const InputError& problem) {
      return std::string(problem.what());
    }
    return std::string();
  };
  EXPECT_THAT(error("baysian"), testing::HasSubstr("bayesian"));
  EXPECT_THAT(error("bayesian:acquisiton=ei"), testing::HasSubstr("acquisition"));
  EXPECT_THAT(error("bayesian:jitter"), testing::HasSubstr("KEY=VALUE"));
  EXPECT_THAT(error("bayesian:acquisition=eii"), testing::HasSubstr("ei"));
}

}  // namespace
}  // namespace powdercal

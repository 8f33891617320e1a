#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "optimizers/bayesian/bayesian.h"
#include "tests/optimizers/problems.h"

namespace powdercal {
namespace {

BayesianOptions Read(const std::string& text) {
  BayesianOptions options;
  ReadYaml(text, "study.yaml",
           [&](Archive& archive) { options.Serialize(archive, HastelloySpace()); });
  return options;
}

std::string ReadError(const std::string& text) {
  try {
    Read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(BayesianOptionsTest, Defaults) {
  const BayesianOptions options = Read("{}");
  EXPECT_EQ(options.acquisition, BayesianOptions::Acquisition::automatic);
  EXPECT_EQ(options.kernel, Kernel::matern52);
  EXPECT_EQ(options.initial_design.name, "sobol");
  EXPECT_TRUE(options.de_duplication);
}

TEST(BayesianOptionsTest, ReadsWhatItWrites) {
  const BayesianOptions options = Read(
      "acquisition: ei\n"
      "jitter: 0.05\n"
      "kernel: rbf\n"
      "initial_design: {name: latin_hypercube, points: 8}\n"
      "de_duplication: false\n");
  BayesianOptions copy = options;
  const BayesianOptions back =
      Read(WriteYaml([&](Archive& archive) { copy.Serialize(archive, HastelloySpace()); }));
  EXPECT_EQ(back.acquisition, BayesianOptions::Acquisition::ei);
  EXPECT_EQ(back.jitter, 0.05);
  EXPECT_EQ(back.kernel, Kernel::rbf);
  EXPECT_EQ(back.initial_design.name, "latin_hypercube");
  EXPECT_EQ(back.initial_design.points, 8);
  EXPECT_FALSE(back.de_duplication);
}

TEST(BayesianOptionsTest, DesignsByNameOnlyAndWithOptions) {
  EXPECT_EQ(Read("initial_design: corners_and_centre\n").initial_design.name, "corners_and_centre");
  EXPECT_EQ(Read("initial_design: {name: sobol, points: 12}\n").initial_design.points, 12);
  const BayesianOptions options = Read(
      "initial_design:\n"
      "  name: list\n"
      "  points:\n"
      "    - {cohesion_energy_density: 100 J/m3, rolling_friction: 0.05}\n");
  ASSERT_EQ(options.initial_design.list.size(), 1);
  EXPECT_EQ(options.initial_design.list[0], (std::vector<double>{100, 0.05}));
}

TEST(BayesianOptionsTest, MistakesAreErrorsWithTheirPlace) {
  using testing::HasSubstr;
  EXPECT_THAT(ReadError("kernal: rbf\n"),
              testing::AllOf(HasSubstr("study.yaml:1:1"), HasSubstr("did you mean 'kernel'?")));
  EXPECT_THAT(ReadError("acquisition: composit_log_ei\n"),
              HasSubstr("did you mean 'composite_log_ei'?"));
  EXPECT_THAT(ReadError("kernel: matern\n"), HasSubstr("valid: matern52, rbf"));
  EXPECT_THAT(ReadError("{acquisition: ei, jitter: -1}\n"),
              HasSubstr("jitter: must be at least 0"));
  EXPECT_THAT(ReadError("jitter: 0.1\n"), HasSubstr("only for `acquisition: ei`"));
  EXPECT_THAT(ReadError("initial_design: sobel\n"), HasSubstr("did you mean 'sobol'?"));
  EXPECT_THAT(ReadError("initial_design: {name: sobol, levels: 3}\n"),
              HasSubstr("initial_design: unknown key 'levels'"));
}

TEST(BayesianOptionsTest, SaysWhatItCannotTreat) {
  const Objectives joint = JointTargets({0, 1}, 1);
  const auto optimizer = MakeBayesian({}, UnitBox(2), joint, 1);
  EXPECT_EQ(optimizer->ExplainUnsupported(UnitBox(2), joint), "");
  Objectives pareto = joint;
  pareto.kind = Objectives::Kind::pareto;
  EXPECT_EQ(optimizer->ExplainUnsupported(UnitBox(2), pareto), "");  // all of one objective
  pareto.targets[1].objective = 1;
  EXPECT_EQ(optimizer->ExplainUnsupported(UnitBox(2), pareto), "");
  const auto ei =
      MakeBayesian({.acquisition = BayesianOptions::Acquisition::ei}, UnitBox(2), joint, 1);
  EXPECT_EQ(ei->ExplainUnsupported(UnitBox(2), joint), "");
  EXPECT_THAT(ei->ExplainUnsupported(UnitBox(2), pareto),
              testing::AllOf(testing::HasSubstr("several objectives"),
                             testing::HasSubstr("composite_log_ei")));
  EXPECT_THAT(optimizer->ExplainUnsupported(UnitBox(2), Objectives{}),
              testing::HasSubstr("no observed response"));
  EXPECT_THAT(optimizer->ExplainUnsupported(SearchSpace{}, joint),
              testing::HasSubstr("no parameter"));
  const BayesianOptions corners{.initial_design = {.name = "corners_and_centre"}};
  EXPECT_THAT(MakeBayesian(corners, UnitBox(11), joint, 1)->ExplainUnsupported(UnitBox(11), joint),
              testing::HasSubstr("use sobol"));
  EXPECT_TRUE(optimizer->capabilities().noise);
  EXPECT_TRUE(optimizer->capabilities().asynchronous);
  EXPECT_TRUE(optimizer->capabilities().failures);
  EXPECT_TRUE(optimizer->capabilities().pareto);
  EXPECT_FALSE(ei->capabilities().pareto);
}

}  // namespace
}  // namespace powdercal

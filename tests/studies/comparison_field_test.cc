#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "studies/comparison/field.h"
#include "tests/support/program.h"

namespace powdercal::comparison {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

Study Load(const Overrides& overrides = {}) {
  return Study::Load(LibraryStudy("quickstart").string(), overrides);
}

std::vector<std::string> LabelsOf(const Field& field) {
  std::vector<std::string> labels;
  for (const Contestant& one : field.contestants()) labels.push_back(one.label);
  return labels;
}

std::string Problem(const std::vector<std::string>& labels) {
  Study study = Load();
  try {
    const Field field(study, labels, 10);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Labels, KeepOptionsTogether) {
  EXPECT_THAT(SplitLabels("bayesian:acquisition=ei,jitter=0.1,random"),
              ElementsAre("bayesian:acquisition=ei,jitter=0.1", "random"));
  EXPECT_THAT(SplitLabels("random,bayesian:a=1,sobol:points=4"),
              ElementsAre("random", "bayesian:a=1", "sobol:points=4"));
  EXPECT_THAT(SplitLabels("x:list=[1,2],y"), ElementsAre("x:list=[1,2]", "y"));
  EXPECT_THAT(SplitLabels("random"), ElementsAre("random"));
}

TEST(Field, WithoutNamesHasEveryOptimizerThatCanTreatTheStudy) {
  Study study = Load();
  const Field field(study, {}, 20);
  EXPECT_THAT(LabelsOf(field), ::testing::IsSupersetOf({"bayesian", "random", "sobol"}));
  EXPECT_EQ(field.contestants().size() + field.refused().size(), OptimizerNames().size());
  // A list has no points unless somebody gives them.
  const auto list = std::find_if(field.refused().begin(), field.refused().end(),
                                 [](const Refusal& one) { return one.label == "list"; });
  ASSERT_NE(list, field.refused().end());
  EXPECT_THAT(list->reason, HasSubstr("points"));
}

TEST(Field, RefusesWhatCannotTreatTheStudyWithAlternatives) {
  Study study = Study::Load(LibraryStudy("hastelloy_x_joint").string(), {{"objective", "pareto"}});
  const Field field(study, {"bayesian:acquisition=ei", "random"}, 20);
  EXPECT_THAT(LabelsOf(field), ElementsAre("random"));
  ASSERT_EQ(field.refused().size(), 1U);
  EXPECT_EQ(field.refused()[0].label, "bayesian:acquisition=ei");
  EXPECT_THAT(field.refused()[0].reason, HasSubstr("composite_log_ei"));
}

TEST(Field, MistakesAreExplained) {
  EXPECT_THAT(Problem({"bayesain"}), HasSubstr("did you mean 'bayesian'?"));
  EXPECT_THAT(Problem({"bayesian:aquisition=ei"}), HasSubstr("acquisition"));
  EXPECT_THAT(Problem({"random", "random"}), HasSubstr("given twice"));
  EXPECT_THAT(Problem({"list"}), HasSubstr("points"));
}

TEST(Field, TheStudysOwnOptimizerHasItsOptions) {
  Study study = Load({{"optimizer.acquisition", "ei"}});
  const Field field(study, {"bayesian", "bayesian:kernel=rbf", "random"}, 20);
  EXPECT_TRUE(field.contestants()[0].study_options);
  EXPECT_THAT(field.contestants()[0].options, HasSubstr("acquisition: ei"));
  EXPECT_THAT(field.contestants()[0].options, Not(HasSubstr("initial_design")));
  EXPECT_FALSE(field.contestants()[1].study_options);
  EXPECT_THAT(field.contestants()[1].options, Not(HasSubstr("acquisition: ei")));
}

std::vector<Eigen::VectorXd> FirstPoints(const Field& field, std::size_t contestant, int seed) {
  const auto optimizer = field.Make(field.contestants()[contestant], seed);
  std::vector<Eigen::VectorXd> points;
  for (const Candidate& candidate : optimizer->Ask(5)) points.push_back(candidate.point);
  while (points.size() < 5) {
    for (const Candidate& candidate : optimizer->Ask(1)) points.push_back(candidate.point);
  }
  return points;
}

TEST(Field, AllBeginWithTheSameInitialDesign) {
  Study study = Load({{"optimizer.initial_design.name", "latin_hypercube"},
                      {"optimizer.initial_design.points", "5"}});
  const Field field(study, {"bayesian", "bayesian:acquisition=ei"}, 20);
  EXPECT_EQ(field.initial_design().name, "latin_hypercube");
  EXPECT_EQ(FirstPoints(field, 0, 3), FirstPoints(field, 1, 3));
  EXPECT_NE(FirstPoints(field, 0, 3), FirstPoints(field, 0, 4));
}

// Some optimizers name an initial design only where one is given.
TEST(Field, TheStudysOwnOptimizerBeginsWithTheCommonDesignToo) {
  Study study = Study::Parse(
      std::regex_replace(StudyText("quickstart"), std::regex("optimizer: .*"), "optimizer: cma_es"),
      "s.yaml", {});
  const Field field(study, {"cma_es", "bayesian"}, 20);
  EXPECT_TRUE(field.contestants()[0].study_options);
  EXPECT_EQ(field.initial_design().name, "sobol");
  EXPECT_EQ(FirstPoints(field, 0, 2), FirstPoints(field, 1, 2));
}

TEST(Field, ADesignOfItsOwnStaysWhereItIsNamed) {
  Study study = Load();
  const Field field(study, {"bayesian", "bayesian:initial_design=sobol"}, 20);
  EXPECT_TRUE(field.contestants()[0].initial_design);
  EXPECT_FALSE(field.contestants()[1].initial_design);
  EXPECT_NE(FirstPoints(field, 0, 1), FirstPoints(field, 1, 1));
}

TEST(Field, DesignsHaveTheBudgetsNumberOfPoints) {
  Study study = Load();
  const Field field(study, {"sobol", "grid", "latin_hypercube:points=3", "orthogonal_array"}, 17);
  EXPECT_EQ(field.Make(field.contestants()[0], 1)->Ask(100).size(), 17U);
  EXPECT_EQ(field.Make(field.contestants()[1], 1)->Ask(100).size(), 16U);  // 4 × 4
  EXPECT_EQ(field.Make(field.contestants()[2], 1)->Ask(100).size(), 3U);
  EXPECT_EQ(field.Make(field.contestants()[3], 1)->Ask(100).size(), 16U);  // 4 levels
  for (const Contestant& one : field.contestants()) EXPECT_TRUE(one.design);
}

}  // namespace
}  // namespace powdercal::comparison

#include "verification/forms.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "verification/laws.h"

namespace powdercal::verification {
namespace {

using ::testing::HasSubstr;

Program OfLaw(const std::string& name) {
  Program program;
  program.law = ShippedLaw(name).law;
  return program;
}

std::vector<std::string> Models(const std::vector<Form>& forms) {
  std::vector<std::string> models;
  for (const Form& form : forms) models.push_back(form.model);
  return models;
}

TEST(Forms, UpdatesAreTwoModelsWhereSpheresSlip) {
  EXPECT_THAT(Models(FormsOf(OfLaw("hertz_mindlin_history"))),
              ::testing::ElementsAre("displacement", "incremental"));
  EXPECT_THAT(Models(FormsOf(OfLaw("hertz_mindlin_history"), false)),
              ::testing::ElementsAre("", ""));
  EXPECT_THAT(Models(FormsOf(OfLaw("linear"))), ::testing::ElementsAre("", ""));
  EXPECT_THAT(Models(FormsOf(OfLaw("hertz_no_history"))), ::testing::ElementsAre(""));
}

TEST(Forms, TorsionIsAModelWhereSpheresTwist) {
  EXPECT_THAT(Models(FormsOf(OfLaw("paper"))), ::testing::ElementsAre("+torsion", "-torsion"));
  EXPECT_THAT(Models(FormsOf(OfLaw("paper"), true, false)), ::testing::ElementsAre("", ""));
}

TEST(Forms, BothTakeTheFirstThatBothHave) {
  const auto forms = FormsOf(OfLaw("hertz_mindlin_history"));
  const auto both = ChooseForms(forms, {"", ""}, {"", ""});
  ASSERT_TRUE(both);
  EXPECT_EQ(both->a, 0U);
  EXPECT_EQ(both->b, 0U);
  const auto second = ChooseForms(forms, {"", ""}, {"no displacement", ""});
  ASSERT_TRUE(second);
  EXPECT_EQ(second->a, 1U);
  EXPECT_EQ(second->b, 1U);
  EXPECT_FALSE(ChooseForms(forms, {"", "no incremental"}, {"no displacement", ""}));
}

TEST(Forms, EachHasItsOwnWhereTheyAreOneModel) {
  const auto choice =
      ChooseForms(FormsOf(OfLaw("linear")), {"", "no incremental"}, {"no displacement", ""});
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->a, 0U);
  EXPECT_EQ(choice->b, 1U);
}

TEST(Forms, ReasonsNameBothSides) {
  const std::string text = ExplainNoForm("x", {"", "no incremental"}, "y", {"no displacement", ""});
  EXPECT_THAT(text, HasSubstr("x: no incremental"));
  EXPECT_THAT(text, HasSubstr("y: no displacement"));
  EXPECT_EQ(ExplainNoForm("x", {"gone", "gone"}, "y", {"", ""}), "x: gone");
}

}  // namespace
}  // namespace powdercal::verification

#include "studies/mode_costs.h"

#include <gmock/gmock.h>

#include <cmath>

#include "tests/support/program.h"

namespace powdercal {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

const ModeCost& Find(const std::vector<ModeCost>& costs, const std::string& mode) {
  for (const ModeCost& cost : costs) {
    if (cost.mode == mode) return cost;
  }
  throw std::out_of_range(mode);
}

// Steps ~ sqrt(E/sigma) ~ kappa^0.75 at constant I.
TEST(CompareModes, StepsGoAsKappaToTheThreeQuarters) {
  const Study study = Study::Load("quickstart");
  const auto costs = CompareModes(study, {0});
  const ModeCost& base = Find(costs, "rigid_limit, kappa 1000");
  for (const auto& [mode, kappa] :
       {std::pair{"rigid_limit, kappa 4000", 4e3}, {"rigid_limit, kappa 10000", 1e4}}) {
    const ModeCost& other = Find(costs, mode);
    EXPECT_NEAR(*other.kappa, kappa, 1e-6 * kappa);
    EXPECT_NEAR(other.steps / base.steps, std::pow(kappa / 1000, 0.75), 1e-6);
    EXPECT_NEAR(other.seconds / base.seconds, std::pow(kappa / 1000, 0.75), 1e-6);
  }
  EXPECT_NEAR(Find(costs, "none").steps / base.steps, std::sqrt(200e9 / base.young_modulus), 1);
}

// Everything is slower by as much as the steps are longer.
TEST(CompareModes, ExactSavesNothing) {
  const auto costs = CompareModes(Study::Load("quickstart"), {0});
  EXPECT_NEAR(Find(costs, "exact").steps / Find(costs, "none").steps, 1, 1e-9);
  EXPECT_THAT(Find(costs, "exact").violated, ::testing::IsEmpty());
  EXPECT_THAT(Find(costs, "rigid_limit, kappa 1000").violated, ::testing::IsEmpty());
}

TEST(CompareModes, TellsTheStudysOwnModeAndWhatItViolates) {
  const auto costs = CompareModes(Study::Load("quickstart"), {0});
  EXPECT_EQ(costs.front().mode, "given");
  EXPECT_TRUE(costs.front().own);
  EXPECT_EQ(costs.front().young_modulus, 5e6);
  EXPECT_THAT(costs.front().violated, Contains("consolidation: sigma/E"));
  EXPECT_THAT(costs.front().violated, Not(Contains(HasSubstr("F_c"))));
}

TEST(CompareModes, SaysWhyAModeIsNotPossible) {
  std::string text = StudyText("quickstart");
  const std::size_t begin = text.find("  - consolidation:");
  text.replace(begin, text.find("objective:") - begin,
               "  - spreading: {observed: {coverage: {value: 0.9, sd: 0.05}}}\n");
  const std::size_t scaling = text.find("scaling:");
  text.replace(scaling, text.find('\n', scaling) - scaling,
               "scaling: {mode: given, young_modulus: 5 MPa}");
  const Study study = Study::Parse(text, "s.yaml", {}, {});
  const auto costs = CompareModes(study, {0});
  EXPECT_THAT(Find(costs, "rigid_limit, kappa 1000").why_not,
              HasSubstr("no experiment of the study applies a stress"));
  EXPECT_EQ(Find(costs, "exact").why_not, "");
}

}  // namespace
}  // namespace powdercal

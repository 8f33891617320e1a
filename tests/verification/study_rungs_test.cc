#include "verification/study_rungs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/program.h"

namespace powdercal::verification {
namespace {

using ::testing::HasSubstr;

// Consolidation alone: void ratio 0.783 ± 0.01.
Finding Consolidation(double mean_a, double mean_b, double sd, int n,
                      Verdict verdict = Verdict::equivalent) {
  Finding finding{.rung = Rung::experiment,
                  .name = "consolidation",
                  .a = "a",
                  .b = "b",
                  .verdict = verdict,
                  .reason = "why not"};
  finding.quantities = {
      {.name = "void_ratio",
       .seeds = SeedStatistics{.n = n, .mean_a = mean_a, .mean_b = mean_b, .sd_a = sd, .sd_b = sd}},
      {.name = "bulk_density", .seeds = SeedStatistics{.n = n, .mean_a = 1, .mean_b = 2}}};
  return finding;
}

std::vector<Finding> Judge(const Finding& finding) {
  const Study study = Study::Load("quickstart");
  return JudgeCalibration(study, std::span(&finding, 1), 0.05);
}

double Chi2(const Finding& finding, const std::string& backend) {
  for (const Quantity& quantity : finding.quantities) {
    if (quantity.name == "chi2 in " + backend) return quantity.difference;
  }
  return std::nan("");
}

TEST(Calibration, ChiSquaredHoldsTheScatterOfTheMean) {
  const auto findings = Judge(Consolidation(0.783, 0.793, 0.02, 4));
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].verdict, Verdict::equivalent);
  EXPECT_DOUBLE_EQ(Chi2(findings[0], "a"), 0);
  // sd² + s²/n = 1e-4 + 4e-4/4.
  EXPECT_NEAR(Chi2(findings[0], "b"), 0.5, 1e-9);
}

// The 0.95 quantile with one degree of freedom is 1.959964² = 3.8415.
TEST(Calibration, IsRejectedBeyondTheQuantile) {
  EXPECT_EQ(Judge(Consolidation(0.783, 0.783 + 0.01959, 0, 4))[0].verdict, Verdict::equivalent);
  const Finding rejected = Judge(Consolidation(0.783, 0.783 - 0.01961, 0, 4))[0];
  EXPECT_EQ(rejected.verdict, Verdict::different);
  EXPECT_THAT(rejected.reason, HasSubstr("b would not have accepted the parameters"));
}

TEST(Calibration, ThatTheReferenceRejectsIsNothingToConfirm) {
  const Finding finding = Judge(Consolidation(0.9, 0.783, 0, 4))[0];
  EXPECT_EQ(finding.verdict, Verdict::unsupported);
  EXPECT_THAT(finding.reason, HasSubstr("nothing to confirm"));
}

TEST(Calibration, FailsWithItsExperiments) {
  for (const Verdict verdict : {Verdict::failed, Verdict::unsupported}) {
    const Finding finding = Judge(Consolidation(0.783, 0.783, 0, 4, verdict))[0];
    EXPECT_EQ(finding.verdict, verdict);
    EXPECT_EQ(finding.reason, "consolidation: why not");
  }
}

TEST(Experiments, MarginsAreTheObservationsSds) {
  const Study study = Study::Load("hastelloy_x_joint");
  const Planner planner(study);
  const auto cases = ExperimentCases(planner, {15'000, 0.25}, 2, {{"shear.cohesion", 20}});
  ASSERT_EQ(cases.size(), 4U);
  const auto find = [&](const std::string& experiment, const std::string& response) {
    for (const SeedCase& entry : cases) {
      for (const Comparison& comparison : entry.comparisons) {
        if (entry.name == experiment && comparison.name == response) return comparison;
      }
    }
    return Comparison();
  };
  EXPECT_DOUBLE_EQ(find("consolidation", "void_ratio").margin, 0.01);
  EXPECT_TRUE(find("consolidation", "void_ratio").counts);
  EXPECT_DOUBLE_EQ(find("spreading", "coverage").margin, 0.05);
  EXPECT_DOUBLE_EQ(find("shear", "cohesion").margin, 20);
  EXPECT_TRUE(find("shear", "cohesion").counts);
  EXPECT_FALSE(find("consolidation", "bulk_density").counts);
  EXPECT_TRUE(find("consolidation", "bulk_density").relative);
}

}  // namespace
}  // namespace powdercal::verification

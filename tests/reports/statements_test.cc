#include "reports/statements.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/reports/sample_studies.h"

namespace powdercal {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

TEST(StatementsTest, ToleranceDecides) {
  ResponseResult response{
      .simulated = 0.7901, .replicates = 1, .observed = 0.783, .sd = 0.01, .tolerance = 0.007};
  EXPECT_FALSE(JudgeFit(response).within);
  response.simulated = 0.7765;
  EXPECT_TRUE(JudgeFit(response).within);
  EXPECT_NEAR(*JudgeFit(response).deviation, -0.0065, 1e-12);
}

TEST(StatementsTest, WithoutToleranceTwoStandardDeviationsOfTheDifference) {
  ResponseResult response{
      .simulated = 0.8, .seed_sd = 0.02, .replicates = 4, .observed = 0.783, .sd = 0.01};
  EXPECT_NEAR(JudgeFit(response).limit, 2 * std::sqrt(1e-4 + 1e-4), 1e-12);
  response.replicates = 1;
  EXPECT_NEAR(JudgeFit(response).limit, 0.02, 1e-12);
}

TEST(StatementsTest, NoValueIsNoFit) {
  const Fit fit = JudgeFit({.observed = 0.783, .sd = 0.01});
  EXPECT_FALSE(fit.deviation);
  EXPECT_FALSE(fit.within);
}

TEST(StatementsTest, Conclusions) {
  EXPECT_EQ(Conclude(QuickstartSample()).headline,
            "Calibrated: the void ratio comes out within the tolerance.");
  EXPECT_EQ(Conclude(TableSample()).headline,
            "Target reached, without simulating: the void ratio comes out within the tolerance.");
  EXPECT_EQ(Conclude(FailedSample()).headline, "Nothing was calibrated: all 3 evaluations failed.");
  EXPECT_EQ(Conclude(JointSample()).headline,
            "Not calibrated: void ratio is outside the accepted deviation at the best point.");
  EXPECT_EQ(Conclude(StudyResults{}).headline,
            "Nothing was calibrated: no evaluation has ended yet.");
}

TEST(StatementsTest, InterruptedStudyIsProvisional) {
  StudyResults results = QuickstartSample();
  results.state = "interrupted";
  EXPECT_THAT(Conclude(results).detail, HasSubstr("can be resumed"));
  EXPECT_THAT(Caveats(results), Contains(HasSubstr("provisional")));
}

TEST(StatementsTest, CaveatsOfTheQuickstart) {
  const std::vector<std::string> caveats = Caveats(QuickstartSample());
  EXPECT_THAT(caveats, Contains(HasSubstr("2 parameters were fitted to 1 response")));
  EXPECT_THAT(caveats, Contains(HasSubstr("Consolidation, σ/E: the simulated particles are 4000")));
  EXPECT_THAT(caveats, Not(Contains(HasSubstr("no simulation"))));
  EXPECT_THAT(caveats, Not(Contains(HasSubstr("gravity counts"))));  // off, not violated
}

TEST(StatementsTest, CaveatsNameAParameterAtTheEndOfItsRange) {
  StudyResults results = QuickstartSample();
  results.history[*results.best].parameters["rolling_friction"] = 0.7;
  EXPECT_THAT(Caveats(results),
              Contains(HasSubstr("Rolling friction lies at the upper end of the range")));
}

TEST(StatementsTest, FirstCaveatSaysThatNothingWasSimulated) {
  const std::vector<std::string> caveats = Caveats(TableSample());
  ASSERT_FALSE(caveats.empty());
  EXPECT_THAT(caveats[0], testing::StartsWith("No simulation was run: "));
}

TEST(StatementsTest, TargetsAreKnownWithoutABest) {
  const std::vector<ResponseResult> targets = TargetResponses(FailedSample());
  ASSERT_EQ(targets.size(), 1u);
  EXPECT_EQ(targets[0].observed, 0.783);
  EXPECT_FALSE(targets[0].simulated);
  EXPECT_THAT(TargetResponses(StudyResults{}), IsEmpty());
}

TEST(TransferTest, SaysByHowManyStandardDeviationsEachIsOff) {
  const StudyResults results = TransferSample();
  const auto& responses = results.transfer.responses;
  // Of the difference: sqrt(0.05² + 0.03²/3).
  EXPECT_NEAR(*StandardDeviationsOff(responses[0]), -0.2 / std::sqrt(0.0025 + 0.0003), 1e-9);
  EXPECT_FALSE(StandardDeviationsOff(responses[1]));
  EXPECT_FALSE(JudgeFit(responses[1]).deviation);
  EXPECT_THAT(
      TransferStatements(results),
      testing::ElementsAre(
          "Coverage of spreading: 0.7 against 0.9 ± 0.05 observed, 3.8 standard deviations too "
          "low; it does not agree.",
          "Packing density of spreading: 0.53 against 0.55 ± 0.05 observed, 0.4 standard "
          "deviations too low; it agrees.",
          "Repose gave no value in 3 of 3 runs, timeout: no result within 600 s."));
  EXPECT_EQ(TransferHeadline(results),
            "Does not transfer to spreading and repose (they were not fitted): 1 of 2 responses "
            "as observed.");
  EXPECT_THAT(Caveats(results), testing::Contains(TransferHeadline(results)));
  EXPECT_EQ(Conclude(results).headline, Conclude(JointSample()).headline)
      << "the conclusion is on what was fitted";
}

TEST(TransferTest, NothingIsSaidWhereNothingWasTransferred) {
  EXPECT_EQ(TransferHeadline(JointSample()), "");
  EXPECT_THAT(TransferStatements(JointSample()), testing::IsEmpty());
}

TEST(TransferTest, HeadlineWhereAllAgreeOrNothingWasObserved) {
  StudyResults results = TransferSample();
  results.transfer.experiments = {"spreading"};
  results.transfer.failures.clear();
  results.transfer.responses.erase(results.transfer.responses.begin());
  EXPECT_EQ(TransferHeadline(results),
            "Transfers to spreading (it was not fitted): its response comes out as observed.");
  results.transfer.responses.pop_back();
  EXPECT_THAT(TransferHeadline(results), testing::HasSubstr("nothing was observed"));
}

TEST(FidelityTextTest, NamesExperimentsWithTheirOwn) {
  EXPECT_EQ(FidelityText(TransferSample()), "quick; shear: standard");
}

}  // namespace
}  // namespace powdercal

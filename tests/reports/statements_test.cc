#include "reports/statements.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
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

TEST(ConfirmationTest, SaysWhatEachBackendMakesOfTheBestPoint) {
  const StudyResults results = ConfirmationSample();
  const auto headline = [&](std::size_t i) {
    return ConfirmationHeadline(results, results.confirmations[i]);
  };
  EXPECT_EQ(headline(0),
            "embedded 1 does not confirm the best point: the void ratio is outside the accepted "
            "deviation there, not with liggghts.");
  EXPECT_EQ(headline(1),
            "shearless 0.9 confirms the best point in part: 1 of 3 responses come out as observed. "
            "The stress 3kPa and stress 5kPa could not be had there: shear: it has no <shear> "
            "cell.");
  EXPECT_EQ(headline(2),
            "absent could not confirm the best point: not available: no program 'absent' on PATH.");
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_FALSE(Agrees(results, results.confirmations[i]));
    EXPECT_THAT(Caveats(results), testing::Contains(headline(i)));
  }
  EXPECT_EQ(Conclude(results).kind, Conclusion::Kind::fits) << "the conclusion is the study's own";
}

TEST(ConfirmationTest, ComparesWithTheStudysOwnBackend) {
  const StudyResults results = ConfirmationSample();
  const ConfirmationResult& whole = results.confirmations[0];
  const BackendDifference difference =
      CompareBackends(whole.responses[0], results.history[*results.best].responses[0]);
  EXPECT_NEAR(*difference.value, 0.04, 1e-12);
  EXPECT_NEAR(*difference.sd, std::sqrt(2 * 0.004 * 0.004 / 4), 1e-12);
  EXPECT_THAT(
      ConfirmationStatements(results, whole)[0],
      testing::HasSubstr("Void ratio of consolidation: 0.828 against 0.788 with liggghts, a "
                         "difference of 0.04 ± 0.0028"));
  ResponseResult single = whole.responses[0];
  single.replicates = 1;
  EXPECT_FALSE(CompareBackends(single, whole.responses[0]).sd) << "one seed says nothing of it";
  single.simulated.reset();
  EXPECT_FALSE(CompareBackends(single, whole.responses[0]).value);
}

TEST(ConfirmationTest, BackendsMayAgreeInAMissAndOneMayBePending) {
  StudyResults results = ConfirmationSample();
  EvaluationResult& best = results.history[*results.best];
  results.confirmations.resize(1);
  ConfirmationResult& other = results.confirmations[0];
  other.responses = best.responses;
  EXPECT_EQ(ConfirmationHeadline(results, other),
            "embedded 1 confirms the best point: all 3 responses come out as observed.");
  *best.responses[0].simulated += 0.05;
  EXPECT_EQ(ConfirmationHeadline(results, other),
            "embedded 1 does not agree on the best point: the void ratio is outside the accepted "
            "deviation with liggghts, not there.");
  *other.responses[0].simulated += 0.05;
  EXPECT_EQ(ConfirmationHeadline(results, other),
            "embedded 1 agrees with liggghts on the best point: the void ratio is outside the "
            "accepted deviation with both.");
  EXPECT_TRUE(Agrees(results, other));
  EXPECT_THAT(Caveats(results), testing::Not(testing::Contains(testing::HasSubstr("embedded"))));
  *other.responses[0].simulated -= 0.05;
  other.responses[0].seed_sd = 0.2;
  other.responses[0].tolerance = best.responses[0].tolerance = 0.01;
  EXPECT_EQ(ConfirmationHeadline(results, other),
            "embedded 1 neither confirms nor refutes the best point: the void ratio is outside the "
            "accepted deviation with liggghts, not there, but the two backends differ by 0.5 "
            "standard deviations of the particle seeds only. More seeds would tell.");
  EXPECT_FALSE(Agrees(results, other));
  other = {.backend = "embedded", .outcome = kPending};
  EXPECT_THAT(Caveats(results), testing::Contains("The best point has not been simulated on "
                                                  "embedded yet."));
  results.state = "running";
  EXPECT_THAT(Caveats(results), testing::Not(testing::Contains(testing::HasSubstr("embedded"))));
}

TEST(ApproximationTest, SaysWhatItChanges) {
  StudyResults results = ApproximationSample();
  EXPECT_THAT(
      ApproximationStatements(results),
      testing::ElementsAre(
          testing::HasSubstr("Void ratio of consolidation: 0.783 with the approximation, 0.763 "
                             "without, a difference of 0.02 ± 0.0028"),
          "Shear without the approximation gave no value, timeout: no result within 600 s."));
  EXPECT_THAT(Caveats(results), testing::Contains("SJKR2 is <approximated> by DMT."));
  EXPECT_THAT(Caveats(results),
              testing::Contains("The approximation changes the void ratio of consolidation by 2 "
                                "standard deviations of the observation: the parameters are those "
                                "of the law that was simulated, not of the one that it stands "
                                "for."));
  *results.approximation_effect->exact[0].simulated += 0.015;
  EXPECT_THAT(Caveats(results),
              testing::Not(testing::Contains(testing::HasSubstr("The approximation changes"))))
      << "by half of one";
  results.approximation_effect.reset();
  EXPECT_THAT(ApproximationStatements(results), testing::IsEmpty());
}

TEST(FidelityTextTest, NamesExperimentsWithTheirOwn) {
  EXPECT_EQ(FidelityText(TransferSample()), "quick; shear: standard");
}

// A study of two experiments with one response each, observed as 0 ± 1: within 2 it fits.
StudyResults TwoExperiments(const std::vector<std::array<double, 2>>& values) {
  StudyResults results;
  results.state = "finished";
  results.objectives = {"consolidation", "angle_of_repose"};
  for (const std::array<double, 2>& pair : values) {
    EvaluationResult evaluation{
        .id = static_cast<std::int64_t>(results.history.size()), .outcome = "ok", .chi2 = 0};
    for (std::size_t o = 0; o < 2; ++o) {
      evaluation.responses.push_back({.name = results.objectives[o] + ".value",
                                      .unit = "1",
                                      .simulated = pair[o],
                                      .replicates = 1,
                                      .sd = 1});
      evaluation.objectives.push_back({.chi2 = pair[o] * pair[o], .misfit = pair[o] * pair[o]});
    }
    results.pareto.push_back(results.history.size());
    results.history.push_back(evaluation);
    ++results.total;
    ++results.ok;
  }
  if (!values.empty()) results.best = 0;
  return results;
}

TEST(CompatibilityTest, OneEvaluationFitsAll) {
  const Compatibility found = JudgeCompatibility(TwoExperiments({{0.1, 3}, {1.5, 1}, {1, 1}}));
  EXPECT_TRUE(found.together);
  EXPECT_EQ(found.statement,
            "Consolidation and angle of repose can be fitted together: evaluation 2 does.");
}

TEST(CompatibilityTest, EachAloneButNotBoth) {
  const StudyResults results = TwoExperiments({{2.5, 2.5}, {0.1, 5}, {4, 0.2}});
  const Compatibility found = JudgeCompatibility(results);
  EXPECT_FALSE(found.together);
  EXPECT_EQ(found.statement,
            "Consolidation and angle of repose contradict each other as far as was searched: each "
            "is fitted by some evaluation, and none fits both.");
  EXPECT_EQ(found.detail,
            "Where consolidation fits best (evaluation 1), the misfit of angle of repose is 25 "
            "instead of 0.04 (evaluation 2). "
            "Where angle of repose fits best (evaluation 2), the misfit of consolidation is 16 "
            "instead of 0.01 (evaluation 1).");
  EXPECT_THAT(Caveats(results), testing::Contains(found.statement));
}

TEST(CompatibilityTest, OneIsNeverFitted) {
  const Compatibility found = JudgeCompatibility(TwoExperiments({{0.1, 5}}));
  EXPECT_FALSE(found.together);
  EXPECT_EQ(
      found.statement,
      "No evaluation fits angle of repose, even without regard to the rest: its lowest misfit "
      "is 25 over 1 response.");
}

TEST(CompatibilityTest, NothingToSayOfOneObjectiveOrNone) {
  EXPECT_EQ(JudgeCompatibility(TwoExperiments({})).statement, "");
  EXPECT_EQ(JudgeCompatibility(JointSample()).statement, "");
  EXPECT_EQ(JudgeCompatibility(ParetoSample(1)).statement, "");
}

TEST(StatementsTest, ACategoryIsNotTheEndOfARange) {
  EXPECT_THAT(Caveats(CategoricalSample()), Not(Contains(HasSubstr("Rolling model"))));
}

}  // namespace
}  // namespace powdercal

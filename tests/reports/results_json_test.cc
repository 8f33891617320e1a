#include "reports/results_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/reports/sample_studies.h"

namespace powdercal {
namespace {

using nlohmann::json;

TEST(ResultsJsonTest, HasTheKeysOfSchema1) {
  const json root = ResultsToJson(QuickstartSample());
  EXPECT_EQ(root.at("schema"), 1);
  for (const char* key :
       {"study", "optimizer", "backend", "evaluations", "best", "pareto", "history", "runs",
        "failures", "pi_groups", "wall_s", "simulation_s", "overhead_s"}) {
    EXPECT_TRUE(root.contains(key)) << key;
  }
  EXPECT_FALSE(root.contains("notice"));
  EXPECT_EQ(root.at("study").at("name"), "quickstart");
  EXPECT_EQ(root.at("optimizer").at("name"), "bayesian");
  EXPECT_EQ(root.at("backend").at("version"), "3.8.0");
  EXPECT_EQ(root.at("backend").at("simulated"), true);
  EXPECT_EQ(root.at("evaluations"),
            json({{"total", 14}, {"ok", 12}, {"partial", 0}, {"failed", 2}, {"cached", 0}}));
  EXPECT_NEAR(root.at("overhead_fraction").get<double>(), 3.1 / 412.6, 1e-12);
}

TEST(ResultsJsonTest, BestHasParametersResponsesAndChi2) {
  const StudyResults results = QuickstartSample();
  const json best = ResultsToJson(results).at("best");
  EXPECT_EQ(best.at("evaluation"), results.history[*results.best].id);
  EXPECT_EQ(best.at("parameters").at("cohesion_energy_density"), 55400.0);
  const json& response = best.at("responses").at("consolidation.void_ratio");
  EXPECT_EQ(response.at("observed"), 0.783);
  EXPECT_EQ(response.at("sd"), 0.01);
  EXPECT_EQ(response.at("unit"), "1");
  EXPECT_EQ(response.at("within"), true);
  EXPECT_NEAR(response.at("simulated").get<double>(), 0.7789, 1e-4);
  EXPECT_EQ(best.at("chi2"), *results.history[*results.best].chi2);
}

TEST(ResultsJsonTest, HistoryDoesNotDependOnTimeRunsOrInterruption) {
  StudyResults results = QuickstartSample();
  const json history = ResultsToJson(results).at("history");
  results.wall_seconds *= 3;
  results.cached = 5;
  results.state = "interrupted";
  results.program_version = "9";
  results.backend_version = "other";
  for (EvaluationResult& evaluation : results.history) {
    evaluation.message += " after 12.3 s on node7";
    for (RunResult& run : evaluation.runs) {
      run.id += 100;
      run.wall_seconds *= 2;
      run.message = "other";
    }
    evaluation.runs.resize(evaluation.runs.size() / 2);
  }
  EXPECT_EQ(ResultsToJson(results).at("history").dump(), history.dump());
  EXPECT_EQ(history.size(), 14u);
  EXPECT_EQ(history[1].at("outcome"), "not_quasi_static");
  EXPECT_TRUE(history[1].at("chi2").is_null());
}

TEST(ResultsJsonTest, RunsAndFailuresHoldTheDetails) {
  const json root = ResultsToJson(QuickstartSample());
  EXPECT_EQ(root.at("runs").size(), 28u);
  EXPECT_EQ(root.at("runs")[0].at("evaluation"), 0);
  EXPECT_EQ(root.at("runs")[0].at("wall_s"), 28.4);
  ASSERT_EQ(root.at("failures").size(), 2u);
  EXPECT_THAT(root.at("failures")[1].at("message").get<std::string>(), testing::HasSubstr("600 s"));
}

TEST(ResultsJsonTest, SaysThatNothingWasSimulated) {
  const json root = ResultsToJson(TableSample());
  EXPECT_THAT(root.at("notice").get<std::string>(), testing::StartsWith("no simulation was run: "));
  EXPECT_EQ(root.at("backend").at("simulated"), false);
}

TEST(ResultsJsonTest, WithoutABestThereIsNull) {
  const json root = ResultsToJson(FailedSample());
  EXPECT_TRUE(root.at("best").is_null());
  EXPECT_EQ(root.at("evaluations").at("ok"), 0);
  EXPECT_EQ(root.at("study").at("targets")[0].at("observed"), 0.783);
  EXPECT_EQ(ResultsToJson(StudyResults{}).at("history"), json::array());
}

TEST(ResultsJsonTest, ParetoPointsAreWrittenOut) {
  const StudyResults results = ParetoSample();
  const json root = ResultsToJson(results);
  EXPECT_EQ(root.at("study").at("objective"), "pareto");
  ASSERT_EQ(root.at("pareto").size(), results.pareto.size());
  for (std::size_t i = 0; i < results.pareto.size(); ++i) {
    const EvaluationResult& evaluation = results.history[results.pareto[i]];
    const json& point = root.at("pareto")[i];
    EXPECT_EQ(point.at("evaluation"), evaluation.id);
    EXPECT_EQ(point.at("responses").size(), 3u);
    ASSERT_EQ(point.at("objectives").size(), 2u);
    EXPECT_EQ(point.at("objectives").at("shear").at("chi2"), *evaluation.objectives[1].chi2);
    EXPECT_EQ(point.at("objectives").at("shear").at("misfit"), *evaluation.objectives[1].misfit);
  }
  EXPECT_TRUE(root.at("history")[5].at("objectives").at("shear").at("chi2").is_null());
}

TEST(ResultsJsonTest, AJointStudyHasNoObjectives) {
  const json root = ResultsToJson(JointSample());
  EXPECT_EQ(root.at("study").at("objective"), "joint");
  EXPECT_TRUE(root.at("pareto").empty());
  EXPECT_FALSE(root.at("best").contains("objectives"));
  EXPECT_FALSE(root.at("history")[0].contains("objectives"));
}

TEST(ResultsJsonTest, TextIsAlwaysValidJson) {
  StudyResults results = QuickstartSample();
  results.description = "bytes \xFF\xFE";
  results.history[0].runs[0].diagnostics["nan"] = std::numeric_limits<double>::quiet_NaN();
  const json read = json::parse(JsonText(ResultsToJson(results)));
  EXPECT_TRUE(read.at("runs")[0].at("diagnostics").at("nan").is_null());
  EXPECT_EQ(read.at("best").at("parameters").at("rolling_friction").get<double>(), 0.66);
}

TEST(ResultsJsonTest, TransferStandsApartFromTheFit) {
  const json root = ResultsToJson(TransferSample());
  const json& best = root.at("best");
  EXPECT_FALSE(best.at("responses").contains("spreading.coverage"));
  const json& coverage = best.at("transfer").at("spreading.coverage");
  EXPECT_EQ(coverage.at("observed"), 0.9);
  EXPECT_EQ(coverage.at("within"), false);
  EXPECT_NEAR(coverage.at("standard_deviations_off").get<double>(), -3.78, 0.01);
  const json& thickness = best.at("transfer").at("spreading.layer_thickness");
  EXPECT_EQ(thickness.at("simulated"), 71e-6);
  for (const char* key : {"observed", "sd", "deviation", "within", "standard_deviations_off"}) {
    EXPECT_TRUE(thickness.at(key).is_null()) << key;
  }
  ASSERT_EQ(best.at("transfer_failures").size(), 1u);
  EXPECT_EQ(best.at("transfer_failures")[0].at("outcome"), "timeout");
  EXPECT_EQ(root.at("runs").back().at("experiment"), "spreading");
  EXPECT_EQ(root.at("runs").back().at("evaluation"), best.at("evaluation"));
  EXPECT_EQ(root.at("study").at("experiments")[2].at("calibrated"), false);
  EXPECT_TRUE(ResultsToJson(JointSample()).at("best").at("transfer").empty());
}

TEST(ResultsJsonTest, ConfirmationsStandApartFromTheFit) {
  const json root = ResultsToJson(ConfirmationSample());
  ASSERT_EQ(root.at("confirmations").size(), 3u);
  const json& whole = root.at("confirmations")[0];
  EXPECT_EQ(whole.at("backend"), "embedded");
  EXPECT_EQ(whole.at("version"), "1");
  EXPECT_EQ(whole.at("outcome"), "ok");
  EXPECT_EQ(whole.at("agrees"), false);
  EXPECT_EQ(whole.at("chi2"), 17.3);
  const json& ratio = whole.at("responses").at("consolidation.void_ratio");
  EXPECT_NEAR(ratio.at("difference").get<double>(), 0.04, 1e-12);
  EXPECT_TRUE(ratio.at("difference_sd").is_number());
  EXPECT_EQ(ratio.at("observed"), 0.783);
  EXPECT_EQ(ratio.at("within"), false);
  const json& part = root.at("confirmations")[1];
  EXPECT_EQ(part.at("outcome"), "partial");
  EXPECT_TRUE(part.at("chi2").is_null());
  EXPECT_EQ(part.at("failures")[0].at("outcome"), "unsupported");
  EXPECT_TRUE(part.at("responses").at("shear.stress_3kPa").at("difference").is_null());
  EXPECT_EQ(root.at("confirmations")[2].at("outcome"), "unavailable");
  EXPECT_EQ(root.at("runs").back().at("backend"), "embedded");
  EXPECT_TRUE(ResultsToJson(JointSample()).at("confirmations").empty());
}

TEST(ResultsJsonTest, ApproximationsHaveTheirEffect) {
  const json root = ResultsToJson(ApproximationSample());
  EXPECT_EQ(root.at("study").at("approximations")[0].at("name"), "dmt_pull_off");
  const json& effect = root.at("approximation_effect");
  EXPECT_EQ(effect.at("backend"), "embedded");
  const json& ratio = effect.at("responses").at("consolidation.void_ratio");
  EXPECT_NEAR(ratio.at("difference").get<double>(), 0.02, 1e-12);
  EXPECT_NEAR(ratio.at("exact").at("simulated").get<double>(), 0.763, 1e-12);
  EXPECT_TRUE(effect.at("responses").at("shear.stress_3kPa").at("difference").is_null());
  EXPECT_EQ(effect.at("failures")[0].at("outcome"), "timeout");
  EXPECT_EQ(root.at("runs").back().at("id"), 950);
  const json plain = ResultsToJson(JointSample());
  EXPECT_TRUE(plain.at("approximation_effect").is_null());
  EXPECT_TRUE(plain.at("study").at("approximations").empty());
}

TEST(ResultsJsonTest, PartialFailuresNameTheExperiment) {
  const json root = ResultsToJson(TransferSample());
  EXPECT_EQ(root.at("evaluations").at("partial"), 1);
  const json& entry = root.at("history")[7];
  EXPECT_EQ(entry.at("outcome"), "partial");
  EXPECT_TRUE(entry.at("chi2").is_null());
  EXPECT_TRUE(entry.at("responses").at("consolidation.void_ratio").at("simulated").is_number());
  ASSERT_EQ(root.at("failures").size(), 2u);
  const json& failure = root.at("failures")[1];
  EXPECT_EQ(failure.at("outcome"), "partial");
  EXPECT_EQ(failure.at("experiments")[0].at("experiment"), "shear");
  EXPECT_EQ(failure.at("experiments")[0].at("outcome"), "not_quasi_static");
}

TEST(ResultsJsonTest, LowerFidelitiesAreNoPartOfTheHistory) {
  const StudyResults sample = SeveralFidelitiesSample();
  const json root = ResultsToJson(sample);
  EXPECT_EQ(root.at("history").size(), sample.history.size());
  ASSERT_EQ(root.at("lower_fidelity").size(), 5u);
  EXPECT_EQ(root.at("lower_fidelity")[0].at("fidelity"), "quick");
  EXPECT_TRUE(root.at("lower_fidelity")[0].at("best_chi2").is_null());
  EXPECT_EQ(root.at("history")[0].at("fidelity"), "standard");
  EXPECT_EQ(root.at("failures").back().at("evaluation"), 104);
  EXPECT_TRUE(ResultsToJson(QuickstartSample()).at("lower_fidelity").empty());
}

TEST(ResultsJsonTest, CategoriesAreNames) {
  const json document = ResultsToJson(CategoricalSample());
  EXPECT_EQ(document.at("best").at("parameters").at("rolling_model"), "epsd2");
  const json& history = document.at("history");
  EXPECT_EQ(history.at(0).at("parameters").at("rolling_model"), "epsd2");
  EXPECT_EQ(history.at(1).at("parameters").at("rolling_model"), "cdt");
  const json& parameter = document.at("study").at("parameters").at(2);
  EXPECT_EQ(parameter.at("name"), "rolling_model");
  EXPECT_EQ(parameter.at("choices"), json::array({"cdt", "epsd2"}));
  EXPECT_FALSE(parameter.contains("lower"));
}

}  // namespace
}  // namespace powdercal

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>

#include "studies/runner.h"
#include "tests/support/program.h"

// Studies of several experiments: partial failures, and the transfer of the best point to
// experiments that were not calibrated.

namespace powdercal {
namespace {

using ::testing::HasSubstr;

StudyResults RunAlso(Study& study, const std::filesystem::path& folder,
                     const std::vector<std::string>& also) {
  StudyRunner runner(study, {.folder = folder, .evaluate_also = study.TransferExperiments(also)});
  EXPECT_EQ(runner.Run(), StudyRunner::End::finished);
  return CollectResults(study, Ledger(folder / "ledger.sqlite", Ledger::Mode::read_only));
}

StudyResults RunIn(Study& study, const std::filesystem::path& folder) {
  return RunAlso(study, folder, {});
}

// Answers for each experiment; spreading has no answer where mu_r is above `limit`.
class Answers final : public Backend {
 public:
  explicit Answers(double limit = 1) : limit_(limit) {}
  const std::string& name() const override {
    static const std::string kName = "answers";
    return kName;
  }
  Availability availability() const override { return {.available = true, .version = "1"}; }
  std::string ExplainUnsupported(const Program& program) const override {
    return program.experiment == "shear" ? "it has no answer" : "";
  }
  Trace Run(const Program& program, const RunContext& context) const override {
    ++runs;
    const double mu_r = program.parameters.at("rolling_friction");
    const double scatter = 1e-3 * static_cast<double>(program.particles.seed % 7);
    Trace trace;
    if (context.stop.stop_requested()) {
      trace.outcome = {Reason::cancelled, ""};
    } else if (program.experiment == "spreading" && mu_r > limit_) {
      trace.outcome = {Reason::not_quasi_static, "the layer does not come to rest"};
    } else if (program.experiment == "spreading") {
      trace.reported["coverage"] = {.value = 0.6 + 0.2 * mu_r + scatter};
      trace.reported["swept_share"] = {.value = 0.3};
    } else {
      trace.reported["void_ratio"] = {.value = 0.7 + 0.2 * mu_r + scatter};
    }
    return trace;
  }

  mutable std::atomic<int> runs = 0;

 private:
  double limit_;
};

// Consolidation is calibrated; spreading as `spreading` says.
Study TwoExperiments(const std::string& spreading, double limit = 1,
                     const std::string& optimizer = "optimizer: random\n",
                     Overrides overrides = {}) {
  std::string text = StudyText("quickstart", "          tolerance: 0.01\n");
  const std::size_t begin = text.find("objective: joint");
  text = text.substr(0, begin) + "  - spreading: " + spreading +
         "\n  - shear: {preshear: 9 kPa}\n" + optimizer;
  overrides.emplace("backend.replicates", "2");
  overrides.emplace("backend.confirm_replicates", "3");
  overrides.emplace("budget.evaluations", "8");
  Study study = Study::Parse(text + "backend: {replicates: 2}\nbudget: {evaluations: 8}\n",
                             "s.yaml", LibraryStudy("").parent_path(), overrides);
  study.backend.backend = std::make_unique<Answers>(limit);
  return study;
}
constexpr const char* kCompared =
    "{calibrate: false, observed: {coverage: {value: 0.9, sd: 0.05}}}";
constexpr const char* kFitted = "{observed: {coverage: {value: 0.7, sd: 0.05}}}";

int RunsOf(const Study& study) { return dynamic_cast<const Answers&>(*study.backend.backend).runs; }

TEST(PartialFailure, IsRecordedWithItsReasonToldAndNeverBest) {
  const TemporaryFolder folder;
  Study study = TwoExperiments(kFitted, 0.4);
  const StudyResults results = RunIn(study, folder / "x");
  EXPECT_EQ(results.total, 8);
  EXPECT_GT(results.partial, 0);
  EXPECT_GT(results.ok, 0);
  EXPECT_EQ(results.failed, 0);
  EXPECT_EQ(results.ok + results.partial, results.total);
  for (const EvaluationResult& evaluation : results.history) {
    const bool fails = evaluation.parameters.at("rolling_friction") > 0.4;
    EXPECT_EQ(evaluation.outcome, fails ? kPartial : "ok");
    EXPECT_EQ(evaluation.chi2.has_value(), !fails);
    EXPECT_TRUE(evaluation.responses[0].simulated) << "consolidation is known all the same";
    EXPECT_EQ(evaluation.responses[1].simulated.has_value(), !fails);
    if (!fails) continue;
    ASSERT_EQ(evaluation.failures.size(), 1u);
    EXPECT_EQ(evaluation.failures[0].experiment, "spreading");
    EXPECT_EQ(evaluation.failures[0].reason, "not_quasi_static");
    EXPECT_EQ(evaluation.failures[0].failed_runs, 2);
    EXPECT_EQ(evaluation.message, "spreading: the layer does not come to rest");
  }
  EXPECT_EQ(results.history[*results.best].outcome, "ok");
  int told = 0;
  const Ledger ledger(folder / "x/ledger.sqlite", Ledger::Mode::read_only);
  for (const LedgerEvent& event : ledger.Events()) {
    if (event.kind != LedgerEvent::Kind::tell || event.observation->failure.empty()) continue;
    ++told;
    EXPECT_FALSE(event.observation->failed);
    EXPECT_TRUE(std::isfinite(event.observation->responses[0]));
    EXPECT_TRUE(std::isnan(event.observation->responses[1]));
    EXPECT_EQ(event.observation->failure, "spreading not_quasi_static");
  }
  EXPECT_EQ(told, results.partial);
}

// Spreading wants mu_r = 0.5 and can be had below 0.45 only: what consolidation says beyond, and
// where spreading fails, leads to the edge.
TEST(PartialFailure, BayesianLearnsFromTheResponsesThatAreThere) {
  const TemporaryFolder folder;
  Study study = TwoExperiments(kFitted, 0.45, "optimizer: {name: bayesian}\n",
                               {{"budget.evaluations", "16"},
                                {"budget.deterministic", "true"},
                                {"experiments[0].consolidation.observed.void_ratio.value", "0.8"}});
  const StudyResults results = RunIn(study, folder / "x");
  EXPECT_GT(results.partial, 0);
  ASSERT_TRUE(results.best);
  EXPECT_NEAR(results.history[*results.best].parameters.at("rolling_friction"), 0.45, 0.05);
}

TEST(PartialFailure, WithoutACompleteEvaluationThereIsNoBest) {
  const TemporaryFolder folder;
  Study study = TwoExperiments(kFitted, 0);
  const StudyResults results = RunIn(study, folder / "x");
  EXPECT_FALSE(results.best);
  EXPECT_EQ(results.partial, 8);
}

TEST(Transfer, EvaluatesTheBestPointOnWhatWasNotFitted) {
  const TemporaryFolder folder;
  Study study = TwoExperiments(kCompared);
  const StudyResults results = RunAlso(study, folder / "x", {"spreading"});
  ASSERT_TRUE(results.best);
  EXPECT_THAT(results.transfer.experiments, ::testing::ElementsAre("spreading"));
  ASSERT_EQ(results.transfer.runs.size(), 3u) << "as many seeds as the best point";
  ASSERT_EQ(results.transfer.responses.size(), 2u) << "what was not observed as well";
  const ResponseResult& coverage = results.transfer.responses[0];
  EXPECT_EQ(coverage.name, "spreading.coverage");
  const double mu_r = results.history[*results.best].parameters.at("rolling_friction");
  EXPECT_NEAR(*coverage.simulated, 0.6 + 0.2 * mu_r + 0.003, 0.003);
  EXPECT_EQ(coverage.observed, 0.9);
  EXPECT_EQ(coverage.replicates, 3);
  EXPECT_FALSE(results.transfer.responses[1].was_observed());
  EXPECT_TRUE(results.transfer.failures.empty());
  EXPECT_EQ(results.scaling_tables.size(), 2u);

  Study plain = TwoExperiments(kCompared);
  const StudyResults without = RunIn(plain, folder / "y");
  ASSERT_EQ(results.history.size(), without.history.size());
  for (std::size_t i = 0; i < results.history.size(); ++i) {
    EXPECT_EQ(results.history[i].parameters, without.history[i].parameters);
    EXPECT_EQ(results.history[i].chi2, without.history[i].chi2);
  }
  EXPECT_EQ(RunsOf(study), RunsOf(plain) + 3) << "it took no part in the calibration";
  EXPECT_TRUE(without.transfer.experiments.empty());
  for (const EvaluationResult& evaluation : results.history) {
    for (const RunResult& run : evaluation.runs) EXPECT_EQ(run.experiment, "consolidation");
  }
}

TEST(Transfer, OfAFinishedStudyAtOnceAndOnlyOnce) {
  const TemporaryFolder folder;
  Study study = TwoExperiments(kCompared);
  RunIn(study, folder / "x");
  for (const int runs : {3, 0}) {
    Study again = TwoExperiments(kCompared);
    EXPECT_EQ(RunAlso(again, folder / "x", {"spreading"}).transfer.runs.size(), 3u);
    EXPECT_EQ(RunsOf(again), runs);
  }
  Study later = TwoExperiments(kCompared);
  EXPECT_EQ(RunIn(later, folder / "x").transfer.runs.size(), 3u) << "shown without being asked for";
}

TEST(Transfer, FollowsAStudyThatEndedAtItsTolerance) {
  const TemporaryFolder folder;
  Study study =
      TwoExperiments(kCompared, 1, "optimizer: random\n",
                     {{"experiments[0].consolidation.observed.void_ratio.tolerance", "0.5"},
                      {"budget.parallel", "2"}});
  const StudyResults results = RunAlso(study, folder / "x", {"spreading"});
  EXPECT_EQ(results.stop_reason, "every tolerance reached");
  EXPECT_EQ(results.transfer.responses[0].replicates, 3);
}

TEST(Transfer, IsOfTheBestPointOnly) {
  const TemporaryFolder folder;
  Study small = TwoExperiments(kCompared, 1, "optimizer: random\n", {{"budget.evaluations", "2"}});
  RunAlso(small, folder / "x", {"spreading"});
  Study large = TwoExperiments(kCompared, 1, "optimizer: random\n", {{"budget.evaluations", "20"}});
  const StudyResults better = RunIn(large, folder / "x");
  ASSERT_GT(*better.best, 1u);
  EXPECT_TRUE(better.transfer.experiments.empty()) << "another point is the best now";
  EXPECT_EQ(RunAlso(large, folder / "x", {"spreading"}).transfer.runs.size(), 3u);
}

TEST(Transfer, FailuresHaveTheirReason) {
  const TemporaryFolder folder;
  Study study = TwoExperiments(kCompared, 0);
  const StudyResults results = RunAlso(study, folder / "x", {"spreading"});
  ASSERT_TRUE(results.best);
  ASSERT_EQ(results.transfer.responses.size(), 1u);
  EXPECT_FALSE(results.transfer.responses[0].simulated);
  ASSERT_EQ(results.transfer.failures.size(), 1u);
  EXPECT_EQ(results.transfer.failures[0].reason, "not_quasi_static");
  EXPECT_EQ(results.transfer.failures[0].failed_runs, 3);
}

TEST(Transfer, InterruptedItGoesOnWhereItStopped) {
  const TemporaryFolder folder;
  std::stop_source stop;
  struct StopInTransfer : ProgressListener {
    explicit StopInTransfer(std::stop_source& source) : stop(source) {}
    void OnTransfer(const LedgerCandidate&, const Progress& progress) override {
      EXPECT_EQ(progress.transfer_runs, 3);
      EXPECT_EQ(progress.transfer_done, 0);
      transferring = true;
    }
    void OnRun(const LedgerRun&, const Progress&) override {
      if (transferring) stop.request_stop();
    }
    std::stop_source& stop;
    bool transferring = false;
  } listener(stop);
  {
    Study study = TwoExperiments(kCompared, 1, "optimizer: random\n", {{"budget.parallel", "1"}});
    StudyRunner runner(study, {.folder = folder / "x",
                               .stop = stop.get_token(),
                               .listener = &listener,
                               .evaluate_also = {1}});
    EXPECT_EQ(runner.Run(), StudyRunner::End::interrupted);
    const StudyResults cut =
        CollectResults(study, Ledger(folder / "x/ledger.sqlite", Ledger::Mode::read_only));
    EXPECT_EQ(cut.state, "finished") << "the calibration is";
    EXPECT_EQ(cut.transfer.runs.size(), 1u);
  }
  Study study = TwoExperiments(kCompared);
  EXPECT_EQ(RunAlso(study, folder / "x", {"spreading"}).transfer.runs.size(), 3u);
  EXPECT_EQ(RunsOf(study), 2);
}

TEST(Transfer, UnsupportedExperimentsStopItBeforeAnythingStarts) {
  const TemporaryFolder folder;
  Study study = TwoExperiments(kCompared);
  try {
    RunAlso(study, folder / "x", {"shear"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("cannot run shear: it has no answer"));
  }
  EXPECT_EQ(RunsOf(study), 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "x"));
}

}  // namespace
}  // namespace powdercal

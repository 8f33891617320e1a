#include <gmock/gmock.h>

#include <atomic>

#include "studies/runner.h"
#include "tests/support/program.h"

// `confirm_with`: the best point on other backends.

namespace powdercal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A void ratio that is off by `offset`; spreading only if it can.
class Answers final : public Backend {
 public:
  Answers(std::string name, double offset, std::string version = "1")
      : name_(std::move(name)), offset_(offset), version_(std::move(version)) {}
  const std::string& name() const override { return name_; }
  Availability availability() const override {
    if (version_.empty()) return {.why_not = "no program 'answers' on PATH"};
    return {.available = true, .version = version_};
  }
  double Throughput(const Program&) const override { return 1e6; }
  std::string ExplainUnsupported(const Program& program) const override {
    return program.experiment == "spreading" && !spreads ? "it has no blade" : "";
  }
  Trace Run(const Program& program, const RunContext& context) const override {
    ++runs;
    Trace trace;
    if (const std::string reason = ExplainUnsupported(program); !reason.empty()) {
      trace.outcome = {Reason::unsupported, reason};
      return trace;
    }
    if (context.stop.stop_requested()) {
      trace.outcome = {Reason::cancelled, ""};
      return trace;
    }
    if (crashes) {
      trace.outcome = {Reason::crashed, "a segmentation fault"};
      return trace;
    }
    const double scatter = 1e-3 * static_cast<double>(program.particles.seed % 7);
    const double value = 0.7 + 0.2 * program.parameters.at("rolling_friction") + offset_ + scatter;
    trace.reported[program.experiment == "spreading" ? "coverage" : "void_ratio"] = {.value =
                                                                                         value};
    trace.diagnostics.law = name_ + "'s law";
    return trace;
  }

  mutable std::atomic<int> runs = 0;
  bool spreads = true;
  bool crashes = false;

 private:
  std::string name_;
  double offset_;
  std::string version_;
};

// Consolidation, and spreading too where `both`, with these other backends.
Study ConfirmedStudy(std::vector<std::unique_ptr<Answers>> others, bool both = false) {
  std::string text = StudyText("quickstart", "          tolerance: 0.01\n");
  text = text.substr(0, text.find("objective: joint"));
  if (both) text += "  - spreading: {observed: {coverage: {value: 0.8, sd: 0.1}}}\n";
  Study study = Study::Parse(text +
                                 "optimizer: random\nbackend: {replicates: 2}\n"
                                 "budget: {evaluations: 8, parallel: 1}\n",
                             "s.yaml", LibraryStudy("").parent_path());
  study.backend.backend = std::make_unique<Answers>("own", 0);
  for (auto& other : others) study.backend.confirm_with.push_back(std::move(other));
  return study;
}

Study With(std::unique_ptr<Answers> other, bool both = false) {
  std::vector<std::unique_ptr<Answers>> others;
  if (other) others.push_back(std::move(other));
  return ConfirmedStudy(std::move(others), both);
}

int RunsOf(const Backend& backend) { return dynamic_cast<const Answers&>(backend).runs; }

StudyResults RunIn(Study& study, const std::filesystem::path& folder) {
  StudyRunner runner(study, {.folder = folder});
  EXPECT_EQ(runner.Run(), StudyRunner::End::finished);
  return CollectResults(study, Ledger(folder / "ledger.sqlite", Ledger::Mode::read_only));
}

TEST(Confirmation, SimulatesTheBestPointElsewhereWithTheSameParticles) {
  const TemporaryFolder folder;
  Study study = With(std::make_unique<Answers>("other", 0.05, "2.1"));
  const StudyResults results = RunIn(study, folder / "x");
  ASSERT_TRUE(results.best);
  ASSERT_EQ(results.confirmations.size(), 1u);
  const ConfirmationResult& other = results.confirmations[0];
  EXPECT_EQ(other.backend, "other");
  EXPECT_EQ(other.version, "2.1");
  EXPECT_EQ(other.outcome, "ok");
  EXPECT_EQ(other.law, "other's law");
  ASSERT_EQ(other.runs.size(), 3u) << "confirm_replicates";
  const EvaluationResult& best = results.history[*results.best];
  ASSERT_EQ(best.runs.size(), 3u) << "those of the other backend are not among them";
  for (std::size_t r = 0; r < 3; ++r) {
    EXPECT_EQ(other.runs[r].program_hash, best.runs[r].program_hash);
    EXPECT_EQ(other.runs[r].backend, "other");
    EXPECT_EQ(best.runs[r].backend, "own");
  }
  ASSERT_EQ(other.responses.size(), 1u);
  EXPECT_NEAR(*other.responses[0].simulated, *best.responses[0].simulated + 0.05, 1e-12);
  EXPECT_EQ(other.responses[0].replicates, 3);
  ASSERT_TRUE(other.chi2);
  EXPECT_GT(*other.chi2, *best.chi2);

  const Ledger ledger(folder / "x/ledger.sqlite", Ledger::Mode::read_only);
  int elsewhere = 0;
  for (const LedgerRun& run : ledger.Runs()) {
    if (run.backend != "other") continue;
    ++elsewhere;
    EXPECT_EQ(run.backend_version, "2.1");
  }
  EXPECT_EQ(elsewhere, 3);

  Study plain = With(nullptr);
  const StudyResults without = RunIn(plain, folder / "y");
  EXPECT_TRUE(without.confirmations.empty());
  ASSERT_EQ(without.history.size(), results.history.size());
  for (std::size_t i = 0; i < results.history.size(); ++i) {
    EXPECT_EQ(results.history[i].parameters, without.history[i].parameters);
    EXPECT_EQ(results.history[i].chi2, without.history[i].chi2);
  }
}

TEST(Confirmation, CanBeAddedToAStudyThatHasEndedAndIsDoneOnce) {
  const TemporaryFolder folder;
  Study plain = With(nullptr);
  RunIn(plain, folder / "x");
  for (const int runs : {3, 0}) {
    Study again = With(std::make_unique<Answers>("other", 0));
    EXPECT_EQ(again.Fingerprint(), plain.Fingerprint());
    EXPECT_EQ(RunIn(again, folder / "x").confirmations.at(0).runs.size(), 3u);
    EXPECT_EQ(RunsOf(*again.backend.confirm_with[0]), runs);
    EXPECT_EQ(RunsOf(*again.backend.backend), 0);
  }
  Study later = With(nullptr);
  EXPECT_EQ(RunIn(later, folder / "x").confirmations.at(0).runs.size(), 3u)
      << "shown without being asked for";
}

TEST(Confirmation, OfSeveralBackendsThoseThatCannotAreRecordedWithTheReason) {
  const TemporaryFolder folder;
  std::vector<std::unique_ptr<Answers>> others;
  others.push_back(std::make_unique<Answers>("absent", 0, ""));
  others.push_back(std::make_unique<Answers>("bladeless", 0));
  others.back()->spreads = false;
  others.push_back(std::make_unique<Answers>("broken", 0));
  others.back()->crashes = true;
  others.push_back(std::make_unique<Answers>("whole", 0.001));
  Study study = ConfirmedStudy(std::move(others), true);
  EXPECT_THAT(Planner(study).ConfirmationWarnings(),
              ElementsAre(HasSubstr("absent will not confirm the best point: it is not available, "
                                    "no program 'answers' on PATH"),
                          HasSubstr("bladeless will not confirm the best point in spreading: it "
                                    "has no blade")));
  EXPECT_EQ(Planner(study).ExplainUnsupported(), "") << "the study runs all the same";
  const StudyResults results = RunIn(study, folder / "x");
  ASSERT_EQ(results.confirmations.size(), 4u);
  const ConfirmationResult& absent = results.confirmations[0];
  EXPECT_EQ(absent.outcome, kUnavailable);
  EXPECT_EQ(absent.version, "");
  EXPECT_THAT(absent.message, HasSubstr("no program 'answers' on PATH"));
  EXPECT_EQ(RunsOf(*study.backend.confirm_with[0]), 0);
  const ConfirmationResult& bladeless = results.confirmations[1];
  EXPECT_EQ(bladeless.outcome, kPartial);
  ASSERT_EQ(bladeless.failures.size(), 1u);
  EXPECT_EQ(bladeless.failures[0].experiment, "spreading");
  EXPECT_EQ(bladeless.failures[0].reason, "unsupported");
  EXPECT_TRUE(bladeless.responses[0].simulated);
  EXPECT_FALSE(bladeless.responses[1].simulated);
  EXPECT_FALSE(bladeless.chi2);
  EXPECT_EQ(results.confirmations[2].outcome, "crashed");
  EXPECT_THAT(results.confirmations[2].message, HasSubstr("a segmentation fault"));
  EXPECT_EQ(results.confirmations[3].outcome, "ok");
  EXPECT_EQ(results.state, "finished");
}

TEST(Confirmation, OfABackendThatHasBeenInstalledSinceOrIsGone) {
  const TemporaryFolder folder;
  Study absent = With(std::make_unique<Answers>("other", 0, ""));
  EXPECT_EQ(RunIn(absent, folder / "x").confirmations[0].outcome, kUnavailable);
  Study present = With(std::make_unique<Answers>("other", 0, "1.0"));
  EXPECT_EQ(RunIn(present, folder / "x").confirmations[0].outcome, "ok");
  Study newer = With(std::make_unique<Answers>("other", 0, "1.1"));
  const StudyResults results = RunIn(newer, folder / "x");
  EXPECT_EQ(results.confirmations[0].version, "1.1");
  EXPECT_EQ(results.confirmations[0].runs.size(), 3u) << "versions are not mixed";
  Study gone = With(std::make_unique<Answers>("other", 0, ""));
  EXPECT_EQ(RunIn(gone, folder / "x").confirmations[0].outcome, "ok") << "what is known stays";
}

TEST(Confirmation, InterruptedItGoesOnWhereItStopped) {
  const TemporaryFolder folder;
  std::stop_source stop;
  struct StopInConfirmation : ProgressListener {
    explicit StopInConfirmation(std::stop_source& source) : stop(source) {}
    void OnConfirmation(const LedgerCandidate&, const Progress& progress) override {
      EXPECT_EQ(progress.confirmation_runs, 3);
      EXPECT_EQ(progress.confirmation_done, 0);
      confirming = true;
    }
    void OnRun(const LedgerRun& run, const Progress& progress) override {
      if (!confirming) return;
      EXPECT_EQ(run.backend, "other");
      EXPECT_EQ(progress.confirmation_done, 1);
      stop.request_stop();
    }
    std::stop_source& stop;
    bool confirming = false;
  } listener(stop);
  {
    Study study = With(std::make_unique<Answers>("other", 0));
    StudyRunner runner(study,
                       {.folder = folder / "x", .stop = stop.get_token(), .listener = &listener});
    EXPECT_EQ(runner.Run(), StudyRunner::End::interrupted);
    const StudyResults cut =
        CollectResults(study, Ledger(folder / "x/ledger.sqlite", Ledger::Mode::read_only));
    EXPECT_EQ(cut.state, "finished") << "the calibration is";
    EXPECT_EQ(cut.confirmations.at(0).runs.size(), 1u);
  }
  Study study = With(std::make_unique<Answers>("other", 0));
  EXPECT_EQ(RunIn(study, folder / "x").confirmations.at(0).runs.size(), 3u);
  EXPECT_EQ(RunsOf(*study.backend.confirm_with[0]), 2);
  EXPECT_EQ(RunsOf(*study.backend.backend), 0);
}

TEST(Confirmation, IsOfTheBestPointOnly) {
  const TemporaryFolder folder;
  Study small = With(std::make_unique<Answers>("other", 0));
  small.budget.evaluations = 2;
  RunIn(small, folder / "x");
  Study large = With(nullptr);
  large.budget.evaluations = 20;
  const StudyResults better = RunIn(large, folder / "x");
  ASSERT_GT(*better.best, 1u);
  EXPECT_TRUE(better.confirmations.empty()) << "another point is the best now";
}

TEST(Confirmation, IsPartOfTheCost) {
  Study study = With(std::make_unique<Answers>("other", 0));
  const Planner::Cost cost = Planner(study).EstimateCost();
  ASSERT_EQ(cost.confirmations.size(), 1u);
  ASSERT_EQ(cost.confirmations[0].experiments.size(), 1u);
  EXPECT_EQ(cost.confirmations[0].experiments[0].runs, 3);
  EXPECT_EQ(cost.runs, 8 * 2 + 1 + 3);
}

}  // namespace
}  // namespace powdercal

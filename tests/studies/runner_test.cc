#include "studies/runner.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <new>
#include <thread>

#include "tests/support/program.h"
#include "tests/support/stop_after.h"

namespace powdercal {
namespace {

using ::testing::HasSubstr;

// The table study: real responses, real optimizer, ledger and scheduler, in milliseconds.
Study TableStudy(Overrides overrides = {}) {
  return Study::Load(LibraryStudy("hastelloy_x_table3").string(), overrides);
}

StudyResults RunIn(Study& study, const std::filesystem::path& folder,
                   ProgressListener* listener = nullptr) {
  StudyRunner runner(study, {.folder = folder, .listener = listener});
  EXPECT_EQ(runner.Run(), StudyRunner::End::finished);
  return CollectResults(study, Ledger(folder / "ledger.sqlite", Ledger::Mode::read_only));
}

Study StudyWithOptimizer(const std::string& section, Overrides overrides) {
  const std::string text = StudyText("hastelloy_x_table3");
  const std::size_t begin = text.find("optimizer:\n");
  const std::size_t end = text.find("backend:");
  return Study::Parse(text.substr(0, begin) + section + text.substr(end), "s.yaml",
                      LibraryStudy("").parent_path(), overrides);
}

Study RandomStudy(Overrides overrides) {
  return StudyWithOptimizer("optimizer: random\n", std::move(overrides));
}

void ExpectEqualHistories(const StudyResults& a, const StudyResults& b) {
  ASSERT_EQ(a.history.size(), b.history.size());
  for (std::size_t i = 0; i < a.history.size(); ++i) {
    EXPECT_EQ(a.history[i].parameters, b.history[i].parameters) << i;
    EXPECT_EQ(a.history[i].origin, b.history[i].origin) << i;
    EXPECT_EQ(a.history[i].chi2, b.history[i].chi2) << i;
    EXPECT_EQ(a.history[i].responses[0].simulated, b.history[i].responses[0].simulated) << i;
  }
}

TEST(Runner, ReachesTheToleranceOfTheTableStudy) {
  const TemporaryFolder folder;
  Study study = TableStudy();
  const StudyResults results = RunIn(study, folder / "x");
  ASSERT_TRUE(results.best);
  EXPECT_TRUE(results.converged);
  EXPECT_EQ(results.stop_reason, "every tolerance reached");
  EXPECT_LT(std::abs(*results.history[*results.best].responses[0].simulated - 0.783), 0.007);
  EXPECT_FALSE(results.simulated);
  EXPECT_EQ(results.simulation_seconds, 0);
  EXPECT_EQ(results.history[0].parameters.at("cohesion_energy_density"), 100)
      << "the paper's case 0-1 comes first";
}

TEST(Runner, StopsAtItsBudget) {
  const TemporaryFolder folder;
  Study study =
      TableStudy({{"budget.evaluations", "7"},
                  {"experiments[0].consolidation.observed.void_ratio.tolerance", "1e-12"}});
  const StudyResults results = RunIn(study, folder / "x");
  EXPECT_EQ(results.total, 7);
  EXPECT_EQ(results.stop_reason, "budget of 7 evaluations used");
  EXPECT_FALSE(results.converged);
}

TEST(Runner, SameSeedSameHistoryWithSeveralAtATime) {
  const TemporaryFolder folder;
  std::vector<StudyResults> results;
  for (const char* parallel : {"3", "3"}) {
    Study study = TableStudy({{"budget.parallel", parallel}, {"budget.deterministic", "true"}});
    results.push_back(RunIn(study, folder / ("p" + std::to_string(results.size()))));
  }
  ExpectEqualHistories(results[0], results[1]);
  EXPECT_TRUE(results[0].converged);
}

TEST(Runner, ResumingAFinishedStudyRunsNothing) {
  const TemporaryFolder folder;
  Study study = TableStudy();
  const StudyResults first = RunIn(study, folder / "x");
  struct Counter : ProgressListener {
    int runs = 0;
    int resumed = -1;
    void OnRun(const LedgerRun&, const Progress&) override { ++runs; }
    void OnResume(int evaluations) override { resumed = evaluations; }
  } counter;
  Study again = TableStudy();
  const StudyResults second = RunIn(again, folder / "x", &counter);
  EXPECT_EQ(counter.runs, 0);
  EXPECT_EQ(counter.resumed, first.total);
  ExpectEqualHistories(first, second);
}

TEST(Runner, InterruptedAtAnyPointItEndsAsIfItHadNot) {
  const TemporaryFolder folder;
  for (const std::string parallel : {"1", "2"}) {
    const Overrides overrides = {{"budget.parallel", parallel}, {"budget.deterministic", "true"}};
    Study whole = TableStudy(overrides);
    const StudyResults expected = RunIn(whole, folder / ("whole" + parallel));
    for (int stop_after = 1; stop_after < expected.total; ++stop_after) {
      const auto path = folder / ("cut" + parallel + "-" + std::to_string(stop_after));
      {
        std::stop_source stop;
        StopAfter listener(stop, stop_after);
        Study study = TableStudy(overrides);
        StudyRunner runner(study,
                           {.folder = path, .stop = stop.get_token(), .listener = &listener});
        EXPECT_EQ(runner.Run(), StudyRunner::End::interrupted);
      }
      Study study = TableStudy(overrides);
      ExpectEqualHistories(RunIn(study, path), expected);
    }
  }
}

TEST(Runner, LargerBudgetGoesOnWhereTheSmallerEnded) {
  const TemporaryFolder folder;
  Study small = RandomStudy({{"budget.evaluations", "6"}});
  EXPECT_EQ(RunIn(small, folder / "x").total, 6);
  Study large = RandomStudy({{"budget.evaluations", "9"}});
  const StudyResults results = RunIn(large, folder / "x");
  EXPECT_EQ(results.total, 9);
  Study whole = RandomStudy({{"budget.evaluations", "9"}});
  ExpectEqualHistories(results, RunIn(whole, folder / "y"));
}

TEST(Runner, AStudyOfOneExperimentHasItsBestPointAsParetoFront) {
  const TemporaryFolder folder;
  Study joint = TableStudy();
  Study pareto = TableStudy({{"objective", "pareto"}});
  const StudyResults expected = RunIn(joint, folder / "joint");
  const StudyResults results = RunIn(pareto, folder / "pareto");
  ExpectEqualHistories(results, expected);
  EXPECT_TRUE(expected.objectives.empty());
  EXPECT_TRUE(expected.pareto.empty());
  EXPECT_THAT(results.objectives, testing::ElementsAre("consolidation"));
  EXPECT_THAT(results.pareto, testing::ElementsAre(*results.best));
  for (const EvaluationResult& evaluation : results.history) {
    ASSERT_EQ(evaluation.objectives.size(), 1u);
    EXPECT_EQ(evaluation.objectives[0].chi2, evaluation.chi2);
  }
}

// A void ratio that grows with cohesion and a friction that falls with it: the targets want k of
// about 64 and 25 kJ/m3.
Study ContradictoryStudy(const std::filesystem::path& folder, Overrides overrides = {}) {
  std::string csv =
      "cohesion_energy_density [J/m3],rolling_friction,consolidation.void_ratio,shear.tan_phi\n";
  for (int i = 0; i <= 4; ++i) {
    for (int j = 0; j <= 4; ++j) {
      const double k = 100 + i * 24975;
      const double mu_r = 0.05 + j * 0.1625;
      csv += fmt::format("{},{},{},{}\n", k, mu_r, 0.59 + 3e-6 * k, 0.7 - 4e-6 * k + 0.1 * mu_r);
    }
  }
  WriteFileAtomically(folder / "known.csv", csv);
  std::string text =
      StudyText("hastelloy_x_table3", "tangential: no_history", "tangential: history");
  const std::size_t begin = text.find("experiments:\n");
  text = text.substr(0, begin) +
         "experiments:\n"
         "  - consolidation:\n"
         "      stress: 9 kPa\n"
         "      observed: {void_ratio: {value: 0.783, sd: 0.01}}\n"
         "  - shear:\n"
         "      preshear: 9 kPa\n"
         "      observed: {tan_phi: {value: 0.63, sd: 0.01}}\n"
         "objective: pareto\n"
         "optimizer: bayesian\n"
         "backend: {name: table, file: known.csv}\n"
         "budget: {evaluations: 24, parallel: 1}\n";
  return Study::Parse(text, "s.yaml", folder, overrides);
}

TEST(Runner, TwoExperimentsThatContradictEachOtherSpanAFront) {
  const TemporaryFolder folder;
  Study study = ContradictoryStudy(folder.path());
  const StudyResults results = RunIn(study, folder / "x");
  EXPECT_THAT(results.objectives, testing::ElementsAre("consolidation", "shear"));
  ASSERT_GE(results.pareto.size(), 6u);
  EXPECT_THAT(results.pareto, testing::Contains(*results.best));
  double lowest[2] = {1e300, 1e300};
  for (const std::size_t i : results.pareto) {
    const EvaluationResult& evaluation = results.history[i];
    for (int o = 0; o < 2; ++o) {
      lowest[o] = std::min(lowest[o], *evaluation.objectives[o].chi2);
    }
    EXPECT_NEAR(*evaluation.objectives[0].chi2 + *evaluation.objectives[1].chi2, *evaluation.chi2,
                1e-9 * *evaluation.chi2);
  }
  EXPECT_LT(lowest[0], 0.1);
  EXPECT_LT(lowest[1], 0.1);
  EXPECT_GT(*results.history[*results.best].chi2, 10) << "no point serves both";
}

TEST(Runner, AFrontIsTheSameAfterAnInterruption) {
  const TemporaryFolder folder;
  const Overrides overrides = {{"budget.evaluations", "12"}};
  Study whole = ContradictoryStudy(folder.path(), overrides);
  const StudyResults expected = RunIn(whole, folder / "whole");
  {
    std::stop_source stop;
    StopAfter listener(stop, 8);
    Study study = ContradictoryStudy(folder.path(), overrides);
    StudyRunner runner(study,
                       {.folder = folder / "cut", .stop = stop.get_token(), .listener = &listener});
    EXPECT_EQ(runner.Run(), StudyRunner::End::interrupted);
  }
  Study study = ContradictoryStudy(folder.path(), overrides);
  const StudyResults results = RunIn(study, folder / "cut");
  ExpectEqualHistories(results, expected);
  EXPECT_EQ(results.pareto, expected.pareto);
}

TEST(Runner, EqualPointsShareOneRun) {
  const TemporaryFolder folder;
  Study study = StudyWithOptimizer(
      "optimizer:\n"
      "  name: list\n"
      "  points:\n"
      "    - {cohesion_energy_density: 1e2 J/m3, rolling_friction: 0.05}\n"
      "    - {cohesion_energy_density: 1e2 J/m3, rolling_friction: 0.05}\n",
      {{"budget.parallel", "2"}});
  const StudyResults results = RunIn(study, folder / "x");
  ASSERT_EQ(results.total, 2);
  EXPECT_EQ(results.history[0].responses[0].simulated, results.history[1].responses[0].simulated);
  EXPECT_EQ(results.history[0].runs[0].id, results.history[1].runs[0].id);
  EXPECT_THAT(results.stop_reason, HasSubstr("the optimizer has finished"));
}

TEST(Runner, WallTimeEndsTheStudy) {
  const TemporaryFolder folder;
  Study study =
      RandomStudy({{"budget.evaluations", "1000000"},
                   {"budget.wall_time", "0.5 s"},
                   {"experiments[0].consolidation.observed.void_ratio.tolerance", "1e-9"}});
  const StudyResults results = RunIn(study, folder / "x");
  EXPECT_THAT(results.stop_reason, HasSubstr("wall time"));
  EXPECT_GT(results.total, 0);
}

TEST(Runner, AnotherVersionOfTheBackendIsNotMixedIn) {
  const TemporaryFolder folder;
  Study study = TableStudy();
  RunIn(study, folder / "x");
  Ledger(folder / "x/ledger.sqlite", Ledger::Mode::read_write).SetMeta("backend_version", "0.9");
  try {
    StudyRunner(study, {.folder = folder / "x"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("begun with table 0.9"));
  }
}

// Answers with a void ratio, but fails in its own ways for some particles.
class Faulty final : public Backend {
 public:
  const std::string& name() const override {
    static const std::string kName = "faulty";
    return kName;
  }
  Availability availability() const override { return {.available = true, .version = "1"}; }
  std::string ExplainUnsupported(const Program&) const override { return ""; }
  Trace Run(const Program&, const RunContext&) const override {
    switch (runs_++) {
      case 1:
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        throw std::bad_alloc();
      case 2:
        throw std::runtime_error("an index beyond the end");
      default: {
        Trace trace;
        trace.reported["void_ratio"] = {.value = 0.9};
        return trace;
      }
    }
  }

 private:
  mutable std::atomic<int> runs_ = 0;
};

TEST(Runner, ExceptionsOfABackendFailTheirOwnRunOnly) {
  const TemporaryFolder folder;
  Study study = RandomStudy({{"budget.evaluations", "5"}});
  study.backend.backend = std::make_unique<Faulty>();
  const StudyResults results = RunIn(study, folder / "x");
  EXPECT_EQ(results.total, 5);
  EXPECT_EQ(results.failed, 2);
  EXPECT_EQ(results.history[1].outcome, "crashed");
  EXPECT_THAT(results.history[1].message, HasSubstr("bad_alloc"));
  EXPECT_EQ(results.history[2].outcome, "crashed");
  EXPECT_THAT(results.history[2].message, HasSubstr("an index beyond the end"));
  EXPECT_EQ(results.history[4].outcome, "ok");
  EXPECT_GE(results.simulation_seconds, 0.02) << "what it took until then is no overhead";
}

TEST(Runner, AbsentSimulatorStopsBeforeAnythingIsMade) {
  const TemporaryFolder folder;
  const ProcessResult result =
      Powdercal({"run", "quickstart", "--backend", "liggghts", "--out", (folder / "x").string()},
                folder.path(), {{"PATH", "/nonexistent"}});
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_THAT(result.output, HasSubstr("no program 'liggghts' on PATH"));
  EXPECT_FALSE(std::filesystem::exists(folder / "x"));
}

}  // namespace
}  // namespace powdercal

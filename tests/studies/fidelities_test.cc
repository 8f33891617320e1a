#include "studies/fidelities.h"

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>

#include "studies/runner.h"
#include "tests/support/program.h"
#include "tests/support/stop_after.h"

namespace powdercal {
namespace {

using ::testing::HasSubstr;

Study SeveralFidelities(Overrides overrides = {}) {
  overrides.emplace("backend.fidelity", "standard");
  overrides.emplace("backend.lower_fidelities", "[quick]");
  return Study::Load("quickstart", overrides);
}

// Void ratios of a bed whose size shifts them; every answer says at which fidelity it was asked.
class Answers final : public Backend {
 public:
  const std::string& name() const override {
    static const std::string kName = "answers";
    return kName;
  }
  Availability availability() const override { return {.available = true, .version = "1"}; }
  std::string ExplainUnsupported(const Program&) const override { return ""; }
  Trace Run(const Program& program, const RunContext& context) const override {
    Trace trace;
    if (context.stop.stop_requested()) {
      trace.outcome = {Reason::cancelled, ""};
      return trace;
    }
    const bool quick = program.fidelity == Fidelity::quick;
    ++(quick ? quick_runs : standard_runs);
    const double k = std::log10(program.parameters.at("cohesion_energy_density"));
    const double mu_r = program.parameters.at("rolling_friction");
    const double scatter = 1e-3 * static_cast<double>(program.particles.seed % 7);
    trace.reported["void_ratio"] = {.value =
                                        0.6 + 0.02 * k * k * mu_r + (quick ? 0.05 : 0) + scatter};
    return trace;
  }

  mutable std::atomic<int> quick_runs = 0;
  mutable std::atomic<int> standard_runs = 0;
};

StudyResults RunIn(Study& study, const std::filesystem::path& folder, std::stop_token stop = {},
                   ProgressListener* listener = nullptr) {
  StudyRunner runner(study, {.folder = folder, .stop = stop, .listener = listener});
  runner.Run();
  return CollectResults(study, Ledger(folder / "ledger.sqlite", Ledger::Mode::read_only));
}

Study AnsweredStudy(int evaluations) {
  Study study = SeveralFidelities({{"budget.evaluations", std::to_string(evaluations)},
                                   {"budget.deterministic", "true"},
                                   {"budget.parallel", "2"}});
  study.experiments[0].observed[0].tolerance.reset();
  study.backend.backend = std::make_unique<Answers>();
  return study;
}

TEST(Fidelities, CostIsTheShareOfParticleSteps) {
  const Study study = SeveralFidelities();
  const Planner planner(study);
  const StudyFidelities fidelities(study, planner);
  ASSERT_TRUE(fidelities.several());
  ASSERT_EQ(fidelities.levels().size(), 2u);
  EXPECT_EQ(fidelities.levels()[0].fidelity, 0.5);
  // 1000 of 3000 particles, which a lower bed lets settle in fewer steps.
  EXPECT_GT(fidelities.CostAt(0.5), 0.2);
  EXPECT_LT(fidelities.CostAt(0.5), 1.0 / 3);
  EXPECT_EQ(fidelities.levels()[1].fidelity, 1);
  EXPECT_EQ(fidelities.CostAt(1), 1);
  EXPECT_EQ(FidelityNameAt(study, 0.5), "quick");
  EXPECT_EQ(FidelityNameAt(study, 1), "standard");
}

TEST(Fidelities, LowerOnesPlanSmallerPrograms) {
  const Study study = SeveralFidelities();
  const Planner planner(study);
  const StudyFidelities fidelities(study, planner);
  const Program quick = fidelities.PlannerAt(0.5).Plan({1e4, 0.3}, 0)[0].program;
  const Program standard = fidelities.PlannerAt(1).Plan({1e4, 0.3}, 0)[0].program;
  EXPECT_EQ(quick.fidelity, Fidelity::quick);
  EXPECT_EQ(standard.fidelity, Fidelity::standard);
  EXPECT_LT(quick.particles.count, standard.particles.count);
  // What a study at `quick` would run: the ledger's runs serve either.
  const Study small = Study::Load("quickstart");
  EXPECT_EQ(quick.Hash(), Planner(small).Plan({1e4, 0.3}, 0)[0].program.Hash());
}

TEST(Fidelities, AStudyWithoutAChoiceHasNone) {
  const Study study = Study::Load("quickstart");
  const Planner planner(study);
  const StudyFidelities fidelities(study, planner);
  EXPECT_FALSE(fidelities.several());
  EXPECT_TRUE(fidelities.levels().empty());
  EXPECT_EQ(&fidelities.PlannerAt(1), &planner);
  EXPECT_EQ(FidelityNameAt(study, 1), "quick");
}

TEST(Fidelities, AreWrittenAndReadBackAndPartOfTheProblem) {
  Study study = SeveralFidelities();
  Study again = Study::Parse(study.ToYaml(), "s.yaml", study.base_folder);
  EXPECT_EQ(again.backend.lower_fidelities, std::vector<Fidelity>{Fidelity::quick});
  EXPECT_EQ(again.Fingerprint(), study.Fingerprint());
  Study plain = Study::Load("quickstart", {{"backend.fidelity", "standard"}});
  EXPECT_NE(plain.Fingerprint(), study.Fingerprint());
  EXPECT_THAT(plain.ToYaml(), Not(HasSubstr("lower_fidelities")));
}

void ExpectRefusal(const Overrides& overrides, const std::string& text) {
  try {
    SeveralFidelities(overrides);
    FAIL() << "accepted; expected: " << text;
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(text));
  }
}

TEST(Fidelities, RefusesWhatCannotBe) {
  ExpectRefusal({{"backend.lower_fidelities", "[standard]"}},
                "'standard' is not below the study's fidelity 'standard'");
  ExpectRefusal({{"backend.lower_fidelities", "[quik]"}}, "did you mean 'quick'");
  ExpectRefusal({{"optimizer.acquisition", "qlog_nei"}}, "several fidelities need one objective");
  try {
    Study::Load("twin_joint", {{"backend.fidelity", "standard"},
                               {"backend.lower_fidelities", "[quick]"},
                               {"objective", "pareto"},
                               {"optimizer.acquisition", "qlog_nehvi"}});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("several fidelities need one objective"));
  }
  const std::string text = StudyText("quickstart");
  const std::string genetic = text.substr(0, text.find("optimizer:")) + "optimizer: genetic\n" +
                              "backend: {fidelity: standard, lower_fidelities: [quick]}\n";
  try {
    Study::Parse(genetic, "s.yaml", LibraryStudy("").parent_path());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("optimizer 'genetic' cannot choose between fidelities"));
  }
  try {
    Study::Load("hastelloy_x_table3", {{"backend.lower_fidelities", "[quick]"}});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("simulates nothing"));
  }
}

TEST(Fidelities, TheBudgetCountsCostsAndOnlyTheTargetIsRanked) {
  const TemporaryFolder folder;
  Study study = AnsweredStudy(8);
  const StudyResults results = RunIn(study, folder / "x");
  EXPECT_GT(results.total, 8) << "smaller simulations count for less";
  EXPECT_EQ(results.history.size() + results.lower_fidelity.size(),
            static_cast<std::size_t>(results.total));
  ASSERT_GE(results.lower_fidelity.size(), 5u) << "the initial design at least";
  for (const EvaluationResult& evaluation : results.history) {
    EXPECT_EQ(evaluation.fidelity, "standard");
  }
  for (const EvaluationResult& evaluation : results.lower_fidelity) {
    EXPECT_EQ(evaluation.fidelity, "quick");
    EXPECT_FALSE(evaluation.best_chi2);
  }
  ASSERT_TRUE(results.best);
  // The design of five at `quick` has points nearer to the target than its shift lets them be.
  const double found = *results.history[*results.best].responses[0].simulated;
  EXPECT_NEAR(found, study.experiments[0].observed[0].value, 0.01);
  const auto& answers = dynamic_cast<const Answers&>(*study.backend.backend);
  EXPECT_EQ(answers.quick_runs,
            study.backend.replicates * static_cast<int>(results.lower_fidelity.size()));
  const double cost = StudyFidelities(study, Planner(study)).CostAt(0.5);
  const double used = static_cast<double>(results.history.size()) +
                      cost * static_cast<double>(results.lower_fidelity.size());
  EXPECT_GE(used, 8 - 1e-9);
  EXPECT_LT(used, 9);
}

// Small simulations count for less, never for more, than an evaluation.
class Watcher final : public StopAfter {
 public:
  using StopAfter::StopAfter;
  void OnEvaluation(const LedgerCandidate& candidate, const ReducedResponses& responses,
                    const std::vector<ExperimentFailure>& failures,
                    const Progress& progress) override {
    EXPECT_LE(progress.used, progress.done);
    StopAfter::OnEvaluation(candidate, responses, failures, progress);
  }
};

TEST(Fidelities, ResumedItAsksAtTheSameFidelities) {
  const TemporaryFolder folder;
  Study study = AnsweredStudy(6);
  const StudyResults whole = RunIn(study, folder / "whole");
  for (const int evaluations : {2, 6, 9}) {
    const std::filesystem::path part = folder / ("part" + std::to_string(evaluations));
    std::stop_source stop;
    Watcher listener(stop, evaluations);
    Study first = AnsweredStudy(6);
    RunIn(first, part, stop.get_token(), &listener);
    Study second = AnsweredStudy(6);
    const StudyResults resumed = RunIn(second, part);
    ASSERT_EQ(resumed.history.size(), whole.history.size());
    ASSERT_EQ(resumed.lower_fidelity.size(), whole.lower_fidelity.size());
    for (std::size_t i = 0; i < whole.history.size(); ++i) {
      EXPECT_EQ(resumed.history[i].parameters, whole.history[i].parameters);
      EXPECT_EQ(resumed.history[i].chi2, whole.history[i].chi2);
    }
    for (std::size_t i = 0; i < whole.lower_fidelity.size(); ++i) {
      EXPECT_EQ(resumed.lower_fidelity[i].parameters, whole.lower_fidelity[i].parameters);
    }
  }
}

}  // namespace
}  // namespace powdercal

#include "studies/study.h"

#include <gmock/gmock.h>

#include "tests/support/program.h"

namespace powdercal {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

const std::filesystem::path kLibrary = LibraryStudy("").parent_path();

// The message for a shipped study with one piece of text replaced.
std::string MessageFor(const std::string& study, const std::string& from, const std::string& to) {
  try {
    Study::Parse(StudyText(study, from, to), "bad.yaml", kLibrary);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Study, ShippedStudiesLoad) {
  for (const std::string& name : ShippedStudies()) {
    EXPECT_NO_THROW(Study::Load(LibraryStudy(name).string())) << name;
    EXPECT_NO_THROW(Study::Load(name)) << name << " by name";
  }
}

TEST(Study, AShippedStudyMayLieInAFolder) {
  EXPECT_THAT(ShippedStudies(), AllOf(Contains("quickstart"), Contains("paper/spreading")));
  EXPECT_EQ(Study::Load("paper/spreading").name, "paper-spreading");
  EXPECT_EQ(Study::Load("paper/spreading.yaml").name, "paper-spreading");
  // Its table lies beside its folder.
  EXPECT_EQ(Study::Load("paper/table3_search").backend.backend->name(), "table");
}

std::string LoadingMessage(const std::string& name) {
  try {
    Study::Load(name);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Study, AnUnknownNameIsAnsweredWithTheNearestStudy) {
  EXPECT_THAT(LoadingMessage("quickstrat"), HasSubstr("did you mean 'quickstart'?"));
  EXPECT_THAT(LoadingMessage("paper/spredding"), HasSubstr("did you mean 'paper/spreading'?"));
  EXPECT_THAT(LoadingMessage("stress_swep"), HasSubstr("did you mean 'paper/stress_sweep'?"));
  EXPECT_THAT(LoadingMessage("paper/../quickstart"), HasSubstr("no such study file"));
  EXPECT_THAT(LoadingMessage("paper"), HasSubstr("no such study file"));
}

TEST(Study, QuickstartSaysWhatTheFileSays) {
  const Study study = Study::Load("quickstart");
  EXPECT_EQ(study.powder.density, 8220);
  EXPECT_EQ(study.powder.young_modulus, 200e9);
  EXPECT_DOUBLE_EQ(study.powder.sizes.mean, 29e-6);
  EXPECT_EQ(study.law.cohesion, ContactLaw::Cohesion::sjkr2);
  EXPECT_EQ(study.law.rolling, ContactLaw::Rolling::epsd2);
  ASSERT_EQ(study.space.dimension(), 2);
  EXPECT_EQ(study.space.parameters[0].symbol, "k");
  EXPECT_EQ(study.space.parameters[0].upper, 1e5);
  EXPECT_EQ(study.backend.backend->name(), "embedded");
  const Objectives objectives = study.MakeObjectives();
  ASSERT_EQ(objectives.targets.size(), 1u);
  EXPECT_EQ(objectives.targets[0].response, "consolidation.void_ratio");
  EXPECT_EQ(objectives.targets[0].value, 0.783);
}

TEST(Study, TheBackendIsEmbeddedUnlessAnotherIsNamed) {
  const std::string section =
      "backend: {name: embedded, fidelity: quick, replicates: 3, confirm_replicates: 6}\n";
  const std::string named = Study::Load("quickstart").ToYaml();
  const auto parse = [&](const std::string& backend, const Overrides& overrides = {}) {
    return Study::Parse(StudyText("quickstart", section, backend), "s.yaml", kLibrary, overrides);
  };
  const Study unnamed = parse("");
  EXPECT_EQ(unnamed.backend.backend->name(), "embedded");
  EXPECT_EQ(unnamed.backend.replicates, 1);
  EXPECT_EQ(parse("backend: {replicates: 3, confirm_replicates: 6}\n").ToYaml(), named);
  EXPECT_EQ(parse("", {{"backend.replicates", "3"}, {"backend.confirm_replicates", "6"}}).ToYaml(),
            named);
  EXPECT_EQ(parse("", {{"backend.name", "liggghts"}}).backend.backend->name(), "liggghts");
  EXPECT_EQ(parse("backend: liggghts\n").backend.backend->name(), "liggghts");
}

TEST(Study, AnotherBackendKeepsAllElseThatItHas) {
  const Study study = Study::Load("quickstart", {{"backend.name", "liggghts"}});
  EXPECT_EQ(study.backend.backend->name(), "liggghts");
  EXPECT_EQ(study.backend.replicates, 3);
  EXPECT_EQ(study.backend.confirm_replicates, 6);
}

TEST(Study, ResolvedTextReadsBackToTheSameStudy) {
  for (const std::string& name : ShippedStudies()) {
    Study study = Study::Load(name);
    const std::string text = study.ToYaml();
    Study again = Study::Parse(text, "study.yaml", LibraryStudy(name).parent_path());
    EXPECT_EQ(again.ToYaml(), text) << name;
    EXPECT_EQ(again.Fingerprint(), study.Fingerprint()) << name;
  }
}

TEST(Study, FingerprintIgnoresTheBudgetAlone) {
  const std::string base = Study::Load("quickstart").Fingerprint();
  EXPECT_EQ(Study::Load("quickstart", {{"budget.evaluations", "7"}}).Fingerprint(), base);
  EXPECT_NE(Study::Load("quickstart", {{"seed", "7"}}).Fingerprint(), base);
  EXPECT_NE(Study::Load("quickstart", {{"backend.fidelity", "standard"}}).Fingerprint(), base);
}

// The quickstart study with further experiments.
Study WithExperiments(const std::string& more, const Overrides& overrides = {},
                      const std::filesystem::path& folder = kLibrary) {
  return Study::Parse(StudyText("quickstart", "objective: joint", more + "objective: joint"),
                      "s.yaml", folder, overrides);
}

std::string MessageWith(const std::string& more, const std::filesystem::path& folder = kLibrary) {
  try {
    WithExperiments(more, {}, folder);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(StudyExperiments, OnlyWhatIsObservedIsCalibratedUnlessTheStudySaysOtherwise) {
  const Study study = WithExperiments(
      "  - shear: {preshear: 9 kPa}\n"
      "  - spreading:\n"
      "      calibrate: false\n"
      "      observed: {coverage: {value: 0.9, sd: 0.05}}\n");
  EXPECT_THAT(study.CalibratedExperiments(), ::testing::ElementsAre(0u));
  ASSERT_EQ(study.MakeObjectives().targets.size(), 1u);
  EXPECT_EQ(study.Observations().size(), 1u);
  EXPECT_EQ(study.experiments[2].observed.size(), 1u) << "kept to compare with";
  const Study all = WithExperiments(
      "  - spreading: {observed: {coverage: {value: 0.9, sd: 0.05}}}\n", {{"objective", "joint"}});
  EXPECT_THAT(all.CalibratedExperiments(), ::testing::ElementsAre(0u, 1u));
  EXPECT_EQ(all.MakeObjectives().targets[1].objective, 1);
}

TEST(StudyExperiments, FidelityOfTheirOwn) {
  const std::string spreading =
      "  - spreading: {fidelity: standard, observed: {coverage: {value: 0.9, sd: 0.05}}}\n";
  Study study = WithExperiments(spreading);
  EXPECT_EQ(study.FidelityOf(0), Fidelity::quick);
  EXPECT_EQ(study.FidelityOf(1), Fidelity::standard);
  Study again =
      Study::Parse(study.ToYaml(), "study.yaml", kLibrary,
                   {{"backend.fidelity", "paper"}, {"experiments[1].spreading.fidelity", "quick"}});
  EXPECT_EQ(again.FidelityOf(0), Fidelity::paper) << "the resolved study leaves it to the backend";
  EXPECT_EQ(again.FidelityOf(1), Fidelity::quick);
  EXPECT_NE(again.Fingerprint(), study.Fingerprint());
}

TEST(StudyExperiments, WhatIsNotCalibratedMayBeAddedToAStudyThatHasRun) {
  Study alone = Study::Load("quickstart");
  Study more = WithExperiments("  - shear: {preshear: 9 kPa}\n");
  Study compared = WithExperiments(
      "  - spreading: {calibrate: false, observed: {coverage: {value: 0.9, sd: 0.05}}}\n");
  Study fitted = WithExperiments("  - spreading: {observed: {coverage: {value: 0.9, sd: 0.05}}}\n");
  EXPECT_EQ(more.Fingerprint(), alone.Fingerprint());
  EXPECT_EQ(compared.Fingerprint(), alone.Fingerprint());
  EXPECT_NE(fitted.Fingerprint(), alone.Fingerprint());
  EXPECT_THAT(more.ToYaml(), HasSubstr("calibrate: false")) << "but it is written down";
}

TEST(StudyExperiments, TransferTakesThoseThatAreNotCalibrated) {
  const Study study = WithExperiments("  - shear: {preshear: 9 kPa}\n  - spreading: {}\n");
  EXPECT_THAT(study.TransferExperiments({"spreading", "shear"}), ::testing::ElementsAre(1u, 2u));
  EXPECT_THAT(study.TransferExperiments({}), ::testing::IsEmpty());
  const auto message = [&](const std::string& name) -> std::string {
    try {
      study.TransferExperiments({"shear", name});
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(message("consolidation"),
              AllOf(HasSubstr("command line: --evaluate-also"), HasSubstr("is calibrated"),
                    HasSubstr("not calibrated: shear, spreading")));
  EXPECT_THAT(message("spreadin"),
              AllOf(HasSubstr("not in the study"), HasSubstr("did you mean 'spreading'?")));
}

TEST(StudyExperiments, MistakesAreExplained) {
  EXPECT_THAT(MessageWith("  - spreading: {calibrate: true}\n"),
              AllOf(HasSubstr("experiments[1].spreading.calibrate"), HasSubstr("'observed'")));
  EXPECT_THAT(MessageWith("  - spreading: {calibrat: true}\n"),
              HasSubstr("did you mean 'calibrate'?"));
  EXPECT_THAT(MessageWith("  - spreading: {fidelity: quik}\n"),
              HasSubstr("unknown fidelity 'quik'"));
  EXPECT_THAT(
      MessageFor("quickstart", "      observed:", "      calibrate: false\n      observed:"),
      HasSubstr("nothing to calibrate against"));
}

class ObservedFiles : public ::testing::Test {
 protected:
  std::string Shear(const std::string& observed) const {
    return "  - shear: {preshear: 9 kPa, observed: {" + observed + "}}\n";
  }
  std::string Message(const std::string& observed) const {
    return MessageWith(Shear(observed), folder_.path());
  }
  void Write(const std::string& rows) const {
    WriteFileAtomically(folder_ / "locus.csv",
                        "normal_stress [kPa],shear_stress [kPa],shear_stress_sd [kPa]\n" + rows);
  }

  TemporaryFolder folder_;
};

TEST_F(ObservedFiles, AreReadOnceAndWrittenOut) {
  Write("3,1.8,0.15\n6,3.4,0.2\n");
  for (const std::string given :
       {"yield_locus: locus.csv", "yield_locus: {file: locus.csv, source: locus.csv}"}) {
    Study study = WithExperiments(Shear(given), {}, folder_.path());
    const auto& observed = study.experiments[1].observed;
    ASSERT_EQ(observed.size(), 2u);
    EXPECT_EQ(observed[1].response, "shear_stress_2");
    EXPECT_DOUBLE_EQ(observed[1].value, 3400);
    EXPECT_DOUBLE_EQ(observed[1].sd, 200);
    EXPECT_EQ(observed[1].source, "locus.csv");
    const std::string text = study.ToYaml();
    EXPECT_THAT(text, ::testing::Not(HasSubstr("yield_locus")));
    Study again = Study::Parse(text, "study.yaml", "/nowhere");
    EXPECT_EQ(again.ToYaml(), text) << "the folder of a run does not need the file";
    EXPECT_EQ(again.Fingerprint(), study.Fingerprint());
  }
}

TEST_F(ObservedFiles, MistakesAreExplained) {
  EXPECT_THAT(Message("yield_locus: nosuch.csv"),
              AllOf(HasSubstr("s.yaml:"), HasSubstr("shear.observed.yield_locus"),
                    HasSubstr("nosuch.csv")));
  EXPECT_THAT(Message("yield_locs: locus.csv"), HasSubstr("did you mean 'yield_locus'?"));
  Write("3,1.8,0.15\n6,much,0.2\n");
  EXPECT_THAT(Message("yield_locus: locus.csv"),
              AllOf(HasSubstr("locus.csv:3"), HasSubstr("shear_stress"), HasSubstr("much")));
  Write("3,1.8,0.15\n6,3.4,0.2\n");
  EXPECT_THAT(Message("yield_locus: locus.csv, shear_stress_1: {value: 1 kPa, sd: 1 Pa}"),
              AllOf(HasSubstr("shear_stress_1"), HasSubstr("observed twice")));
  EXPECT_THAT(Message("shear_stress_1: 1.8 kPa"),
              AllOf(HasSubstr("not read from a file"), HasSubstr("yield_locus")));
}

TEST(Study, OverridesReachAnyKey) {
  const Study study = Study::Load("quickstart", {{"budget.evaluations", "7"},
                                                 {"numerics.time_step", "1e-6 s"},
                                                 {"experiments[0].consolidation.stress", "3 kPa"}});
  EXPECT_EQ(study.budget.evaluations, 7);
  EXPECT_EQ(study.numerics.time_step, 1e-6);
  EXPECT_EQ(study.backend.replicates, 3) << "what is not overridden stays";
}

TEST(Study, OverridesReplaceListsAndSections) {
  const Study study = Study::Load(
      "quickstart", {{"parameters.rolling_friction.range", "[0.1, 0.2]"}, {"optimizer", "random"}});
  EXPECT_EQ(study.space.parameters[1].lower, 0.1);
  EXPECT_EQ(study.space.parameters[1].upper, 0.2);
  EXPECT_EQ(study.optimizer->name(), "random");
}

TEST(Study, UnusedOverrideIsAnError) {
  try {
    Study::Load("quickstart", {{"budget.evaluatons", "7"}});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("command line"), HasSubstr("budget.evaluatons")));
  }
}

TEST(StudyErrors, UnknownKeySuggestsTheNearest) {
  EXPECT_THAT(MessageFor("quickstart", "restitution: 0.4", "restitition: 0.4"),
              AllOf(HasSubstr("bad.yaml:"), HasSubstr("material"), HasSubstr("restitution")));
  EXPECT_THAT(MessageFor("quickstart", "objective: joint", "objectiv: joint"),
              AllOf(HasSubstr("unknown key 'objectiv'"), HasSubstr("did you mean 'objective'?")));
}

TEST(StudyErrors, MissingUnit) {
  EXPECT_THAT(MessageFor("quickstart", "stress: 9 kPa", "stress: 9"),
              AllOf(HasSubstr("experiments[0].consolidation.stress"), HasSubstr("has no unit"),
                    HasSubstr("pressure")));
  EXPECT_THAT(MessageFor("quickstart", "unit: J/m3, ", ""),
              AllOf(HasSubstr("missing unit"), HasSubstr("J/m3")));
}

TEST(StudyErrors, WrongDimensionNamesBoth) {
  EXPECT_THAT(MessageFor("quickstart", "density: 8220 kg/m3", "density: 8220 kPa"),
              AllOf(HasSubstr("bad.yaml:8"), HasSubstr("density"), HasSubstr("pressure"),
                    HasSubstr("8220 kPa")));
}

TEST(StudyErrors, ReversedRange) {
  EXPECT_THAT(MessageFor("quickstart", "range: [1e2, 1e5]", "range: [1e5, 1e2]"),
              AllOf(HasSubstr("parameters.cohesion_energy_density.range"), HasSubstr("100000"),
                    HasSubstr("not below")));
}

TEST(StudyErrors, UnknownBackendOptimizerExperimentResponse) {
  EXPECT_THAT(MessageFor("quickstart", "name: embedded", "name: embeded"),
              AllOf(HasSubstr("unknown backend 'embeded'"), HasSubstr("did you mean 'embedded'?")));
  EXPECT_THAT(MessageFor("quickstart", "name: bayesian", "name: baysian"),
              HasSubstr("did you mean 'bayesian'?"));
  EXPECT_THAT(MessageFor("quickstart", "- consolidation:", "- consolidaton:"),
              HasSubstr("did you mean 'consolidation'?"));
  EXPECT_THAT(MessageFor("quickstart", "void_ratio:", "voidratio:"),
              HasSubstr("did you mean 'void_ratio'?"));
}

TEST(StudyErrors, FreeParameterWithoutEffect) {
  EXPECT_THAT(MessageFor("quickstart", "cohesion: sjkr2", "cohesion: none"),
              AllOf(HasSubstr("cohesion_energy_density"), HasSubstr("no effect")));
}

TEST(StudyErrors, MissingCsvAndBadRow) {
  EXPECT_THAT(MessageFor("hastelloy_x_table3", "file: hastelloy_x_table3.csv", "file: absent.csv"),
              HasSubstr("absent.csv"));
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "bad.csv",
                      "cohesion_energy_density [J/m3],rolling_friction,consolidation.void_ratio\n"
                      "100,0.05,0.575\n200,zero,0.6\n300,0.1,0.7\n");
  try {
    Study::Parse(
        StudyText("hastelloy_x_table3", "hastelloy_x_table3.csv", (folder / "bad.csv").string()),
        "bad.yaml", kLibrary);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("bad.csv:3"), HasSubstr("zero")));
  }
}

TEST(StudyErrors, NoSuchStudyNamesTheShippedOnes) {
  try {
    Study::Load("quickstrat");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("did you mean 'quickstart'?"));
  }
}

const char kRollingFriction[] = "rolling_friction: {";
const char kWithModel[] = "rolling_model: {choices: [cdt, epsd2]}\n  rolling_friction: {";

TEST(CategoricalParameter, IsReadWrittenAndShownByName) {
  Study study =
      Study::Parse(StudyText("quickstart", kRollingFriction, kWithModel), "s.yaml", kLibrary);
  ASSERT_EQ(study.space.dimension(), 3);
  const Parameter& parameter = study.space.parameters[1];
  EXPECT_EQ(parameter.name, "rolling_model");
  EXPECT_EQ(parameter.kind, Parameter::Kind::categorical);
  EXPECT_EQ(parameter.levels(), 2);
  EXPECT_EQ(parameter.CategoryAt(0), "cdt");
  EXPECT_EQ(parameter.CategoryAt(1), "epsd2");
  EXPECT_EQ(study.law.rolling, ContactLaw::Rolling::epsd2);
  EXPECT_EQ(study.LawAt({1e4, 0, 0.5}).rolling, ContactLaw::Rolling::cdt);
  EXPECT_TRUE(study.warnings.empty());
  Study back = Study::Parse(study.ToYaml(), "back.yaml", kLibrary);
  EXPECT_EQ(back.ToYaml(), study.ToYaml());
  EXPECT_EQ(back.space.parameters[1].categories, parameter.categories);
}

TEST(CategoricalParameter, TheContactLawHasOneOfTheChoices) {
  const std::string text = StudyText("quickstart", kRollingFriction,
                                     "rolling_model: {choices: [cdt, none]}\n  "
                                     "rolling_friction: {");
  Study study = Study::Parse(text, "s.yaml", kLibrary);
  EXPECT_EQ(study.law.rolling, ContactLaw::Rolling::cdt);
  ASSERT_EQ(study.warnings.size(), 1u);
  EXPECT_THAT(study.warnings[0], HasSubstr("epsd2 has no effect"));
  EXPECT_TRUE(Study::Parse(study.ToYaml(), "back.yaml", kLibrary).warnings.empty());
}

TEST(CategoricalParameter, MistakesAreNamed) {
  const auto message = [](const std::string& section) {
    return MessageFor("quickstart", kRollingFriction, section + "\n  rolling_friction: {");
  };
  EXPECT_THAT(message("rolling_model: {choices: [cdt, espd2]}"), HasSubstr("epsd2"));
  EXPECT_THAT(message("rolling_model: {choices: [cdt]}"), HasSubstr("at least two of"));
  EXPECT_THAT(message("rolling_model: {range: [0, 1]}"), HasSubstr("has `choices`"));
  EXPECT_THAT(message("rolling_model: {}"), HasSubstr("choices"));
}

TEST(CategoricalParameter, OptimizersWithoutCategoriesAndTablesRefuse) {
  const auto message = [](const Overrides& overrides) -> std::string {
    try {
      Study::Parse(StudyText("quickstart", kRollingFriction, kWithModel), "s.yaml", kLibrary,
                   overrides);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message({{"optimizer", "cma_es"}}),
              AllOf(HasSubstr("rolling_model"), HasSubstr("genetic")));
  EXPECT_THAT(message({{"optimizer", "least_squares"}}),
              AllOf(HasSubstr("rolling_model"), HasSubstr("derivative")));
  EXPECT_EQ(message({{"optimizer", "genetic"}}), "");
  EXPECT_EQ(message({{"optimizer", "orthogonal_array"}}), "");
}

}  // namespace
}  // namespace powdercal

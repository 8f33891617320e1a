#include "studies/planner.h"

#include <gmock/gmock.h>

#include <regex>

#include "tests/support/program.h"

namespace powdercal {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kLibrary = LibraryStudy("").parent_path();

TEST(Planner, ScalesAndPutsTheParametersIn) {
  const Study study = Study::Load("quickstart");
  const Planner planner(study);
  const auto runs = planner.Plan({47500, 0.5}, 0);
  ASSERT_EQ(runs.size(), 1u);
  const Program& program = runs[0].program;
  EXPECT_EQ(program.materials.young_modulus, 5e6);
  EXPECT_EQ(program.materials.particle_particle.cohesion_energy_density, 47500);
  EXPECT_EQ(program.materials.particle_wall.cohesion_energy_density, 47500);
  EXPECT_EQ(program.materials.particle_particle.rolling_friction, 0.5);
  EXPECT_EQ(program.parameters.at("cohesion_energy_density"), 47500);
  const auto* servo = std::get_if<Servo>(&program.stages.at(2));
  ASSERT_NE(servo, nullptr);
  EXPECT_EQ(servo->stress, 900);
  const double rayleigh = RayleighTime(6.25e-6, 8220, 5e6, 0.3);
  EXPECT_NEAR(program.time_step, 0.2 * rayleigh, 1e-12);
}

TEST(Planner, SamePointSameRunsOtherPointsOtherParticles) {
  const Study study = Study::Load("quickstart");
  const Planner planner(study);
  const auto run = [&](double k, int replicate) { return planner.Plan({k, 0.5}, replicate)[0]; };
  EXPECT_EQ(run(1e4, 0).key, run(1e4, 0).key);
  EXPECT_NE(run(1e4, 0).seed, run(1e4, 1).seed);
  EXPECT_NE(run(1e4, 0).seed, run(2e4, 0).seed);
  EXPECT_NE(run(1e4, 0).key, run(1e4, 1).key);
}

TEST(Planner, RefusesWhatTheBackendCannotRun) {
  const Study study = Study::Parse(StudyText("quickstart", "tangential: history",
                                             "tangential: history, shear_update: incremental"),
                                   "s.yaml", kLibrary, {{"backend.name", "liggghts"}});
  EXPECT_THAT(Planner(study).ExplainUnsupported(), HasSubstr("shear_update"));
}

// The quickstart study with a shear test instead.
std::string ShearStudy(const std::string& law) {
  const std::string text = ReadFile(LibraryStudy("quickstart"));
  const std::size_t begin = text.find("contact_law:");
  const std::size_t experiments = text.find("experiments:");
  const std::size_t end = text.find("objective:");
  return text.substr(0, begin) + "contact_law: " + law +
         text.substr(text.find("\n", begin), experiments - text.find("\n", begin)) +
         "experiments:\n  - shear: {preshear: 9 kPa, observed: {steady_state_friction: {value: "
         "0.5, sd: 0.02}}}\n" +
         text.substr(end);
}

TEST(Planner, AnExperimentCanRefuseThePowder) {
  const Study good = Study::Parse(ShearStudy("{cohesion: sjkr2, rolling: epsd2}"), "s.yaml", {});
  EXPECT_EQ(Planner(good).ExplainUnsupported(), "");
  EXPECT_THAT(Planner(good).Warnings(), ::testing::IsEmpty());
  const Study bad = Study::Parse(
      ShearStudy("{tangential: no_history, cohesion: sjkr2, rolling: epsd2}"), "s.yaml", {});
  EXPECT_THAT(Planner(bad).ExplainUnsupported(), HasSubstr("shear: tangential: no_history"));
}

TEST(Planner, WarnsAtTheLargestRollingFriction) {
  const Study study = Study::Parse(ShearStudy("{cohesion: sjkr2, rolling: cdt}"), "s.yaml", {});
  EXPECT_THAT(Planner(study).Warnings(),
              ::testing::ElementsAre(HasSubstr("rolling_friction 0.7, chi")));
}

TEST(Planner, SimulationHasTheExperimentsOwnRate) {
  const Study study = Study::Parse(ShearStudy("{cohesion: sjkr2, rolling: epsd2}"), "s.yaml", {});
  const auto tables = Planner(study).ScalingTables({0}, {47500, 0.5});
  const auto& groups = tables.at(0).groups;
  const auto rate = std::find_if(groups.begin(), groups.end(),
                                 [](const GroupComparison& group) { return group.symbol == "I"; });
  ASSERT_NE(rate, groups.end());
  EXPECT_NEAR(*rate->simulation, 4e-3, 1e-12);
  EXPECT_FALSE(rate->experiment);
}

TEST(Planner, ScalingTableShowsWhatTheSoftSimulationBreaks) {
  const Study study = Study::Load("quickstart");
  const auto tables = Planner(study).ScalingTables({0}, {47500, 0.5});
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(tables[0].experiment, "consolidation");
  const auto& groups = tables[0].groups;
  ASSERT_FALSE(groups.empty());
  EXPECT_EQ(groups[0].symbol, "sigma/E");
  EXPECT_NEAR(*groups[0].experiment, 4.5e-8, 1e-12);
  EXPECT_NEAR(*groups[0].simulation, 1.8e-4, 1e-9);
  EXPECT_EQ(groups[0].verdict, GroupComparison::Verdict::violated);
}

TEST(Planner, WarnsOfATimeStepThatBlowsUp) {
  const Study good = Study::Load("quickstart");
  EXPECT_THAT(Planner(good).Warnings(), ::testing::IsEmpty());
  const Study study = Study::Load("quickstart", {{"numerics.time_step", "1 us"}});
  EXPECT_THAT(Planner(study).Warnings(), ::testing::ElementsAre(HasSubstr("0.72 Rayleigh")));
}

TEST(Planner, CostGrowsWithTheBudget) {
  const Study small = Study::Load("quickstart", {{"budget.evaluations", "5"}});
  const Study large = Study::Load("quickstart", {{"budget.evaluations", "50"}});
  EXPECT_GT(Planner(large).EstimateCost().seconds, 5 * Planner(small).EstimateCost().seconds);
  EXPECT_GT(Planner(small).EstimateCost().seconds_per_run, 0);
}

Study ThreeExperiments() {
  return Study::Parse(
      StudyText("quickstart", "objective: joint",
                "  - shear: {preshear: 9 kPa}\n"
                "  - spreading: {fidelity: standard, observed: {coverage: {value: 0.9, sd: "
                "0.05}}}\nobjective: joint"),
      "s.yaml", kLibrary, {});
}

TEST(Planner, PlansWhatIsCalibratedEachAtItsFidelity) {
  const Study study = ThreeExperiments();
  const auto runs = Planner(study).Plan({1e4, 0.5}, 0);
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].program.experiment, "consolidation");
  EXPECT_EQ(runs[0].program.fidelity, Fidelity::quick);
  EXPECT_EQ(runs[1].program.experiment, "spreading");
  EXPECT_EQ(runs[1].program.fidelity, Fidelity::standard);
  EXPECT_EQ(runs[0].seed, runs[1].seed) << "one seed for a replicate of a point";
  EXPECT_NE(runs[0].key, runs[1].key);
}

TEST(Planner, CostCountsEachExperimentByItself) {
  const Study study = ThreeExperiments();  // 20 evaluations of 3 seeds, 6 to confirm
  const Planner::Cost cost = Planner(study).EstimateCost();
  ASSERT_EQ(cost.experiments.size(), 2u);
  EXPECT_EQ(cost.experiments[0].runs, 63);
  EXPECT_GT(cost.experiments[1].particles, cost.experiments[0].particles);
  EXPECT_EQ(cost.runs, 126);
  EXPECT_NEAR(cost.seconds * study.parallel(),
              63 * (cost.experiments[0].seconds + cost.experiments[1].seconds), 1e-9);
  const Planner::Cost more = Planner(study).EstimateCost({1});
  ASSERT_EQ(more.experiments.size(), 3u);
  EXPECT_EQ(more.experiments[2].experiment, 1u);
  EXPECT_EQ(more.runs, 126 + 6);
  EXPECT_GT(more.seconds, cost.seconds);
}

TEST(Planner, OneStressForTheExperimentsThatHaveOne) {
  const Study study = ThreeExperiments();
  const Planner planner(study);
  EXPECT_EQ(planner.ExplainUnsupported(), "");
  EXPECT_EQ(planner.Simulation(1, {1e4, 0.5}).stress, 900);
  EXPECT_FALSE(planner.Simulation(2, {1e4, 0.5}).stress.has_value());
  EXPECT_EQ(planner.ScalingTables({0, 1, 2}, {1e4, 0.5}).size(), 3u);
}

TEST(Planner, TheChosenCategoryReachesTheProgram) {
  const Study study =
      Study::Parse(StudyText("quickstart", "rolling_friction: {",
                             "rolling_model: {choices: [epsd2, cdt]}\n  rolling_friction: {"),
                   "s.yaml", kLibrary);
  const Planner planner(study);
  const auto law = [&](double model) { return planner.Plan({1e4, model, 0.5}, 0)[0].program.law; };
  EXPECT_EQ(law(0).rolling, ContactLaw::Rolling::epsd2);
  EXPECT_EQ(law(1).rolling, ContactLaw::Rolling::cdt);
  EXPECT_EQ(planner.Centres().size(), 2u);
  EXPECT_EQ(planner.Simulation(0, {1e4, 1, 0.5}).directional_torque, true);
  EXPECT_EQ(planner.Simulation(0, {1e4, 0, 0.5}).directional_torque, false);
  EXPECT_EQ(planner.ExplainUnsupported(), "");
}

// Each of the choices has to be possible, not the one in the middle of the box only.
TEST(Planner, RefusesAChoiceThatTheBackendCannotRun) {
  const std::string text = std::regex_replace(
      StudyText("quickstart", "cohesion: sjkr2, rolling: epsd2", "shear_update: incremental"),
      std::regex("cohesion_energy_density: .*"), "rolling_model: {choices: [cdt, none]}");
  const Study study = Study::Parse(text, "s.yaml", kLibrary, {{"backend.name", "yade"}});
  const Planner planner(study);
  EXPECT_EQ(planner.Centre()[0], 1);  // none
  EXPECT_THAT(planner.ExplainUnsupported(), HasSubstr("YADE has no CDT"));
}

}  // namespace
}  // namespace powdercal

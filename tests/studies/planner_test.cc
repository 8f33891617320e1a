#include "studies/planner.h"

#include <gmock/gmock.h>

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

}  // namespace
}  // namespace powdercal

#include "studies/approximation.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "scaling/groups.h"
#include "studies/planner.h"
#include "studies/runner.h"
#include "tests/support/program.h"

namespace powdercal {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

constexpr double kEnergyDensity = 47500;  // [J/m3]
constexpr double kModulus = 2.75e6;       // [Pa] E*

const std::filesystem::path kLibrary = LibraryStudy("").parent_path();

Study Quickstart(const std::string& approximate, const std::string& law = "cohesion: sjkr2",
                 const Overrides& overrides = {}) {
  std::string text = StudyText("quickstart", "cohesion: sjkr2", law);
  text.insert(text.find("parameters:"), approximate);
  return Study::Parse(text, "s.yaml", kLibrary, overrides);
}
constexpr const char* kDeclared = "approximate: {cohesion: dmt_pull_off}\n";

std::string ErrorOf(const std::string& approximate, const std::string& law = "cohesion: sjkr2",
                    const Overrides& overrides = {}) {
  try {
    Quickstart(approximate, law, overrides);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// docs/physics.md §2.
TEST(DmtPullOff, HasThePullOffForceOfSjkr2) {
  const double radius = 7e-6;
  const double energy = PullOffSurfaceEnergy(kEnergyDensity, radius, kModulus);
  EXPECT_NEAR(
      energy / (4 * pi * pi / 3 * std::pow(kEnergyDensity, 3) * radius / kModulus / kModulus), 1,
      1e-12);
  EXPECT_NEAR(PullOffForceDmt(energy, radius) / PullOffForceSjkr2(kEnergyDensity, radius, kModulus),
              1, 1e-12);
  EXPECT_EQ(PullOffSurfaceEnergy(0, radius, kModulus), 0);
  // At a wall, F = (4/3) E* √r δ^1.5 − 2 π k r δ is lowest where its slope is zero, at √δ = π k
  // √r/E*.
  const double overlap = std::pow(pi * kEnergyDensity / kModulus, 2) * radius;
  const double pull = 2 * pi * kEnergyDensity * radius * overlap -
                      4.0 / 3 * kModulus * std::sqrt(radius) * std::pow(overlap, 1.5);
  const double at_wall = PullOffSurfaceEnergyAtWall(kEnergyDensity, radius, kModulus);
  EXPECT_NEAR(PullOffForceDmt(at_wall, radius) / pull, 1, 1e-12);
  EXPECT_NEAR(at_wall / (pi * pi / 6 * std::pow(kEnergyDensity, 3) * radius / kModulus / kModulus),
              1, 1e-12);
}

// What the statement says: parting two particles takes a quarter of the work.
TEST(DmtPullOff, TakesAQuarterOfTheWork) {
  const double radius = 7e-6;
  const double force = PullOffForceSjkr2(kEnergyDensity, radius, kModulus);
  const double overlap = std::pow(3 * force / (4 * kModulus * std::sqrt(radius)), 2.0 / 3);
  const double dmt = 0.6 * force * overlap;
  const double rest = EquilibriumOverlapSjkr2(kEnergyDensity, radius, kModulus);
  EXPECT_NEAR(dmt / (0.4 * pi * kEnergyDensity * radius * rest * rest), 0.249, 5e-4);
  EXPECT_NEAR(overlap / rest, 0.280, 5e-4);
}

// Decision 010: of spheres drawn at random in pairs, the mean pull-off force is that of SJKR2 as
// well. With DMT of equal force at R0 it is <R*> R0 against <R*²>.
TEST(DmtPullOff, KeepsTheMeanPullOffForceOfRandomPairs) {
  const SizeDistribution sizes = Study::Load("quickstart").powder.sizes;
  constexpr int kPoints = 200;
  double sum = 0;
  double squares = 0;
  double radii = 0;
  double squared_radii = 0;
  for (int i = 0; i < kPoints; ++i) {
    const double a = sizes.Quantile((i + 0.5) / kPoints) / 2;
    radii += a;
    squared_radii += a * a;
    for (int j = 0; j < kPoints; ++j) {
      const double b = sizes.Quantile((j + 0.5) / kPoints) / 2;
      const double reduced = a * b / (a + b);
      sum += reduced;
      squares += reduced * reduced;
    }
  }
  const double pairs = sum * sizes.Moment(1) / 4 / squares;
  const double walls = radii * sizes.Moment(1) / 2 / squared_radii;
  RecordProperty("pairs", std::to_string(pairs));
  RecordProperty("walls", std::to_string(walls));
  EXPECT_NEAR(pairs, 1, 0.01);
  EXPECT_NEAR(walls, 0.97, 0.01);
}

TEST(Approximations, ReplaceTheLawBetweenParametersAndProgram) {
  const Study study = Quickstart(kDeclared);
  const Program program = Planner(study).Plan({kEnergyDensity, 0.5}, 0)[0].program;
  const double diameter = study.powder.sizes.Moment(1);
  const double modulus = EffectiveModulus(5e6, 0.3);
  EXPECT_EQ(program.law.cohesion, ContactLaw::Cohesion::dmt);
  EXPECT_EQ(program.materials.particle_particle.surface_energy,
            PullOffSurfaceEnergy(kEnergyDensity, diameter / 4, modulus));
  EXPECT_EQ(program.materials.particle_wall.surface_energy,
            PullOffSurfaceEnergyAtWall(kEnergyDensity, diameter / 2, modulus));
  EXPECT_EQ(program.materials.particle_particle.cohesion_energy_density, 0);
  EXPECT_EQ(program.parameters.at("cohesion_energy_density"), kEnergyDensity);
  EXPECT_EQ(study.law.cohesion, ContactLaw::Cohesion::sjkr2) << "the parameter is of this law";

  const Study plain = Quickstart("");
  const Planner exact(study, *study.backend.backend, Planner::Law::exact);
  EXPECT_EQ(exact.Plan({kEnergyDensity, 0.5}, 0)[0].key,
            Planner(plain).Plan({kEnergyDensity, 0.5}, 0)[0].key);
}

// Both sides of the table of groups are for equal spheres of the mean diameter.
TEST(Approximations, LeaveTheGroupsOfCohesionAsTheyAre) {
  const Study study = Quickstart(kDeclared);
  const Study plain = Quickstart("");
  const auto groups = [](const Study& s) {
    return EvaluateGroups(Planner(s).Simulation(0, {kEnergyDensity, 0.5}));
  };
  int compared = 0;
  for (const auto& [symbol, value] : groups(study)) {
    if (symbol != "Bo" && symbol != "F_c/(sigma d^2)") continue;
    for (const auto& [other, expected] : groups(plain)) {
      if (other != symbol) continue;
      EXPECT_NEAR(value / expected, 1, 1e-12) << symbol;
      ++compared;
    }
  }
  EXPECT_EQ(compared, 2);
}

TEST(Approximations, ArePartOfTheFingerprintOnlyWhereDeclared) {
  Study study = Quickstart(kDeclared);
  Study plain = Quickstart("");
  Study none = Quickstart("approximate: {cohesion: none}\n");
  EXPECT_NE(study.Fingerprint(), plain.Fingerprint());
  EXPECT_EQ(none.Fingerprint(), plain.Fingerprint());
  EXPECT_THAT(study.ToYaml(), HasSubstr("approximate:\n  cohesion: dmt_pull_off"));
  Study again = Study::Parse(study.ToYaml(), "again.yaml", kLibrary);
  EXPECT_EQ(again.Fingerprint(), study.Fingerprint());
  EXPECT_THAT(Study::Load("quickstart", {{"approximate.cohesion", "dmt_pull_off"}}).Fingerprint(),
              study.Fingerprint());
}

TEST(Approximations, MistakesHaveTheirReason) {
  EXPECT_THAT(ErrorOf("approximate: {cohesion: dmt_pulloff}\n"),
              HasSubstr("did you mean 'dmt_pull_off'?"));
  EXPECT_THAT(ErrorOf("approximate: {cohesoin: dmt_pull_off}\n"),
              HasSubstr("did you mean 'cohesion'?"));
  EXPECT_THAT(ErrorOf(kDeclared, "cohesion: none"),
              ::testing::AllOf(HasSubstr("approximate.cohesion: dmt_pull_off replaces SJKR2, and "
                                         "contact_law has cohesion: none"),
                               HasSubstr("s.yaml:")));
  EXPECT_THAT(ErrorOf("approximate: dmt_pull_off\n"), HasSubstr("expected a map"));
  std::string table = StudyText("hastelloy_x_table3");
  table.insert(table.find("parameters:"), kDeclared);
  try {
    Study::Parse(table, "s.yaml", kLibrary);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("backend 'table' simulates nothing"));
  }
}

TEST(Approximations, SayHowFarTheyGo) {
  Study study = Quickstart(kDeclared);
  const auto statements = study.approximations.Describe(study.powder.sizes);
  ASSERT_EQ(statements.size(), 1u);
  EXPECT_EQ(statements[0].part, "cohesion");
  EXPECT_EQ(statements[0].name, "dmt_pull_off");
  EXPECT_THAT(statements[0].text, HasSubstr("times that of SJKR2 between two of the smallest"));
  const SizeDistribution one{.mean = 30e-6, .min = 30e-6, .max = 30e-6};
  EXPECT_THAT(study.approximations.Describe(one)[0].text,
              ::testing::Not(HasSubstr("smallest particles")));
  EXPECT_TRUE(Approximations{}.Describe(one).empty());
}

// Knows both laws: DMT gives a void ratio that is higher by 0.03.
class BothLaws final : public Backend {
 public:
  explicit BothLaws(std::string name) : name_(std::move(name)) {}
  const std::string& name() const override { return name_; }
  Availability availability() const override { return {.available = true, .version = "7"}; }
  std::string ExplainUnsupported(const Program&) const override { return ""; }
  Trace Run(const Program& program, const RunContext&) const override {
    const double scatter = 1e-3 * static_cast<double>(program.particles.seed % 7);
    const bool dmt = program.law.cohesion == ContactLaw::Cohesion::dmt;
    Trace trace;
    trace.reported["void_ratio"] = {.value = 0.77 + (dmt ? 0.03 : 0) + scatter};
    return trace;
  }

 private:
  std::string name_;
};

TEST(Approximations, EffectIsMeasuredAtTheBestPoint) {
  const TemporaryFolder folder;
  Study study = Quickstart(kDeclared, "cohesion: sjkr2",
                           {{"optimizer", "random"},
                            {"budget.evaluations", "3"},
                            {"budget.parallel", "1"},
                            {"backend.replicates", "2"},
                            {"backend.confirm_replicates", "3"}});
  study.backend.backend = std::make_unique<BothLaws>("embedded");
  for (int session = 0; session < 2; ++session) {
    StudyRunner runner(study, {.folder = folder / "x"});
    EXPECT_EQ(runner.Run(), StudyRunner::End::finished);
  }
  const Ledger ledger(folder / "x/ledger.sqlite", Ledger::Mode::read_only);
  EXPECT_EQ(ledger.GetMeta("approximations"), "cohesion: dmt_pull_off");
  EXPECT_EQ(ledger.Runs().size(), 3u * 2 + 1 + 3);
  const StudyResults results = CollectResults(study, ledger);
  ASSERT_TRUE(results.best);
  EXPECT_EQ(results.history[*results.best].runs.size(), 3u)
      << "those without the approximation are not among them";
  ASSERT_TRUE(results.approximation_effect);
  const ApproximationEffect& effect = *results.approximation_effect;
  EXPECT_EQ(effect.backend, "embedded");
  EXPECT_EQ(effect.version, "7");
  ASSERT_EQ(effect.exact.size(), 1u);
  EXPECT_EQ(effect.exact[0].replicates, 3);
  EXPECT_NEAR(*effect.approximated[0].simulated - *effect.exact[0].simulated, 0.03, 1e-12);
  EXPECT_EQ(*effect.approximated[0].simulated,
            *results.history[*results.best].responses[0].simulated);
  EXPECT_EQ(results.approximations.size(), 1u);
  EXPECT_TRUE(results.confirmations.empty());
}

}  // namespace
}  // namespace powdercal

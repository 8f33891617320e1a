#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scaling/groups.h"
#include "scaling/real_powder.h"
#include "scaling/scaling.h"
#include "tests/scaling/mode_sections.h"

namespace powdercal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

Conditions HastelloyX(Conditions::Cohesion law = Conditions::Cohesion::dmt) {
  return {.stress = 9e3,
          .study_stress = 9e3,
          .young_modulus = 200e9,
          .poisson_ratio = 0.3,
          .density = 8220,
          .diameter = 29e-6,
          .gravity = 9.81,
          .surface_energy = 1e-4,
          .bulk_solid_fraction = 0.55,
          .bed_height = 3e-4,
          .law_of_cohesion = law};
}

Conditions Spreading() {
  Conditions conditions = HastelloyX();
  conditions.stress.reset();
  conditions.velocity = 0.025;
  conditions.gap = 80e-6;
  return conditions;
}

double Ratio(const std::string& symbol, const Conditions& experiment,
             const Conditions& simulation) {
  return EvaluateGroup(symbol, simulation).value() / EvaluateGroup(symbol, experiment).value();
}

void ExpectKept(const std::vector<std::string>& symbols, const Conditions& experiment,
                const Conditions& simulation) {
  for (const std::string& symbol : symbols) {
    EXPECT_NEAR(Ratio(symbol, experiment, simulation), 1, 1e-12) << symbol;
  }
}

TEST(Exact, KeepsEveryGroup) {
  for (const char* yaml : {"scaling: {mode: exact, young_modulus: 5 MPa}",
                           "scaling: {mode: exact, young_modulus: 123 GPa}"}) {
    const auto scaling = Read(yaml);
    for (Conditions experiment : {HastelloyX(), Spreading()}) {
      experiment.width = 1e-3;
      if (experiment.stress) experiment.shear_rate = 3;
      const Conditions simulation = scaling->ToSimulation(experiment);
      for (const GroupComparison& group : CompareGroups(experiment, simulation)) {
        EXPECT_NEAR(group.ratio.value(), 1, 1e-12) << group.symbol;
        EXPECT_EQ(group.verdict, GroupComparison::Verdict::ok) << group.symbol;
      }
    }
  }
}

// The row `exact` of docs/physics.md: 0.225 Pa, 2.45e-4 m/s2, 583 J/m3.
TEST(Exact, GivesStressGravityCohesionAndSpeeds) {
  const auto scaling = Read("scaling: {mode: exact, young_modulus: 5 MPa}");
  EXPECT_TRUE(scaling->scales_cohesion());
  const Conditions simulation = scaling->ToSimulation(HastelloyX(Conditions::Cohesion::sjkr2));
  EXPECT_NEAR(*simulation.stress, 0.225, 1e-12);
  EXPECT_NEAR(*simulation.gravity, 2.4525e-4, 1e-12);
  EXPECT_NEAR(*simulation.cohesion_energy_density, 583, 0.5);
  EXPECT_FALSE(simulation.surface_energy.has_value());
  EXPECT_NEAR(simulation.speed_ratio, 0.005, 1e-12);
  EXPECT_NEAR(*scaling->ToSimulation(Spreading()).velocity, 1.25e-4, 1e-12);
  EXPECT_THAT(scaling->Describe(), AllOf(HasSubstr("5 MPa"), HasSubstr("every group")));
}

TEST(Exact, ExplainsWhatIsWrong) {
  EXPECT_THAT(ErrorOf("scaling: exact"), HasSubstr("missing key 'young_modulus'"));
  EXPECT_THAT(ErrorOf("scaling: {mode: exact, young_modulus: 0 Pa}"), HasSubstr("above 0 Pa"));
  EXPECT_THAT(ErrorOf("scaling: {mode: exact, young_modulus: -1 Pa}"), HasSubstr("above 0 Pa"));
  EXPECT_THAT(
      Read("scaling: {mode: exact, young_modulus: 201 GPa}")->ExplainUnsupported(HastelloyX()),
      HasSubstr("above the powder's (200 GPa)"));
  Conditions nameless = HastelloyX();
  nameless.young_modulus.reset();
  EXPECT_THAT(Read("scaling: {mode: exact, young_modulus: 5 MPa}")->ExplainUnsupported(nameless),
              HasSubstr("material.young_modulus"));
}

// Row `rigid_limit` A of docs/physics.md: 0.26 GPa, 2.77e5 J/m3.
TEST(RigidLimit, LowersTheModulusToTheFloor) {
  const auto scaling = Read("scaling: rigid_limit");
  const Conditions experiment = HastelloyX(Conditions::Cohesion::sjkr2);
  const Conditions simulation = scaling->ToSimulation(experiment);
  EXPECT_NEAR(*EvaluateGroup("kappa", simulation), 1000, 1e-9);
  EXPECT_NEAR(*simulation.young_modulus, 0.26e9, 0.005e9);
  EXPECT_NEAR(*simulation.cohesion_energy_density, 2.77e5, 0.01e5);
  ExpectKept({"sigma/(rho_b g h)", "F_c/(sigma d^2)", "Bo"}, experiment, simulation);
  EXPECT_EQ(simulation.stress, 9e3);
  EXPECT_EQ(simulation.gravity, 9.81);
  EXPECT_EQ(simulation.speed_ratio, 1);
  for (const GroupComparison& group : CompareGroups(experiment, simulation, "consolidation")) {
    EXPECT_NE(group.verdict, GroupComparison::Verdict::violated) << group.symbol;
  }
  const Conditions stiffer =
      Read("scaling: {mode: rigid_limit, kappa: 1e4}")->ToSimulation(experiment);
  EXPECT_NEAR(*stiffer.young_modulus, 8.2e9, 0.05e9);
  EXPECT_NEAR(*stiffer.cohesion_energy_density, 2.77e6, 0.01e6);
}

// docs/scaling.md: at equal pull-off force and E, SJKR2 has four times the work of separation.
TEST(Cohesion, EqualForceIsNotEqualWork) {
  const auto scaling = Read("scaling: {mode: exact, young_modulus: 200 GPa}");
  const Conditions sjkr2 = scaling->ToSimulation(HastelloyX(Conditions::Cohesion::sjkr2));
  const Conditions dmt = scaling->ToSimulation(HastelloyX(Conditions::Cohesion::dmt));
  EXPECT_NEAR(Ratio("Bo", dmt, sjkr2), 1, 1e-12);
  EXPECT_NEAR(Ratio("W/(m g d)", dmt, sjkr2), 4.02, 0.005);
  EXPECT_EQ(Ratio("F_w/F_c", dmt, sjkr2), 0.25);
}

TEST(RigidLimit, OneModulusServesAllTestsAndIsNeverAboveThePowders) {
  Conditions light = HastelloyX();
  light.stress = 1e3;
  const auto scaling = Read("scaling: rigid_limit");
  EXPECT_EQ(scaling->ToSimulation(light).young_modulus,
            scaling->ToSimulation(HastelloyX()).young_modulus);
  EXPECT_EQ(scaling->ToSimulation(Spreading()).young_modulus,
            scaling->ToSimulation(HastelloyX()).young_modulus);
  Conditions soft = HastelloyX();
  soft.young_modulus = 1e6;
  EXPECT_EQ(scaling->ToSimulation(soft).young_modulus, 1e6);
}

TEST(RigidLimit, ExplainsWhatIsMissing) {
  Conditions none = Spreading();
  none.study_stress.reset();
  EXPECT_THAT(Read("scaling: rigid_limit")->ExplainUnsupported(none),
              AllOf(HasSubstr("kappa"), HasSubstr("no experiment of the study applies a stress")));
  EXPECT_THAT(ErrorOf("scaling: {mode: rigid_limit, kappa: 0}"), HasSubstr("[1, "));
  EXPECT_THAT(ErrorOf("scaling: {mode: rigid_limit, young_modulus: 1 GPa}"),
              HasSubstr("unknown key 'young_modulus'"));
}

TEST(Custom, MatchesWhatItIsAskedFor) {
  // As sigma_over_e, and gravity and cohesion along with it.
  const auto scaling = Read(
      "scaling:\n  mode: custom\n  young_modulus: 5 MPa\n  groups:\n    sigma/E: 1\n"
      "    sigma/(rho_b g h): 1\n    F_c/(sigma d^2): {weight: 2, tolerance: 1.01}\n");
  const Conditions experiment = HastelloyX(Conditions::Cohesion::sjkr2);
  ASSERT_EQ(scaling->ExplainUnsupported(experiment), "");
  const Conditions simulation = scaling->ToSimulation(experiment);
  EXPECT_NEAR(*simulation.stress, 0.225, 1e-9);
  EXPECT_NEAR(*simulation.gravity, 2.4525e-4, 1e-9);
  EXPECT_NEAR(*simulation.cohesion_energy_density, 583, 0.5);
  ExpectKept({"sigma/E", "kappa", "sigma/(rho_b g h)", "F_c/(sigma d^2)", "Bo"}, experiment,
             simulation);
}

TEST(Custom, WhatNoGroupAsksForStays) {
  const auto scaling =
      Read("scaling: {mode: custom, young_modulus: 5 MPa, groups: {V/sqrt(g d): 1, Bo: 1}}");
  const Conditions simulation = scaling->ToSimulation(Spreading());
  EXPECT_NEAR(*simulation.velocity, 0.025, 1e-15);
  EXPECT_NEAR(*simulation.gravity, 9.81, 1e-12);
  EXPECT_NEAR(*simulation.surface_energy, 1e-4, 1e-16);
  EXPECT_EQ(simulation.young_modulus, 5e6);
}

TEST(Custom, ValueOfTheSimulationsOwn) {
  const auto scaling = Read(
      "scaling: {mode: custom, young_modulus: 5 MPa, keep: [gravity], groups: "
      "{kappa: {value: 1000}, F_c/(sigma d^2): 1}}");
  const Conditions experiment = HastelloyX();
  const Conditions simulation = scaling->ToSimulation(experiment);
  EXPECT_NEAR(*EvaluateGroup("kappa", simulation), 1000, 1e-6);
  EXPECT_EQ(simulation.gravity, 9.81);
  ExpectKept({"F_c/(sigma d^2)"}, experiment, simulation);
}

TEST(Custom, CompromisesWithinTolerancesByWeight) {
  const auto read = [](const std::string& weight) {
    return Read(
        "scaling: {mode: custom, young_modulus: 150 GPa, keep: [gravity, cohesion], "
        "groups: {sigma/E: {weight: " +
        weight + ", tolerance: 2}, F_c/(sigma d^2): {tolerance: 2}}}");
  };
  const Conditions experiment = HastelloyX();
  const Conditions even = read("1")->ToSimulation(experiment);
  EXPECT_NEAR(Ratio("sigma/E", experiment, even), std::sqrt(4.0 / 3), 1e-9);
  const Conditions heavy = read("10")->ToSimulation(experiment);
  EXPECT_NEAR(Ratio("sigma/E", experiment, heavy), 1, 0.01);
  EXPECT_NEAR(Ratio("F_c/(sigma d^2)", experiment, heavy), 4.0 / 3, 0.02);
}

// A heavy group leaves none of its miss to the other: only the least largest miss is within both.
TEST(Custom, TolerancesComeBeforeWeights) {
  const auto scaling = Read(
      "scaling: {mode: custom, young_modulus: 150 GPa, keep: [gravity, cohesion], groups: "
      "{sigma/E: {weight: 100, tolerance: 1.2}, F_c/(sigma d^2): {tolerance: 1.2}}}");
  const Conditions experiment = HastelloyX();
  ASSERT_EQ(scaling->ExplainUnsupported(experiment), "");
  const Conditions simulation = scaling->ToSimulation(experiment);
  EXPECT_LE(Ratio("sigma/E", experiment, simulation), 1.2 * (1 + 1e-6));
  EXPECT_LE(Ratio("F_c/(sigma d^2)", experiment, simulation), 1.2 * (1 + 1e-6));
}

TEST(Custom, RefusesTheInfeasibleAndNamesTheConflict) {
  const auto scaling = Read(
      "scaling: {mode: custom, young_modulus: 5 MPa, keep: [gravity], groups: "
      "{sigma/E: 1, sigma/(rho_b g h): 1, Bo: 1}}");
  const std::string reason = scaling->ExplainUnsupported(HastelloyX());
  EXPECT_THAT(reason, AllOf(HasSubstr("cannot be matched together"), HasSubstr("sigma/E (off"),
                            HasSubstr("sigma/(rho_b g h) (off"), Not(HasSubstr("Bo"))));
}

TEST(Custom, GroupThatNoExperimentHas) {
  const auto scaling =
      Read("scaling: {mode: custom, young_modulus: 5 MPa, groups: {sigma/E: 1, Bo: 1}}");
  std::vector<Conditions> study = {Spreading()};
  EXPECT_THAT(scaling->ExplainWithoutEffect(study),
              AllOf(HasSubstr("no experiment of the study has the group 'sigma/E'")));
  study.push_back(HastelloyX());
  EXPECT_EQ(scaling->ExplainWithoutEffect(study), "");
  for (Conditions& experiment : study) experiment.surface_energy.reset();
  EXPECT_THAT(scaling->ExplainWithoutEffect(study),
              AllOf(HasSubstr("'Bo'"), HasSubstr("material.surface_energy")));
}

TEST(Custom, ErrorTexts) {
  EXPECT_THAT(ErrorOf("scaling: {mode: custom, young_modulus: 5 MPa}"),
              HasSubstr("missing key 'groups'"));
  EXPECT_THAT(ErrorOf("scaling: {mode: custom, young_modulus: 5 MPa, groups: {}}"),
              HasSubstr("needs a group"));
  EXPECT_THAT(ErrorOf("scaling: {mode: custom, young_modulus: 5 MPa, groups: {kapa: 1}}"),
              AllOf(HasSubstr("unknown group 'kapa'"), HasSubstr("did you mean 'kappa'?")));
  EXPECT_THAT(ErrorOf("scaling: {mode: custom, young_modulus: 5 MPa, groups: {kappa: 0}}"),
              HasSubstr("must be above 0"));
  EXPECT_THAT(
      ErrorOf("scaling: {mode: custom, young_modulus: 5 MPa, groups: {kappa: {tolerance: 1}}}"),
      HasSubstr("must be above 1"));
  EXPECT_THAT(ErrorOf("scaling: {mode: custom, young_modulus: 5 MPa, keep: [gravty], groups: "
                      "{kappa: 1}}"),
              HasSubstr("did you mean 'gravity'?"));
}

TEST(Modes, WriteTheResolvedSection) {
  for (const char* yaml :
       {"scaling:\n  mode: exact\n  young_modulus: 5000000 Pa\n",
        "scaling:\n  mode: rigid_limit\n  kappa: 4000\n",
        "scaling:\n  mode: custom\n  young_modulus: 5000000 Pa\n  keep: [gravity]\n  groups:\n"
        "    sigma/E:\n      weight: 1\n      tolerance: 1.1\n"
        "    F_c/(sigma d^2):\n      weight: 2\n      tolerance: 1.5\n      value: 0.001\n"}) {
    auto scaling = Read(yaml);
    EXPECT_EQ(WriteYaml([&](Archive& archive) { SerializeScaling(archive, scaling); }), yaml);
  }
}

TEST(ReadBack, GivesTheSurfaceEnergyThatWentIn) {
  for (const char* yaml :
       {"scaling: rigid_limit", "scaling: {mode: exact, young_modulus: 5 MPa}"}) {
    for (const Conditions::Cohesion law :
         {Conditions::Cohesion::sjkr2, Conditions::Cohesion::dmt}) {
      const Conditions experiment = HastelloyX(law);
      const auto reading =
          ReadBack("consolidation", experiment, Read(yaml)->ToSimulation(experiment));
      ASSERT_TRUE(reading.has_value());
      EXPECT_NEAR(reading->surface_energy, 1e-4, 1e-15) << yaml;
      EXPECT_EQ(reading->kept, "F_c/(sigma d^2)");
    }
  }
}

// The paper's calibration, 900 Pa at 5 MPa: 135 times the cohesion of 0.1 mJ/m2 against the load.
TEST(ReadBack, TakesTheLoadOrGravity) {
  Conditions simulation = HastelloyX();
  simulation.young_modulus = 5e6;
  simulation.stress = 900;
  simulation.surface_energy.reset();
  simulation.cohesion_energy_density = 47500;
  auto reading = ReadBack("consolidation", HastelloyX(), simulation);
  EXPECT_NEAR(reading->surface_energy, 135e-4, 1e-4);
  simulation.stress = 0.225;  // less than the bed's own weight
  reading = ReadBack("consolidation", HastelloyX(), simulation);
  EXPECT_EQ(reading->kept, "Bo");
  EXPECT_NEAR(reading->surface_energy, 13.5e-4, 0.1e-4);
  simulation.stress.reset();
  reading = ReadBack("spreading", Spreading(), simulation);
  EXPECT_EQ(reading->kept, "Bo");
  simulation.cohesion_energy_density.reset();
  EXPECT_FALSE(ReadBack("spreading", Spreading(), simulation).has_value());
}

TEST(ReadBack, SaysWhereTestsStandForDifferentPowders) {
  const PowderCohesion one{.experiment = "consolidation",
                           .surface_energy = 13.5e-3,
                           .kept = "F_c/(sigma d^2)",
                           .young_modulus = 5e6,
                           .cohesion_energy_density = 47500,
                           .stated = 1e-4};
  PowderCohesion other = one;
  other.experiment = "spreading";
  EXPECT_EQ(Describe({one, other}).size(), 2u);
  other.surface_energy = 1.35e-3;
  const auto sentences = Describe({one, other});
  ASSERT_EQ(sentences.size(), 3u);
  EXPECT_THAT(sentences[0], AllOf(HasSubstr("14 mJ/m2"), HasSubstr("states 0.1 mJ/m2")));
  EXPECT_THAT(sentences[2], AllOf(HasSubstr("spreading and consolidation differ 10 times")));
}

}  // namespace
}  // namespace powdercal

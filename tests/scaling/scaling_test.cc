#include "scaling/scaling.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scaling/mode_sections.h"

namespace powdercal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string Write(std::unique_ptr<Scaling>& scaling) {
  return WriteYaml([&](Archive& archive) { SerializeScaling(archive, scaling); });
}

Conditions HastelloyX() {
  return {.stress = 9e3,
          .young_modulus = 200e9,
          .poisson_ratio = 0.3,
          .density = 8220,
          .diameter = 29e-6,
          .gravity = 9.81,
          .surface_energy = 1e-4};
}

TEST(ScalingNames, AreSortedAndMakeable) {
  EXPECT_THAT(ScalingNames(), ::testing::ElementsAre("custom", "exact", "given", "none",
                                                     "rigid_limit", "sigma_over_e"));
  for (const std::string& name : ScalingNames()) {
    const auto scaling = MakeScaling(name);
    EXPECT_EQ(scaling->name(), name);
    EXPECT_NE(scaling->Describe(), "");
  }
  EXPECT_THROW(MakeScaling("exakt"), InputError);
}

TEST(None, KeepsEverything) {
  for (const char* yaml : {"scaling: none", "scaling: {mode: none}", "{}"}) {
    const auto scaling = Read(yaml);
    EXPECT_EQ(scaling->name(), "none");
    EXPECT_EQ(scaling->ExplainUnsupported({}), "");
    const Conditions simulation = scaling->ToSimulation(HastelloyX());
    EXPECT_EQ(simulation.stress, 9e3);
    EXPECT_EQ(simulation.young_modulus, 200e9);
    EXPECT_EQ(simulation.surface_energy, 1e-4);
  }
}

TEST(Given, ReplacesWhatIsStated) {
  const auto scaling =
      Read("scaling: {mode: given, young_modulus: 5 MPa, stress: 0.9 kPa, gravity: 1 m/s2}");
  EXPECT_EQ(scaling->ExplainUnsupported(HastelloyX()), "");
  const Conditions simulation = scaling->ToSimulation(HastelloyX());
  EXPECT_DOUBLE_EQ(*simulation.young_modulus, 5e6);
  EXPECT_DOUBLE_EQ(*simulation.stress, 900);
  EXPECT_DOUBLE_EQ(*simulation.gravity, 1);
  EXPECT_EQ(simulation.density, 8220);
  EXPECT_EQ(simulation.diameter, 29e-6);
  EXPECT_FALSE(simulation.velocity.has_value());
  EXPECT_THAT(scaling->Describe(), AllOf(HasSubstr("5 MPa"), HasSubstr("900 Pa")));
}

TEST(Given, StressRatioServesSeveralStresses) {
  const auto scaling = Read("scaling: {mode: given, young_modulus: 5 MPa, stress_ratio: 0.1}");
  for (const double stress : {3e3, 5e3, 9e3}) {
    Conditions experiment = HastelloyX();
    experiment.stress = stress;
    EXPECT_EQ(scaling->ExplainUnsupported(experiment), "");
    EXPECT_DOUBLE_EQ(*scaling->ToSimulation(experiment).stress, stress / 10);
  }
  Conditions spreading = HastelloyX();
  spreading.stress.reset();
  EXPECT_EQ(scaling->ExplainUnsupported(spreading), "");
  EXPECT_FALSE(scaling->ToSimulation(spreading).stress.has_value());
}

TEST(Given, SpeedsActWhereThereAreAny) {
  const auto scaling = Read("scaling: {mode: given, velocity: 50 mm/s, shear_rate: 10 1/s}");
  Conditions spreading = HastelloyX();
  spreading.velocity = 0.025;
  EXPECT_DOUBLE_EQ(*scaling->ToSimulation(spreading).velocity, 0.05);
  EXPECT_FALSE(scaling->ToSimulation(spreading).shear_rate.has_value());
  EXPECT_FALSE(scaling->ToSimulation(HastelloyX()).velocity.has_value());
  Conditions shear = HastelloyX();
  shear.shear_rate = 0.1;
  EXPECT_DOUBLE_EQ(*scaling->ToSimulation(shear).shear_rate, 10);
}

TEST(Given, ExplainsWhatIsWrong) {
  EXPECT_THAT(Read("scaling: given")->ExplainUnsupported(HastelloyX()),
              AllOf(HasSubstr("states nothing"), HasSubstr("'none'")));
  EXPECT_THAT(
      Read("scaling: {mode: given, young_modulus: 201 GPa}")->ExplainUnsupported(HastelloyX()),
      AllOf(HasSubstr("201 GPa"), HasSubstr("above the powder's (200 GPa)")));
}

TEST(Given, OneStressForAllExperimentsThatApplyOne) {
  Conditions spreading = HastelloyX();
  spreading.stress.reset();
  const auto scaling = Read("scaling: {mode: given, stress: 1 kPa}");
  EXPECT_EQ(scaling->ExplainUnsupported(spreading), "");
  EXPECT_FALSE(scaling->ToSimulation(spreading).stress.has_value());
  const std::vector<Conditions> both = {spreading, HastelloyX()};
  EXPECT_EQ(scaling->ExplainWithoutEffect(both), "");
  EXPECT_THAT(scaling->ExplainWithoutEffect(std::span(both).first(1)),
              AllOf(HasSubstr("1 kPa"), HasSubstr("no experiment applies one")));
}

// Eq. 5 of the seed paper.
TEST(SigmaOverE, ReproducesThePaper) {
  const auto scaling = Read("scaling: {mode: sigma_over_e, young_modulus: 5 MPa}");
  EXPECT_EQ(scaling->ExplainUnsupported(HastelloyX()), "");
  const Conditions simulation = scaling->ToSimulation(HastelloyX());
  EXPECT_DOUBLE_EQ(*simulation.stress, 0.225);
  EXPECT_DOUBLE_EQ(*simulation.young_modulus, 5e6);
  EXPECT_EQ(simulation.gravity, 9.81);
  EXPECT_THAT(scaling->Describe(), AllOf(HasSubstr("gravity, cohesion"), HasSubstr("5 MPa")));
}

TEST(SigmaOverE, ExplainsWhatIsMissing) {
  const auto scaling = Read("scaling: {mode: sigma_over_e, young_modulus: 5 MPa}");
  Conditions conditions = HastelloyX();
  conditions.stress.reset();
  EXPECT_EQ(scaling->ToSimulation(conditions).young_modulus, 5e6);
  EXPECT_FALSE(scaling->ToSimulation(conditions).stress.has_value());
  EXPECT_THAT(scaling->ExplainWithoutEffect(std::span(&conditions, 1)),
              HasSubstr("needs an applied stress"));
  conditions = HastelloyX();
  conditions.young_modulus.reset();
  EXPECT_THAT(scaling->ExplainUnsupported(conditions), HasSubstr("material.young_modulus"));
  conditions.young_modulus = 1e6;
  EXPECT_THAT(scaling->ExplainUnsupported(conditions), HasSubstr("above the powder's (1 MPa)"));
  EXPECT_THAT(MakeScaling("sigma_over_e")->ExplainUnsupported(HastelloyX()),
              HasSubstr("needs young_modulus"));
}

TEST(SerializeScaling, WritesTheResolvedSection) {
  for (const char* yaml : {"scaling:\n  mode: none\n",
                           "scaling:\n  mode: sigma_over_e\n"
                           "  young_modulus: 5000000 Pa\n",
                           "scaling:\n  mode: given\n  young_modulus: 5000000 Pa\n"
                           "  stress: 900 Pa\n  gravity: 9.81 m/s2\n",
                           "scaling:\n  mode: given\n  stress_ratio: 0.1\n"}) {
    auto scaling = Read(yaml);
    EXPECT_EQ(Write(scaling), yaml);
  }
  std::unique_ptr<Scaling> absent;
  EXPECT_EQ(Write(absent), "scaling:\n  mode: none\n");
}

TEST(SerializeScaling, ErrorTexts) {
  EXPECT_THAT(ErrorOf("scaling: {mode: gven}"),
              AllOf(HasSubstr("study.yaml:1:17"), HasSubstr("scaling.mode"),
                    HasSubstr("unknown scaling mode 'gven' (valid: custom, exact, given, "
                              "none, rigid_limit, sigma_over_e)"),
                    HasSubstr("did you mean 'given'?")));
  EXPECT_THAT(ErrorOf("scaling: sigma_over_E"), HasSubstr("did you mean 'sigma_over_e'?"));
  EXPECT_THAT(
      ErrorOf("scaling: {mode: given, youngs_modulus: 5 MPa}"),
      AllOf(HasSubstr("unknown key 'youngs_modulus'"), HasSubstr("did you mean 'young_modulus'?")));
  EXPECT_THAT(ErrorOf("scaling: {mode: none, stress: 1 kPa}"), HasSubstr("unknown key 'stress'"));
  EXPECT_THAT(ErrorOf("scaling: {young_modulus: 5 MPa}"), HasSubstr("missing key 'mode'"));
  EXPECT_THAT(ErrorOf("scaling: sigma_over_e"), HasSubstr("missing key 'young_modulus'"));
  EXPECT_THAT(ErrorOf("scaling: {mode: given, stress: 900}"),
              AllOf(HasSubstr("scaling.stress"), HasSubstr("has no unit")));
  EXPECT_THAT(ErrorOf("scaling: {mode: given, stress: 5 mm/s}"), HasSubstr("got a speed"));
  EXPECT_THAT(ErrorOf("scaling: {mode: given, stress: 0 Pa}"), HasSubstr("must be above 0 Pa"));
  EXPECT_THAT(ErrorOf("scaling: {mode: given, young_modulus: -5 MPa}"),
              HasSubstr("must be above 0 Pa"));
  EXPECT_THAT(ErrorOf("scaling: {mode: given, stress: 1 kPa, stress_ratio: 0.1}"),
              AllOf(HasSubstr("scaling.stress_ratio"), HasSubstr("exclude each other")));
}

}  // namespace
}  // namespace powdercal

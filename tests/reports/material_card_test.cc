#include "reports/material_card.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "tests/reports/sample_studies.h"

namespace powdercal {
namespace {

TEST(MaterialCardTest, HoldsParametersFitAndProvenance) {
  const std::string text = MaterialCard(QuickstartSample());
  const YAML::Node card = YAML::Load(text);
  EXPECT_EQ(card["material_card"].as<int>(), 1);
  EXPECT_EQ(card["status"].as<std::string>(), "calibrated");
  const YAML::Node k = card["parameters"]["cohesion_energy_density"];
  EXPECT_EQ(k["value"].as<double>(), 55400);
  EXPECT_EQ(k["unit"].as<std::string>(), "J/m3");
  EXPECT_EQ(k["symbol"].as<std::string>(), "k");
  EXPECT_EQ(k["searched"][1].as<double>(), 1e5);
  const YAML::Node fit = card["fit"]["responses"]["consolidation.void_ratio"];
  EXPECT_EQ(fit["observed"].as<double>(), 0.783);
  EXPECT_TRUE(fit["within"].as<bool>());
  EXPECT_EQ(fit["replicates"].as<int>(), 3);
  EXPECT_THAT(card["contact_law"]["as_run"].as<std::string>(), testing::HasSubstr("gran model"));
  EXPECT_EQ(card["scaling"]["mode"].as<std::string>(), "given");
  EXPECT_EQ(card["provenance"]["backend"]["version"].as<std::string>(), "3.8.0");
  EXPECT_EQ(card["provenance"]["evaluations"]["failed"].as<int>(), 2);
  EXPECT_EQ(card["provenance"]["particle_seeds"].size(), 2u);
  EXPECT_THAT(text, testing::HasSubstr("4000 times too soft"));
  // Shortest digits, not 0.66000000000000003.
  EXPECT_THAT(text, testing::HasSubstr("value: 0.66\n"));
}

TEST(MaterialCardTest, StatusSaysHowFarToTrustIt) {
  const auto status = [](const StudyResults& results) {
    return YAML::Load(MaterialCard(results))["status"].as<std::string>();
  };
  EXPECT_EQ(status(TableSample()), "no_simulation");
  EXPECT_EQ(status(FailedSample()), "nothing_calibrated");
  EXPECT_EQ(status(JointSample()), "not_converged");
  StudyResults interrupted = QuickstartSample();
  interrupted.state = "interrupted";
  EXPECT_EQ(status(interrupted), "provisional");
}

TEST(MaterialCardTest, NoParametersWithoutABest) {
  const YAML::Node card = YAML::Load(MaterialCard(FailedSample()));
  EXPECT_FALSE(card["parameters"]);
  EXPECT_FALSE(card["fit"]);
  EXPECT_EQ(card["caveats"].size(), 2u);
}

TEST(MaterialCardTest, TextsSurviveYaml) {
  StudyResults results = QuickstartSample();
  results.powder = "odd: \"name\" # {not} a\ncomment";
  EXPECT_EQ(YAML::Load(MaterialCard(results))["powder"].as<std::string>(), results.powder);
}

TEST(MaterialCardTest, SaysWhatOtherBackendsMakeOfTheParameters) {
  const YAML::Node card = YAML::Load(MaterialCard(ConfirmationSample()));
  ASSERT_EQ(card["confirmations"].size(), 3u);
  const YAML::Node whole = card["confirmations"][0];
  EXPECT_EQ(whole["backend"].as<std::string>(), "embedded");
  EXPECT_EQ(whole["outcome"].as<std::string>(), "ok");
  EXPECT_NEAR(whole["responses"]["consolidation.void_ratio"]["difference"].as<double>(), 0.04,
              1e-12);
  EXPECT_FALSE(card["fit"]["responses"]["consolidation.void_ratio"]["difference"]);
  EXPECT_EQ(card["confirmations"][2]["outcome"].as<std::string>(), "unavailable");
  EXPECT_FALSE(YAML::Load(MaterialCard(JointSample()))["confirmations"]);
}

TEST(MaterialCardTest, NamesApproximationsWithTheirEffect) {
  const YAML::Node card = YAML::Load(MaterialCard(ApproximationSample()));
  EXPECT_EQ(card["approximations"][0]["part"].as<std::string>(), "cohesion");
  EXPECT_EQ(card["approximations"][0]["name"].as<std::string>(), "dmt_pull_off");
  EXPECT_EQ(card["approximation_effect"].size(), 2u);
  EXPECT_FALSE(YAML::Load(MaterialCard(JointSample()))["approximations"]);
}

TEST(MaterialCardTest, SaysHowTheParametersDoWhereTheyWereNotFitted) {
  const YAML::Node card = YAML::Load(MaterialCard(TransferSample()));
  const YAML::Node coverage = card["transfer"]["responses"]["spreading.coverage"];
  EXPECT_EQ(coverage["within"].as<bool>(), false);
  EXPECT_NEAR(coverage["standard_deviations_off"].as<double>(), -3.78, 0.01);
  EXPECT_FALSE(card["transfer"]["responses"]["spreading.layer_thickness"]["observed"]);
  EXPECT_FALSE(card["fit"]["responses"]["spreading.coverage"]);
  EXPECT_EQ(card["transfer"]["statements"].size(), 3u);
  EXPECT_FALSE(YAML::Load(MaterialCard(JointSample()))["transfer"]);
}

TEST(MaterialCardTest, CategoriesAreNames) {
  const YAML::Node card = YAML::Load(MaterialCard(CategoricalSample()));
  const YAML::Node model = card["parameters"]["rolling_model"];
  EXPECT_EQ(model["value"].as<std::string>(), "epsd2");
  EXPECT_EQ(model["searched"].as<std::vector<std::string>>(),
            (std::vector<std::string>{"cdt", "epsd2"}));
  EXPECT_EQ(card["parameters"]["cohesion_energy_density"]["value"].as<double>(), 55400);
}

}  // namespace
}  // namespace powdercal

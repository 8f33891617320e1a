#include <gmock/gmock.h>

#include "tests/cli/streams.h"

// `approximate: {cohesion: dmt_pull_off}` in everything that powdercal puts out.

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kStatement = "SJKR2 cohesion is approximated by DMT adhesion";

class DeclaredApproximation : public ::testing::Test {
 protected:
  DeclaredApproximation() {
    std::string text = StudyText(
        "quickstart", "parameters:", "approximate: {cohesion: dmt_pull_off}\nparameters:");
    WriteFileAtomically(folder_ / "study.yaml",
                        text.substr(0, text.find("optimizer:")) +
                            "optimizer:\n"
                            "  name: list\n"
                            "  points:\n"
                            "    - {cohesion_energy_density: 7e3 J/m3, rolling_friction: 0.4}\n"
                            "backend: {replicates: 1, confirm_replicates: 2}\n");
  }
  Streams Run(const std::vector<std::string>& arguments) const {
    return PowdercalStreams(arguments, folder_.path());
  }

  TemporaryFolder folder_;
};

TEST_F(DeclaredApproximation, StandsInCheckAndSimulate) {
  const Streams text = Run({"check", "study.yaml"});
  EXPECT_EQ(text.exit_status, 0) << text.error;
  EXPECT_THAT(text.output, AllOf(HasSubstr("approximation of cohesion: dmt_pull_off"),
                                 HasSubstr(kStatement), HasSubstr("+ dmt +"),
                                 HasSubstr("what the approximation changes, on embedded")));
  const json check = json::parse(Run({"check", "study.yaml", "--json"}).output);
  EXPECT_EQ(check.at("approximations")[0].at("name"), "dmt_pull_off");
  EXPECT_EQ(check.at("cost").at("approximation")[0].at("runs"), 2);
  const Streams simulate =
      Run({"simulate", "study.yaml", "-p", "k=7e3", "-p", "mu_r=0.4", "--json"});
  EXPECT_EQ(simulate.exit_status, 0) << simulate.error;
  EXPECT_THAT(simulate.error, HasSubstr(kStatement));
  const json document = json::parse(simulate.output);
  EXPECT_EQ(document.at("approximations")[0].at("part"), "cohesion");
  EXPECT_THAT(document.at("runs")[0].at("law").get<std::string>(), HasSubstr("+ dmt +"));
  EXPECT_EQ(document.at("parameters").at("cohesion_energy_density"), 7000);
}

TEST_F(DeclaredApproximation, StandsInEveryResultWithWhatItChanges) {
  const Streams run = Run({"run", "study.yaml", "--out", "x"});
  ASSERT_EQ(run.exit_status, 0) << run.error;
  EXPECT_THAT(run.error, AllOf(HasSubstr(kStatement),
                               HasSubstr("without the approximation of the contact law: 0 of 2 "
                                         "runs are in the ledger"),
                               HasSubstr("2/2 consolidation without the approximation")));
  EXPECT_THAT(run.output, AllOf(HasSubstr("what the approximation of the contact law changes:\n"
                                          "  Void ratio of consolidation: "),
                                HasSubstr(std::string("note: ") + kStatement)));
  const json results = ReadJson(folder_ / "x/results.json");
  EXPECT_EQ(results.at("study").at("approximations")[0].at("name"), "dmt_pull_off");
  EXPECT_THAT(results.at("study").at("contact_law").get<std::string>(), HasSubstr("sjkr2"));
  EXPECT_THAT(results.at("backend").at("contact_law_as_run").get<std::string>(),
              HasSubstr("+ dmt +"));
  const json& effect = results.at("approximation_effect");
  EXPECT_EQ(effect.at("backend"), "embedded");
  const json& ratio = effect.at("responses").at("consolidation.void_ratio");
  EXPECT_EQ(ratio.at("exact").at("replicates"), 2);
  EXPECT_EQ(ratio.at("approximated").at("simulated"),
            results.at("best").at("responses").at("consolidation.void_ratio").at("simulated"));
  EXPECT_TRUE(ratio.at("difference").is_number());
  EXPECT_EQ(results.at("runs").size(), 4u);
  EXPECT_THAT(ReadFile(folder_ / "x/report.html"),
              AllOf(HasSubstr("class=\"card wide approximation\""), HasSubstr(kStatement)));
  EXPECT_THAT(ReadFile(folder_ / "x/material_card.yaml"),
              AllOf(HasSubstr("\napproximations:\n"), HasSubstr("\napproximation_effect:\n"),
                    HasSubstr(kStatement)));
}

}  // namespace
}  // namespace powdercal

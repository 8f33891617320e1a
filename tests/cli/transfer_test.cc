#include <gmock/gmock.h>

#include "tests/cli/streams.h"

// `--evaluate-also` on a table, which answers in no time.

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class EvaluateAlso : public ::testing::Test {
 protected:
  EvaluateAlso() {
    std::string text = StudyText("hastelloy_x_table3", "optimizer:\n",
                                 "  - spreading:\n"
                                 "      calibrate: false\n"
                                 "      observed: {coverage: {value: 0.9, sd: 0.05}}\n"
                                 "optimizer:\n");
    const std::string file = "hastelloy_x_table3.csv";
    text.replace(text.find(file), file.size(), "table.csv");
    WriteFileAtomically(folder_ / "study.yaml", text);
    WriteFileAtomically(folder_ / "table.csv",
                        "cohesion_energy_density [J/m3],rolling_friction,consolidation.void_ratio,"
                        "spreading.coverage\n"
                        "1e2,0.05,0.57,0.99\n1e2,0.7,0.6,0.95\n1e5,0.05,0.9,0.4\n1e5,0.7,1.5,0.2\n"
                        "5e4,0.4,0.78,0.6\n");
  }

  Streams Run(std::vector<std::string> arguments) const {
    return PowdercalStreams(arguments, folder_.path());
  }

  TemporaryFolder folder_;
};

TEST_F(EvaluateAlso, ShowsFittedAndTransferredApart) {
  const Streams run = Run({"run", "study.yaml", "--out", "x", "--evaluate-also", "spreading"});
  ASSERT_EQ(run.exit_status, 0) << run.error;
  EXPECT_THAT(run.error, AllOf(HasSubstr("on experiments that were not calibrated: 0 of 1 runs"),
                               HasSubstr("1/1 spreading with particle seed")));
  EXPECT_THAT(run.output, AllOf(HasSubstr("the best point on what was not fitted:\n"
                                          "  spreading.coverage = "),
                                HasSubstr("Does not transfer to spreading")));
  const json results = ReadJson(folder_ / "x/results.json");
  EXPECT_TRUE(results.at("best").at("transfer").contains("spreading.coverage"));
  EXPECT_EQ(results.at("best").at("responses").size(), 1u);
  EXPECT_THAT(ReadFile(folder_ / "x/report.html"), HasSubstr("class=\"card wide transfer\""));
  EXPECT_THAT(ReadFile(folder_ / "x/material_card.yaml"), HasSubstr("\ntransfer:\n"));

  std::filesystem::remove(folder_ / "x/results.json");
  ASSERT_EQ(Run({"report", "x"}).exit_status, 0);
  EXPECT_EQ(ReadJson(folder_ / "x/results.json"), results) << "all of it is in the ledger";
  const Streams again = Run({"resume", "x", "--evaluate-also", "spreading"});
  EXPECT_EQ(again.exit_status, 0);
  EXPECT_THAT(again.error, HasSubstr("1 of 1 runs are in the ledger"));
  EXPECT_EQ(ReadJson(folder_ / "x/results.json").at("runs"), results.at("runs"));
}

TEST_F(EvaluateAlso, AfterTheStudyHasEnded) {
  ASSERT_EQ(Run({"run", "study.yaml", "--out", "x"}).exit_status, 0);
  const json before = ReadJson(folder_ / "x/results.json");
  EXPECT_TRUE(before.at("best").at("transfer").empty());
  const Streams later = Run({"resume", "x", "--evaluate-also", "spreading"});
  EXPECT_EQ(later.exit_status, 0);
  const json after = ReadJson(folder_ / "x/results.json");
  EXPECT_EQ(after.at("history"), before.at("history"));
  EXPECT_FALSE(after.at("best").at("transfer").empty());
}

TEST_F(EvaluateAlso, MistakesStartNothing) {
  const std::vector<std::pair<std::string, std::string>> mistakes = {
      {"consolidation", "'consolidation' is calibrated in this study; not calibrated: spreading"},
      {"spreding", "did you mean 'spreading'?"},
      {"shear", "experiment 'shear' is not in the study (consolidation, spreading)"}};
  for (const auto& [name, message] : mistakes) {
    for (const char* command : {"run", "check"}) {
      const Streams result =
          Run({command, "study.yaml", "--out", "x", "--evaluate-also", "spreading", name});
      EXPECT_EQ(result.exit_status, 2);
      EXPECT_THAT(result.error,
                  AllOf(HasSubstr("command line: --evaluate-also"), HasSubstr(message)));
      EXPECT_THAT(Listing(folder_.path()), ElementsAre("study.yaml", "table.csv"));
    }
  }
}

TEST_F(EvaluateAlso, CheckPlansWhatIsAskedFor) {
  const auto check = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"check", "study.yaml", "--json"});
    return json::parse(Run(more).output);
  };
  const json plain = check({});
  ASSERT_EQ(plain.at("programs").size(), 1u);
  const json also = check({"--evaluate-also", "spreading"});
  ASSERT_EQ(also.at("programs").size(), 2u);
  EXPECT_EQ(also.at("programs")[1].at("calibrated"), false);
  EXPECT_EQ(also.at("pi_groups").size(), 2u);
  EXPECT_EQ(also.at("cost").at("experiments")[1].at("runs"), 1);
  EXPECT_EQ(also.at("fingerprint"), plain.at("fingerprint"));
}

TEST_F(EvaluateAlso, SimulateTakesSingleExperiments) {
  const auto experiments = [&](std::vector<std::string> more) {
    more.insert(more.begin(),
                {"simulate", "study.yaml", "-p", "k=5e4", "-p", "mu_r=0.4", "--json"});
    const json document = json::parse(Run(more).output);
    std::vector<std::string> names;
    for (const json& run : document.at("runs")) names.push_back(run.at("experiment"));
    return names;
  };
  EXPECT_THAT(experiments({}), ElementsAre("consolidation", "spreading"));
  EXPECT_THAT(experiments({"--experiment", "spreading"}), ElementsAre("spreading"));
  const Streams wrong =
      Run({"simulate", "study.yaml", "-p", "k=5e4", "-p", "mu_r=0.4", "--experiment", "shear"});
  EXPECT_EQ(wrong.exit_status, 2);
  EXPECT_THAT(wrong.error, HasSubstr("unknown experiment 'shear'"));
}

}  // namespace
}  // namespace powdercal

#include <gmock/gmock.h>

#include "tests/cli/streams.h"

// `backend.confirm_with` on the command line, with the embedded engine.

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::string StudyWith(const std::string& backend, const std::string& law = "cohesion: sjkr2") {
  std::string text = StudyText("quickstart", "cohesion: sjkr2", law);
  return text.substr(0, text.find("optimizer:")) +
         "optimizer:\n"
         "  name: list\n"
         "  points:\n"
         "    - {cohesion_energy_density: 5e3 J/m3, rolling_friction: 0.4}\n"
         "backend: " +
         backend + "\n";
}

TEST(ConfirmWith, MistakesAreNamedBeforeAnythingStarts) {
  const TemporaryFolder folder;
  const std::vector<std::pair<std::string, std::string>> mistakes = {
      {"{confirm_with: [ligggths]}", "did you mean 'liggghts'?"},
      {"{confirm_with: [embedded]}", "'embedded' is the backend of the study itself"},
      {"{confirm_with: [table]}", "'table' simulates nothing, and can confirm nothing"},
      {"{confirm_with: [liggghts, liggghts]}", "named twice"},
      {"{confirm_with: {liggghts: 1}}", "expected a list, found a map"},
      {"{name: table, file: t.csv, confirm_with: liggghts}",
       "'table' simulates nothing that another backend could confirm"}};
  for (const auto& [backend, message] : mistakes) {
    WriteFileAtomically(folder / "study.yaml", StudyWith(backend));
    const Streams result = PowdercalStreams({"run", "study.yaml"}, folder.path());
    EXPECT_EQ(result.exit_status, 2) << backend;
    EXPECT_THAT(result.error, AllOf(HasSubstr("backend.confirm_with"), HasSubstr(message)));
    EXPECT_FALSE(std::filesystem::exists(folder / "runs"));
  }
}

TEST(ConfirmWith, CheckSaysWhatWillNotBePossible) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "study.yaml", StudyWith("{confirm_with: liggghts}"));
  const auto check = [&](const std::vector<std::pair<std::string, std::string>>& environment) {
    return Powdercal({"check", "study.yaml", "--json"}, folder.path(), environment);
  };
  const ProcessResult absent = check({{"PATH", "/nonexistent"}});
  EXPECT_EQ(absent.exit_status, 0) << absent.output;
  const json document = json::parse(absent.output);
  EXPECT_EQ(document.at("ready"), true);
  EXPECT_THAT(document.at("warnings").dump(),
              HasSubstr("liggghts will not confirm the best point: it is not available, no program "
                        "'liggghts' on PATH"));
  EXPECT_EQ(document.at("confirmations")[0].at("backend"), "liggghts");
  EXPECT_EQ(document.at("confirmations")[0].at("available"), false);
  EXPECT_TRUE(document.at("cost").at("confirmations")[0].at("experiments").empty());
  WriteFileAtomically(folder / "study.yaml", StudyWith("embedded"));
  EXPECT_EQ(json::parse(check({}).output).at("fingerprint"), document.at("fingerprint"));
}

// Where the other simulator is absent the study ends well, and says so everywhere.
TEST(ConfirmWith, AnAbsentSimulatorIsRecorded) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "study.yaml",
                      StudyWith("{replicates: 1, confirm_replicates: 2, confirm_with: liggghts}"));
  const ProcessResult run =
      Powdercal({"run", "study.yaml", "--out", "x"}, folder.path(), {{"PATH", "/nonexistent"}});
  ASSERT_EQ(run.exit_status, 0) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("warning: liggghts will not confirm the best point"),
                                HasSubstr("on other backends: 0 of 2 runs are in the ledger"),
                                HasSubstr("consolidation on liggghts failed, unsupported"),
                                HasSubstr("liggghts could not confirm the best point: not "
                                          "available: no program 'liggghts' on PATH")));
  const json results = ReadJson(folder / "x/results.json");
  ASSERT_EQ(results.at("confirmations").size(), 1u);
  EXPECT_EQ(results.at("confirmations")[0].at("outcome"), "unavailable");
  EXPECT_EQ(results.at("confirmations")[0].at("agrees"), false);
  EXPECT_THAT(results.at("caveats").dump(), HasSubstr("liggghts could not confirm"));
  EXPECT_THAT(ReadFile(folder / "x/report.html"), HasSubstr("class=\"card wide confirmations\""));
  EXPECT_THAT(ReadFile(folder / "x/material_card.yaml"), HasSubstr("\nconfirmations:\n"));
}

}  // namespace
}  // namespace powdercal

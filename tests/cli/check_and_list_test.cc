#include <gmock/gmock.h>

#include "tests/cli/streams.h"

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

TEST(Check, PrintsStudyPlanGroupsAndCostAndStartsNothing) {
  const TemporaryFolder folder;
  const Streams result = PowdercalStreams({"check", "hastelloy_x_table3"}, folder.path());
  EXPECT_EQ(result.exit_status, 0);
  EXPECT_EQ(result.error, "");
  for (const char* piece :
       {"# resolved study", "density: 8220 kg/m3", "# plan",
        "backend: table 1 (consolidation.void_ratio by gaussian_process)", "# scaling 'given'",
        "consolidation at k = ", "# cost", "no simulation was run", "ready to run"}) {
    EXPECT_THAT(result.output, HasSubstr(piece));
  }
  EXPECT_THAT(Listing(folder.path()), IsEmpty());
}

TEST(Check, JsonHoldsTheSame) {
  const TemporaryFolder folder;
  const Streams result =
      PowdercalStreams({"check", "hastelloy_x_table3", "--json", "--seed", "3"}, folder.path());
  EXPECT_EQ(result.exit_status, 0);
  EXPECT_EQ(result.error, "");
  const json check = json::parse(result.output);
  EXPECT_EQ(check.at("schema"), 1);
  EXPECT_EQ(check.at("study"), "hastelloy-x-table3");
  EXPECT_EQ(check.at("ready"), true);
  EXPECT_EQ(check.at("problem"), "");
  EXPECT_THAT(check.at("resolved").get<std::string>(), HasSubstr("seed: 3"));
  EXPECT_EQ(check.at("backend").at("name"), "table");
  EXPECT_EQ(check.at("backend").at("simulates"), false);
  EXPECT_EQ(check.at("programs").size(), 1u);
  EXPECT_GT(check.at("pi_groups").at(0).at("groups").size(), 3u);
  EXPECT_GT(check.at("cost").at("runs"), 0);
  EXPECT_THAT(Listing(folder.path()), IsEmpty());
}

TEST(Check, SaysHowTheEmbeddedEngineWillRun) {
  const TemporaryFolder folder;
  const Streams text =
      PowdercalStreams({"check", "quickstart", "--set", "backend.isa=portable"}, folder.path());
  EXPECT_EQ(text.exit_status, 0);
  EXPECT_THAT(text.output, HasSubstr("backend: embedded 1 (built in, portable, 1 thread)"));
  const auto check = [&](const std::string& option) {
    return json::parse(
        PowdercalStreams({"check", "quickstart", "--json", "--set", option}, folder.path()).output);
  };
  const json many = check("backend.threads=256");
  EXPECT_THAT(many.at("warnings").dump(), HasSubstr("backend.threads: 256 threads on "));
  EXPECT_THAT(many.at("backend").at("description").get<std::string>(), HasSubstr("256 threads"));
  EXPECT_GT(check("backend.isa=portable").at("cost").at("seconds"),
            check("backend.isa=auto").at("cost").at("seconds").get<double>() / 2);
}

TEST(Check, TheResolvedStudyIsTheStudy) {
  const TemporaryFolder folder;
  const auto check = [&](const std::string& study) {
    return json::parse(PowdercalStreams({"check", study, "--json"}, folder.path()).output);
  };
  const json shipped = check("quickstart");
  WriteFileAtomically(folder / "resolved.yaml", shipped.at("resolved").get<std::string>());
  EXPECT_EQ(check("resolved.yaml").at("fingerprint"), shipped.at("fingerprint"));
}

TEST(Check, IsNotReadyWhereRunWouldNotStart) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "x");
  WriteFileAtomically(folder / "x/thesis.tex", "precious");
  const Streams text =
      PowdercalStreams({"check", "hastelloy_x_table3", "--out", "x"}, folder.path());
  EXPECT_EQ(text.exit_status, 2);
  EXPECT_THAT(text.error, HasSubstr("thesis.tex"));
  EXPECT_THAT(text.output, Not(HasSubstr("ready to run")));
  const Streams machine =
      PowdercalStreams({"check", "hastelloy_x_table3", "--out", "x", "--json"}, folder.path());
  EXPECT_EQ(machine.exit_status, 2);
  const json check = json::parse(machine.output);
  EXPECT_EQ(check.at("ready"), false);
  EXPECT_THAT(check.at("problem").get<std::string>(), HasSubstr("thesis.tex"));
}

TEST(List, JsonNamesWhatThereIs) {
  const TemporaryFolder folder;
  const Streams result = PowdercalStreams({"list", "--json"}, folder.path());
  EXPECT_EQ(result.exit_status, 0);
  EXPECT_EQ(result.error, "");
  const json list = json::parse(result.output);
  const auto names = [&](const char* kind) {
    std::vector<std::string> found;
    for (const json& item : list.at(kind)) found.push_back(item.at("name"));
    return found;
  };
  using ::testing::Contains;
  EXPECT_THAT(names("backends"), Contains("embedded"));
  EXPECT_THAT(names("backends"), Contains("liggghts"));
  EXPECT_THAT(names("backends"), Contains("table"));
  EXPECT_THAT(names("experiments"), Contains("consolidation"));
  EXPECT_THAT(names("optimizers"), Contains("bayesian"));
  EXPECT_THAT(names("parameters"), Contains("rolling_friction"));
  EXPECT_THAT(names("scaling"), Contains("sigma_over_e"));
  EXPECT_THAT(names("studies"), Contains("quickstart"));
  EXPECT_FALSE(names("surrogates").empty());
  const json one =
      json::parse(PowdercalStreams({"list", "studies", "--json"}, folder.path()).output);
  EXPECT_EQ(one.size(), 1u);
  EXPECT_TRUE(std::filesystem::exists(one.at("studies").at(0).at("file").get<std::string>()));
}

TEST(List, AParameterOfNamesHasItsChoices) {
  const TemporaryFolder folder;
  const Streams result = PowdercalStreams({"list", "parameters", "--json"}, folder.path());
  ASSERT_EQ(result.exit_status, 0);
  const json listed = json::parse(result.output);
  bool found = false;
  for (const json& parameter : listed.at("parameters")) {
    const bool model = parameter.at("name") == "rolling_model";
    EXPECT_EQ(parameter.contains("choices"), model);
    if (model) {
      EXPECT_EQ(parameter.at("choices"), json::array({"none", "cdt", "epsd2"}));
    }
    found = found || model;
  }
  EXPECT_TRUE(found);
}

TEST(List, TheEmbeddedEngineIsAlwaysThere) {
  const TemporaryFolder folder;
  const ProcessResult result =
      Powdercal({"list", "backends"}, folder.path(), {{"PATH", "/nonexistent"}});
  EXPECT_THAT(result.output, ContainsRegex("embedded +1 +built in, "));
}

TEST(List, SaysWhyASimulatorIsAbsent) {
  const TemporaryFolder folder;
  const ProcessResult result =
      Powdercal({"list", "backends"}, folder.path(), {{"PATH", "/nonexistent"}});
  EXPECT_EQ(result.exit_status, 0);
  EXPECT_THAT(result.output, ContainsRegex("absent +no program 'liggghts' on PATH"));
}

}  // namespace
}  // namespace powdercal

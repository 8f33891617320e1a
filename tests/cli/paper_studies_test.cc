// The shipped studies of the seed paper, by their names, from any working directory.

#include <gmock/gmock.h>

#include "tests/cli/streams.h"

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::Contains;
using ::testing::HasSubstr;

std::vector<std::string> PaperStudies() {
  const TemporaryFolder folder;
  std::vector<std::string> names;
  const Streams list = PowdercalStreams({"list", "studies", "--json"}, folder.path());
  EXPECT_EQ(list.exit_status, 0) << list.error;
  const json document = json::parse(list.output);
  for (const json& study : document.at("studies")) {
    const std::string name = study.at("name");
    if (name.starts_with("paper/")) names.push_back(name);
  }
  return names;
}

TEST(PaperStudies, AllAreReadyToRun) {
  const TemporaryFolder folder;
  const std::vector<std::string> names = PaperStudies();
  EXPECT_THAT(names, Contains("paper/spreading"));
  for (const std::string& name : names) {
    const Streams result = PowdercalStreams({"check", name, "--json"}, folder.path());
    ASSERT_EQ(result.exit_status, 0) << name << ": " << result.error;
    const json check = json::parse(result.output);
    EXPECT_EQ(check.at("ready"), true) << name << ": " << check.at("problem");
    EXPECT_THAT(check.at("resolved").get<std::string>(), HasSubstr("mode: given")) << name;
  }
}

// Of the initial cases none is nearer than 0.2; eight evaluations are 13 in all.
TEST(PaperStudies, TheSearchesOnTheTableRun) {
  for (const std::string name : {"table3_search", "jitter_forest", "jitter_process"}) {
    const TemporaryFolder folder;
    const Streams result =
        PowdercalStreams({"run", "paper/" + name, "--evaluations", "13", "--json"}, folder.path());
    ASSERT_EQ(result.exit_status, 0) << name << ": " << result.error;
    const json results = json::parse(result.output);
    EXPECT_EQ(results.at("backend").at("simulated"), false) << name;
    EXPECT_EQ(results.at("evaluations").at("total"), 13) << name;
    const json& best = results.at("best").at("responses").at("consolidation.void_ratio");
    EXPECT_NEAR(best.at("simulated"), 0.783, 0.1) << name;
    EXPECT_EQ(results.at("history").at(0).at("parameters").at("rolling_friction"), 0.05) << name;
  }
}

}  // namespace
}  // namespace powdercal

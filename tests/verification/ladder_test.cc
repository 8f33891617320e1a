#include "verification/ladder.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/program.h"
#include "tests/verification/faulty_backend.h"
#include "verification/ladder_json.h"

namespace powdercal::verification {
namespace {

Finding Of(const char* a, const char* b, Verdict verdict, const char* name = "oblique") {
  return {.name = name, .a = a, .b = b, .verdict = verdict};
}

TEST(Bridges, NeedAThirdThatAgreesWithBoth) {
  std::vector<Finding> findings = {Of("e", "l", Verdict::equivalent),
                                   Of("e", "y", Verdict::equivalent),
                                   Of("l", "y", Verdict::unsupported)};
  NoteBridges(findings);
  EXPECT_TRUE(findings[2].note.starts_with("bridged by e,"));
  EXPECT_EQ(findings[2].verdict, Verdict::unsupported);

  findings = {Of("e", "l", Verdict::equivalent), Of("e", "y", Verdict::different),
              Of("l", "y", Verdict::unsupported)};
  NoteBridges(findings);
  EXPECT_EQ(findings[2].note, "");

  findings = {Of("e", "l", Verdict::equivalent), Of("e", "y", Verdict::equivalent, "head-on"),
              Of("l", "y", Verdict::unsupported)};
  NoteBridges(findings);
  EXPECT_EQ(findings[2].note, "");
}

TEST(LadderReport, PassesUnlessSomethingSpeaksAgainst) {
  LadderReport report;
  report.findings = {Of("a", "b", Verdict::equivalent), Of("a", "b", Verdict::unsupported)};
  EXPECT_TRUE(report.passed());
  for (const Verdict verdict : {Verdict::different, Verdict::undecided, Verdict::failed}) {
    report.findings[1].verdict = verdict;
    EXPECT_FALSE(report.passed()) << ToString(verdict);
    EXPECT_EQ(report.Count(verdict), 1);
  }
}

TEST(Ladder, TellsEverythingInJson) {
  const TemporaryFolder folder;
  const FaultyBackend same("same", NoFault());
  const FaultyBackend faulty("faulty", MoreFriction());
  const std::vector<Contender> contenders = {Contender(same), Contender(faulty)};
  const LadderReport report =
      ClimbLadder({.law = ShippedLaw("linear")}, contenders, {.rungs = {Rung::contact}},
                  {.parallel = 2, .work_folder = folder.path()});
  EXPECT_FALSE(report.passed());
  const nlohmann::json json = LadderToJson(report);
  EXPECT_EQ(json["schema"], 1);
  EXPECT_EQ(json["subject"], "linear");
  EXPECT_EQ(json["passed"], false);
  EXPECT_EQ(json["backends"][1]["name"], "faulty");
  EXPECT_EQ(json["compared"], report.findings.size());
  EXPECT_EQ(json["counts"]["different"], report.Count(Verdict::different));
  bool found = false;
  for (const auto& finding : json["findings"]) {
    if (finding["case"] != "wall, oblique") continue;
    found = true;
    EXPECT_EQ(finding["rung"], "contact");
    EXPECT_EQ(finding["verdict"], "different");
    EXPECT_EQ(finding["backends"], nlohmann::json({"same", "faulty"}));
    ASSERT_EQ(finding["quantities"].size(), 3U);
    EXPECT_EQ(finding["quantities"][1]["name"], "velocity");
    EXPECT_EQ(finding["quantities"][1]["tolerance"], 1e-7);
    EXPECT_GT(finding["quantities"][1]["difference"], 1e-4);
  }
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace powdercal::verification

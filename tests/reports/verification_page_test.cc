#include "reports/verification_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/program.h"

namespace powdercal {
namespace {

using namespace verification;
using ::testing::HasSubstr;
using ::testing::Not;

LadderReport SampleReport() {
  LadderReport report{
      .subject = "a <law>",
      .law = "hertz",
      .program_version = "0.1.0",
      .contenders = {{"embedded", "1", "avx2", ""}, {"yade", "", "", "no program 'yade'"}},
      .options = {.rungs = {Rung::contact, Rung::packing, Rung::calibration}}};
  report.findings = {{.rung = Rung::contact,
                      .name = "oblique",
                      .level = "L2",
                      .a = "embedded",
                      .b = "yade",
                      .verdict = Verdict::different,
                      .reason = "velocity off by 0.1",
                      .quantities = {{.name = "velocity",
                                      .difference = 0.1,
                                      .tolerance = 1e-6,
                                      .verdict = Verdict::different}}},
                     {.rung = Rung::packing,
                      .name = "bed",
                      .a = "embedded",
                      .b = "yade",
                      .verdict = Verdict::undecided,
                      .reason = "some 9 seeds would decide",
                      .quantities = {{.name = "void_ratio at 900 Pa",
                                      .unit = "1",
                                      .difference = 0.01,
                                      .tolerance = 0.02,
                                      .tolerance_reason = "two standard deviations",
                                      .seeds = SeedStatistics{.n = 6,
                                                              .mean_a = 0.75,
                                                              .mean_b = 0.76,
                                                              .lower = -0.01,
                                                              .upper = 0.03,
                                                              .p = 0.2},
                                      .verdict = Verdict::undecided}}}};
  report.failures = {{Rung::packing, "bed, seed 3", "yade", "timeout", "stopped after 2 s"}};
  return report;
}

TEST(VerificationPage, ShowsEveryFigureAndReason) {
  const std::string page = VerificationPage(SampleReport());
  for (const char* text :
       {"Verification of embedded, yade", "a &lt;law&gt;", "1.0e-01", "1e-06",
        "velocity off by 0.1", "some 9 seeds would decide", "void_ratio at 900 Pa",
        "two standard deviations", "bed, seed 3", "stopped after 2 s",
        "not available: no program &#39;yade&#39;", "not shown to be equivalent"}) {
    EXPECT_THAT(page, HasSubstr(text));
  }
  EXPECT_THAT(page, Not(HasSubstr("{{")));
  EXPECT_THAT(page, Not(HasSubstr("http://")));
}

TEST(VerificationPage, SaysWhenNothingWasCompared) {
  LadderReport report = SampleReport();
  for (Finding& finding : report.findings) finding.verdict = Verdict::unsupported;
  EXPECT_THAT(VerificationPage(report), HasSubstr("Nothing could be compared"));
}

TEST(VerificationPage, IsWrittenBesideItsJson) {
  const TemporaryFolder folder;
  WriteVerification(SampleReport(), folder.path());
  EXPECT_EQ(ReadJson(folder / "verification.json")["subject"], "a <law>");
  EXPECT_THAT(ReadFile(folder / "verification.html"), HasSubstr("<!doctype html>"));
}

}  // namespace
}  // namespace powdercal

#include "backends/trace.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace powdercal {
namespace {

TEST(Reasons, AreNamedInTheOrderOfTheEnumeration) {
  EXPECT_EQ(ReasonNames().size(), 9u);
  EXPECT_EQ(ToString(Reason::ok), "ok");
  EXPECT_EQ(ToString(Reason::invalid_input), "invalid_input");
  EXPECT_EQ(ToString(Reason::unsupported), "unsupported");
  EXPECT_EQ(ToString(Reason::lost_particles), "lost_particles");
  EXPECT_EQ(ToString(Reason::unstable), "unstable");
  EXPECT_EQ(ToString(Reason::not_quasi_static), "not_quasi_static");
  EXPECT_EQ(ToString(Reason::timeout), "timeout");
  EXPECT_EQ(ToString(Reason::crashed), "crashed");
  EXPECT_EQ(ToString(Reason::cancelled), "cancelled");
}

TEST(Trace, FindsTheLastMomentOfAName) {
  Trace trace;
  trace.moments = {
      {.name = "hold", .time = 1}, {.name = "servo", .time = 2}, {.name = "hold", .time = 3}};
  EXPECT_EQ(trace.Find("settle"), nullptr);
  ASSERT_NE(trace.Find("hold"), nullptr);
  EXPECT_EQ(trace.Find("hold")->time, 3);
}

TEST(Trace, OutcomeAndDiagnosticsAsJson) {
  EXPECT_EQ(ToJson(Outcome{Reason::timeout, "600 s"}).dump(),
            R"({"message":"600 s","reason":"timeout"})");
  Diagnostics diagnostics;
  diagnostics.steps = 12;
  diagnostics.law = "hertz";
  diagnostics.figures["void_ratio.surrogate_sd"] = 0.5;
  const nlohmann::json json = ToJson(diagnostics);
  EXPECT_EQ(json["steps"], 12);
  EXPECT_EQ(json["law"], "hertz");
  EXPECT_EQ(json["figures"]["void_ratio.surrogate_sd"], 0.5);
  EXPECT_EQ(json.size(), 10u);
}

}  // namespace
}  // namespace powdercal

#include "verification/contact_rung.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/program.h"
#include "tests/verification/faulty_backend.h"

namespace powdercal::verification {
namespace {

using ::testing::HasSubstr;

Trace TwoFrames(double x, double v = 1, double w = 0) {
  Trace trace;
  for (const double t : {1.0, 2.0}) {
    Moment moment;
    moment.time = t;
    moment.packing = {
        {.id = 1, .radius = 2, .position = {x, 0, 0}, .velocity = {v, 0, 0}, .spin = {0, w, 0}}};
    trace.moments.push_back(moment);
  }
  return trace;
}

TEST(CompareTrajectories, IsRelativeToRadiusAndSpeed) {
  Outcome outcome;
  const auto q = CompareTrajectories(TwoFrames(0, 4, 1), TwoFrames(1, 4.4, 1.1), 0.2, &outcome);
  ASSERT_TRUE(outcome.ok());
  ASSERT_EQ(q.size(), 3U);
  EXPECT_NEAR(q[0].difference, 0.5, 1e-12);
  EXPECT_EQ(q[0].verdict, Verdict::different);
  EXPECT_NEAR(q[1].difference, 0.1, 1e-12);
  EXPECT_EQ(q[1].verdict, Verdict::equivalent);
  EXPECT_NEAR(q[2].difference, 0.05, 1e-12);
}

TEST(CompareTrajectories, WhatIsNotANumberDiffers) {
  Outcome outcome;
  const auto q = CompareTrajectories(TwoFrames(0), TwoFrames(std::nan("")), 1, &outcome);
  ASSERT_EQ(q.size(), 3U);
  EXPECT_EQ(q[0].verdict, Verdict::different);
}

TEST(CompareTrajectories, WantsTheSameFrames) {
  Outcome outcome;
  Trace shorter = TwoFrames(0);
  shorter.moments.pop_back();
  EXPECT_TRUE(CompareTrajectories(TwoFrames(0), shorter, 1, &outcome).empty());
  EXPECT_THAT(outcome.message, HasSubstr("2 packings on the way in one, 1 in the other"));
  Trace later = TwoFrames(0);
  later.moments[1].time = 2.01;
  EXPECT_TRUE(CompareTrajectories(TwoFrames(0), later, 1, &outcome).empty());
  EXPECT_THAT(outcome.message, HasSubstr("2.01 s"));
}

// A ladder of the embedded engine against itself with a fault.
class Contacts : public ::testing::Test {
 protected:
  std::vector<Finding> Verify(const std::string& law, const Backend& other) {
    const auto engine = MakeBackend("embedded");
    const std::vector<Contender> contenders = {Contender(*engine), Contender(other)};
    return VerifyContacts(ShippedLaw(law), contenders,
                          {.parallel = 2, .work_folder = folder_.path()});
  }
  static std::vector<std::string> Different(const std::vector<Finding>& findings) {
    std::vector<std::string> names;
    for (const Finding& finding : findings) {
      if (finding.verdict == Verdict::different) names.push_back(finding.name);
    }
    return names;
  }
  TemporaryFolder folder_;
};

TEST_F(Contacts, OfOneEngineAreEquivalent) {
  const FaultyBackend same("same", NoFault());
  for (const std::string& law : LawNames()) {
    for (const Finding& finding : Verify(law, same)) {
      EXPECT_EQ(finding.verdict, Verdict::equivalent) << law << ", " << finding.name;
      EXPECT_EQ(finding.quantities.size(), 3U);
      for (const Quantity& q : finding.quantities) EXPECT_EQ(q.difference, 0) << finding.name;
    }
  }
}

TEST_F(Contacts, CatchFivePerCentOfFriction) {
  const FaultyBackend faulty("more friction", MoreFriction());
  for (const char* law : {"hertz_mindlin_history", "linear", "hertz_no_history", "paper"}) {
    EXPECT_THAT(Different(Verify(law, faulty)), ::testing::Contains("wall, oblique")) << law;
  }
  // Head-on impacts know no friction.
  EXPECT_THAT(Different(Verify("hertz_mindlin_history", faulty)),
              ::testing::Not(::testing::Contains("head-on")));
}

TEST_F(Contacts, CatchWallsOfTwiceTheStiffness) {
  const FaultyBackend faulty("stiff walls", StiffWalls());
  for (const std::string& law : LawNames()) {
    const auto found = Different(Verify(law, faulty));
    EXPECT_THAT(found, ::testing::Contains("wall, head-on")) << law;
    EXPECT_THAT(found, ::testing::Not(::testing::Contains("head-on"))) << law;
  }
}

TEST_F(Contacts, CatchTheLackOfRollingResistance) {
  const FaultyBackend faulty("no rolling", NoRolling());
  for (const char* law : {"hertz_mindlin_history_epsd2", "hertz_mindlin_history_cdt",
                          "hertz_mindlin_history_sjkr2_epsd2", "paper"}) {
    EXPECT_THAT(Different(Verify(law, faulty)),
                ::testing::IsSupersetOf({"rolling decay", "twisting", "wall, rolling"}))
        << law;
  }
}

TEST_F(Contacts, SayByHowMuch) {
  const FaultyBackend faulty("more friction", MoreFriction());
  for (const Finding& finding : Verify("hertz_mindlin_history", faulty)) {
    if (finding.name != "wall, oblique") continue;
    EXPECT_THAT(finding.reason, HasSubstr("velocity off by"));
    EXPECT_THAT(finding.reason, HasSubstr("tolerance 1e-09"));
    EXPECT_GT(finding.quantities[1].difference, 1e-4);
  }
}

// Knows only what it is told.
class Picky final : public Backend {
 public:
  Picky(std::string name, bool available, ContactLaw::ShearUpdate update)
      : name_(std::move(name)), available_(available), update_(update) {}
  const std::string& name() const override { return name_; }
  Availability availability() const override {
    if (!available_) return {.why_not = "it is not installed"};
    return {.available = true, .version = "1"};
  }
  std::string ExplainUnsupported(const Program& program) const override {
    return program.law.shear_update == update_ ? "" : "not with this shear_update";
  }
  Trace Run(const Program& program, const RunContext& context) const override {
    return MakeBackend("embedded")->Run(program, context);
  }

 private:
  std::string name_;
  bool available_;
  ContactLaw::ShearUpdate update_;
};

TEST_F(Contacts, AreComparedInAFormThatBothHave) {
  const Picky other("incremental only", true, ContactLaw::ShearUpdate::incremental);
  for (const Finding& finding : Verify("hertz_mindlin_history", other)) {
    EXPECT_EQ(finding.verdict, Verdict::equivalent) << finding.name;
    EXPECT_THAT(finding.law_b, HasSubstr("incremental"));
    if (finding.name == "oblique") {
      EXPECT_EQ(finding.law_a, finding.law_b);
      EXPECT_THAT(finding.note, HasSubstr("in a form that both have"));
      EXPECT_EQ(finding.quantities[0].tolerance, 1e-6);
    }
    if (finding.name == "head-on") {
      EXPECT_THAT(finding.law_a, HasSubstr("displacement"));
      EXPECT_THAT(finding.note, HasSubstr("in forms that are one here"));
      EXPECT_EQ(finding.quantities[0].tolerance, 1e-12);
    }
  }
}

TEST_F(Contacts, OfABackendThatIsAbsentAreUnsupported) {
  const Picky other("absent", false, ContactLaw::ShearUpdate::incremental);
  for (const Finding& finding : Verify("linear", other)) {
    EXPECT_EQ(finding.verdict, Verdict::unsupported);
    EXPECT_EQ(finding.reason, "absent: not available: it is not installed");
  }
}

// Ends badly, or throws.
class Failing final : public Backend {
 public:
  explicit Failing(bool throws) : throws_(throws) {}
  const std::string& name() const override {
    static const std::string kName = "failing";
    return kName;
  }
  Availability availability() const override { return {.available = true, .version = "1"}; }
  std::string ExplainUnsupported(const Program&) const override { return ""; }
  Trace Run(const Program&, const RunContext&) const override {
    if (throws_) throw std::runtime_error("the disk is full");
    return {.outcome = {Reason::lost_particles, "one particle is gone"}};
  }

 private:
  bool throws_;
};

TEST_F(Contacts, OfWhichOneFailsSayWhy) {
  for (const bool throws : {false, true}) {
    for (const Finding& finding : Verify("linear", Failing(throws))) {
      EXPECT_EQ(finding.verdict, Verdict::failed);
      EXPECT_THAT(finding.reason, HasSubstr(throws ? "failing: crashed, the disk is full"
                                                   : "failing: lost_particles, one particle"));
    }
  }
}

}  // namespace
}  // namespace powdercal::verification

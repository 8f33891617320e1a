#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/program.h"
#include "tests/verification/faulty_backend.h"
#include "verification/ladder.h"
#include "verification/packing_rung.h"

// Beds of the embedded engine against itself with a fault. What 5 % of friction do to a bed is less
// than ten seeds can tell, and less than the margins: rung 1 is there for that.

namespace powdercal::verification {
namespace {

LadderReport Climb(const std::string& law, const Backend& other) {
  const TemporaryFolder folder;
  const auto engine = MakeBackend("embedded");
  const std::vector<Contender> contenders = {Contender(*engine), Contender(other)};
  return ClimbLadder({.law = ShippedLaw(law)}, contenders, {.rungs = {Rung::packing}, .seeds = 10},
                     {.parallel = 2, .work_folder = folder.path()});
}

// Particles in another order: another rounding, and soon another bed.
class ShuffledBackend final : public Backend {
 public:
  const std::string& name() const override {
    static const std::string kName = "shuffled";
    return kName;
  }
  Availability availability() const override { return {.available = true, .version = "1"}; }
  std::string ExplainUnsupported(const Program&) const override { return ""; }
  Trace Run(const Program& program, const RunContext& context) const override {
    Program changed = program;
    for (Sphere& sphere : *changed.particles.packing) sphere.position[0] *= 1 + 1e-12;
    return MakeBackend("embedded")->Run(changed, context);
  }
};

TEST(Packings, ThatDifferByRoundingAreEquivalent) {
  const LadderReport report = Climb("hertz_mindlin_history_epsd2", ShuffledBackend());
  ASSERT_EQ(report.findings.size(), 1U);
  EXPECT_EQ(report.findings[0].verdict, Verdict::equivalent) << report.findings[0].reason;
  double scatter = 0;
  for (const Quantity& quantity : report.findings[0].quantities) {
    scatter = std::max(scatter, quantity.seeds->sd_difference);
  }
  EXPECT_GT(scatter, 1e-4) << "the beds are the same, and the test is none";
}

TEST(Packings, CatchTheLackOfRollingResistance) {
  const FaultyBackend faulty("no rolling", NoRolling());
  const LadderReport report = Climb("hertz_mindlin_history_epsd2", faulty);
  ASSERT_EQ(report.findings.size(), 1U);
  EXPECT_EQ(report.findings[0].verdict, Verdict::different);
  EXPECT_THAT(report.findings[0].reason, ::testing::HasSubstr("void_ratio at 900 Pa differs by -"));
}

}  // namespace
}  // namespace powdercal::verification

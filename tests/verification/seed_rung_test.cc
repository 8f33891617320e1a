#include "verification/seed_rung.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "backends/registry.h"
#include "tests/support/program.h"
#include "verification/packing_rung.h"

namespace powdercal::verification {
namespace {

using ::testing::HasSubstr;

// Knows the answer without a simulation: the particle seed and something of its own.
class Stub final : public Backend {
 public:
  Stub(std::string name, std::function<double(double)> answer)
      : name_(std::move(name)), answer_(std::move(answer)) {}

  const std::string& name() const override { return name_; }
  Availability availability() const override { return {.available = true, .version = "1"}; }
  std::string ExplainUnsupported(const Program& program) const override {
    return program.law.rolling == ContactLaw::Rolling::cdt ? "it has no cdt" : "";
  }
  Trace Run(const Program& program, const RunContext& context) const override {
    ++runs;
    if (context.stop.stop_requested()) return {.outcome = {Reason::cancelled, "stopped"}};
    const double value = answer_(static_cast<double>(program.particles.seed));
    if (std::isinf(value)) return {.outcome = {Reason::unstable, "blown up"}};
    Trace trace;
    if (!std::isnan(value)) trace.reported["e"] = {value, 0};
    return trace;
  }

  mutable std::atomic<int> runs = 0;

 private:
  std::string name_;
  std::function<double(double)> answer_;
};

SeedCase Case(int seeds, double margin, bool relative = false) {
  SeedCase entry{.name = "bed"};
  for (int seed = 1; seed <= seeds; ++seed) {
    Program program;
    program.experiment = "bed";
    program.particles.seed = static_cast<std::uint64_t>(seed);
    entry.seeds.push_back(program.particles.seed);
    entry.programs.push_back(program);
  }
  entry.comparisons = {{.name = "e", .unit = "1", .margin = margin, .relative = relative}};
  entry.measure = [](const Program&, const Trace& trace, Outcome*) {
    Measurement measurement;
    for (const auto& [name, reported] : trace.reported) {
      measurement.responses[name].value = reported.value;
    }
    return measurement;
  };
  return entry;
}

class SeedRung : public ::testing::Test {
 protected:
  std::vector<Finding> Compare(const SeedCase& entry, Ledger* ledger = nullptr) {
    const std::vector<Contender> contenders = {Contender(a_), Contender(*b_)};
    return CompareOverSeeds(Rung::packing, std::span(&entry, 1), contenders, 0.05,
                            {.parallel = 2, .work_folder = folder_.path(), .ledger = ledger});
  }
  Finding Compare(std::function<double(double)> answer, double margin, int seeds = 5) {
    b_ = std::make_unique<Stub>("b", std::move(answer));
    return Compare(Case(seeds, margin)).at(0);
  }

  TemporaryFolder folder_;
  Stub a_{"a", [](double seed) { return seed; }};
  std::unique_ptr<Stub> b_ = std::make_unique<Stub>("b", [](double seed) { return seed; });
};

TEST_F(SeedRung, TestsSeedBySeed) {
  const Finding same = Compare([](double seed) { return seed + (seed > 3 ? 0.01 : -0.01); }, 0.1);
  EXPECT_EQ(same.verdict, Verdict::equivalent);
  EXPECT_EQ(same.reason, "");
  ASSERT_EQ(same.quantities.size(), 1U);
  EXPECT_EQ(same.quantities[0].seeds->n, 5);
  EXPECT_DOUBLE_EQ(same.quantities[0].seeds->mean_a, 3);
  const Finding other = Compare([](double seed) { return seed + 1; }, 0.1);
  EXPECT_EQ(other.verdict, Verdict::different);
  EXPECT_THAT(other.reason, HasSubstr("e differs by +1 [+1, +1], margin 0.1"));
}

TEST_F(SeedRung, SaysHowManySeedsWouldDecide) {
  const Finding finding =
      Compare([](double seed) { return seed + (std::fmod(seed, 2) - 0.5); }, 0.4);
  EXPECT_EQ(finding.verdict, Verdict::undecided);
  EXPECT_THAT(finding.reason, ::testing::ContainsRegex("some [0-9]+ seeds would decide"));
}

TEST_F(SeedRung, AFailedRunIsAFinding) {
  const Finding finding = Compare([](double seed) { return seed == 2 ? INFINITY : seed; }, 0.1);
  EXPECT_EQ(finding.verdict, Verdict::failed);
  EXPECT_EQ(finding.reason, "1 of 5 runs failed in b: unstable, blown up");
  EXPECT_EQ(finding.quantities[0].seeds->n, 4);
}

TEST_F(SeedRung, AMissingValueIsNoted) {
  const Finding finding = Compare([](double seed) { return seed == 2 ? NAN : seed; }, 0.1);
  EXPECT_EQ(finding.verdict, Verdict::equivalent);
  EXPECT_EQ(finding.quantities[0].note, "1 of 5 seeds gave no value");
}

TEST_F(SeedRung, WhatOneCannotDoIsUnsupported) {
  SeedCase entry = Case(3, 0.1);
  for (Program& program : entry.programs) program.law.rolling = ContactLaw::Rolling::cdt;
  const Finding finding = Compare(entry).at(0);
  EXPECT_EQ(finding.verdict, Verdict::unsupported);
  EXPECT_EQ(finding.reason, "a: it has no cdt");
  EXPECT_EQ(a_.runs, 0);
}

TEST_F(SeedRung, RelativeMarginsAreThoseOfTheReference) {
  EXPECT_DOUBLE_EQ(Compare(Case(5, 0.1, true)).at(0).quantities[0].tolerance, 0.3);
}

TEST_F(SeedRung, RunsInTheLedgerAreNotRepeatedAndFailedOnesAre) {
  b_ = std::make_unique<Stub>("b", [](double seed) { return seed == 2 ? INFINITY : seed; });
  Ledger ledger(folder_ / "ledger.sqlite", Ledger::Mode::read_write);
  Compare(Case(5, 0.1), &ledger);
  EXPECT_EQ(a_.runs, 5);
  EXPECT_EQ(b_->runs, 5);
  const Finding finding = Compare(Case(6, 0.1), &ledger).at(0);
  EXPECT_EQ(a_.runs, 6);
  EXPECT_EQ(b_->runs, 7);
  EXPECT_EQ(finding.quantities[0].seeds->n, 5);
  EXPECT_DOUBLE_EQ(finding.quantities[0].seeds->mean_a, 3.8);
}

TEST(PackingCase, IsOneExplicitPackingForEveryBackend) {
  const SeedCase entry = PackingCase(ShippedLaw("hertz_mindlin_history"), 2, {});
  ASSERT_EQ(entry.programs.size(), 2U);
  for (const Program& program : entry.programs) {
    ASSERT_TRUE(program.particles.packing);
    EXPECT_EQ(program.particles.packing->size(), 1000U);
    EXPECT_EQ(MakeBackend("embedded")->ExplainUnsupported(program), "");
  }
  EXPECT_NE(entry.programs[0].Hash(), entry.programs[1].Hash());
  EXPECT_EQ(entry.comparisons.size(), 9U);
}

TEST(PackingCase, TakesMargins) {
  const SeedCase entry = PackingCase(ShippedLaw("linear"), 2, {{"void_ratio", 0.005}});
  for (const Comparison& comparison : entry.comparisons) {
    if (!comparison.name.starts_with("void_ratio")) continue;
    EXPECT_EQ(comparison.margin, 0.005);
    EXPECT_EQ(comparison.margin_reason, "as given");
  }
}

}  // namespace
}  // namespace powdercal::verification

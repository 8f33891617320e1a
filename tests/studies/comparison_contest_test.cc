#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "studies/comparison/contest.h"
#include "studies/comparison/record.h"

namespace powdercal::comparison {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Objectives OneTarget() {
  return {.targets = {{.response = "a.x", .unit = "1", .value = 0, .sd = 1}}};
}

// Asks for 1/n, 2/n, …; waits while more than `window` are pending.
class Walk final : public Optimizer {
 public:
  explicit Walk(int points, int window = 1000) : points_(points), window_(window) {}
  std::vector<Candidate> Ask(int) override {
    Candidate candidate{asked_, Eigen::VectorXd::Constant(1, double(asked_ + 1) / points_), ""};
    ++asked_;
    return {candidate};
  }
  void Tell(std::span<const Observation> observations) override {
    for (const Observation& one : observations) {
      order_.push_back(static_cast<int>(one.id));
      failures_ += one.failed ? 1 : 0;
    }
  }
  Status status() const override {
    if (asked_ == points_) return {Status::Phase::finished, "all asked"};
    const bool wait = asked_ - static_cast<int>(order_.size()) >= window_;
    return {wait ? Status::Phase::waiting : Status::Phase::ready, ""};
  }
  Capabilities capabilities() const override { return {}; }
  std::string ExplainUnsupported(const SearchSpace&, const Objectives&) const override {
    return "";
  }

  std::vector<int> order_;
  int failures_ = 0;

 private:
  int points_;
  int window_;
  std::int64_t asked_ = 0;
};

LedgerRun MakeRun(double seconds, double value, bool ok = true) {
  LedgerRun run{.experiment = "a"};
  run.diagnostics.wall_seconds = seconds;
  if (ok) {
    run.measurement.responses["x"].value = value;
  } else {
    run.outcome = {Reason::timeout, "too slow"};
  }
  return run;
}

// Simulations take `seconds[evaluation]`; the response is the number of the evaluation.
void Play(Contest& contest, const std::vector<double>& seconds, const std::vector<int>& fail = {}) {
  for (auto simulations = contest.Advance(); !simulations.empty();
       simulations = contest.Advance()) {
    for (const Simulation& s : simulations) {
      const bool failed = std::find(fail.begin(), fail.end(), s.evaluation) != fail.end();
      contest.Provide(
          s, MakeRun(seconds[static_cast<std::size_t>(s.evaluation)], s.evaluation, !failed));
    }
  }
}

Rules MakeRules(int evaluations, int slots, int replicates = 1) {
  return {.experiments = {0}, .replicates = replicates, .slots = slots, .evaluations = evaluations};
}

TEST(Contest, OneSlotTakesTheSumOfTheTimes) {
  Contest contest(std::make_unique<Walk>(100), OneTarget(), MakeRules(3, 1));
  Play(contest, {1, 2, 4});
  EXPECT_EQ(contest.now(), 7);
  EXPECT_EQ(contest.busy_seconds(), 7);
  EXPECT_THAT(contest.told(), ElementsAre(0, 1, 2));
  EXPECT_EQ(contest.evaluations()[1].told_at, 3);
  EXPECT_THAT(contest.end(), HasSubstr("budget of 3 evaluations used"));
}

TEST(Contest, TellsInTheOrderOfVirtualTime) {
  auto walk = std::make_unique<Walk>(100);
  const Walk& optimizer = *walk;
  Contest contest(std::move(walk), OneTarget(), MakeRules(4, 2));
  // One slot has 0 until 5; the other 1 until 1, 2 until 3, 3 until 6.
  Play(contest, {5, 1, 2, 3});
  EXPECT_THAT(optimizer.order_, ElementsAre(1, 2, 0, 3));
  EXPECT_EQ(contest.evaluations()[2].told_at, 3);
  EXPECT_EQ(contest.now(), 6);
  EXPECT_EQ(contest.busy_seconds(), 11);
}

TEST(Contest, SimulationsAreChargedWithTheirCores) {
  Rules rules = MakeRules(2, 1, 3);
  rules.cores = 2;
  Contest contest(std::make_unique<Walk>(100), OneTarget(), rules);
  Play(contest, {1, 10});
  EXPECT_EQ(contest.core_seconds(), 2 * 3 * (1 + 10));
  EXPECT_EQ(contest.evaluations()[0].core_seconds, 6);
  EXPECT_EQ(contest.evaluations()[0].runs.size(), 3);
}

TEST(Contest, AnOptimizerThatWaitsLeavesSlotsIdle) {
  Contest contest(std::make_unique<Walk>(100, 1), OneTarget(), MakeRules(4, 2));
  Play(contest, {1, 1, 1, 1});
  EXPECT_EQ(contest.now(), 4);
  EXPECT_EQ(contest.busy_seconds() / (2 * contest.now()), 0.5);
}

TEST(Contest, EndsWithTheOptimizer) {
  Contest contest(std::make_unique<Walk>(2), OneTarget(), MakeRules(10, 2));
  Play(contest, {1, 1});
  EXPECT_THAT(contest.end(), HasSubstr("the optimizer has finished: all asked"));
  EXPECT_EQ(contest.told().size(), 2);
}

TEST(Contest, FailuresAreToldAndCharged) {
  auto walk = std::make_unique<Walk>(100);
  const Walk& optimizer = *walk;
  Contest contest(std::move(walk), OneTarget(), MakeRules(3, 1));
  Play(contest, {1, 100, 1}, {1});
  EXPECT_EQ(optimizer.failures_, 1);
  EXPECT_EQ(contest.core_seconds(), 102);
  const ContestRecord record = Summarise(contest, {.parameters = {{.name = "p"}}}, {});
  EXPECT_TRUE(record.steps[1].failed);
  EXPECT_TRUE(std::isnan(record.steps[1].judged[0]));
  EXPECT_EQ(record.steps[1].reported, 0);
  EXPECT_EQ(record.steps[2].core_seconds, 102);
}

TEST(Contest, WhatEndsBeyondTheCoreSecondsDoesNotCount) {
  Rules rules = MakeRules(10, 2);
  rules.core_seconds = 6;
  Contest contest(std::make_unique<Walk>(100), OneTarget(), rules);
  Play(contest, {2, 3, 2, 3, 2, 3, 2, 3, 2, 3});
  EXPECT_THAT(contest.end(), HasSubstr("budget of 6 core-seconds used"));
  const ContestRecord record = Summarise(contest, {.parameters = {{.name = "p"}}}, {});
  EXPECT_EQ(record.steps.size(), 2);  // 2 and 3 are within 6, the next ends at 7
  EXPECT_EQ(record.steps.back().core_seconds, 5);
  EXPECT_GT(contest.told().size(), 2);
}

// The same point over and over.
class Stubborn final : public Optimizer {
 public:
  std::vector<Candidate> Ask(int) override {
    return {{asked_++, Eigen::VectorXd::Constant(1, 0.5), ""}};
  }
  void Tell(std::span<const Observation> observations) override {
    told_ += static_cast<int>(observations.size());
  }
  Status status() const override { return {}; }
  Capabilities capabilities() const override { return {}; }
  std::string ExplainUnsupported(const SearchSpace&, const Objectives&) const override {
    return "";
  }
  int told_ = 0;

 private:
  std::int64_t asked_ = 0;
};

TEST(Contest, ARepeatedPointCountsButCostsNothing) {
  auto stubborn = std::make_unique<Stubborn>();
  const Stubborn& optimizer = *stubborn;
  Contest contest(std::move(stubborn), OneTarget(), MakeRules(5, 1));
  Play(contest, {3, 3, 3, 3, 3});
  EXPECT_EQ(contest.core_seconds(), 3);
  EXPECT_EQ(contest.now(), 3);
  EXPECT_EQ(optimizer.told_, 5);
  EXPECT_TRUE(contest.evaluations()[4].repeated);
}

TEST(Record, IsJudgedByTheTruthButReportsWhatWasObserved) {
  Contest contest(std::make_unique<Walk>(4), OneTarget(), MakeRules(4, 1));
  // Observed: 0, 1, 2, 3, so that the first is reported for good. True: ten times the place.
  Play(contest, {1, 1, 1, 1});
  const SearchSpace space{.parameters = {{.name = "p", .lower = 0, .upper = 8}}};
  const ContestRecord record = Summarise(
      contest, space, [](const Eigen::VectorXd& point) -> Eigen::VectorXd { return 10 * point; });
  EXPECT_EQ(record.steps[0].judged[0], 2.5 * 2.5);
  EXPECT_EQ(record.steps[3].judged[0], 100);
  EXPECT_EQ(record.steps[3].reported, 0);
  EXPECT_EQ(record.fit, 0);
  EXPECT_THAT(record.parameters, ElementsAre(2));  // a quarter of the way
  EXPECT_EQ(ReportedPoint(contest, record)[0], 0.25);
}

TEST(Record, OfNothingReportsNothing) {
  Contest contest(std::make_unique<Walk>(2), OneTarget(), MakeRules(2, 1));
  Play(contest, {1, 1}, {0, 1});
  const ContestRecord record = Summarise(contest, {.parameters = {{.name = "p"}}}, {});
  EXPECT_TRUE(record.parameters.empty());
  EXPECT_TRUE(std::isnan(record.fit));
  EXPECT_EQ(ReportedPoint(contest, record).size(), 0);
  EXPECT_EQ(record.steps.back().reported, -1);
}

}  // namespace
}  // namespace powdercal::comparison

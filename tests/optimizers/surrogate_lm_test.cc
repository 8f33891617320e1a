#include "optimizers/least_squares/surrogate_lm.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "optimizers/test_problems.h"
#include "tests/optimizers/problems.h"

namespace powdercal {
namespace {

using testing::HasSubstr;

double BestDistance(const std::vector<Observation>& history) {
  double best = 1e300;
  for (const Observation& observation : history) {
    if (!observation.failed) best = std::min(best, (observation.point - kTwoAnswer).norm());
  }
  return best;
}

TEST(SurrogateLmTest, MatchesTwoResponsesWithinTenEvaluations) {
  const auto optimizer = MakeSurrogateLm({}, UnitBox(2), kTwo, 2);
  const std::vector<Observation> history = RunSerially(optimizer.get(), TwoResponses, 10);
  EXPECT_LT(BestDistance(history), 1e-3);
  EXPECT_THAT(optimizer->status().message, HasSubstr("minimum of the model, chi²"));
  EXPECT_EQ(optimizer->status().phase, Status::Phase::ready);
}

// True sum of squares of the evaluation that came out best, median of three seeds.
double MedianEnvironmentalSquares(const std::string& name, int evaluations) {
  TestProblem problem = MakeTestProblem("environmental", "");
  const SearchSpace& space = problem.space;
  for (Target& target : problem.objectives.targets) target.sd = 0.05;
  std::vector<double> squares;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    RandomStream random(1000 + seed);
    const auto optimizer = MakeOptimizerFactory(name)->Make(space, problem.objectives, seed);
    const auto responses = [&](const Eigen::VectorXd& point) {
      Eigen::VectorXd values = problem.respond(space.FromUnit(point));
      for (double& value : values) value += 0.05 * random.Normal();
      return values;
    };
    double lowest = 1e300;
    double reached = 0;
    for (const Observation& o : RunSerially(optimizer.get(), responses, evaluations)) {
      const double seen = ChiSquared(problem.objectives, o.responses, {});
      if (seen >= lowest) continue;
      lowest = seen;
      const Eigen::VectorXd noise_free = problem.respond(space.FromUnit(o.point));
      reached = problem.measure({&noise_free, 1});
    }
    squares.push_back(reached);
  }
  std::sort(squares.begin(), squares.end());
  return squares[1];
}

TEST(SurrogateLmTest, UnderNoiseItIsNoWorseThanDifferences) {
  const double by_surrogate = MedianEnvironmentalSquares("surrogate_lm", 30);
  EXPECT_LT(by_surrogate, 0.02);
  EXPECT_LE(by_surrogate, MedianEnvironmentalSquares("least_squares", 30));
}

TEST(SurrogateLmTest, SameCallsGiveSamePointsHoweverTheObservationsArrived) {
  const auto undisturbed = MakeSurrogateLm({}, UnitBox(2), kTwo, 3);
  std::vector<Observation> history = RunSerially(undisturbed.get(), TwoResponses, 10);
  const auto resumed = MakeSurrogateLm({}, UnitBox(2), kTwo, 3);
  for (int i = 0; i < 6; ++i) resumed->Ask(1);  // the design
  std::reverse(history.begin(), history.begin() + 6);
  resumed->Tell(std::span(history).subspan(2, 4));
  resumed->Tell(std::span(history).subspan(0, 2));
  for (std::size_t i = 6; i < history.size(); ++i) {
    EXPECT_EQ(resumed->Ask(1)[0].point, history[i].point);
    resumed->Tell(std::span(history).subspan(i, 1));
  }
  EXPECT_EQ(resumed->Ask(1)[0].point, undisturbed->Ask(1)[0].point);
  EXPECT_NE(MakeSurrogateLm({}, UnitBox(2), kTwo, 4)->Ask(1)[0].point, history[5].point);
}

TEST(SurrogateLmTest, ABatchHasTheMinimumOnceAndThenUncertainPoints) {
  const auto optimizer = MakeSurrogateLm({}, UnitBox(2), kTwo, 5);
  RunSerially(optimizer.get(), TwoResponses, 6);
  const std::vector<Candidate> batch = optimizer->Ask(4);
  ASSERT_EQ(batch.size(), 4);
  EXPECT_EQ(batch[0].origin, "surrogate_lm: minimum");
  std::vector<Eigen::VectorXd> points;
  for (const Candidate& candidate : batch) points.push_back(candidate.point);
  EXPECT_GT(SmallestDistance(points), 1e-6);
  EXPECT_EQ(std::count_if(batch.begin(), batch.end(),
                          [](const Candidate& candidate) {
                            return candidate.origin == "surrogate_lm: minimum";
                          }),
            1);
}

// x0² = 0.25 twice over in a box that reaches from −1 to 1.
TEST(SurrogateLmTest, ABatchGoesToBothMinima) {
  const auto response = [](const Eigen::VectorXd& x) {
    return Eigen::VectorXd(Eigen::VectorXd::Constant(1, std::pow(2 * x[0] - 1, 2)));
  };
  const auto optimizer = MakeSurrogateLm({.initial_design = {.name = "grid", .levels = 7}},
                                         UnitBox(1), JointTargets({0.25}, 0.01), 5);
  RunSerially(optimizer.get(), response, 7);
  const std::vector<Candidate> batch = optimizer->Ask(2);
  EXPECT_NEAR(std::abs(batch[0].point[0] - 0.5), 0.25, 0.01);
  EXPECT_NEAR(batch[0].point[0] + batch[1].point[0], 1, 0.02);
  EXPECT_EQ(batch[1].origin, "surrogate_lm: another minimum");
}

TEST(SurrogateLmTest, ARegionThatFailsIsLeft) {
  const auto response = [](const Eigen::VectorXd& x) {
    if (x[0] > 0.55) return Eigen::VectorXd();
    return Eigen::VectorXd(Eigen::VectorXd::Constant(1, x[0] + 0.2 * std::sin(6 * x[1])));
  };
  // Out of reach: the model's minimum stays in the region.
  const auto optimizer = MakeSurrogateLm({}, UnitBox(2), JointTargets({0.9}, 0.01), 3);
  const std::vector<Observation> history = RunSerially(optimizer.get(), response, 30);
  std::vector<Eigen::VectorXd> points;
  int late_failures = 0;
  for (std::size_t i = 0; i < history.size(); ++i) {
    points.push_back(history[i].point);
    if (i >= 15 && history[i].failed) ++late_failures;
  }
  EXPECT_LE(late_failures, 11);
  EXPECT_GT(SmallestDistance(points), 1e-6);
}

TEST(SurrogateLmTest, EverythingFailsAndItStillExplores) {
  const auto optimizer = MakeSurrogateLm({}, UnitBox(2), kTwo, 3);
  const std::vector<Observation> history = RunSerially(
      optimizer.get(), [](const Eigen::VectorXd&) { return Eigen::VectorXd(); }, 15);
  ASSERT_EQ(history.size(), 15);
  EXPECT_THAT(optimizer->status().message, HasSubstr("no response has two values"));
}

TEST(SurrogateLmTest, ResponsesMayBeMissing) {
  const auto response = [](const Eigen::VectorXd& x) {
    Eigen::VectorXd values = TwoResponses(x);
    if (x[1] > 0.8) values[0] = kNaN;
    return values;
  };
  const auto optimizer = MakeSurrogateLm({}, UnitBox(2), kTwo, 1);
  EXPECT_LT(BestDistance(RunSerially(optimizer.get(), response, 14)), 0.01);
}

TEST(SurrogateLmTest, SaysWhereItIsFlatOrAtABound) {
  const auto message = [](const Objectives& objectives, const Responses& responses) {
    const auto optimizer = MakeSurrogateLm({}, UnitBox(2), objectives, 1);
    RunSerially(optimizer.get(), responses, 14);
    return optimizer->status().message;
  };
  const auto identity = [](const Eigen::VectorXd& x) { return Eigen::VectorXd(x); };
  EXPECT_THAT(message(JointTargets({-0.5, 0.5}, 0.01), identity),
              HasSubstr("x0 is at its lower bound"));
  const auto sum = [](const Eigen::VectorXd& x) {
    return Eigen::VectorXd(Eigen::VectorXd::Constant(1, x.sum()));
  };
  EXPECT_THAT(message(JointTargets({1}, 0.01), sum), HasSubstr("flat valley: direction ("));
}

TEST(SurrogateLmTest, OptionsAndRefusals) {
  SurrogateLmOptions options;
  ReadYaml("{kernel: rbf, initial_design: {name: sobol, points: 7}}", "study.yaml",
           [&](Archive& archive) { options.Serialize(archive, UnitBox(2)); });
  EXPECT_EQ(options.kernel, Kernel::rbf);
  EXPECT_EQ(options.initial_design.points, 7);
  const auto optimizer = MakeSurrogateLm({}, UnitBox(2), kTwo, 1);
  EXPECT_EQ(optimizer->ExplainUnsupported(UnitBox(2), kTwo), "");
  Objectives other = kTwo;
  other.targets[0].minimise = true;
  EXPECT_THAT(optimizer->ExplainUnsupported(UnitBox(2), other), HasSubstr("surrogate_lm"));
  EXPECT_TRUE(optimizer->capabilities().failures);
  const Candidate candidate = optimizer->Ask(1)[0];
  const Observation wrong = Succeeded(candidate, Eigen::VectorXd::Zero(1));
  EXPECT_THROW(optimizer->Tell(std::span(&wrong, 1)), std::invalid_argument);
}

}  // namespace
}  // namespace powdercal

#include "optimizers/least_squares/least_squares.h"

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

LeastSquaresOptions From(const std::vector<double>& start) {
  return {.initial_design = {.name = "list", .list = {start}}, .starts = 1};
}

struct Outcome {
  std::vector<Observation> history;
  Eigen::VectorXd best;
  std::string message;
  Status::Phase phase;
};

// A vector of the wrong size is a failure; the answer is the point of the lowest chi².
Outcome Minimise(const LeastSquaresOptions& options, const Objectives& objectives, int dimension,
                 const Responses& responses, int evaluations = 200) {
  const auto optimizer = MakeLeastSquares(options, UnitBox(dimension), objectives, 1);
  Outcome outcome{.history = RunSerially(optimizer.get(), responses, evaluations), .best = {}};
  double lowest = std::numeric_limits<double>::infinity();
  for (const Observation& observation : outcome.history) {
    if (observation.failed || !observation.responses.allFinite()) continue;
    const double chi2 = ChiSquared(objectives, observation.responses, {});
    if (chi2 < lowest) {
      lowest = chi2;
      outcome.best = observation.point;
    }
  }
  outcome.message = optimizer->status().message;
  outcome.phase = optimizer->status().phase;
  return outcome;
}

// Lowest sum of squares of 50 evaluations, the initial 10 included.
double EnvironmentalSquares(std::uint64_t seed, double noise) {
  const TestProblem problem = MakeTestProblem("environmental", "");
  RandomStream random(1000 + seed);
  std::vector<Eigen::VectorXd> truths;
  const auto responses = [&](const Eigen::VectorXd& point) {
    Eigen::VectorXd values = problem.respond(problem.space.FromUnit(point));
    truths.push_back(values);
    for (double& value : values) value += noise * random.Normal();
    return values;
  };
  RunSerially(MakeLeastSquares({}, problem.space, problem.objectives, seed).get(), responses, 50);
  return problem.measure(truths);
}

TEST(LeastSquaresTest, EnvironmentalModelWithinFiftyEvaluations) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    EXPECT_LT(EnvironmentalSquares(seed, 0), 1e-10) << seed;
  }
}

// Nobody tells of the noise; differences of 1e-6 would then leave it where it started (0.3).
TEST(LeastSquaresTest, NoiseIsFoundAndDoesNotStopIt) {
  std::vector<double> squares;
  for (std::uint64_t seed = 0; seed < 7; ++seed) {
    squares.push_back(EnvironmentalSquares(seed, 0.05));
  }
  std::sort(squares.begin(), squares.end());
  EXPECT_LT(squares[3], 0.05);
}

TEST(LeastSquaresTest, DesignThenAStencilAsOneBatchThenOneStep) {
  const auto optimizer = MakeLeastSquares({.initial_design = {.name = "sobol", .points = 6}},
                                          UnitBox(3), JointTargets({0.2, 0.3, 0.4}, 0.01), 1);
  const auto tell = [&](const Candidate& candidate) {
    const Observation told = Succeeded(candidate, candidate.point.cwiseSqrt());
    optimizer->Tell(std::span(&told, 1));
  };
  EXPECT_EQ(optimizer->status().phase, Status::Phase::ready);
  std::vector<Candidate> batch = optimizer->Ask(4);
  EXPECT_EQ(batch.size(), 4);
  for (const Candidate& candidate : optimizer->Ask(10)) batch.push_back(candidate);
  ASSERT_EQ(batch.size(), 6);
  EXPECT_EQ(optimizer->status().phase, Status::Phase::waiting);
  EXPECT_TRUE(optimizer->Ask(10).empty());
  for (const Candidate& candidate : batch) tell(candidate);
  const std::vector<Candidate> stencil = optimizer->Ask(10);
  ASSERT_EQ(stencil.size(), 3);
  EXPECT_EQ(stencil[1].id, 7);
  EXPECT_EQ(stencil[1].origin, "stencil of x1");
  for (const Candidate& candidate : stencil) tell(candidate);
  EXPECT_EQ(optimizer->Ask(10).size(), 1);
}

TEST(LeastSquaresTest, StencilsAreReflectedAtBounds) {
  const Outcome outcome = Minimise(From({1, 0}), kTwo, 2, TwoResponses);
  for (const Observation& observation : outcome.history) {
    EXPECT_GE(observation.point.minCoeff(), 0);
    EXPECT_LE(observation.point.maxCoeff(), 1);
  }
  EXPECT_LT(outcome.history[1].point[0], 1);
  EXPECT_GT(outcome.history[2].point[1], 0);
  EXPECT_LT((outcome.best - kTwoAnswer).norm(), 1e-6);
  EXPECT_EQ(outcome.phase, Status::Phase::finished);
  EXPECT_THAT(outcome.message, HasSubstr("converged"));
}

TEST(LeastSquaresTest, OrderOfTellingMakesNoDifferenceAndReplayGoesOnAlike) {
  const auto undisturbed = MakeLeastSquares({}, UnitBox(2), kTwo, 3);
  const std::vector<Observation> history = RunSerially(undisturbed.get(), TwoResponses, 12);
  const auto batched = MakeLeastSquares({}, UnitBox(2), kTwo, 3);
  const auto replayed = MakeLeastSquares({}, UnitBox(2), kTwo, 3);
  std::size_t next = 0;
  while (next < history.size()) {
    std::vector<Observation> told;
    for (const Candidate& candidate : batched->Ask(100)) {
      if (next == history.size()) break;
      EXPECT_EQ(candidate.point, history[next].point) << next;
      told.push_back(history[next++]);
    }
    std::reverse(told.begin(), told.end());
    batched->Tell(told);
  }
  for (const Observation& observation : history) {
    const std::vector<Candidate> again = replayed->Ask(1);
    ASSERT_EQ(again.size(), 1);
    EXPECT_EQ(again[0].id, observation.id);
    EXPECT_EQ(again[0].point, observation.point);
    replayed->Tell(std::span(&observation, 1));
  }
  EXPECT_EQ(replayed->Ask(1)[0].point, undisturbed->Ask(1)[0].point);
}

TEST(LeastSquaresTest, AFailedStepIsRejected) {
  // The first steps from the far corner overshoot into the region that fails.
  const auto responses = [](const Eigen::VectorXd& x) {
    if (x[0] < 0.25) return Eigen::VectorXd();
    return Eigen::VectorXd(Eigen::Vector2d(std::log(x[0]), x[1]));
  };
  const Objectives objectives = JointTargets({std::log(0.3), 0.6}, 0.01);
  const Outcome outcome = Minimise(From({0.95, 0.1}), objectives, 2, responses);
  EXPECT_TRUE(std::any_of(outcome.history.begin(), outcome.history.end(),
                          [](const Observation& observation) { return observation.failed; }));
  EXPECT_LT((outcome.best - kTwoAnswer).norm(), 1e-6);
}

TEST(LeastSquaresTest, AFailedStencilPointIsTriedOnTheOtherSide) {
  const auto responses = [](const Eigen::VectorXd& x) {
    return x[0] > 0.5 ? Eigen::VectorXd() : TwoResponses(x);
  };
  const Outcome outcome = Minimise(From({0.5, 0.5}), kTwo, 2, responses);
  EXPECT_TRUE(outcome.history[1].failed);
  EXPECT_LT(outcome.history[3].point[0], 0.5);
  EXPECT_EQ(outcome.history[3].point[1], 0.5);
  EXPECT_LT((outcome.best - kTwoAnswer).norm(), 1e-6);
}

TEST(LeastSquaresTest, AColumnWithoutValuesIsDroppedAndReported) {
  const auto responses = [](const Eigen::VectorXd& x) {
    return x[0] != 0.5 ? Eigen::VectorXd() : TwoResponses(x);
  };
  // With x0 = 0.5 chi² is lowest where 2 (0.5 x1² + 0.02) x1 + 2 (x1 − 0.66) = 0.
  const Outcome outcome = Minimise(From({0.5, 0.9}), kTwo, 2, responses);
  EXPECT_EQ(outcome.best[0], 0.5);
  const double x1 = outcome.best[1];
  EXPECT_NEAR((0.5 * x1 * x1 + 0.02) * x1 + x1 - 0.66, 0, 1e-4);
  EXPECT_THAT(outcome.message, HasSubstr("evaluations on both sides in x0 have failed"));
}

TEST(LeastSquaresTest, AResponseThatIsMissingAtTheStartDoesNotCount) {
  const auto responses = [](const Eigen::VectorXd& x) {
    const Eigen::VectorXd two = TwoResponses(x);
    return Eigen::VectorXd(Eigen::Vector3d(two[0], kNaN, two[1]));
  };
  const Outcome outcome =
      Minimise(From({0.8, 0.8}), JointTargets({0.48, 7, 0.51}, 0.01), 2, responses);
  EXPECT_LT((outcome.history.back().point - kTwoAnswer).norm(), 0.01);
  EXPECT_THAT(outcome.message, HasSubstr("response1 was missing in"));
}

TEST(LeastSquaresTest, AStartWithAllResponsesComesFirst) {
  const auto responses = [](const Eigen::VectorXd& x) {
    Eigen::VectorXd two = TwoResponses(x);
    if (x[0] < 0.1) two[1] = kNaN;
    return two;
  };
  LeastSquaresOptions options = From({0.05, 0.6});
  options.initial_design.list.push_back({0.9, 0.1});
  const Outcome outcome = Minimise(options, kTwo, 2, responses, 5);
  EXPECT_GT(outcome.history[2].point[0], 0.8);  // the stencil
}

TEST(LeastSquaresTest, ReportsADeadParameter) {
  const auto responses = [](const Eigen::VectorXd& x) { return TwoResponses(x.head(2)); };
  const Outcome outcome = Minimise(From({0.5, 0.5, 0.5}), kTwo, 3, responses);
  EXPECT_THAT(outcome.message, HasSubstr("dead parameter: no response changes with x2"));
  EXPECT_THAT(outcome.message, testing::Not(HasSubstr("converged")));
}

TEST(LeastSquaresTest, ReportsAFlatValleyWithItsDirection) {
  const auto responses = [](const Eigen::VectorXd& x) {
    const double sum = 3 * x[0] + 4 * x[1];
    return Eigen::VectorXd(Eigen::Vector2d(sum, std::exp(0.1 * sum)));
  };
  const Objectives objectives = JointTargets({3, std::exp(0.3)}, 0.01);
  const Outcome outcome = Minimise(From({0.6, 0.6}), objectives, 2, responses);
  EXPECT_THAT(outcome.message,
              HasSubstr("flat valley: direction (x0:+0.80, x1:-0.60) leaves chi² unchanged"));
}

TEST(LeastSquaresTest, ReportsParametersAtTheirBounds) {
  const Objectives objectives = JointTargets({-0.5, 1.4}, 0.01);
  const auto responses = [](const Eigen::VectorXd& x) { return Eigen::VectorXd(x); };
  const Outcome outcome = Minimise(From({0.4, 0.4}), objectives, 2, responses);
  EXPECT_EQ(outcome.best, Eigen::VectorXd(Eigen::Vector2d(0, 1)));
  EXPECT_THAT(outcome.message, HasSubstr("x0 is at its lower bound; x1 is at its upper bound"));
}

TEST(LeastSquaresTest, GoesOnAlongABound) {
  // Residuals x0 + 0.3 and x0 + x1² − 0.25: with x0 = 0 held the best x1 is 0.5.
  const auto responses = [](const Eigen::VectorXd& x) {
    return Eigen::VectorXd(Eigen::Vector2d(x[0], x[0] + x[1] * x[1]));
  };
  const Outcome outcome =
      Minimise(From({0.9, 0.9}), JointTargets({-0.3, 0.25}, 0.01), 2, responses);
  EXPECT_EQ(outcome.best[0], 0);
  EXPECT_NEAR(outcome.best[1], 0.5, 1e-5);
}

TEST(LeastSquaresTest, StepsFollowTheNoiseThatItIsToldOf) {
  const auto step = [](double variance) {
    const auto optimizer =
        MakeLeastSquares({.initial_design = {.name = "sobol", .points = 5}}, UnitBox(2), kTwo, 1);
    std::vector<Observation> told;
    for (const Candidate& candidate : optimizer->Ask(5)) {
      told.push_back(Succeeded(candidate, TwoResponses(candidate.point)));
      told.back().variances.setConstant(variance);
    }
    optimizer->Tell(told);
    const std::vector<Candidate> stencil = optimizer->Ask(2);
    return (stencil[0].point - stencil[1].point).norm() / std::sqrt(2);
  };
  EXPECT_LT(step(0), 1e-3);
  // h ∝ σ^½ of all the noise.
  EXPECT_NEAR(step(1e-6) / step(1e-8), std::sqrt(10), 1e-3);
  EXPECT_GT(step(1e-4), 0.01);
  EXPECT_LE(step(1), 0.2 + 1e-12);
}

TEST(LeastSquaresTest, AStepOfTheUsersIsKept) {
  LeastSquaresOptions options = From({0.5, 0.5});
  options.step = 0.01;
  const Outcome outcome = Minimise(options, kTwo, 2, TwoResponses, 4);
  EXPECT_NEAR(outcome.history[1].point[0], 0.51, 1e-12);
}

TEST(LeastSquaresTest, SaysThatResponsesScatter) {
  RandomStream random(4);
  const auto responses = [&](const Eigen::VectorXd& x) {
    return Eigen::VectorXd(TwoResponses(x) +
                           0.01 * Eigen::Vector2d(random.Normal(), random.Normal()));
  };
  const Outcome outcome = Minimise(From({0.8, 0.2}), kTwo, 2, responses);
  EXPECT_THAT(outcome.message, HasSubstr("the responses scatter or jump"));
  EXPECT_LT((outcome.best - kTwoAnswer).norm(), 0.1);
}

TEST(LeastSquaresTest, TheNextStartFollowsWhenOneHasEnded) {
  // Two minima in x0, the lower at 0.8; the best start leads to the other one.
  const auto responses = [](const Eigen::VectorXd& x) {
    const double u = x[0] - 0.2;
    return Eigen::VectorXd(Eigen::Vector2d(u * (x[0] - 0.8) + 0.1, 0.1 * (0.8 - x[0])));
  };
  const Objectives objectives = JointTargets({0.1, 0}, 0.01);
  LeastSquaresOptions options = From({0.25});
  options.initial_design.list.push_back({0.5});
  options.starts = 5;
  const Outcome outcome = Minimise(options, objectives, 1, responses);
  EXPECT_NEAR(outcome.best[0], 0.8, 1e-6);
  EXPECT_THAT(outcome.message, HasSubstr("best of 2 searches"));
  options.starts = 1;
  EXPECT_GT(std::abs(Minimise(options, objectives, 1, responses).best[0] - 0.8), 0.1);
}

TEST(LeastSquaresTest, EverythingFailsAndItSaysSo) {
  const Outcome outcome =
      Minimise({}, kTwo, 2, [](const Eigen::VectorXd&) { return Eigen::VectorXd(); });
  EXPECT_EQ(outcome.phase, Status::Phase::finished);
  EXPECT_EQ(outcome.history.size(), 6);
  EXPECT_THAT(outcome.message, HasSubstr("all 6 evaluations have failed"));
}

TEST(LeastSquaresTest, WhatIsKnownIsNotAskedAgain) {
  const auto optimizer = MakeLeastSquares(From({0.5, 0.5}), UnitBox(2), kTwo, 1);
  const Eigen::Vector2d point(0.5, 0.5);
  const Observation earlier{
      .id = -1, .point = point, .responses = TwoResponses(point), .variances = {}};
  optimizer->Tell(std::span(&earlier, 1));
  const std::vector<Candidate> first = optimizer->Ask(5);
  ASSERT_EQ(first.size(), 2);
  EXPECT_EQ(first[0].id, 0);
  EXPECT_EQ(first[0].origin, "stencil of x0");
}

TEST(LeastSquaresTest, CanBeDestroyedAtAnyMoment) {
  for (int evaluations = 0; evaluations < 30; ++evaluations) {
    const auto optimizer = MakeLeastSquares({}, UnitBox(2), kTwo, 2);
    RunSerially(optimizer.get(), TwoResponses, evaluations);
    optimizer->Ask(1);
  }
}

TEST(LeastSquaresTest, TellingAgainReplacesAndWakesNobody) {
  const auto optimizer = MakeLeastSquares({}, UnitBox(2), kTwo, 2);
  const std::vector<Observation> history = RunSerially(optimizer.get(), TwoResponses, 8);
  optimizer->Ask(100);
  optimizer->Tell(std::span(history).subspan(2, 3));
  EXPECT_EQ(optimizer->status().phase, Status::Phase::waiting);
  Observation wrong = history[0];
  wrong.responses = Eigen::VectorXd::Zero(3);
  EXPECT_THROW(optimizer->Tell(std::span(&wrong, 1)), std::invalid_argument);
}

TEST(LeastSquaresTest, RefusesWhatItCannotTreat) {
  const auto reason = [](const SearchSpace& space, const Objectives& objectives) {
    return MakeLeastSquares({}, space, objectives, 1)->ExplainUnsupported(space, objectives);
  };
  EXPECT_EQ(reason(UnitBox(2), kTwo), "");
  EXPECT_THAT(reason(SearchSpace{}, kTwo), HasSubstr("no parameter"));
  EXPECT_THAT(reason(UnitBox(2), Objectives{}), HasSubstr("no observed response"));
  SearchSpace discrete = UnitBox(2);
  discrete.parameters[1].kind = Parameter::Kind::integer;
  EXPECT_THAT(reason(discrete, kTwo), testing::AllOf(HasSubstr("'x1'"), HasSubstr("use random")));
  Objectives other = kTwo;
  other.targets[1].minimise = true;
  EXPECT_THAT(reason(UnitBox(2), other), HasSubstr("as low as possible"));
  other = kTwo;
  other.kind = Objectives::Kind::pareto;
  EXPECT_EQ(reason(UnitBox(2), other), "");  // all of one objective
  other.targets[1].objective = 1;
  EXPECT_THAT(reason(UnitBox(2), other),
              testing::AllOf(HasSubstr("several objectives"), HasSubstr("use bayesian")));
}

TEST(LeastSquaresTest, OptionsAreReadAndWritten) {
  const auto read = [](const std::string& text) {
    LeastSquaresOptions options;
    ReadYaml(text, "study.yaml",
             [&](Archive& archive) { options.Serialize(archive, HastelloySpace()); });
    return options;
  };
  LeastSquaresOptions options =
      read("{starts: 3, tolerance: 1e-4, step: 0.05, precision: 1e-6, initial_design: grid}");
  const LeastSquaresOptions back =
      read(WriteYaml([&](Archive& archive) { options.Serialize(archive, HastelloySpace()); }));
  EXPECT_EQ(back.starts, 3);
  EXPECT_EQ(back.tolerance, 1e-4);
  EXPECT_EQ(back.precision, 1e-6);
  EXPECT_EQ(back.step, 0.05);
  EXPECT_EQ(back.initial_design.name, "grid");
  EXPECT_FALSE(read("{}").step.has_value());
  EXPECT_THROW(read("starts: 0"), InputError);
  EXPECT_THROW(read("step: 0.7"), InputError);
  EXPECT_THROW(read("tolerence: 1e-3"), InputError);
}

}  // namespace
}  // namespace powdercal

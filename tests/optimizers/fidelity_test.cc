#include "optimizers/bayesian/fidelity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/statistics.h"
#include "optimizers/bayesian/bayesian.h"
#include "optimizers/test_problems.h"
#include "tests/optimizers/problems.h"

namespace powdercal {
namespace {

using testing::HasSubstr;

// A process of one parameter and the fidelity; `scale`: lengthscale of the fidelity.
GaussianProcess ProcessWith(double scale, const Eigen::MatrixXd& points) {
  GaussianProcess::Options options;
  options.standardise = false;
  options.hyperparameters = Hyperparameters{
      .lengthscales = Eigen::Vector2d(0.2, scale), .signal_variance = 1, .noise_variance = 1e-6};
  GaussianProcess process(options);
  process.Fit(points, Eigen::VectorXd::Zero(points.rows()), {});
  return process;
}

const std::vector<FidelityLevel> kLevels = {{0.5, 0.2}, {1, 1}};

double Choose(double scale, const Eigen::MatrixXd& points, double x,
              const Eigen::MatrixXd& taken = Eigen::MatrixXd(0, 2)) {
  return ChooseFidelity({ProcessWith(scale, points)}, Eigen::ArrayXd::Ones(1),
                        Eigen::ArrayXd::Zero(1), Eigen::VectorXd::Constant(1, x), kLevels, taken);
}

TEST(FidelityTest, CheapEvaluationsPayWhereTheyTellOfTheTarget) {
  const Eigen::MatrixXd far = Eigen::RowVector2d(0, 1);
  EXPECT_EQ(Choose(10, far, 0.8), 0.5);  // as good as the target, a fifth of the cost
  EXPECT_EQ(Choose(0.1, far, 0.8), 1);   // it tells nothing
  // What a cheap evaluation nearby can tell is known already.
  Eigen::MatrixXd cheap(2, 2);
  cheap << 0, 1, 0.8, 0.5;
  EXPECT_EQ(Choose(1, far, 0.8), 0.5);
  EXPECT_EQ(Choose(1, cheap, 0.8), 1);
}

TEST(FidelityTest, NothingIsEvaluatedTwice) {
  const Eigen::MatrixXd far = Eigen::RowVector2d(0, 1);
  EXPECT_EQ(Choose(10, far, 0.8, Eigen::RowVector2d(0.8, 0.5)), 1);
  EXPECT_EQ(Choose(10, far, 0.8, Eigen::RowVector2d(0.8, 1)), 0.5);
}

// Without any noise, at x far from all data: c²/v is the squared prior correlation over s, which
// for a Matérn 5/2 at distance r = 0.5/scale is [(1 + √5 r + 5r²/3) exp(−√5 r)]².
TEST(FidelityTest, TheShareOfVarianceIsWeighedAgainstTheCost) {
  const double r = 0.5;  // scale 1
  const double root = std::sqrt(5.0) * r;
  const double share = std::pow((1 + root + root * root / 3) * std::exp(-root), 2);
  const GaussianProcess process = ProcessWith(1, Eigen::RowVector2d(100, 1));
  const auto choose = [&](double cost) {
    const std::vector<FidelityLevel> levels = {{0.5, cost}, {1, 1}};
    return ChooseFidelity({process}, Eigen::ArrayXd::Ones(1), Eigen::ArrayXd::Zero(1),
                          Eigen::VectorXd::Constant(1, 0.5), levels, Eigen::MatrixXd(0, 2));
  };
  EXPECT_EQ(choose(share * 0.99), 0.5);
  EXPECT_EQ(choose(share * 1.01), 1);
}

TEST(FidelityTest, BadLevelsAreExplained) {
  const auto explain = [](const std::vector<FidelityLevel>& levels) {
    return ExplainBadFidelities(levels);
  };
  EXPECT_EQ(explain({}), "");
  EXPECT_EQ(explain(kLevels), "");
  EXPECT_THAT(explain({{0.5, 1}}), HasSubstr("target"));
  EXPECT_THAT(explain({{0, 1}, {1, 1}}), HasSubstr("(0, 1]"));
  EXPECT_THAT(explain({{1.5, 1}, {1, 1}}), HasSubstr("(0, 1]"));
  EXPECT_THAT(explain({{0.5, 0}, {1, 1}}), HasSubstr("cost"));
  EXPECT_THAT(explain({{1, 1}, {1, 2}}), HasSubstr("twice"));
}

TEST(BayesianFidelityTest, SaysWhatItCannotTreat) {
  BayesianOptions options{.fidelities = kLevels};
  const auto explain = [&](const Objectives& objectives) {
    return MakeBayesian(options, UnitBox(2), objectives, 1)
        ->ExplainUnsupported(UnitBox(2), objectives);
  };
  EXPECT_EQ(explain(JointTargets({1, 2}, 0.1)), "");
  Objectives several = JointTargets({1, 2}, 0.1);
  several.kind = Objectives::Kind::pareto;
  several.targets[1].objective = 1;
  EXPECT_THAT(explain(several), HasSubstr("one objective"));
  options.acquisition = BayesianOptions::Acquisition::qlog_nei;
  EXPECT_THAT(explain(JointTargets({1}, 0.1)), HasSubstr("composite_log_ei"));
  options.fidelities = {{0.5, 1}};
  EXPECT_THAT(explain(JointTargets({1}, 0.1)), HasSubstr("target"));
}

struct Search {
  std::vector<Candidate> asked;
  std::vector<Eigen::VectorXd> at_target;  // responses; empty below it
  double regret = 0;
};

// Until so much is spent.
Search SearchUntil(const TestProblem& problem, bool several, double budget, std::uint64_t seed) {
  BayesianOptions options{.initial_design = problem.initial_design};
  if (several) options.fidelities = problem.fidelities;
  const auto optimizer = MakeBayesian(options, problem.space, problem.objectives, seed);
  Search search;
  for (double spent = 0; spent < budget - 1e-9;) {
    const Candidate candidate = optimizer->Ask(1).at(0);
    const Observation observation = Observe(problem, candidate, seed);
    optimizer->Tell({&observation, 1});
    spent += CostOf(problem, candidate);
    search.asked.push_back(candidate);
    search.at_target.push_back(candidate.fidelity < 1 ? Eigen::VectorXd() : observation.responses);
  }
  search.regret = problem.measure(search.at_target);
  return search;
}

TEST(BayesianFidelityTest, BeginsCheaplyThenLearnsHowTheTargetDiffers) {
  const TestProblem problem = MakeTestProblem("branin_multi_fidelity", "");
  const Search search = SearchUntil(problem, true, 6, 1);
  ASSERT_GT(search.asked.size(), 8);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(search.asked[i].fidelity, 0.5) << i;
  for (std::size_t i = 5; i < 7; ++i) EXPECT_EQ(search.asked[i].fidelity, 1) << i;
  for (const Candidate& candidate : search.asked) {
    const auto known = [&](const FidelityLevel& l) { return l.fidelity == candidate.fidelity; };
    EXPECT_TRUE(std::any_of(problem.fidelities.begin(), problem.fidelities.end(), known));
    EXPECT_EQ(candidate.point.size(), 2);
  }
}

TEST(BayesianFidelityTest, SameCallsGiveSamePointsAndFidelities) {
  const TestProblem problem = MakeTestProblem("branin_multi_fidelity", "");
  const Search first = SearchUntil(problem, true, 5, 3);
  const Search second = SearchUntil(problem, true, 5, 3);
  ASSERT_EQ(first.asked.size(), second.asked.size());
  for (std::size_t i = 0; i < first.asked.size(); ++i) {
    EXPECT_EQ(first.asked[i].point, second.asked[i].point);
    EXPECT_EQ(first.asked[i].fidelity, second.asked[i].fidelity);
  }
}

TEST(BayesianFidelityTest, ReachesTheSameRegretForLess) {
  const TestProblem problem = MakeTestProblem("branin_multi_fidelity", "");
  std::vector<double> several;
  std::vector<double> target;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    several.push_back(SearchUntil(problem, true, 14, seed).regret);
    target.push_back(SearchUntil(problem, false, 20, seed).regret);
  }
  EXPECT_LE(Median(several), Median(target));
}

// Pending points at a low fidelity do not count as reached, and are not asked for again.
TEST(BayesianFidelityTest, SeveralPointsUnderWayAreDistinct) {
  const TestProblem problem = MakeTestProblem("branin_multi_fidelity", "");
  BayesianOptions options{.initial_design = problem.initial_design,
                          .fidelities = problem.fidelities};
  const auto optimizer = MakeBayesian(options, problem.space, problem.objectives, 2);
  std::vector<Observation> told;
  for (const Candidate& candidate : optimizer->Ask(5)) {
    told.push_back(Observe(problem, candidate, 2));
  }
  optimizer->Tell(told);
  const std::vector<Candidate> asked = optimizer->Ask(6);
  ASSERT_EQ(asked.size(), 6);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_TRUE(asked[i].fidelity != asked[j].fidelity ||
                  (asked[i].point - asked[j].point).norm() > 1e-6);
    }
  }
}

}  // namespace
}  // namespace powdercal

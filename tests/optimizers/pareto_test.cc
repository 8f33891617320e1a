#include "optimizers/pareto.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/random.h"
#include "optimizers/bayesian/bayesian.h"
#include "optimizers/bayesian/scalarisation.h"
#include "tests/optimizers/problems.h"

namespace powdercal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(NonDominatedTest, KeepsWhatNothingBeats) {
  Eigen::MatrixXd points(6, 2);
  points << 3, 1,  //
      1, 3,        //
      2, 2,        //
      3, 3,        // beaten by (2, 2)
      2, 2,        // a tie
      1, 4;        // beaten by (1, 3), which is equal in one objective
  EXPECT_THAT(NonDominated(points), ElementsAre(0, 1, 2, 4));
}

TEST(NonDominatedTest, LeavesOutWhatIsNotFinite) {
  Eigen::MatrixXd points(4, 2);
  points << 0, kNaN,                               //
      1, 1,                                        //
      0, std::numeric_limits<double>::infinity(),  //
      2, 0;
  EXPECT_THAT(NonDominated(points), ElementsAre(1, 3));
  EXPECT_THAT(NonDominated(Eigen::MatrixXd(0, 2)), IsEmpty());
  EXPECT_THAT(NonDominated(Eigen::MatrixXd::Constant(2, 3, kNaN)), IsEmpty());
}

TEST(ScalarisationTest, CornersComeFirstThenTheSimplex) {
  const Eigen::MatrixXd nothing(0, 3);
  for (int turn = 0; turn < 9; ++turn) {
    const Eigen::ArrayXd shares =
        MakeScalarisation(nothing, turn, RandomStream(1).Split(turn)).shares;
    EXPECT_NEAR(shares.sum(), 1, 1e-12);
    EXPECT_GT(shares.minCoeff(), 0.003);
    if (turn < 3) {
      EXPECT_GT(shares[turn], 0.99);
    } else {
      EXPECT_LT(shares.maxCoeff(), 0.99);
    }
  }
}

TEST(ScalarisationTest, SharesAreUniformOverTheSimplex) {
  // The marginal of a share of three has the density 2(1 − λ): mean 1/3, variance 1/18.
  double sum = 0;
  double squares = 0;
  constexpr int kCount = 4000;
  for (int i = 0; i < kCount; ++i) {
    const double share =
        MakeScalarisation(Eigen::MatrixXd(0, 3), 5, RandomStream(2).Split(i)).shares[1];
    sum += share;
    squares += share * share;
  }
  const double mean = sum / kCount;
  EXPECT_NEAR(mean, 1.0 / 3, 0.015);
  EXPECT_NEAR(squares / kCount - mean * mean, 1.0 / 18, 0.005);
}

TEST(ScalarisationTest, ObjectivesAreWeighedByTheirRangeAlongTheFront) {
  Eigen::MatrixXd chi2(4, 2);
  chi2 << 2, 400,  //
      12, 0,       //
      kNaN, 0,     //
      900, 900;    // dominated: its height is no measure
  const Scalarisation scalarisation = MakeScalarisation(chi2, 2, RandomStream(3));
  EXPECT_NEAR(scalarisation.weights[0] / scalarisation.weights[1],
              scalarisation.shares[0] / 10 / (scalarisation.shares[1] / 400), 1e-9);
  EXPECT_EQ(scalarisation.weights.maxCoeff(), 1);
  // Along a front shorter than one unit of chi² no objective is blown up.
  chi2 << 1, 1.1, 1.1, 1, 1, 1.1, 1.1, 1;
  const Scalarisation flat = MakeScalarisation(chi2, 0, RandomStream(3));
  EXPECT_NEAR(flat.weights[1], flat.shares[1] / flat.shares[0], 1e-12);
}

// Two experiments see the same two quantities y(x) and want different ones, each with an equal
// standard deviation in every direction of y: the Pareto set is the segment between the wishes, and
// on the front √chi²_0 sd_0 + √chi²_1 sd_1 = |difference of the wishes|.
class TwoExperiments {
 public:
  static constexpr double kFirstSd = 0.1;
  static constexpr double kSecondSd = 0.02;

  TwoExperiments() {
    objectives_.kind = Objectives::Kind::pareto;
    const Eigen::Vector4d values = Responses(first_, second_);
    const double sds[] = {kFirstSd, kFirstSd, std::numbers::sqrt2 * kSecondSd,
                          std::numbers::sqrt2 * kSecondSd};
    for (int t = 0; t < 4; ++t) {
      objectives_.targets.push_back({.response = fmt::format("test{}.response{}", t / 2, t % 2),
                                     .unit = "1",
                                     .value = values[t],
                                     .sd = sds[t],
                                     .objective = t / 2});
    }
  }

  const Objectives& objectives() const { return objectives_; }

  static Eigen::VectorXd Evaluate(const Eigen::VectorXd& x) {
    const Eigen::Vector2d y = Quantities(x);
    return Responses(y, y);
  }

  /// Largest distance, in y, from a point of the Pareto set to the nearest evaluation.
  double LargestGap(const std::vector<Observation>& history) const {
    double largest = 0;
    for (int i = 0; i <= 20; ++i) {
      const Eigen::Vector2d wanted = first_ + i / 20.0 * (second_ - first_);
      double nearest = 10;
      for (const Observation& observation : history) {
        nearest = std::min(nearest, (Quantities(observation.point) - wanted).norm());
      }
      largest = std::max(largest, nearest);
    }
    return largest;
  }

  double LowestChi2(const std::vector<Observation>& history, int objective) const {
    double lowest = 1e300;
    for (const Observation& observation : history) {
      lowest =
          std::min(lowest, ChiSquared(objectives_, Evaluate(observation.point), {}, objective));
    }
    return lowest;
  }

 private:
  static Eigen::Vector2d Quantities(const Eigen::VectorXd& x) {
    return {x[0] + 0.3 * x[1] * x[1], x[1] - 0.2 * std::sin(3 * x[0])};
  }
  static Eigen::Vector4d Responses(const Eigen::Vector2d& y, const Eigen::Vector2d& z) {
    return {y[0], y[1], z[0] + z[1], z[0] - z[1]};
  }

  Eigen::Vector2d first_ = {0.3, 0.1};
  Eigen::Vector2d second_ = {0.8, 0.5};
  Objectives objectives_;
};

double MedianGap(const TwoExperiments& problem, const std::string& optimizer) {
  std::vector<double> gaps;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const auto instance =
        MakeOptimizerFactory(optimizer)->Make(UnitBox(2), problem.objectives(), seed);
    gaps.push_back(problem.LargestGap(RunSerially(instance.get(), TwoExperiments::Evaluate, 30)));
  }
  std::sort(gaps.begin(), gaps.end());
  return gaps[1];
}

TEST(BayesianParetoTest, CoversTheFrontInThirtyEvaluations) {
  const TwoExperiments problem;
  const double searched = MedianGap(problem, "bayesian");
  EXPECT_LT(searched, 0.08);
  EXPECT_LT(searched, MedianGap(problem, "random") / 2);
}

TEST(BayesianParetoTest, ReachesTheEndsOfTheFront) {
  const TwoExperiments problem;
  const auto optimizer = MakeBayesian({}, UnitBox(2), problem.objectives(), 1);
  const std::vector<Observation> history =
      RunSerially(optimizer.get(), TwoExperiments::Evaluate, 20);
  EXPECT_LT(problem.LowestChi2(history, 0), 0.1);
  EXPECT_LT(problem.LowestChi2(history, 1), 0.1);
}

TEST(BayesianParetoTest, SaysWhatItWeighed) {
  const TwoExperiments problem;
  const auto optimizer = MakeBayesian({}, UnitBox(2), problem.objectives(), 1);
  EXPECT_TRUE(optimizer->capabilities().pareto);
  EXPECT_EQ(optimizer->ExplainUnsupported(UnitBox(2), problem.objectives()), "");
  RunSerially(optimizer.get(), TwoExperiments::Evaluate, 6);
  EXPECT_EQ(optimizer->Ask(1)[0].origin, "composite_log_ei, weights 0.99 : 0.01");
  EXPECT_EQ(optimizer->Ask(1)[0].origin, "composite_log_ei, weights 0.01 : 0.99");
  EXPECT_THAT(optimizer->Ask(1)[0].origin, testing::StartsWith("composite_log_ei, weights 0."));
}

TEST(BayesianParetoTest, ReplaysExactly) {
  const TwoExperiments problem;
  const auto undisturbed = MakeBayesian({}, UnitBox(2), problem.objectives(), 3);
  std::vector<Observation> history = RunSerially(undisturbed.get(), TwoExperiments::Evaluate, 12);
  const auto resumed = MakeBayesian({}, UnitBox(2), problem.objectives(), 3);
  for (int i = 0; i < 6; ++i) resumed->Ask(1);  // the design
  std::reverse(history.begin(), history.begin() + 6);
  resumed->Tell(std::span(history).subspan(0, 6));
  for (std::size_t i = 6; i < history.size(); ++i) {
    const Candidate again = resumed->Ask(1)[0];
    EXPECT_EQ(again.point, history[i].point);
    resumed->Tell(std::span(history).subspan(i, 1));
  }
  EXPECT_EQ(resumed->Ask(1)[0].point, undisturbed->Ask(1)[0].point);
}

TEST(BayesianParetoTest, ABatchEqualsAskingOneByOne) {
  const TwoExperiments problem;
  const auto batched = MakeBayesian({}, UnitBox(2), problem.objectives(), 5);
  const auto single = MakeBayesian({}, UnitBox(2), problem.objectives(), 5);
  RunSerially(batched.get(), TwoExperiments::Evaluate, 6);
  RunSerially(single.get(), TwoExperiments::Evaluate, 6);
  const std::vector<Candidate> batch = batched->Ask(4);
  for (std::size_t i = 0; i < batch.size(); ++i) {
    EXPECT_EQ(single->Ask(1)[0].point, batch[i].point) << i;
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GT((batch[i].point - batch[j].point).norm(), 0.01) << i << " and " << j;
    }
  }
}

// A test that cannot be evaluated over a part of the box away from the front.
TEST(BayesianParetoTest, AnObjectiveMayBeMissing) {
  const TwoExperiments problem;
  const auto responses = [](const Eigen::VectorXd& x) {
    Eigen::VectorXd values = TwoExperiments::Evaluate(x);
    if (x[0] < 0.2) values.tail(2).setConstant(kNaN);
    return values;
  };
  const auto optimizer = MakeBayesian({}, UnitBox(2), problem.objectives(), 2);
  const std::vector<Observation> history = RunSerially(optimizer.get(), responses, 30);
  EXPECT_LT(problem.LargestGap(history), 0.12);
}

TEST(BayesianParetoTest, AnObjectiveMayBeMissingThroughout) {
  const TwoExperiments problem;
  const auto responses = [](const Eigen::VectorXd& x) {
    Eigen::VectorXd values = TwoExperiments::Evaluate(x);
    values.tail(2).setConstant(kNaN);
    return values;
  };
  const auto optimizer = MakeBayesian({}, UnitBox(2), problem.objectives(), 2);
  RunSerially(optimizer.get(), responses, 8);
  EXPECT_THAT(optimizer->Ask(1)[0].origin, HasSubstr("space filling"));
}

// The share of random points of the box below the reference that a front dominates.
double SampledHypervolume(const Eigen::MatrixXd& front, const Eigen::VectorXd& reference,
                          int draws) {
  RandomStream random(5);
  int dominated = 0;
  Eigen::VectorXd point(reference.size());
  for (int i = 0; i < draws; ++i) {
    for (Eigen::Index k = 0; k < point.size(); ++k) point[k] = random.Uniform() * reference[k];
    for (Eigen::Index row = 0; row < front.rows(); ++row) {
      if ((front.row(row).transpose().array() <= point.array()).all()) {
        ++dominated;
        break;
      }
    }
  }
  return reference.prod() * dominated / draws;
}

TEST(HypervolumeTest, KnownVolumes) {
  EXPECT_EQ(Hypervolume(Eigen::MatrixXd(0, 2), Eigen::Vector2d(1, 1)), 0);
  EXPECT_EQ(Hypervolume(Eigen::MatrixXd{{0.25}, {0.5}}, Eigen::VectorXd::Ones(1)), 0.75);
  const Eigen::MatrixXd front{{1, 3}, {2, 2}, {3, 1}, {3, 3}, {5, 0}, {kNaN, 0}};
  EXPECT_EQ(Hypervolume(front, Eigen::Vector2d(4, 4)), 6);
  EXPECT_EQ(Hypervolume(Eigen::MatrixXd{{1, 1, 1}, {0, 1, 2}}, Eigen::Vector3d(2, 2, 3)),
            2 + 2 - 1);
}

TEST(HypervolumeTest, AgreesWithSamplingAndBoxesFillTheRest) {
  RandomStream random(3);
  for (const int objectives : {2, 3, 4}) {
    Eigen::MatrixXd points(12, objectives);
    for (double& x : points.reshaped()) x = random.Uniform();
    const Eigen::VectorXd reference = Eigen::VectorXd::Constant(objectives, 1.1);
    const double volume = Hypervolume(points, reference);
    EXPECT_NEAR(volume, SampledHypervolume(points, reference, 100'000), 0.01);
    const Boxes boxes = NonDominatedBoxes(points, reference);
    double rest = 0;
    for (Eigen::Index b = 0; b < boxes.lower.rows(); ++b) {
      rest += (boxes.upper.row(b).array() - boxes.lower.row(b).array().max(0)).max(0).prod();
    }
    EXPECT_NEAR(volume + rest, reference.prod(), 1e-9);
  }
}

}  // namespace
}  // namespace powdercal

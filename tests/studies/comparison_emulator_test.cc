#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/statistics.h"
#include "optimizers/designs/design.h"
#include "studies/comparison/emulator.h"
#include "studies/runner.h"
#include "tests/support/program.h"

namespace powdercal::comparison {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kScatter = 0.01;

double VoidRatio(const Eigen::VectorXd& x) { return 0.7 + 0.2 * x[0] + 0.05 * std::sin(3 * x[1]); }
double Seconds(const Eigen::VectorXd& x) { return std::exp(1 + x[0]); }

Study Quickstart(const Overrides& overrides = {}) {
  return Study::Load(LibraryStudy("quickstart").string(), overrides);
}

// Of `count` points with `replicates` seeds each; runs fail where x0 is above `limit`.
std::vector<KnownPoint> Sample(int count, int replicates, double scatter = kScatter,
                               double limit = 2) {
  RandomStream random(7);
  std::vector<KnownPoint> points;
  const Eigen::MatrixXd places = SobolPoints(count, 2, 3);
  for (Eigen::Index i = 0; i < places.rows(); ++i) {
    KnownPoint point{.point = places.row(i), .runs = {}};
    for (int r = 0; r < replicates; ++r) {
      LedgerRun run{
          .key = fmt::format("{}-{}", i, r), .experiment = "consolidation", .backend = "embedded"};
      run.diagnostics.wall_seconds = Seconds(point.point);
      if (point.point[0] > limit) {
        run.outcome = {Reason::timeout, "too slow"};
        run.diagnostics.wall_seconds = 60;
      } else {
        run.measurement.responses["void_ratio"].value =
            VoidRatio(point.point) + scatter * random.Normal();
      }
      point.runs.push_back(std::move(run));
    }
    points.push_back(std::move(point));
  }
  return points;
}

Eigen::VectorXd At(double a, double b) { return Eigen::Vector2d(a, b); }

TEST(Emulator, FollowsResponseScatterAndTime) {
  const Study study = Quickstart();
  const Emulator emulator(study, Sample(30, 3));
  ASSERT_EQ(emulator.quality().size(), 1U);
  const Emulator::Quality& quality = emulator.quality().front();
  EXPECT_EQ(quality.response, "consolidation.void_ratio");
  EXPECT_EQ(quality.points, 30);
  EXPECT_GT(quality.leave_one_out_r2, 0.95);
  EXPECT_TRUE(quality.from_replicates);
  // 60 degrees of freedom: the standard error of the standard deviation is 9 % of it.
  EXPECT_NEAR(quality.seed_sd, kScatter, 0.25 * kScatter);
  EXPECT_THAT(emulator.warnings(), IsEmpty());
  EXPECT_EQ(emulator.runs(), 90);
  EXPECT_EQ(emulator.failed_runs(), 0);

  const RandomStream world(1);
  std::vector<double> values;
  for (int r = 0; r < 400; ++r) {
    const LedgerRun run = emulator.Simulate(0, At(0.4, 0.6), r, world);
    ASSERT_TRUE(run.outcome.ok());
    values.push_back(run.measurement.responses.at("void_ratio").value);
    EXPECT_NEAR(run.diagnostics.wall_seconds, Seconds(At(0.4, 0.6)), 0.02 * std::exp(1.4));
  }
  const double truth = emulator.Truth(At(0.4, 0.6))[0];
  EXPECT_NEAR(truth, VoidRatio(At(0.4, 0.6)), kScatter);
  EXPECT_NEAR(Mean(values), truth, 4 * quality.seed_sd / 20);
  EXPECT_NEAR(StandardDeviation(values), quality.seed_sd, 0.15 * quality.seed_sd);
}

TEST(Emulator, TheSameWorldGivesTheSameRuns) {
  const Study study = Quickstart();
  const Emulator emulator(study, Sample(20, 2));
  const auto value = [&](int seed, double x, int replicate) {
    return emulator.Simulate(0, At(x, 0.5), replicate, RandomStream(seed).Split("world"))
        .measurement.responses.at("void_ratio")
        .value;
  };
  EXPECT_EQ(value(1, 0.5, 0), value(1, 0.5, 0));
  EXPECT_NE(value(1, 0.5, 0), value(1, 0.5, 1));
  EXPECT_NE(value(1, 0.5, 0), value(2, 0.5, 0));
  EXPECT_EQ(emulator.fingerprint(), Emulator(study, Sample(20, 2)).fingerprint());
  EXPECT_NE(emulator.fingerprint(), Emulator(study, Sample(21, 2)).fingerprint());
}

TEST(Emulator, FailsWhereSimulationsFailed) {
  const Study study = Quickstart();
  const Emulator emulator(study, Sample(40, 2, kScatter, 0.7));
  EXPECT_GT(emulator.failed_runs(), 0);
  int far = 0, near = 0;
  for (int r = 0; r < 200; ++r) {
    near += emulator.Simulate(0, At(0.95, 0.5), r, RandomStream(1)).outcome.ok() ? 1 : 0;
    far += emulator.Simulate(0, At(0.2, 0.5), r, RandomStream(1)).outcome.ok() ? 1 : 0;
  }
  EXPECT_LT(near, 60);
  EXPECT_GT(far, 180);
  for (int r = 0; r < 200; ++r) {
    const LedgerRun run = emulator.Simulate(0, At(0.95, 0.5), r, RandomStream(1));
    if (run.outcome.ok()) continue;
    EXPECT_EQ(run.diagnostics.wall_seconds, 60);
    EXPECT_TRUE(run.measurement.responses.empty());
    EXPECT_EQ(run.outcome.message, "too slow");
  }
}

TEST(Emulator, SaysWhenItIsPoor) {
  const Study study = Quickstart();
  const Emulator emulator(study, Sample(24, 1, 0.5));
  ASSERT_EQ(emulator.warnings().size(), 2U);
  EXPECT_THAT(emulator.warnings()[0], HasSubstr("emulated poorly"));
  EXPECT_THAT(emulator.warnings()[1], HasSubstr("no point has several particle seeds"));
  EXPECT_FALSE(emulator.quality().front().from_replicates);
  // A process may take single values for waves; its residuals do not.
  EXPECT_GT(emulator.quality().front().seed_sd, 0.1);
}

TEST(Emulator, NeedsEnoughPoints) {
  const Study study = Quickstart();
  try {
    Emulator(study, Sample(4, 3));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("consolidation.void_ratio"));
    EXPECT_THAT(error.what(), HasSubstr("there are 4"));
    EXPECT_THAT(error.what(), HasSubstr("--design"));
  }
}

TEST(KnownPoints, AreThoseOfTheLedger) {
  const TemporaryFolder folder;
  Study study =
      Study::Load(LibraryStudy("hastelloy_x_table3").string(), {{"budget.evaluations", "7"}});
  StudyRunner(study, {.folder = folder / "x"}).Run();
  const Ledger ledger(folder / "x/ledger.sqlite", Ledger::Mode::read_only);
  std::vector<KnownPoint> points = ReadKnownPoints(study, ledger);
  ASSERT_EQ(points.size(), 7U);
  EXPECT_EQ(points[0].point, Eigen::VectorXd(Eigen::Vector2d(0, 0)));
  for (const KnownPoint& point : points) EXPECT_EQ(point.runs.size(), 1U);
  Merge(points, &points);  // nothing new
  EXPECT_EQ(points.size(), 7U);
  EXPECT_EQ(points[3].runs.size(), 1U);
}

TEST(OtherProblem, IsOneWhoseSimulationsWouldDiffer) {
  Study study = Quickstart();
  for (const Overrides& same :
       {Overrides{}, Overrides{{"seed", "5"}}, Overrides{{"budget.evaluations", "3"}},
        Overrides{{"optimizer", "random"}}, Overrides{{"backend.replicates", "1"}},
        Overrides{{"experiments[0].consolidation.observed.void_ratio.value", "0.8"}}}) {
    Study other = Quickstart(same);
    EXPECT_EQ(ExplainOtherProblem(study, other), "");
  }
  Study denser = Quickstart({{"material.density", "8000 kg/m3"}});
  EXPECT_THAT(ExplainOtherProblem(study, denser), HasSubstr("material differs"));
  Study finer = Quickstart({{"backend.fidelity", "standard"}});
  EXPECT_THAT(ExplainOtherProblem(study, finer), HasSubstr("experiments"));
  Study table = Study::Load(LibraryStudy("hastelloy_x_table3").string());
  EXPECT_THAT(ExplainOtherProblem(study, table),
              ::testing::AllOf(HasSubstr("backend"), HasSubstr("contact_law")));
}

}  // namespace
}  // namespace powdercal::comparison

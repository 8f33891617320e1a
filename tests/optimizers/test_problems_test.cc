#include "optimizers/test_problems.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/errors.h"

namespace powdercal {
namespace {

constexpr const char* kTable3 = POWDERCAL_SOURCE_DIR "/studies/library/hastelloy_x_table3.csv";

double MeasureOf(const TestProblem& problem, const Eigen::VectorXd& values) {
  const Eigen::VectorXd responses = problem.respond(values);
  return problem.measure(std::span(&responses, 1));
}

TEST(TestProblemsTest, PublishedMinima) {
  EXPECT_NEAR(MeasureOf(MakeTestProblem("branin", kTable3), Eigen::Vector2d(9.42478, 2.475)), 0,
              1e-6);
  Eigen::VectorXd hartmann(6);
  hartmann << 0.20169, 0.150011, 0.476874, 0.275332, 0.311652, 0.6573;
  EXPECT_NEAR(MeasureOf(MakeTestProblem("hartmann6", kTable3), hartmann), 0, 1e-5);
  EXPECT_NEAR(MeasureOf(MakeTestProblem("mixed", kTable3), Eigen::Vector4d(0.5, 0.6, 5, 1)), 0,
              1e-15);
  EXPECT_EQ(MeasureOf(MakeTestProblem("environmental", kTable3),
                      Eigen::Vector4d(10, 0.07, 1.505, 30.1525)),
            0);
}

TEST(TestProblemsTest, CheapBraninIsShiftedAndItsTargetIsNot) {
  const TestProblem problem = MakeTestProblem("branin_multi_fidelity", kTable3);
  const TestProblem branin = MakeTestProblem("branin", kTable3);
  const Eigen::Vector2d x(2, 1);
  EXPECT_EQ(problem.respond(x), branin.respond(x));
  EXPECT_NEAR(problem.respond_at(x, 1)[0], branin.respond(x)[0], 1e-12);
  // x2 + 0.1 · 0.5 · 2²
  EXPECT_NEAR(problem.respond_at(x, 0.5)[0], branin.respond(Eigen::Vector2d(2, 1.2))[0], 1e-12);
  EXPECT_EQ(CostOf(problem, {.fidelity = 0.5}), 0.1);
  EXPECT_EQ(CostOf(problem, {.fidelity = 1}), 1);
  EXPECT_EQ(CostOf(branin, {}), 1);
  const Observation cheap =
      Observe(problem, {.point = Eigen::Vector2d(0.5, 0.5), .fidelity = 0.5}, 1);
  EXPECT_EQ(cheap.fidelity, 0.5);
  EXPECT_EQ(cheap.responses, problem.respond_at(Eigen::Vector2d(2.5, 7.5), 0.5));
}

TEST(TestProblemsTest, FrontsHaveTheirHypervolumes) {
  const TestProblem zdt1 = MakeTestProblem("zdt1", kTable3);
  const TestProblem dtlz2 = MakeTestProblem("dtlz2", kTable3);
  std::vector<Eigen::VectorXd> line;
  std::vector<Eigen::VectorXd> sphere;
  for (int i = 0; i <= 400; ++i) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(30);
    x[0] = i / 400.0;
    line.push_back(zdt1.respond(x));
  }
  for (int i = 0; i <= 24; ++i) {
    for (int j = 0; j <= 24; ++j) {
      Eigen::VectorXd x = Eigen::VectorXd::Constant(12, 0.5);
      x[0] = i / 24.0;
      x[1] = j / 24.0;
      sphere.push_back(dtlz2.respond(x));
    }
  }
  // 1.1² − ∫ (1 − √x) dx − …: 0.8766…; 1.1³ − π/6.
  EXPECT_NEAR(zdt1.measure(line), 1.21 - 1.0 / 3, 2e-3);
  EXPECT_NEAR(dtlz2.measure(sphere), 1.331 - std::acos(-1.0) / 6, 0.05);
}

TEST(TestProblemsTest, ObservationsHaveNoiseAndFailures) {
  for (const std::string& name : TestProblemNames()) {
    const TestProblem problem = MakeTestProblem(name, kTable3);
    EXPECT_EQ(problem.name, name);
    EXPECT_FALSE(problem.description.empty());
    const Candidate middle{
        .id = 3,
        .point = problem.space.Snap(Eigen::VectorXd::Constant(problem.space.dimension(), 0.5))};
    const Observation first = Observe(problem, middle, 1);
    ASSERT_FALSE(first.failed) << name;
    EXPECT_EQ(first.responses.size(), static_cast<Eigen::Index>(problem.objectives.targets.size()));
    EXPECT_EQ(Observe(problem, middle, 1).responses, first.responses);
    EXPECT_EQ(Observe(problem, middle, 2).responses == first.responses,
              problem.noise_sd.size() == 0);
  }
  const Candidate failing{.point = Eigen::Vector2d(0.2, 0.5)};
  EXPECT_TRUE(Observe(MakeTestProblem("failures", kTable3), failing, 1).failed);
  EXPECT_FALSE(Observe(MakeFailuresWithoutFailing(), failing, 1).failed);
  EXPECT_THROW(MakeTestProblem("branim", kTable3), InputError);
}

}  // namespace
}  // namespace powdercal

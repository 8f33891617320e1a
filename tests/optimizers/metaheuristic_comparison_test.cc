// Own implementations beside pagmo's at equal evaluations; figures in docs/optimizers.md.
#include <gtest/gtest.h>

#include "core/statistics.h"
#include "optimizers/optimizer_text.h"
#include "optimizers/test_problems.h"

namespace powdercal {
namespace {

// What the problem measures, median over seeds 1, 2, …
double MedianMeasure(const TestProblem& problem, const std::string& optimizer, int evaluations,
                     std::uint64_t seeds) {
  std::vector<double> measures;
  const auto factory = ParseOptimizer(optimizer, problem.space, nullptr);
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const auto search = factory->Make(problem.space, problem.objectives, seed);
    std::vector<Eigen::VectorXd> responses;
    while (static_cast<int>(responses.size()) < evaluations) {
      const auto batch = search->Ask(evaluations - static_cast<int>(responses.size()));
      if (batch.empty()) ADD_FAILURE() << optimizer << ": " << search->status().message;
      if (batch.empty()) break;
      std::vector<Observation> told;
      for (const Candidate& candidate : batch) {
        told.push_back(Observe(problem, candidate, seed));
        responses.push_back(told.back().responses);
      }
      search->Tell(told);
    }
    measures.push_back(problem.measure(responses));
  }
  return Median(measures);
}

TestProblem Problem(const std::string& name) {
  return MakeTestProblem(name, POWDERCAL_SOURCE_DIR "/studies/library/hastelloy_x_table3.csv");
}

class OwnAndPagmoTest : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(SingleObjective, OwnAndPagmoTest,
                         testing::Values("cma_es", "differential_evolution", "genetic"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(OwnAndPagmoTest, OwnIsNoWorseOnHartmann6) {
  const TestProblem problem = Problem("hartmann6");
  const std::string name = GetParam();
  const double own = MedianMeasure(problem, name, 500, 20);
  EXPECT_LE(own, MedianMeasure(problem, name + ":implementation=pagmo", 500, 20));
  EXPECT_LT(own, 0.05);
}

TEST(OwnAndPagmoFrontTest, OwnMoeadIsNoWorseOnZdt1) {
  const TestProblem problem = Problem("zdt1");
  const double own = MedianMeasure(problem, "moead", 4040, 11);
  EXPECT_GE(own, MedianMeasure(problem, "moead:implementation=pagmo", 4040, 11));
  EXPECT_GE(own, MedianMeasure(problem, "nsga2", 4040, 11));
}

TEST(OwnAndPagmoFrontTest, OwnMoeadIsNoWorseOnDtlz2) {
  const TestProblem problem = Problem("dtlz2");
  const double own = MedianMeasure(problem, "moead", 4048, 11);
  EXPECT_GE(own, MedianMeasure(problem, "moead:implementation=pagmo", 4048, 11));
  EXPECT_GE(own, MedianMeasure(problem, "moead:implementation=pagmo,population=92", 4048, 11));
}

}  // namespace
}  // namespace powdercal

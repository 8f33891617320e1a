#include "reports/plots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/reports/sample_studies.h"

namespace powdercal {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// The data of the last layer: the evaluations.
const json& PointRows(const Figure& figure) {
  return figure.spec.at("layer").back().at("data").at("values");
}

TEST(PlotsTest, ConvergenceHasEveryEvaluation) {
  const Figure figure = ConvergenceFigure(QuickstartSample());
  const json& rows = figure.spec.at("data").at("values");
  ASSERT_EQ(rows.size(), 14u);
  EXPECT_EQ(rows[0].at("kind"), "initial design");
  EXPECT_EQ(rows[1].at("kind"), "failed");
  EXPECT_EQ(rows[8].at("kind"), "best");
  EXPECT_TRUE(rows[1].at("drawn").is_null());
}

TEST(PlotsTest, PerfectFitIsDrawnOnTheLogarithmicAxis) {
  StudyResults results = QuickstartSample();
  results.history[*results.best].chi2 = 0;
  const Figure figure = ConvergenceFigure(results);
  for (const json& row : figure.spec.at("data").at("values")) {
    if (row.at("drawn").is_null()) continue;
    EXPECT_GT(row.at("drawn").get<double>(), 0);
  }
}

TEST(PlotsTest, TwoParametersGiveAPlaneForEachResponse) {
  const std::vector<Figure> figures = SurfaceFigures(QuickstartSample());
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_EQ(figures[0].pair, -1);
  EXPECT_THAT(figures[0].caption, HasSubstr("through 12 evaluations"));
  EXPECT_THAT(figures[0].caption, HasSubstr("Thick line: the observed void ratio, 0.783"));
  EXPECT_EQ(PointRows(figures[0]).size(), 14u);
  const json& map = figures[0].spec.at("layer")[0].at("data").at("values")[0];
  EXPECT_EQ(map.at("mean").size(), map.at("sd").size());
  // The model follows the samples: about 0.57 to 1.2 over this plane.
  const auto [low, high] = std::minmax_element(map.at("mean").begin(), map.at("mean").end());
  EXPECT_NEAR(low->get<double>(), 0.56, 0.05);
  EXPECT_GT(high->get<double>(), 1.0);
}

TEST(PlotsTest, LevelThatIsNotReachedIsSaid) {
  StudyResults results = QuickstartSample();
  for (EvaluationResult& evaluation : results.history) evaluation.responses[0].observed = 5;
  EXPECT_THAT(SurfaceFigures(results)[0].caption, HasSubstr("is not reached here"));
}

TEST(PlotsTest, ThreeParametersGiveThreePairs) {
  const StudyResults results = JointSample();
  EXPECT_EQ(ParameterPairs(results), (std::vector<std::string>{"k and μᵣ", "k and E", "μᵣ and E"}));
  const std::vector<Figure> figures = SurfaceFigures(results);
  ASSERT_EQ(figures.size(), 9u);
  EXPECT_EQ(figures[2].pair, 2);
  EXPECT_THAT(figures[2].caption, HasSubstr("held at the best point"));
  // The modulus was searched on a logarithmic scale.
  EXPECT_EQ(figures[2].spec.at("layer")[0].at("encoding").at("y").at("scale").at("type"), "log");
  EXPECT_TRUE(ParallelFigures(results).empty());
}

TEST(PlotsTest, MoreParametersGiveParallelCoordinates) {
  StudyResults results = JointSample();
  results.parameters.push_back({.name = "friction", .symbol = "mu", .unit = "1"});
  for (EvaluationResult& evaluation : results.history) evaluation.parameters["friction"] = 0.5;
  EXPECT_EQ(SurfaceFigures(results).size(), 3u);
  const std::vector<Figure> figures = ParallelFigures(results);
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_EQ(figures[0].spec.at("data").at("values").size(), 23u * 4u);
}

TEST(PlotsTest, OneParameterGivesALine) {
  const std::vector<Figure> figures = SurfaceFigures(LineSample());
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_TRUE(ParameterPairs(LineSample()).empty());
  EXPECT_THAT(figures[0].caption, HasSubstr("two standard deviations"));
}

TEST(PlotsTest, TooFewEvaluationsAreExplained) {
  const std::vector<Figure> figures = SurfaceFigures(FailedSample());
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_TRUE(figures[0].spec.is_null());
  EXPECT_THAT(figures[0].caption, HasSubstr("at least 3 successful evaluations"));
}

TEST(PlotsTest, FitNeedsTwoResponses) {
  EXPECT_TRUE(FitFigures(QuickstartSample()).empty());
  const std::vector<Figure> figures = FitFigures(JointSample());
  ASSERT_EQ(figures.size(), 2u);  // deviations of all three, and the two in Pa
  EXPECT_EQ(figures[0].spec.at("layer").back().at("data").at("values").size(), 3u);
  EXPECT_EQ(figures[1].spec.at("data").at("values").size(), 2u);
}

TEST(PlotsTest, TwoObjectivesGiveAPlaneWithTheFront) {
  const StudyResults results = ParetoSample();
  const std::vector<Figure> figures = ParetoFigures(results);
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_EQ(figures[0].title, "Misfits of consolidation and shear");
  const json& rows = figures[0].spec.at("data").at("values");
  EXPECT_EQ(rows.size(), 23u) << "one of 24 failed";
  std::size_t front = 0;
  int best = 0;
  for (const json& row : rows) {
    if (row.at("standing") == "other evaluation") continue;
    ++front;
    if (row.at("standing") == "best: lowest sum") {
      ++best;
      EXPECT_EQ(row.at("evaluation"), results.history[*results.best].id);
    }
    EXPECT_EQ(row.at("m1"),
              *results.history[row.at("evaluation").get<std::size_t>()].objectives[1].misfit);
  }
  EXPECT_EQ(front, results.pareto.size());
  EXPECT_EQ(best, 1);
}

TEST(PlotsTest, AMisfitOfNothingIsDrawnOnTheLogarithmicAxis) {
  StudyResults results = ParetoSample();
  results.history[*results.best].objectives[0].misfit = 0;
  const json spec = ParetoFigures(results)[0].spec;
  for (const json& row : spec.at("data").at("values")) {
    EXPECT_GT(row.at("m0").get<double>(), 0);
  }
}

TEST(PlotsTest, MoreObjectivesGiveLines) {
  const std::vector<Figure> figures = ParetoFigures(ParetoSample(3));
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_EQ(figures[0].spec.at("data").at("values").size(), 23u * 3u);
}

TEST(PlotsTest, OneObjectiveHasNoFront) {
  EXPECT_TRUE(ParetoFigures(JointSample()).empty());
  StudyResults results = ParetoSample(1);
  EXPECT_EQ(results.pareto.size(), 1u);
  EXPECT_TRUE(ParetoFigures(results).empty());
}

TEST(PlotsTest, NothingAtAll) {
  const StudyResults nothing;
  EXPECT_TRUE(ConvergenceFigure(nothing).spec.is_null());
  EXPECT_TRUE(SurfaceFigures(nothing).empty());
  EXPECT_TRUE(FitFigures(nothing).empty());
  EXPECT_TRUE(ParallelFigures(nothing).empty());
  EXPECT_TRUE(ParetoFigures(nothing).empty());
}

TEST(PlotsTest, NamesAreNoAxisOfASurface) {
  const StudyResults results = CategoricalSample();
  const std::vector<Figure> figures = SurfaceFigures(results);
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_THAT(figures[0].title, HasSubstr("k and"));
  EXPECT_THAT(figures[0].caption, HasSubstr("other parameters are held at the best point"));
  EXPECT_THAT(figures[0].spec.dump(), HasSubstr("epsd2"));  // in the tooltip of the evaluations
}

}  // namespace
}  // namespace powdercal

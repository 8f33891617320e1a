#include "optimizers/designs/design.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/optimizers/problems.h"

namespace powdercal {
namespace {

Eigen::MatrixXd Points(const std::vector<DesignPoint>& design) {
  Eigen::MatrixXd points(static_cast<Eigen::Index>(design.size()), design.front().point.size());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    points.row(i) = design[static_cast<std::size_t>(i)].point.transpose();
  }
  return points;
}

// Whether each column has exactly one entry in each of `count` strata.
bool Stratified(const Eigen::MatrixXd& points) {
  const auto count = static_cast<double>(points.rows());
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    std::set<int> strata;
    for (const double u : points.col(k)) strata.insert(static_cast<int>(u * count));
    if (strata.size() != static_cast<std::size_t>(points.rows())) return false;
  }
  return true;
}

double SmallestDistance(const Eigen::MatrixXd& points) {
  double smallest = 10;
  for (Eigen::Index i = 1; i < points.rows(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      smallest = std::min(smallest, (points.row(i) - points.row(j)).norm());
    }
  }
  return smallest;
}

// The message of reading `text` as the options of the design called `name`.
std::string ReadError(const std::string& name, const std::string& text, const SearchSpace& space) {
  try {
    ReadYaml(text, "study.yaml", [&](Archive& archive) {
      DesignOptions options{.name = name};
      options.Serialize(archive, space);
    });
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(DesignTest, CornersAndCentre) {
  const std::vector<DesignPoint> design = MakeDesign({.name = "corners_and_centre"}, UnitBox(3), 1);
  ASSERT_EQ(design.size(), 9);
  std::set<std::vector<double>> corners;
  for (int i = 0; i < 8; ++i) {
    const Eigen::VectorXd& point = design[static_cast<std::size_t>(i)].point;
    EXPECT_TRUE(((point.array() == 0) || (point.array() == 1)).all());
    corners.insert({point.begin(), point.end()});
  }
  EXPECT_EQ(corners.size(), 8);
  EXPECT_EQ(design[0].label, "corner 1");
  EXPECT_EQ(design[8].label, "centre");
  EXPECT_EQ(design[8].point, Eigen::Vector3d::Constant(0.5));
  EXPECT_EQ(MakeDesign({.name = "corners_and_centre"}, UnitBox(10), 1).size(), 1025);
}

TEST(DesignTest, GridHasAllCombinationsWithTheEnds) {
  const Eigen::MatrixXd points = Points(MakeDesign({.name = "grid", .levels = 4}, UnitBox(2), 1));
  ASSERT_EQ(points.rows(), 16);
  std::set<std::pair<long, long>> seen;
  for (Eigen::Index i = 0; i < 16; ++i) {
    seen.emplace(std::lround(3 * points(i, 0)), std::lround(3 * points(i, 1)));
    EXPECT_NEAR(3 * points(i, 0), std::round(3 * points(i, 0)), 1e-12);
  }
  EXPECT_EQ(seen.size(), 16);
  EXPECT_EQ(points.minCoeff(), 0);
  EXPECT_EQ(points.maxCoeff(), 1);
}

TEST(DesignTest, LatinHypercubeIsStratifiedAndSpread) {
  const Eigen::MatrixXd points =
      Points(MakeDesign({.name = "latin_hypercube", .points = 20}, UnitBox(4), 3));
  EXPECT_TRUE(Stratified(points));
  // A single random one has a median of 0.17.
  EXPECT_GT(SmallestDistance(points), 0.24);
  EXPECT_EQ(points, Points(MakeDesign({.name = "latin_hypercube", .points = 20}, UnitBox(4), 3)));
  EXPECT_NE(points, Points(MakeDesign({.name = "latin_hypercube", .points = 20}, UnitBox(4), 4)));
}

TEST(DesignTest, SobolIsANetWhateverTheShift) {
  for (const std::uint64_t seed : {0, 1, 12345}) {
    const Eigen::MatrixXd points =
        Points(MakeDesign({.name = "sobol", .points = 64}, UnitBox(5), seed));
    EXPECT_TRUE(Stratified(points));
    EXPECT_TRUE(Stratified(points.topRows(16)));
    // The first two inputs are a (0, 6, 2)-net: one point in each of 8 × 8 cells.
    std::set<std::pair<int, int>> cells;
    for (Eigen::Index i = 0; i < 64; ++i) {
      cells.emplace(static_cast<int>(8 * points(i, 0)), static_cast<int>(8 * points(i, 1)));
    }
    EXPECT_EQ(cells.size(), 64);
  }
  EXPECT_EQ(SobolPoints(9, 3, 5), SobolPoints(9, 3, 5));
  EXPECT_EQ(SobolPoints(9, 3, 5).topRows(4), SobolPoints(4, 3, 5));
  EXPECT_NE(SobolPoints(9, 3, 5), SobolPoints(9, 3, 6));
  EXPECT_GT(SobolPoints(1000, 30, 5).minCoeff(), 0);
  EXPECT_LT(SobolPoints(1000, 30, 5).maxCoeff(), 1);
}

TEST(DesignTest, DefaultNumberOfPoints) {
  EXPECT_EQ(MakeDesign({.name = "sobol"}, UnitBox(1), 1).size(), 5);
  EXPECT_EQ(MakeDesign({.name = "sobol"}, UnitBox(6), 1).size(), 14);
  EXPECT_EQ(MakeDesign({.name = "latin_hypercube"}, UnitBox(2), 1).size(), 6);
}

TEST(DesignTest, ListReadsQuantitiesOfTheParameters) {
  DesignOptions options{.name = "list"};
  const SearchSpace space = HastelloySpace();
  ReadYaml(
      "points:\n"
      "  - {cohesion_energy_density: 50.05 kJ/m3, rolling_friction: 0.7}\n"
      "  - {rolling_friction: 0.05, cohesion_energy_density: 100 Pa}\n",
      "study.yaml", [&](Archive& archive) { options.Serialize(archive, space); });
  const std::vector<DesignPoint> design = MakeDesign(options, space, 1);
  ASSERT_EQ(design.size(), 2);
  EXPECT_TRUE(design[0].point.isApprox(Eigen::Vector2d(0.5, 1), 1e-12));
  EXPECT_EQ(design[1].point, Eigen::Vector2d(0, 0));
  EXPECT_EQ(design[1].label, "point 2");

  const std::string written =
      WriteYaml([&](Archive& archive) { options.Serialize(archive, space); });
  DesignOptions back{.name = "list"};
  ReadYaml(written, "", [&](Archive& archive) { back.Serialize(archive, space); });
  EXPECT_EQ(back.list, options.list);
}

TEST(DesignTest, BadOptionsAreErrorsWithTheirPlace) {
  using testing::HasSubstr;
  const SearchSpace space = HastelloySpace();
  EXPECT_THAT(ReadError("sobol", "points: 0\n", space),
              HasSubstr("points: must lie in [1, 100000]"));
  EXPECT_THAT(ReadError("sobol", "point: 8\n", space), HasSubstr("did you mean 'points'?"));
  EXPECT_THAT(ReadError("grid", "levels: 1\n", space), HasSubstr("levels: must lie in [2"));
  EXPECT_THAT(ReadError("grid", "levels: 400\n", space), HasSubstr("1.6e+05 points"));
  EXPECT_THAT(ReadError("list", "{}\n", space), HasSubstr("missing key 'points'"));
  EXPECT_THAT(ReadError("list", "points: []\n", space), HasSubstr("the list of points is empty"));
  EXPECT_THAT(ReadError("list", "points:\n  - {cohesion_energy_density: 1 kPa}\n", space),
              HasSubstr("missing key 'rolling_friction'"));
  EXPECT_THAT(
      ReadError("list", "points:\n  - {cohesion_energy_density: 5, rolling_friction: 0.1}\n",
                space),
      HasSubstr("study.yaml:2:31: points[0].cohesion_energy_density"));
  EXPECT_THAT(
      ReadError("list", "points:\n  - {cohesion_energy_density: 1 kPa, rolling_friction: 0.8}\n",
                space),
      HasSubstr("points[0].rolling_friction: must lie in [0.05, 0.7]"));
  EXPECT_THAT(ReadError("corners_and_centre", "{}\n", UnitBox(11)), HasSubstr("use sobol"));
  EXPECT_THROW(MakeDesign({.name = "corners_and_centre"}, UnitBox(11), 1), std::invalid_argument);
  EXPECT_THROW(MakeDesign({.name = "list", .list = {{1.0}}}, UnitBox(2), 1), std::invalid_argument);
  EXPECT_THROW(MakeDesign({.name = "sobel"}, UnitBox(2), 1), std::invalid_argument);
}

TEST(DesignOptimizerTest, AsksForItsPointsAndIsFinished) {
  const std::unique_ptr<OptimizerFactory> factory = MakeOptimizerFactory("corners_and_centre");
  const auto optimizer = factory->Make(UnitBox(2), JointTargets({0}, 1), 1);
  EXPECT_EQ(optimizer->status().phase, Status::Phase::ready);
  const std::vector<Candidate> first = optimizer->Ask(3);
  const std::vector<Candidate> second = optimizer->Ask(3);
  ASSERT_EQ(first.size(), 3);
  ASSERT_EQ(second.size(), 2);
  EXPECT_EQ(first[2].id, 2);
  EXPECT_EQ(second[1].id, 4);
  EXPECT_EQ(second[1].origin, "corners_and_centre: centre");
  EXPECT_TRUE(optimizer->Ask(3).empty());
  EXPECT_EQ(optimizer->status().phase, Status::Phase::finished);
  EXPECT_THAT(optimizer->status().message, testing::HasSubstr("all 5 points"));
}

TEST(DesignOptimizerTest, SaysWhyItCannotRun) {
  const std::unique_ptr<OptimizerFactory> factory = MakeOptimizerFactory("corners_and_centre");
  const auto optimizer = factory->Make(UnitBox(12), JointTargets({0}, 1), 1);
  EXPECT_THAT(optimizer->ExplainUnsupported(UnitBox(12), JointTargets({0}, 1)),
              testing::HasSubstr("at most 10 parameters"));
}

}  // namespace
}  // namespace powdercal

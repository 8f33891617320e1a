#include "studies/collapse.h"

#include <gmock/gmock.h>

#include <cmath>

#include "tests/support/program.h"

namespace powdercal {
namespace {

using ::testing::HasSubstr;

// The quickstart's powder under rigid_limit, with the void ratio alone.
Study LoadStudy() { return Study::Load("quickstart"); }

CollapsePoint Point(const std::string& mode, std::map<std::string, double> groups,
                    std::vector<double> values) {
  CollapsePoint point{.mode = mode, .experiment = 0, .groups = std::move(groups)};
  point.responses["void_ratio"] = std::move(values);
  return point;
}

CollapsePoint RigidPoint(double kappa, std::vector<double> values) {
  CollapsePoint point = Point("rigid_limit", {}, std::move(values));
  point.kappa_floor = kappa;
  return point;
}

const GroupTrend& TrendOf(const std::vector<GroupTrend>& trends, const std::string& group) {
  for (const GroupTrend& trend : trends) {
    if (trend.group == group) return trend;
  }
  throw std::out_of_range(group);
}

// e = 1 + 0.1 ln(load/weight), whatever sigma/E is.
TEST(FindTrends, TellsTheGroupThatAResponseFollows) {
  const Study study = LoadStudy();
  std::vector<CollapsePoint> points;
  const double stiffness[] = {3, 100, 1, 30, 10};
  const double load[] = {1, 3, 10, 30, 100};
  for (int i = 0; i < 5; ++i) {
    const double e = 1 + 0.1 * std::log(load[i]);
    points.push_back(Point("a", {{"sigma/E", stiffness[i]}, {"sigma/(rho_b g h)", load[i]}}, {e}));
  }
  const auto trends = FindTrends(study, points);
  ASSERT_EQ(trends.size(), 2u);
  EXPECT_GT(TrendOf(trends, "sigma/(rho_b g h)").collapse, 0.8);
  EXPECT_LT(TrendOf(trends, "sigma/E").collapse, 0.5);
  EXPECT_NEAR(TrendOf(trends, "sigma/(rho_b g h)").slope, 0.1, 1e-12);
  EXPECT_NEAR(TrendOf(trends, "sigma/(rho_b g h)").slope_error, 0, 1e-7);
  EXPECT_EQ(trends[0].response, "void_ratio");
  EXPECT_EQ(trends[0].experiment, "consolidation");
}

TEST(FindTrends, AGroupThatIsTheSameEverywhereExplainsNothing) {
  const Study study = LoadStudy();
  std::vector<CollapsePoint> points;
  for (const double e : {0.8, 0.9, 1.0}) points.push_back(Point("a", {{"sigma/E", 2}}, {e}));
  EXPECT_TRUE(FindTrends(study, points).empty());
}

TEST(FindPlateaus, FindsTheLeastStiffnessThatGivesTheSame) {
  const Study study = LoadStudy();
  const std::vector<CollapsePoint> points = {
      RigidPoint(2000, {0.81, 0.79, 0.80}), RigidPoint(250, {0.71, 0.69, 0.70}),
      RigidPoint(4000, {0.80, 0.82, 0.81}), RigidPoint(1000, {0.79, 0.81, 0.80}),
      Point("sigma_over_e", {{"kappa", 84000}}, {2, 2, 2})};
  auto plateaus = FindPlateaus(study, points);
  ASSERT_EQ(plateaus.size(), 1u);
  EXPECT_EQ(plateaus[0].kappa, 1000);
  EXPECT_EQ(plateaus[0].largest_kappa, 4000);
  EXPECT_NEAR(plateaus[0].seed_sd, std::sqrt(8e-4 / 10), 1e-12);
  EXPECT_NEAR(plateaus[0].change, -0.01, 1e-12);
  EXPECT_NEAR(plateaus[0].error, plateaus[0].seed_sd * std::sqrt(2.0 / 3), 1e-12);

  const std::vector<CollapsePoint> rising = {RigidPoint(1000, {0.70, 0.71}),
                                             RigidPoint(4000, {0.80, 0.81})};
  plateaus = FindPlateaus(study, rising);
  ASSERT_EQ(plateaus.size(), 1u);
  EXPECT_EQ(plateaus[0].kappa, 0);
  EXPECT_NEAR(plateaus[0].change, -0.1, 1e-12);
}

TEST(Collapse, KeepsThePullOffForceAtEveryStiffness) {
  const Study study = LoadStudy();
  const Collapse collapse(
      study, {.kappas = {500, 1000}, .replicates = 2, .experiments = {0}, .parameters = {1, 0.3}});
  std::vector<std::string> modes;
  for (const CollapsePoint& point : collapse.points()) {
    modes.push_back(point.mode);
    ASSERT_EQ(point.runs.size(), 2u);
    EXPECT_EQ(point.runs[0].seed, collapse.points()[0].runs[0].seed);
    EXPECT_NE(point.runs[0].seed, point.runs[1].seed);
    EXPECT_EQ(point.runs[0].program.materials.particle_particle.rolling_friction, 0.3);
    // Bo of 0.1 mJ/m2, at any E: k is not the 1 J/m3 that was given.
    EXPECT_NEAR(point.groups.at("Bo") / collapse.points()[0].groups.at("Bo"), 1, 1e-9)
        << point.mode;
  }
  EXPECT_THAT(modes, ::testing::ElementsAre("rigid_limit", "rigid_limit", "given (this study)",
                                            "sigma_over_e"));
  EXPECT_NEAR(collapse.points()[1].groups.at("kappa"), 1000, 1e-6);
  EXPECT_EQ(collapse.points()[1].kappa_floor, 1000);
  EXPECT_EQ(collapse.points()[2].kappa_floor, 0);
}

TEST(Collapse, NeedsTheSurfaceEnergyOfACohesionThatIsSought) {
  std::string text = StudyText("quickstart");
  const std::size_t energy = text.find("  surface_energy");
  text.erase(energy, text.find('\n', energy) + 1 - energy);
  const Study study = Study::Parse(text, "s.yaml", {}, {});
  try {
    Collapse(study, {.experiments = {0}, .parameters = {1, 0.3}});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("material.surface_energy"));
  }
}

}  // namespace
}  // namespace powdercal

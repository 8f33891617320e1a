#include "experiments/yield_locus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <numbers>

#include "core/errors.h"
#include "core/random.h"

namespace powdercal {
namespace {

using Kind = ShearWarning::Kind;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr double kDegree = std::numbers::pi / 180;

LinearLocus Line(double cohesion, double tan_phi) {
  LinearLocus locus;
  locus.cohesion = cohesion;
  locus.tan_phi = tan_phi;
  return locus;
}

// FT4's 9 kPa set on a line, in Pa.
std::vector<ShearPoint> PointsOnLine(double cohesion, double tan_phi, double sd = 0) {
  std::vector<ShearPoint> points;
  for (const double normal : {7e3, 6e3, 5e3, 4e3, 3e3}) {
    points.push_back({normal, cohesion + tan_phi * normal, 0, sd});
  }
  return points;
}

std::vector<Kind> KindsOf(const StrengthFigures& figures) {
  std::vector<Kind> kinds;
  for (const ShearWarning& warning : figures.warnings) kinds.push_back(warning.kind);
  return kinds;
}

std::vector<double> ValuesOf(const StrengthFigures& f) {
  return {f.cohesion.value,
          f.tan_phi.value,
          f.phi.value,
          f.unconfined_yield_strength.value,
          f.major_principal_stress.value,
          f.minor_principal_stress.value,
          f.flow_function_coefficient.value,
          f.inverse_flow_function.value,
          f.effective_friction_angle.value,
          f.steady_state_angle.value};
}

std::vector<double> SdsOf(const StrengthFigures& f) {
  return {f.cohesion.sd,
          f.tan_phi.sd,
          f.phi.sd,
          f.unconfined_yield_strength.sd,
          f.major_principal_stress.sd,
          f.minor_principal_stress.sd,
          f.flow_function_coefficient.sd,
          f.inverse_flow_function.sd,
          f.effective_friction_angle.sd,
          f.steady_state_angle.sd};
}

// --- Figures ------------------------------------------------------------------------------------

TEST(YieldLocus, FiguresOfAKnownCase) {
  const double tan_phi = std::tan(28 * kDegree);
  const double preshear = 250 + 0.98 * 9000 * tan_phi;
  const StrengthFigures figures = EvaluateStrength(Line(250, tan_phi), {9000, preshear});
  EXPECT_NEAR(figures.unconfined_yield_strength.value, 832, 0.5);
  EXPECT_NEAR(figures.major_principal_stress.value, 15754, 0.5);
  EXPECT_NEAR(figures.flow_function_coefficient.value, 18.93, 0.005);
  EXPECT_NEAR(figures.inverse_flow_function.value, 1 / 18.93, 1e-5);
  EXPECT_NEAR(figures.effective_friction_angle.value, 29.36 * kDegree, 0.005 * kDegree);
  EXPECT_NEAR(figures.phi.value, 28 * kDegree, 1e-12);
  EXPECT_NEAR(figures.steady_state_angle.value, std::atan(preshear / 9000), 1e-12);
  EXPECT_THAT(figures.warnings, IsEmpty());
}

// The argument at which a function of one valley is smallest, by golden section.
double ArgMin(const std::function<double(double)>& f, double a, double b) {
  const double ratio = (std::sqrt(5.0) - 1) / 2;
  for (int i = 0; i < 120; ++i) {
    const double left = b - ratio * (b - a);
    const double right = a + ratio * (b - a);
    (f(left) < f(right) ? b : a) = f(left) < f(right) ? right : left;
  }
  return (a + b) / 2;
}

// Where f changes its sign between a and b.
double Root(const std::function<double(double)>& f, double a, double b) {
  const bool rising = f(a) < 0;
  for (int i = 0; i < 200; ++i) {
    const double middle = (a + b) / 2;
    ((f(middle) < 0) == rising ? a : b) = middle;
  }
  return (a + b) / 2;
}

// Mohr circles built by searching, without any formula for the tangent: centres on the sigma axis
// whose distance from the locus, the smallest over its points, equals the radius.
struct SearchedCircles {
  double strength, major, minor;
};

SearchedCircles SearchCircles(double cohesion, double tan_phi, double normal, double shear) {
  const double reach = 20 * (normal + cohesion);
  const auto distance = [=](double centre) {
    const auto to_point = [=](double sigma) {
      return std::hypot(sigma - centre, cohesion + tan_phi * sigma);
    };
    return to_point(ArgMin(to_point, -reach, reach));
  };
  SearchedCircles result{};
  result.strength =
      2 * Root([&](double centre) { return centre - distance(centre); }, 0, 2 * reach);
  const auto excess = [&](double centre) {
    return std::pow(std::hypot(normal - centre, shear), 2) - std::pow(distance(centre), 2);
  };
  const double between = ArgMin(excess, -cohesion / tan_phi, reach);
  const double centre = Root(excess, -cohesion / tan_phi, between);
  const double radius = std::hypot(normal - centre, shear);
  result.major = centre + radius;
  result.minor = centre - radius;
  return result;
}

TEST(YieldLocus, ClosedFormsMatchCirclesFoundBySearch) {
  RandomStream random(7);
  for (int i = 0; i < 60; ++i) {
    const double normal = random.Uniform(500, 15000);
    const double cohesion = random.Uniform(0.005, 0.4) * normal;
    const double phi = random.Uniform(8, 50) * kDegree;
    const double tan_phi = std::tan(phi);
    const double shear = random.Uniform(0.8, 0.995) * (cohesion + normal * tan_phi);
    SCOPED_TRACE(testing::Message()
                 << "c " << cohesion << " phi " << phi << " preshear " << normal << ", " << shear);
    const SearchedCircles found = SearchCircles(cohesion, tan_phi, normal, shear);
    const StrengthFigures figures = EvaluateStrength(Line(cohesion, tan_phi), {normal, shear});
    const double tolerance = 1e-5 * normal;
    EXPECT_NEAR(figures.unconfined_yield_strength.value, found.strength, tolerance);
    EXPECT_NEAR(figures.major_principal_stress.value, found.major, tolerance);
    EXPECT_NEAR(figures.minor_principal_stress.value, found.minor, tolerance);
    EXPECT_NEAR(figures.flow_function_coefficient.value, found.major / found.strength,
                1e-4 * found.major / found.strength);
    EXPECT_LE(figures.steady_tangent_stress, normal);

    // The usual form, with the stresses shifted by the tensile intercept c cot(phi).
    const double shift = cohesion / tan_phi;
    const double a = normal + shift;
    const double cosine = std::cos(phi);
    const double s = (a - std::sqrt(std::pow(a * std::sin(phi), 2) - std::pow(shear * cosine, 2))) /
                     (cosine * cosine);
    EXPECT_NEAR(figures.major_principal_stress.value, s * (1 + std::sin(phi)) - shift,
                1e-9 * normal);
    EXPECT_NEAR(figures.minor_principal_stress.value, s * (1 - std::sin(phi)) - shift,
                1e-9 * normal);
    EXPECT_NEAR(figures.unconfined_yield_strength.value,
                2 * cohesion * cosine / (1 - std::sin(phi)), 1e-9 * normal);
  }
}

TEST(YieldLocus, TangentPointsLieOnLocusAndCircle) {
  const StrengthFigures figures = EvaluateStrength(Line(400, 0.6), {9000, 5600});
  const double s1 = figures.major_principal_stress.value;
  const double s3 = figures.minor_principal_stress.value;
  const double x = figures.steady_tangent_stress;
  EXPECT_NEAR(std::hypot(x - (s1 + s3) / 2, 400 + 0.6 * x), (s1 - s3) / 2, 1e-8);
  const double strength = figures.unconfined_yield_strength.value;
  const double y = figures.unconfined_tangent_stress;
  EXPECT_NEAR(std::hypot(y - strength / 2, 400 + 0.6 * y), strength / 2, 1e-9);
}

TEST(YieldLocus, EffectiveAngleIsThatOfTheLocusWithoutCohesionAtThePreshear) {
  const StrengthFigures figures = EvaluateStrength(Line(0, 0.55), {4000, 2200});
  EXPECT_NEAR(figures.effective_friction_angle.value, std::atan(0.55), 1e-7);
}

TEST(YieldLocus, FiguresScaleWithTheUnitOfStress) {
  RandomStream random(3);
  std::vector<ShearPoint> points = PointsOnLine(300, 0.55, 40);
  for (ShearPoint& point : points) {
    point.shear += 40 * random.Normal();
    point.normal_sd = 25;
  }
  const ShearPoint preshear{9000, 5100, 30, 50};
  const double factor = 1e-3;
  std::vector<ShearPoint> scaled;
  const auto scale = [factor](const ShearPoint& p) {
    return ShearPoint{factor * p.normal, factor * p.shear, factor * p.normal_sd,
                      factor * p.shear_sd};
  };
  for (const ShearPoint& point : points) scaled.push_back(scale(point));
  const StrengthFigures one = EvaluateStrength(points, preshear);
  const StrengthFigures other = EvaluateStrength(scaled, scale(preshear));
  EXPECT_EQ(KindsOf(one), KindsOf(other));
  const std::vector<double> factors = {factor, 1, 1, factor, factor, factor, 1, 1, 1, 1};
  for (std::size_t i = 0; i < factors.size(); ++i) {
    SCOPED_TRACE(i);
    const double value = factors[i] * ValuesOf(one)[i];
    const double sd = factors[i] * SdsOf(one)[i];
    EXPECT_NEAR(ValuesOf(other)[i], value, 1e-10 * std::abs(value));
    EXPECT_NEAR(SdsOf(other)[i], sd, 1e-6 * sd);
  }
}

// --- Fits ---------------------------------------------------------------------------------------

TEST(YieldLocus, FitFindsAnExactLine) {
  const LinearLocus locus = FitLocus(PointsOnLine(250, 0.53));
  EXPECT_NEAR(locus.cohesion, 250, 1e-9);
  EXPECT_NEAR(locus.tan_phi, 0.53, 1e-13);
  EXPECT_NEAR(locus.r_squared, 1, 1e-13);
  EXPECT_NEAR(locus.residual_sd, 0, 1e-9);
  EXPECT_FALSE(locus.weighted);
}

// Anscombe (1973), The American Statistician 27:17, first set, with the figures that every package
// of statistics gives for it.
TEST(YieldLocus, FitWithoutSdsIsOrdinaryLeastSquares) {
  const std::vector<ShearPoint> points = {{10, 8.04},  {8, 6.95},  {13, 7.58}, {9, 8.81},
                                          {11, 8.33},  {14, 9.96}, {6, 7.24},  {4, 4.26},
                                          {12, 10.84}, {7, 4.82},  {5, 5.68}};
  const LinearLocus locus = FitLocus(points);
  EXPECT_NEAR(locus.cohesion, 3.00009, 1e-5);
  EXPECT_NEAR(locus.tan_phi, 0.500091, 1e-6);
  EXPECT_NEAR(std::sqrt(locus.cohesion_variance), 1.12475, 1e-5);
  EXPECT_NEAR(std::sqrt(locus.tan_phi_variance), 0.117906, 1e-6);
  EXPECT_NEAR(locus.covariance, -9 * locus.tan_phi_variance, 1e-12);
  EXPECT_NEAR(locus.residual_sd, 1.23660, 1e-5);
  EXPECT_NEAR(locus.r_squared, 0.666542, 1e-6);
}

TEST(YieldLocus, WeightedFitSolvesTheNormalEquations) {
  const std::vector<ShearPoint> points = {
      {1, 1.9, 0, 1}, {2, 3.2, 0, 0.5}, {4, 4.9, 0, 2}, {5, 6.3, 0, 1}};
  double s = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const ShearPoint& p : points) {
    const double w = 1 / (p.shear_sd * p.shear_sd);
    s += w, sx += w * p.normal, sy += w * p.shear;
    sxx += w * p.normal * p.normal, sxy += w * p.normal * p.shear;
  }
  const double determinant = s * sxx - sx * sx;
  const LinearLocus locus = FitLocus(points);
  EXPECT_TRUE(locus.weighted);
  EXPECT_NEAR(locus.tan_phi, (s * sxy - sx * sy) / determinant, 1e-13);
  EXPECT_NEAR(locus.cohesion, (sxx * sy - sx * sxy) / determinant, 1e-13);
  ASSERT_LT(locus.chi_squared, 2);
  EXPECT_NEAR(locus.tan_phi_variance, s / determinant, 1e-13);
  EXPECT_NEAR(locus.cohesion_variance, sxx / determinant, 1e-13);
  EXPECT_NEAR(locus.covariance, -sx / determinant, 1e-13);
}

// Pearson's data with York's weights; the solution as in York et al. (2004).
TEST(YieldLocus, FitWithErrorsInBothCoordinates) {
  const std::vector<double> x = {0.0, 0.9, 1.8, 2.6, 3.3, 4.4, 5.2, 6.1, 6.5, 7.4};
  const std::vector<double> y = {5.9, 5.4, 4.4, 4.6, 3.5, 3.7, 2.8, 2.8, 2.4, 1.5};
  const std::vector<double> wx = {1000, 1000, 500, 800, 200, 80, 60, 20, 1.8, 1.0};
  const std::vector<double> wy = {1, 1.8, 4, 8, 20, 20, 70, 70, 100, 500};
  std::vector<ShearPoint> points;
  for (std::size_t i = 0; i < x.size(); ++i) {
    points.push_back({x[i], y[i], 1 / std::sqrt(wx[i]), 1 / std::sqrt(wy[i])});
  }
  const LinearLocus locus = FitLocus(points);
  EXPECT_NEAR(locus.tan_phi, -0.480533, 1e-6);
  EXPECT_NEAR(locus.cohesion, 5.47991, 1e-5);
  EXPECT_NEAR(locus.chi_squared / 8, 1.48329, 1e-5);
  const double inflation = locus.chi_squared / 8;
  EXPECT_NEAR(std::sqrt(locus.tan_phi_variance / inflation), 0.0579850, 1e-6);
  EXPECT_NEAR(std::sqrt(locus.cohesion_variance / inflation), 0.294971, 1e-6);
}

TEST(YieldLocus, FitNeedsTwoNormalStresses) {
  EXPECT_THROW(FitLocus({}), InputError);
  EXPECT_THROW(FitLocus(std::vector<ShearPoint>{{1000, 600}, {1000, 620}}), InputError);
  EXPECT_THROW(FitLocus(std::vector<ShearPoint>{{1000, 600}, {2000, std::nan("")}}), InputError);
}

// --- Propagated variances -----------------------------------------------------------------------

// Spread of the figures over repeated noisy tests, as sds, against what one noiseless test states.
void ExpectSdsOfRepeatedTests(double cohesion, double margin, double sd, double tolerance) {
  constexpr int kRepeats = 20000;
  const double tan_phi = 0.55;
  const ShearPoint preshear{9000, cohesion + tan_phi * 9000 - margin, 0, sd};
  const LinearLocus exact = FitLocus(PointsOnLine(cohesion, tan_phi, sd));
  const StrengthFigures stated = EvaluateStrength(exact, preshear);
  std::vector<double> sums(10, 0);
  std::vector<double> squares(10, 0);
  RandomStream random(11);
  for (int i = 0; i < kRepeats; ++i) {
    std::vector<ShearPoint> points = PointsOnLine(cohesion, tan_phi, sd);
    for (ShearPoint& point : points) point.shear += sd * random.Normal();
    ShearPoint noisy = preshear;
    noisy.shear += sd * random.Normal();
    const std::vector<double> values = ValuesOf(EvaluateStrength(FitLocus(points), noisy));
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double deviation = values[k] - ValuesOf(stated)[k];
      sums[k] += deviation / kRepeats;
      squares[k] += deviation * deviation / kRepeats;
    }
  }
  for (std::size_t k = 0; k < sums.size(); ++k) {
    SCOPED_TRACE(testing::Message() << "figure " << k);
    const double spread = std::sqrt(squares[k] - sums[k] * sums[k]);
    EXPECT_NEAR(SdsOf(stated)[k], spread, tolerance * spread);
  }
}

TEST(YieldLocus, SdsMatchTheSpreadOfRepeatedTests) { ExpectSdsOfRepeatedTests(600, 300, 10, 0.03); }

TEST(YieldLocus, SdsHoldForAPreshearPointOnTheLocus) { ExpectSdsOfRepeatedTests(600, 0, 10, 0.05); }

TEST(YieldLocus, SdsHoldForAPreshearPointNearTheLocus) {
  ExpectSdsOfRepeatedTests(600, 15, 10, 0.05);
}

TEST(YieldLocus, SdsAreUnknownForTwoPointsWithoutSds) {
  const std::vector<ShearPoint> points = {{3000, 1800}, {7000, 4000}};
  const StrengthFigures figures = EvaluateStrength(points, {9000, 5000});
  EXPECT_THAT(KindsOf(figures), ElementsAre(Kind::too_few_points));
  for (const double sd : SdsOf(figures)) EXPECT_TRUE(std::isnan(sd));
  EXPECT_TRUE(std::isnan(FitLocus(points).residual_sd));
}

// --- Warnings -----------------------------------------------------------------------------------

TEST(YieldLocus, WithoutCohesionFlowFunctionIsInfinite) {
  for (const double cohesion : {-80.0, 0.0}) {
    const StrengthFigures figures =
        EvaluateStrength(PointsOnLine(cohesion, 0.5, 30), {9000, 4200, 0, 30});
    EXPECT_THAT(KindsOf(figures), ElementsAre(Kind::cohesion_not_positive));
    EXPECT_NEAR(figures.cohesion.value, cohesion, 1e-9);
    EXPECT_EQ(figures.unconfined_yield_strength.value, 0);
    EXPECT_TRUE(std::isinf(figures.flow_function_coefficient.value));
    EXPECT_TRUE(std::isinf(figures.flow_function_coefficient.sd));
    EXPECT_EQ(figures.inverse_flow_function.value, 0);
    EXPECT_TRUE(std::isfinite(figures.inverse_flow_function.sd));
    EXPECT_TRUE(std::isfinite(figures.major_principal_stress.value));
  }
}

TEST(YieldLocus, SaysWhenCohesionMayBeZero) {
  const StrengthFigures figures = EvaluateStrength(PointsOnLine(60, 0.5, 50), {9000, 4300});
  EXPECT_THAT(KindsOf(figures), ElementsAre(Kind::cohesion_not_significant));
  EXPECT_GT(figures.inverse_flow_function.sd, 0);
  EXPECT_THAT(figures.warnings[0].text, StartsWith("the cohesion of 60 Pa"));
}

TEST(YieldLocus, PreshearAboveTheLocusIsMovedOntoIt) {
  const std::vector<ShearPoint> points = PointsOnLine(300, 0.5, 10);
  const StrengthFigures above = EvaluateStrength(points, {9000, 4850, 0, 10});
  const StrengthFigures on = EvaluateStrength(points, {9000, 4800, 0, 10});
  EXPECT_THAT(KindsOf(above), ElementsAre(Kind::preshear_above_locus));
  EXPECT_THAT(above.warnings[0].text, HasSubstr("50 Pa above"));
  EXPECT_THAT(on.warnings, IsEmpty());
  EXPECT_NEAR(above.major_principal_stress.value, on.major_principal_stress.value, 0.1);
  EXPECT_NEAR(above.steady_tangent_stress, 9000, 0.1);
  EXPECT_NEAR(above.steady_state_angle.value, std::atan(4850.0 / 9000), 1e-12);
}

TEST(YieldLocus, FallingLocus) {
  const StrengthFigures figures = EvaluateStrength(PointsOnLine(3000, -0.1, 10), {9000, 2000});
  EXPECT_TRUE(figures.Has(Kind::friction_not_positive));
  const StrengthFigures flat = EvaluateStrength(PointsOnLine(3000, 0, 10), {9000, 2900});
  EXPECT_TRUE(flat.Has(Kind::friction_not_positive));
  EXPECT_NEAR(flat.unconfined_yield_strength.value, 6000, 1e-6);  // Tresca: twice the cohesion
}

TEST(YieldLocus, TensionAtSteadyState) {
  const StrengthFigures figures = EvaluateStrength(Line(2000, 0.3), {500, 1800});
  EXPECT_THAT(KindsOf(figures), ElementsAre(Kind::tension));
  EXPECT_LT(figures.minor_principal_stress.value, 0);
  EXPECT_NEAR(figures.effective_friction_angle.value, 90 * kDegree, 1e-12);
}

std::vector<ShearPoint> Bent(double curvature, double sd) {
  std::vector<ShearPoint> points = PointsOnLine(600, 0.5, sd);
  for (ShearPoint& point : points) {
    point.shear += curvature * std::pow((point.normal - 5000) / 2000, 2);
  }
  return points;
}

TEST(YieldLocus, CurvedLoci) {
  const ShearPoint preshear{9000, 4500};
  for (const double sd : {20.0, 0.0}) {  // given, and from the scatter: a parabola has none
    EXPECT_TRUE(EvaluateStrength(Bent(100, sd), preshear).Has(Kind::locus_not_concave));
    EXPECT_TRUE(EvaluateStrength(Bent(-100, sd), preshear).Has(Kind::locus_curved));
    EXPECT_THAT(EvaluateStrength(Bent(0, sd), preshear).warnings, IsEmpty());
  }
  EXPECT_THAT(EvaluateStrength(Bent(20, 20), preshear).warnings, IsEmpty());
}

TEST(YieldLocus, ScatterIsRarelyTakenForCurvature) {
  for (const bool known : {true, false}) {
    RandomStream random(5);
    int upwards = 0;
    int downwards = 0;
    constexpr int kRepeats = 4000;
    for (int i = 0; i < kRepeats; ++i) {
      std::vector<ShearPoint> points = PointsOnLine(900, 0.5, 20);
      for (ShearPoint& point : points) {
        point.shear += 20 * random.Normal();
        if (!known) point.shear_sd = 0;
      }
      const StrengthFigures figures = EvaluateStrength(points, {9000, 4500});
      upwards += figures.Has(Kind::locus_not_concave);
      downwards += figures.Has(Kind::locus_curved);
    }
    EXPECT_NEAR(upwards / double{kRepeats}, 0.025, 0.01);
    EXPECT_NEAR(downwards / double{kRepeats}, 0.025, 0.01);
  }
}

TEST(YieldLocus, PointsOutsideTheUsefulRange) {
  std::vector<ShearPoint> points = PointsOnLine(600, 0.5, 10);
  points.push_back({10000, 5600, 0, 10});
  points.push_back({400, 800, 0, 10});
  const StrengthFigures figures = EvaluateStrength(points, {9000, 4900});
  ASSERT_THAT(KindsOf(figures), ElementsAre(Kind::beyond_preshear, Kind::below_unconfined_circle));
  EXPECT_THAT(figures.warnings[0].text, StartsWith("points at 10 kPa are beyond"));
  EXPECT_THAT(figures.warnings[1].text, StartsWith("points at 400 Pa are left"));
}

TEST(YieldLocus, SomeSdsAreNone) {
  std::vector<ShearPoint> points = PointsOnLine(600, 0.5, 10);
  points[2].shear_sd = 0;
  EXPECT_TRUE(EvaluateStrength(points, {9000, 4900}).Has(Kind::sds_ignored));
  EXPECT_FALSE(FitLocus(points).weighted);
}

// --- Reading ------------------------------------------------------------------------------------

TEST(YieldLocus, ReadsATest) {
  const std::string path = testing::TempDir() + "yield_locus_test.csv";
  std::ofstream(path) << "# 9 kPa\n"
                         "normal_stress [kPa], shear_stress [Pa], shear_stress_sd [kPa], preshear\n"
                         "9, 4700, 0.1, 1\n"
                         "7, 4000, 0.05, 0\n"
                         "9, 4900, 0.1, 1\n"
                         "3, 2000, 0.05, 0\n";
  const ShearTest test = ReadYieldLocus(path);
  std::remove(path.c_str());
  ASSERT_EQ(test.points.size(), 2u);
  EXPECT_EQ(test.points[1].normal, 3000);
  EXPECT_EQ(test.points[1].shear, 2000);
  EXPECT_EQ(test.points[1].shear_sd, 50);
  EXPECT_EQ(test.points[1].normal_sd, 0);
  ASSERT_EQ(test.preshears.size(), 2u);
  const ShearPoint preshear = MeanPoint(test.preshears);
  EXPECT_EQ(preshear.normal, 9000);
  EXPECT_DOUBLE_EQ(preshear.shear, 4800);
  EXPECT_NEAR(preshear.shear_sd, 100, 1e-9);  // scatter; 100/sqrt(2) from the sds
}

TEST(YieldLocus, WithoutMarksEveryRowIsAPoint) {
  const ShearTest test =
      ParseYieldLocus("normal_stress [kPa],shear_stress [kPa]\n3,2\n5,3\n", "t.csv");
  EXPECT_EQ(test.points.size(), 2u);
  EXPECT_THAT(test.preshears, IsEmpty());
}

std::string MessageOf(const std::string& rows) {
  try {
    ParseYieldLocus(rows, "t.csv");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(YieldLocus, ErrorsSayWhere) {
  const std::string header = "normal_stress [kPa],shear_stress [kPa],preshear\n";
  EXPECT_THAT(MessageOf(header + "3,2,0\n5,-3,0\n"), StartsWith("t.csv:3"));
  EXPECT_THAT(MessageOf(header + "3,2,0\n5,3,0\n9,5,2\n"), StartsWith("t.csv:4"));
  EXPECT_THAT(MessageOf(header + "3,2,0\n5,3,0\n0,5,1\n"), StartsWith("t.csv:4"));
  EXPECT_THAT(MessageOf(header + "3,2,0\n3,3,0\n9,5,1\n"), HasSubstr("distinct normal stresses"));
  EXPECT_THAT(MessageOf("normal_stress [kPa],shear_stres [kPa]\n3,2\n"),
              HasSubstr("did you mean 'shear_stress'"));
  EXPECT_THAT(MessageOf("normal_stress [kPa]\n3\n"), HasSubstr("shear_stress"));
  EXPECT_THAT(MessageOf("normal_stress [kPa],shear_stress [m]\n3,2\n"), HasSubstr("pressure"));
}

}  // namespace
}  // namespace powdercal

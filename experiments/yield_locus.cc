#include "experiments/yield_locus.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>
#include <utility>

#include "core/errors.h"
#include "core/quantity.h"
#include "core/random.h"
#include "core/table.h"

namespace powdercal {
namespace {

using Kind = ShearWarning::Kind;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-9;  // relative; smaller differences are rounding

double Square(double x) { return x * x; }

std::string Pascals(double stress) { return HumanQuantity(stress, "Pa"); }

bool AllHaveShearSd(std::span<const ShearPoint> points) {
  return std::all_of(points.begin(), points.end(),
                     [](const ShearPoint& point) { return point.shear_sd > 0; });
}

std::size_t CountDistinctNormals(std::span<const ShearPoint> points) {
  std::vector<double> normals;
  for (const ShearPoint& point : points) normals.push_back(point.normal);
  std::sort(normals.begin(), normals.end());
  return static_cast<std::size_t>(std::unique(normals.begin(), normals.end()) - normals.begin());
}

// One sweep of York's iteration for the slope, and what its standard errors need.
class YorkLine {
 public:
  YorkLine(std::span<const ShearPoint> points, double slope) {
    for (const ShearPoint& point : points) {
      weights_.push_back(1 / (Square(point.shear_sd) + Square(slope * point.normal_sd)));
      weight_ += weights_.back();
      mean_normal_ += weights_.back() * point.normal;
      mean_shear_ += weights_.back() * point.shear;
    }
    mean_normal_ /= weight_;
    mean_shear_ /= weight_;
    double numerator = 0;
    double denominator = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double u = points[i].normal - mean_normal_;
      const double v = points[i].shear - mean_shear_;
      const double beta =
          weights_[i] * (u * Square(points[i].shear_sd) + slope * v * Square(points[i].normal_sd));
      betas_.push_back(beta);
      numerator += weights_[i] * beta * v;
      denominator += weights_[i] * beta * u;
    }
    slope_ = numerator / denominator;
  }

  double slope() const { return slope_; }
  double intercept() const { return mean_shear_ - slope_ * mean_normal_; }

  void FillIn(std::span<const ShearPoint> points, LinearLocus* locus) const {
    locus->tan_phi = slope_;
    locus->cohesion = intercept();
    double mean_beta = 0;
    for (std::size_t i = 0; i < betas_.size(); ++i) mean_beta += weights_[i] * betas_[i] / weight_;
    double spread = 0;
    double total = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      spread += weights_[i] * Square(betas_[i] - mean_beta);
      total += weights_[i] * Square(points[i].shear - mean_shear_);
      locus->chi_squared +=
          weights_[i] * Square(points[i].shear - locus->ShearAt(points[i].normal));
    }
    const double mean = mean_normal_ + mean_beta;
    locus->tan_phi_variance = 1 / spread;
    locus->cohesion_variance = 1 / weight_ + Square(mean) / spread;
    locus->covariance = -mean / spread;
    locus->r_squared = total > 0 ? 1 - locus->chi_squared / total : 0;
  }

 private:
  std::vector<double> weights_;
  std::vector<double> betas_;
  double weight_ = 0;
  double mean_normal_ = 0;
  double mean_shear_ = 0;
  double slope_ = 0;
};

void ScaleCovariance(double factor, LinearLocus* locus) {
  locus->cohesion_variance *= factor;
  locus->tan_phi_variance *= factor;
  locus->covariance *= factor;
}

void CheckPoints(std::span<const ShearPoint> points) {
  for (const ShearPoint& point : points) {
    for (const double value : {point.normal, point.shear, point.normal_sd, point.shear_sd}) {
      if (!std::isfinite(value)) throw InputError("a point of the yield locus is not finite");
    }
    assert(point.normal_sd >= 0 && point.shear_sd >= 0);
  }
  if (CountDistinctNormals(points) < 2) {
    throw InputError("a yield locus needs points at two or more distinct normal stresses");
  }
}

// --- Figures ------------------------------------------------------------------------------------

enum Input { kCohesion, kTanPhi, kNormal, kShear };
using Inputs = std::array<double, 4>;
using Matrix = std::array<Inputs, 4>;

// How far the locus is above the preshear point.
double Margin(const Inputs& x) { return x[kCohesion] + x[kTanPhi] * x[kNormal] - x[kShear]; }

// Magnitude of the stresses, to tell rounding from a value.
double StressScale(const Inputs& x) {
  return std::max({std::abs(x[kCohesion]), std::abs(x[kTanPhi] * x[kNormal]), x[kShear]});
}

struct Circle {
  double centre = 0;
  double radius = 0;
};

// Eliminating the radius from R² = (sigma_p − m)² + tau_p² and R q = c + t m, with t = tan(phi) and
// q² = 1 + t², leaves a quadratic in the centre m with this as its smaller root. Unlike the usual
// form it needs no cot(phi).
Circle SteadyCircle(const Inputs& x) {
  const double c = x[kCohesion];
  const double t = x[kTanPhi];
  const double q_squared = 1 + t * t;
  const double margin = std::max(0.0, Margin(x));
  const double locus = c + t * x[kNormal];
  const double root = std::sqrt(std::max(0.0, q_squared * margin * (2 * locus - margin)));
  const double centre = x[kNormal] * q_squared + c * t - root;
  return {centre, (c + t * centre) / std::sqrt(q_squared)};
}

constexpr std::array kFigures = {
    &StrengthFigures::cohesion,
    &StrengthFigures::tan_phi,
    &StrengthFigures::phi,
    &StrengthFigures::unconfined_yield_strength,
    &StrengthFigures::major_principal_stress,
    &StrengthFigures::minor_principal_stress,
    &StrengthFigures::flow_function_coefficient,
    &StrengthFigures::inverse_flow_function,
    &StrengthFigures::effective_friction_angle,
    &StrengthFigures::steady_state_angle,
};

StrengthFigures EvaluateAt(const Inputs& x) {
  const double c = x[kCohesion] > kRounding * StressScale(x) ? x[kCohesion] : 0;
  const double t = x[kTanPhi];
  const double q = std::sqrt(1 + t * t);
  const Circle circle = SteadyCircle(x);
  const double major = circle.centre + circle.radius;
  const double strength = 2 * c * (t + q);
  StrengthFigures figures;
  figures.cohesion.value = x[kCohesion];
  figures.tan_phi.value = t;
  figures.phi.value = std::atan(t);
  figures.unconfined_yield_strength.value = strength;
  figures.major_principal_stress.value = major;
  figures.minor_principal_stress.value = circle.centre - circle.radius;
  figures.flow_function_coefficient.value = strength > 0 ? major / strength : kInfinity;
  figures.inverse_flow_function.value = strength / major;
  figures.effective_friction_angle.value = circle.centre > circle.radius
                                               ? std::asin(circle.radius / circle.centre)
                                               : std::numbers::pi / 2;
  figures.steady_state_angle.value = std::atan2(x[kShear], x[kNormal]);
  figures.steady_tangent_stress = circle.centre - circle.radius * t / q;
  figures.unconfined_tangent_stress = c / q;
  return figures;
}

// Columns whose outer products add up to the covariance: the first along the change of the margin,
// the one quantity in which the figures bend sharply, the others without influence on it.
std::array<Inputs, 5> Factorise(const Inputs& x, Matrix covariance) {
  std::array<Inputs, 5> columns{};
  const Inputs gradient = {1, x[kNormal], x[kTanPhi], -1};
  double variance = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      columns[0][i] += covariance[i][j] * gradient[j];
      variance += gradient[i] * covariance[i][j] * gradient[j];
    }
  }
  for (double& entry : columns[0]) entry = variance > 0 ? entry / std::sqrt(variance) : 0;
  const Matrix whole = covariance;
  const auto remove = [&covariance](const Inputs& column) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) covariance[i][j] -= column[i] * column[j];
    }
  };
  remove(columns[0]);
  for (std::size_t k = 0; k < 4; ++k) {
    if (!(covariance[k][k] > kRounding * whole[k][k])) continue;
    for (std::size_t i = k; i < 4; ++i) {
      columns[k + 1][i] = covariance[i][k] / std::sqrt(covariance[k][k]);
    }
    remove(columns[k + 1]);
  }
  return columns;
}

// Equally likely values of a standard normal variable, with variance 1.
std::vector<double> NormalValues() {
  constexpr int kCount = 32;
  std::vector<double> values;
  double squares = 0;
  for (int i = 0; i < kCount; ++i) {
    values.push_back(NormalQuantile((i + 0.5) / kCount));
    squares += Square(values.back()) / kCount;
  }
  for (double& value : values) value /= std::sqrt(squares);
  return values;
}

void Propagate(const Inputs& x, const Matrix& covariance, StrengthFigures* figures) {
  const std::vector<double> steps = NormalValues();
  const auto count = static_cast<double>(steps.size());
  for (const Inputs& column : Factorise(x, covariance)) {
    std::vector<StrengthFigures> varied;
    for (const double step : steps) {
      Inputs inputs = x;
      for (std::size_t i = 0; i < 4; ++i) inputs[i] += step * column[i];
      varied.push_back(EvaluateAt(inputs));
    }
    for (const auto figure : kFigures) {
      double mean = 0;
      double variance = 0;
      for (const StrengthFigures& one : varied) mean += (one.*figure).value / count;
      for (const StrengthFigures& one : varied) {
        variance += Square((one.*figure).value - mean) / count;
      }
      (figures->*figure).sd = std::hypot((figures->*figure).sd, std::sqrt(variance));
    }
  }
  for (const auto figure : kFigures) {
    Estimate& estimate = figures->*figure;
    if (!std::isfinite(estimate.value) || !std::isfinite(estimate.sd)) estimate.sd = kInfinity;
  }
}

// --- Warnings -----------------------------------------------------------------------------------

void WarnOfLocus(const LinearLocus& locus, StrengthFigures* figures) {
  const double c = locus.cohesion;
  const double error = std::sqrt(locus.cohesion_variance);
  const auto warn = [figures](Kind kind, std::string text) {
    figures->warnings.push_back({kind, std::move(text)});
  };
  if (!(figures->unconfined_yield_strength.value > 0)) {
    warn(Kind::cohesion_not_positive,
         fmt::format("the locus has no cohesion (c = {}): the unconfined yield strength is taken "
                     "as 0 and ffc as infinite",
                     Pascals(c)));
  } else if (c < 2 * error) {
    warn(
        Kind::cohesion_not_significant,
        fmt::format("the cohesion of {} is within two standard errors ({} each) of 0: ffc = {:.3g} "
                    "is hardly more than a lower bound",
                    Pascals(c), Pascals(error), figures->flow_function_coefficient.value));
  }
  if (locus.tan_phi <= 0) {
    warn(Kind::friction_not_positive,
         fmt::format("the shear stress does not rise with the normal stress (tan phi = {:.3g}): "
                     "the figures have no meaning",
                     locus.tan_phi));
  }
}

void WarnOfPreshear(const Inputs& x, const Matrix& covariance, StrengthFigures* figures) {
  const double margin = Margin(x);
  if (margin < -kRounding * StressScale(x)) {
    double variance = 0;
    const Inputs gradient = {1, x[kNormal], x[kTanPhi], -1};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) variance += gradient[i] * covariance[i][j] * gradient[j];
    }
    std::string text = fmt::format("the preshear point lies {} above the locus", Pascals(-margin));
    if (variance > 0)
      text += fmt::format(" ({:.1f} standard deviations)", -margin / std::sqrt(variance));
    text +=
        fmt::format(", where no Mohr circle exists: the locus' own shear stress at {}, {}, is used",
                    Pascals(x[kNormal]), Pascals(x[kShear] + margin));
    figures->warnings.push_back({Kind::preshear_above_locus, std::move(text)});
  }
  const double minor = figures->minor_principal_stress.value;
  if (minor < 0) {
    figures->warnings.push_back(
        {Kind::tension,
         fmt::format("the minor principal stress of steady state is negative ({}): delta is not "
                     "defined and given as 90 degrees",
                     Pascals(minor))});
  }
}

// Two-sided 95 % point of Student's t.
double StudentPoint(int freedom) {
  constexpr std::array kPoints = {12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.23};
  const auto index = static_cast<std::size_t>(freedom - 1);
  return index < kPoints.size() ? kPoints[index] : 1.96 + 2.6 / freedom;
}

// The coefficient of the second orthogonal polynomial, in shear stress at its largest value. It is
// never positive for concave points.
struct Curvature {
  double value = 0;  // [Pa]
  bool significant = false;
};

Curvature MeasureCurvature(std::span<const ShearPoint> points, const LinearLocus& locus) {
  const std::size_t n = points.size();
  std::vector<ShearPoint> squares;  // of the normal stress about the middle, over the normal stress
  double middle = 0;
  for (const ShearPoint& point : points) middle += point.normal / static_cast<double>(n);
  for (const ShearPoint& point : points) {
    const double sd =
        locus.weighted ? std::hypot(point.shear_sd, locus.tan_phi * point.normal_sd) : 1;
    squares.push_back({point.normal, Square(point.normal - middle), 0, sd});
  }
  const LinearLocus trend = FitLocus(squares);
  double information = 0;
  double sum = 0;
  double largest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double p = squares[i].shear - trend.ShearAt(points[i].normal);
    const double weight = 1 / Square(squares[i].shear_sd);
    information += weight * p * p;
    sum += weight * p * (points[i].shear - locus.ShearAt(points[i].normal));
    largest = std::max(largest, std::abs(p));
  }
  const double coefficient = sum / information;
  double remaining = 0;
  double scale = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double p = squares[i].shear - trend.ShearAt(points[i].normal);
    const double residual = points[i].shear - locus.ShearAt(points[i].normal) - coefficient * p;
    remaining += Square(residual / squares[i].shear_sd);
    scale = std::max(scale, std::abs(points[i].shear));
  }
  const int freedom = static_cast<int>(n) - 3;
  double limit = 1.96;
  if (!locus.weighted) {
    if (freedom < 1) return {coefficient * largest, false};
    limit = StudentPoint(freedom) * std::sqrt(remaining / freedom);
  }
  const double value = coefficient * largest;
  return {value, std::abs(value) > kRounding * scale &&
                     std::abs(coefficient) > limit / std::sqrt(information)};
}

std::string ListNormals(std::span<const ShearPoint> points, double from, double to) {
  std::vector<std::string> list;
  for (const ShearPoint& point : points) {
    if (point.normal > from && point.normal < to) list.push_back(Pascals(point.normal));
  }
  return JoinNames(list);
}

void WarnOfPoints(std::span<const ShearPoint> points, const LinearLocus& locus, double preshear,
                  StrengthFigures* figures) {
  const auto warn = [figures](Kind kind, std::string text) {
    figures->warnings.push_back({kind, std::move(text)});
  };
  const bool any_sd = std::any_of(points.begin(), points.end(), [](const ShearPoint& point) {
    return point.shear_sd > 0 || point.normal_sd > 0;
  });
  if (any_sd && !locus.weighted) {
    warn(Kind::sds_ignored,
         "not every point has a standard deviation of its shear stress: all are ignored, the "
         "points weigh the same");
  }
  if (CountDistinctNormals(points) < 3) {
    warn(Kind::too_few_points,
         "only two distinct normal stresses: nothing tells whether the locus is a line");
  } else if (const Curvature curvature = MeasureCurvature(points, locus); curvature.significant) {
    const std::string size = Pascals(std::abs(curvature.value));
    if (curvature.value > 0) {
      warn(Kind::locus_not_concave,
           fmt::format("the points curve upwards by {}, significantly: a yield locus is concave",
                       size));
    } else {
      warn(Kind::locus_curved,
           fmt::format("the points curve downwards by {}, significantly: the line overestimates "
                       "the cohesion",
                       size));
    }
  }
  const std::string beyond = ListNormals(points, preshear * (1 + kRounding), kInfinity);
  if (!beyond.empty()) {
    warn(Kind::beyond_preshear,
         fmt::format("points at {} are beyond the preshear's normal stress, {}, and do not belong "
                     "to its state of consolidation",
                     beyond, Pascals(preshear)));
  }
  const double touch = figures->unconfined_tangent_stress;
  const std::string below = ListNormals(points, -kInfinity, touch * (1 - kRounding));
  if (!below.empty()) {
    warn(Kind::below_unconfined_circle,
         fmt::format("points at {} are left of where the circle of the unconfined yield strength "
                     "touches the locus ({}); customarily they are left out",
                     below, Pascals(touch)));
  }
}

// --- Reading ------------------------------------------------------------------------------------

constexpr std::array<std::string_view, 5> kColumns = {
    "normal_stress", "shear_stress", "normal_stress_sd", "shear_stress_sd", "preshear"};

std::vector<double> ReadColumn(const Table& table, std::string_view name, bool required) {
  if (!required && !table.Has(name)) return std::vector<double>(table.row_count(), 0);
  std::vector<double> values = table.Get(name, name == "preshear" ? "1" : "Pa").values;
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (values[row] >= 0) continue;
    throw InputError("a negative value", {.location = {table.file(), table.line_of_row(row)},
                                          .key = std::string(name),
                                          .value = fmt::format("{:g}", values[row])});
  }
  return values;
}

ShearTest FromTable(const Table& table) {
  const std::vector<std::string> valid(kColumns.begin(), kColumns.end());
  for (const std::string& name : table.column_names()) {
    if (std::find(valid.begin(), valid.end(), name) == valid.end()) {
      throw UnknownName("column", name, valid, {.location = {table.file()}});
    }
  }
  const std::vector<double> normal = ReadColumn(table, "normal_stress", true);
  const std::vector<double> shear = ReadColumn(table, "shear_stress", true);
  const std::vector<double> normal_sd = ReadColumn(table, "normal_stress_sd", false);
  const std::vector<double> shear_sd = ReadColumn(table, "shear_stress_sd", false);
  const std::vector<double> preshear = ReadColumn(table, "preshear", false);
  ShearTest test;
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    const SourceLocation location = {table.file(), table.line_of_row(row)};
    if (preshear[row] != 0 && preshear[row] != 1) {
      throw InputError(
          "expected 1 (a preshear) or 0 (a point of the locus)",
          {.location = location, .key = "preshear", .value = fmt::format("{:g}", preshear[row])});
    }
    if (preshear[row] == 1 && !(normal[row] > 0)) {
      throw InputError("a preshear without normal stress",
                       {.location = location, .key = "normal_stress", .value = "0"});
    }
    (preshear[row] == 1 ? test.preshears : test.points)
        .push_back({normal[row], shear[row], normal_sd[row], shear_sd[row]});
  }
  if (CountDistinctNormals(test.points) < 2) {
    throw InputError("a yield locus needs points at two or more distinct normal stresses",
                     {.location = {table.file(), table.line_of_row(table.row_count() - 1)}});
  }
  return test;
}

}  // namespace

LinearLocus FitLocus(std::span<const ShearPoint> points) {
  CheckPoints(points);
  LinearLocus locus;
  locus.points = static_cast<int>(points.size());
  locus.weighted = AllHaveShearSd(points);
  std::vector<ShearPoint> unweighted(points.begin(), points.end());
  for (ShearPoint& point : unweighted) {
    point.normal_sd = 0;
    point.shear_sd = 1;
  }
  const std::span<const ShearPoint> used = locus.weighted ? points : unweighted;
  double slope = YorkLine(unweighted, 0).slope();
  constexpr int kSweeps = 200;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const double next = YorkLine(used, slope).slope();
    const bool converged = std::abs(next - slope) <= 1e-15 * std::abs(next);
    slope = next;
    if (converged) break;
  }
  YorkLine(used, slope).FillIn(used, &locus);
  double squares = 0;
  for (const ShearPoint& point : points)
    squares += Square(point.shear - locus.ShearAt(point.normal));
  const int freedom = locus.points - 2;
  locus.residual_sd = freedom > 0 ? std::sqrt(squares / freedom) : kNan;
  if (locus.weighted) {
    if (freedom > 0) ScaleCovariance(std::max(1.0, locus.chi_squared / freedom), &locus);
  } else {
    ScaleCovariance(Square(locus.residual_sd), &locus);
    locus.chi_squared = 0;
  }
  return locus;
}

bool StrengthFigures::Has(ShearWarning::Kind kind) const {
  return std::any_of(warnings.begin(), warnings.end(),
                     [kind](const ShearWarning& warning) { return warning.kind == kind; });
}

StrengthFigures EvaluateStrength(const LinearLocus& locus, const ShearPoint& preshear) {
  assert(preshear.normal > 0 && std::isfinite(preshear.normal));
  assert(preshear.shear >= 0 && std::isfinite(preshear.shear));
  const Inputs x = {locus.cohesion, locus.tan_phi, preshear.normal, preshear.shear};
  Matrix covariance{};
  covariance[kCohesion][kCohesion] = locus.cohesion_variance;
  covariance[kTanPhi][kTanPhi] = locus.tan_phi_variance;
  covariance[kCohesion][kTanPhi] = covariance[kTanPhi][kCohesion] = locus.covariance;
  covariance[kNormal][kNormal] = Square(preshear.normal_sd);
  covariance[kShear][kShear] = Square(preshear.shear_sd);
  StrengthFigures figures = EvaluateAt(x);
  if (std::isnan(locus.cohesion_variance)) {
    for (const auto figure : kFigures) (figures.*figure).sd = kNan;
  } else {
    Propagate(x, covariance, &figures);
  }
  WarnOfLocus(locus, &figures);
  WarnOfPreshear(x, covariance, &figures);
  return figures;
}

StrengthFigures EvaluateStrength(std::span<const ShearPoint> points, const ShearPoint& preshear) {
  const LinearLocus locus = FitLocus(points);
  StrengthFigures figures = EvaluateStrength(locus, preshear);
  WarnOfPoints(points, locus, preshear.normal, &figures);
  return figures;
}

ShearTest ReadYieldLocus(const std::string& path) { return FromTable(Table::ReadCsv(path)); }

ShearTest ParseYieldLocus(const std::string& text, const std::string& file) {
  return FromTable(Table::ParseCsv(text, file));
}

ShearPoint MeanPoint(std::span<const ShearPoint> points) {
  assert(!points.empty());
  const auto n = static_cast<double>(points.size());
  const auto mean = [&](double ShearPoint::*value, double ShearPoint::*sd) {
    double sum = 0;
    double variance = 0;
    for (const ShearPoint& point : points) {
      sum += point.*value / n;
      variance += Square(point.*sd / n);
    }
    double scatter = 0;
    for (const ShearPoint& point : points) scatter += Square(point.*value - sum);
    if (points.size() > 1) variance = std::max(variance, scatter / (n * (n - 1)));
    return std::pair(sum, std::sqrt(variance));
  };
  const auto [normal, normal_sd] = mean(&ShearPoint::normal, &ShearPoint::normal_sd);
  const auto [shear, shear_sd] = mean(&ShearPoint::shear, &ShearPoint::shear_sd);
  return {normal, shear, normal_sd, shear_sd};
}

}  // namespace powdercal

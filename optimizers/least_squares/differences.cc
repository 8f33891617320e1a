#include "optimizers/least_squares/differences.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace powdercal {
namespace {

// A response that varies by its standard deviation S as A sin(x/l), A = √2 S, with l = 0.3.
constexpr double kCurvatureOfSpread = 1.41421356 / (0.3 * 0.3);

// Where column k is evaluated: x + offsets[i] e_k. One offset h: (f(h) − f(0))/h. Two, a and b:
// the slope of the parabola through both and 0.
struct Column {
  std::vector<double> offsets;
  std::vector<Eigen::VectorXd> residuals;  // empty entries: failed
};

Column Plan(double x, double h, Scheme scheme) {
  const double inward = x + h <= 1 ? h : -h;
  if (scheme == Scheme::one_sided) return {{inward}, {}};
  if (x + h <= 1 && x - h >= 0) return {{h, -h}, {}};
  return {{inward, 2 * inward}, {}};
}

bool Ask(const Eigen::VectorXd& x, const std::vector<std::string>& symbols,
         const Residuals& residuals, const EvaluateBatch& evaluate, std::vector<Column>* columns) {
  std::vector<Eigen::VectorXd> points;
  std::vector<std::string> origins;
  for (std::size_t k = 0; k < columns->size(); ++k) {
    for (const double offset : (*columns)[k].offsets) {
      Eigen::VectorXd point = x;
      double& coordinate = point[static_cast<Eigen::Index>(k)];
      coordinate = std::clamp(coordinate + offset, 0.0, 1.0);
      points.push_back(std::move(point));
      origins.push_back(fmt::format("stencil of {}", symbols[k]));
    }
  }
  if (points.empty()) return true;
  const auto answers = evaluate(points, origins);
  if (!answers) return false;
  std::size_t next = 0;
  for (std::size_t k = 0; k < columns->size(); ++k) {
    for (double& offset : (*columns)[k].offsets) {
      const Observation& answer = (*answers)[next];
      // The step as it came out after rounding.
      const auto row = static_cast<Eigen::Index>(k);
      offset = points[next][row] - x[row];
      (*columns)[k].residuals.push_back(residuals.Complete(answer) ? residuals.Of(answer)
                                                                   : Eigen::VectorXd());
      ++next;
    }
  }
  return true;
}

// Derivative, and curvature where there are two points. False: all have failed.
bool Derive(const Column& column, const Eigen::VectorXd& at_x, Eigen::VectorXd* derivative,
            double* curvature, double* step) {
  std::vector<double> offsets;
  std::vector<Eigen::VectorXd> slopes;
  for (std::size_t i = 0; i < column.residuals.size(); ++i) {
    if (column.residuals[i].size() == 0) continue;
    offsets.push_back(column.offsets[i]);
    slopes.push_back((column.residuals[i] - at_x) / column.offsets[i]);
  }
  if (slopes.empty()) return false;
  *derivative = slopes[0];
  *step = std::abs(offsets[0]);
  *curvature = 0;
  if (slopes.size() == 2) {
    const Eigen::VectorXd second = (slopes[1] - slopes[0]) / (offsets[1] - offsets[0]);
    *derivative -= offsets[0] * second;
    *curvature = 2 * second.norm();
  }
  return true;
}

// The other side for each column without any value, one-sided; as much of it as the box leaves.
std::vector<Column> OtherSides(const Eigen::VectorXd& x, const std::vector<Column>& columns) {
  std::vector<Column> others(columns.size());
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const Column& column = columns[k];
    const bool failed =
        std::all_of(column.residuals.begin(), column.residuals.end(),
                    [](const Eigen::VectorXd& residual) { return residual.size() == 0; });
    if (!failed || column.offsets.empty()) continue;
    const double coordinate = x[static_cast<Eigen::Index>(k)];
    const double first = column.offsets[0];
    // With both sides tried, a shorter step is what is left.
    const bool both = column.offsets.size() == 2 && first * column.offsets[1] < 0;
    const double wanted = both ? first / 4 : -first;
    const double offset = std::clamp(coordinate + wanted, 0.0, 1.0) - coordinate;
    others[k].offsets = {offset != 0 ? offset : first / 4};
  }
  return others;
}

}  // namespace

StepRule::StepRule(const Residuals& residuals, const ObservationsById& observations, int dimension,
                   double precision) {
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(residuals.size());
  Eigen::ArrayXd squares = sum;
  Eigen::ArrayXd largest = sum;
  double count = 0;
  for (const auto& [id, observation] : observations) {
    if (!residuals.Complete(observation)) continue;
    const Eigen::ArrayXd rho = residuals.Of(observation).array();
    sum += rho;
    squares += rho.square();
    largest = largest.max((rho + residuals.targets.array() / residuals.scales.array()).abs());
    ++count;
  }
  double digits = 0;
  if (count > 0) {
    spread = std::sqrt((squares - sum.square() / count).max(0).sum() / std::max(count - 1, 1.0));
    digits = precision * largest.matrix().norm();
  }
  // One point, or all alike: their distance from the targets is the only scale.
  if (!(spread > 0) && count > 0) spread = std::sqrt(squares.sum() / count);
  if (!(spread > 0)) spread = 1;
  noise = residuals.noise.norm();
  noisy = noise > digits;
  if (!noisy) noise = std::max(digits, 1e-300);
  curvature = Eigen::ArrayXd::Constant(dimension, kCurvatureOfSpread * spread);
}

double StepRule::OneSided(Eigen::Index parameter) const {
  if (fixed) return *fixed;
  return std::clamp(std::pow(8, 0.25) * std::sqrt(noise / curvature[parameter]), 1e-8, 0.2);
}

double StepRule::Central(Eigen::Index parameter) const {
  if (fixed) return *fixed;
  const double length = std::sqrt(1.41421356 * spread / curvature[parameter]);
  return std::clamp(std::cbrt(3 * noise * length / curvature[parameter]), 1e-7, 0.2);
}

double DifferenceJacobian::Noise(Eigen::Index parameter) const {
  return (scheme == Scheme::central ? std::sqrt(0.5) : std::sqrt(2.0)) / steps[parameter];
}

std::optional<DifferenceJacobian> Differences(const Eigen::VectorXd& x,
                                              const Eigen::VectorXd& residuals_at_x, Scheme scheme,
                                              const Eigen::ArrayXd& steps,
                                              const Residuals& residuals,
                                              const std::vector<std::string>& symbols,
                                              const EvaluateBatch& evaluate) {
  std::vector<Column> columns;
  for (Eigen::Index k = 0; k < x.size(); ++k) columns.push_back(Plan(x[k], steps[k], scheme));
  if (!Ask(x, symbols, residuals, evaluate, &columns)) return std::nullopt;
  std::vector<Column> others = OtherSides(x, columns);
  if (!Ask(x, symbols, residuals, evaluate, &others)) return std::nullopt;

  DifferenceJacobian jacobian{.values = Eigen::MatrixXd::Zero(residuals.size(), x.size()),
                              .steps = steps,
                              .scheme = scheme,
                              .dropped = {},
                              .curvature = {}};
  if (scheme == Scheme::central) jacobian.curvature = Eigen::ArrayXd::Zero(x.size());
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    Eigen::VectorXd derivative;
    double curvature = 0;
    double step = 0;
    if (!Derive(columns[index], residuals_at_x, &derivative, &curvature, &step) &&
        !Derive(others[index], residuals_at_x, &derivative, &curvature, &step)) {
      jacobian.dropped.push_back(k);
      continue;
    }
    jacobian.values.col(k) = derivative;
    jacobian.steps[k] = step;
    if (scheme == Scheme::central) jacobian.curvature[k] = curvature;
  }
  return jacobian;
}

}  // namespace powdercal

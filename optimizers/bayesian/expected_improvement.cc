#include "optimizers/bayesian/expected_improvement.h"

#include <cassert>
#include <cmath>
#include <complex>
#include <numbers>

namespace powdercal {
namespace {

// T of the continued fraction of Mills' ratio, Φ(−x)/φ(x) = 1/(x + T), T = 1/(x + 2/(x + 3/(x +
// …))).
double MillsTail(double x) {
  double tail = 0;
  for (int k = 80; k >= 1; --k) tail = k / (x + tail);
  return tail;
}

using Complex = std::complex<double>;

constexpr double kStep = 0.45;      // of the trapezoidal rule, in units of the saddle's width
constexpr double kNegligible = 36;  // exp(−36) = 2e-16
constexpr int kMaxNodes = 400;
constexpr int kMaxAttempts = 6;

struct Terms {
  double best;
  Eigen::ArrayXd squares;  // w δ²
  Eigen::ArrayXd scales;   // w v
};

// K(θ) − θ best − 2 ln(−θ), the logarithm of the integrand.
Complex Exponent(const Complex& theta, const Terms& terms) {
  Complex fractions = 0;
  Complex logs = 0;  // one by one: each D lies in the lower half plane, their product need not
  for (Eigen::Index j = 0; j < terms.scales.size(); ++j) {
    const Complex d = 1.0 - 2.0 * theta * terms.scales[j];
    fractions += terms.squares[j] / d;
    logs += std::log(d);
  }
  return theta * (fractions - terms.best) - 0.5 * logs - 2.0 * std::log(-theta);
}

// The same and its derivatives at θ = −p on the real axis.
struct Saddle {
  double value = 0;   // K(θ) − θ best − 2 ln(−θ)
  double second = 0;  // derivatives by θ
  double third = 0;
};

Saddle EvaluateSaddle(double p, const Terms& terms) {
  const auto& [best, squares, scales] = terms;
  const Eigen::ArrayXd d = 1 + 2 * p * scales;
  Saddle saddle;
  saddle.value = p * best - 2 * std::log(p) - (p * squares / d).sum() - 0.5 * d.log().sum();
  saddle.second =
      2 / (p * p) + (4 * squares * scales / d.cube() + 2 * scales.square() / d.square()).sum();
  saddle.third =
      4 / (p * p * p) +
      (24 * squares * scales.square() / d.square().square() + 8 * scales.cube() / d.cube()).sum();
  return saddle;
}

// The p > 0 where best = K'(−p) + 2/p; the right-hand side falls from ∞ to 0, so there is just one.
double SaddlePoint(const Terms& terms) {
  const auto excess = [&squares = terms.squares, &scales = terms.scales, best = terms.best](
                          double p, double* slope) {
    const Eigen::ArrayXd d = 1 + 2 * p * scales;
    const double second =
        2 / (p * p) + (4 * squares * scales / d.cube() + 2 * scales.square() / d.square()).sum();
    *slope = -second * p;  // by ln p
    return 2 / p + (squares / d.square() + scales / d).sum() - best;
  };
  double slope = 0;
  double low = -std::log(terms.best);  // the excess is positive here
  double high = low + 1;
  while (excess(std::exp(high), &slope) > 0) high += std::max(1.0, high - low);
  double log_p = 0.5 * (low + high);
  for (int i = 0; i < 100 && high - low > 1e-7; ++i) {
    const double value = excess(std::exp(log_p), &slope);
    (value > 0 ? low : high) = log_p;
    const double step = -value / slope;
    log_p += step;
    if (!(log_p > low && log_p < high)) {
      log_p = 0.5 * (low + high);
    } else if (std::abs(step) < 1e-7) {
      break;
    }
  }
  return std::exp(log_p);
}

}  // namespace

LogImprovement LogExpectedImprovement(double best, double mean, double variance) {
  assert(variance > 0);
  const double sd = std::sqrt(variance);
  const double u = (best - mean) / sd;
  // h(u) = u Φ(u) + φ(u), E = sd h(u).
  double log_h = 0;
  double slope = 0;  // d ln h / du = Φ / h
  if (u > -2) {
    const double density = std::exp(-0.5 * u * u) / std::sqrt(2 * std::numbers::pi);
    const double cdf = 0.5 * std::erfc(-u / std::numbers::sqrt2);
    const double h = u * cdf + density;
    log_h = std::log(h);
    slope = cdf / h;
  } else {
    // h(−x) = φ(x) (1 − x R(x)) = φ(x) T / (x + T), without cancellation.
    const double x = -u;
    const double tail = MillsTail(x);
    log_h = -0.5 * x * x - 0.5 * std::log(2 * std::numbers::pi) + std::log(tail / (x + tail));
    slope = 1 / tail;
  }
  return {.value = log_h + std::log(sd),
          .by_mean = -slope / sd,
          .by_variance = (1 - slope * u) / (2 * variance)};
}

double CompositeLogExpectedImprovement(double best, const Eigen::ArrayXd& residuals,
                                       const Eigen::ArrayXd& variances,
                                       const Eigen::ArrayXd& weights, Eigen::ArrayXd* by_residual,
                                       Eigen::ArrayXd* by_variance) {
  assert(best > 0 && variances.minCoeff() > 0 && weights.minCoeff() > 0);
  const Terms terms{best, weights * residuals.square(), weights * variances};
  const double p = SaddlePoint(terms);
  const Saddle saddle = EvaluateSaddle(p, terms);
  const double step = kStep / std::sqrt(saddle.second);
  const double tolerance = 1e-9 + 1e-13 * std::abs(saddle.value);  // rounding of the exponent
  const bool derivatives = by_residual != nullptr || by_variance != nullptr;
  const Eigen::Index count = residuals.size();

  // The parabola may run into the essential singularities at θ = 1/(2 w v), where the integrand
  // explodes; a less bent one does not, and the straight one never.
  double bend = saddle.third / (6 * saddle.second);
  for (int attempt = 0;; ++attempt, bend = attempt < kMaxAttempts ? 0.5 * bend : 0) {
    double sum = 0;
    double last = 0;
    bool descending = true;
    Eigen::ArrayXd residual_sums = Eigen::ArrayXd::Zero(count);
    Eigen::ArrayXd variance_sums = Eigen::ArrayXd::Zero(count);
    for (int node = 0; node < kMaxNodes; ++node) {
      const double y = step * node;
      const Complex theta(-p + bend * y * y, y);
      const Complex exponent = Exponent(theta, terms) - saddle.value;
      descending = exponent.real() <= last + tolerance;
      last = exponent.real();
      if (!descending || last < -kNegligible) break;
      const Complex term = (node == 0 ? 0.5 : 1.0) * std::exp(exponent) * Complex(2 * bend * y, 1);
      sum += term.imag();
      if (!derivatives) continue;
      for (Eigen::Index j = 0; j < count; ++j) {
        const Complex ratio = theta / (1.0 - 2.0 * theta * terms.scales[j]);  // θ / D
        residual_sums[j] += (term * ratio).imag();
        variance_sums[j] += (term * ratio * (2 * terms.squares[j] * ratio + 1.0)).imag();
      }
    }
    if (!descending && bend > 0) continue;
    if (by_residual != nullptr) *by_residual = 2 * weights * residuals * residual_sums / sum;
    if (by_variance != nullptr) *by_variance = weights * variance_sums / sum;
    return saddle.value + std::log(step * sum / std::numbers::pi);
  }
}

}  // namespace powdercal

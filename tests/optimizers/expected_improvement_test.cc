#include "optimizers/bayesian/expected_improvement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/random.h"

namespace powdercal {
namespace {

double LogDensity(double f, double mean, double variance) {
  return -0.5 * (f - mean) * (f - mean) / variance -
         0.5 * std::log(2 * std::numbers::pi * variance);
}

// ln ∫ exp(integrand) over [low, high] by the midpoint rule.
template <typename Integrand>
double LogIntegral(const Integrand& integrand, double low, double high, int nodes) {
  std::vector<double> values;
  for (int i = 0; i < nodes; ++i)
    values.push_back(integrand(low + (high - low) * (i + 0.5) / nodes));
  const double largest = *std::max_element(values.begin(), values.end());
  double sum = 0;
  for (const double value : values) sum += std::exp(value - largest);
  return largest + std::log(sum * (high - low) / nodes);
}

double Composite(double best, double residual, double variance, double weight) {
  return CompositeLogExpectedImprovement(best, Eigen::ArrayXd::Constant(1, residual),
                                         Eigen::ArrayXd::Constant(1, variance),
                                         Eigen::ArrayXd::Constant(1, weight), nullptr, nullptr);
}

TEST(LogExpectedImprovementTest, AgreesWithTheFormulaAndItsTail) {
  // E = sd (u Φ(u) + φ(u)), u = 0.5, sd = 2.
  EXPECT_NEAR(LogExpectedImprovement(3, 2, 4).value,
              std::log(2 * (0.5 * 0.6914624612740131 + 0.3520653267642995)), 1e-12);
  for (const double u : {-1.9, -2.1, -6.0, -30.0, -300.0}) {
    const double width = 60 / std::abs(u);
    const double expected = LogIntegral(
        [&](double z) { return std::log(u - z) + LogDensity(z, 0, 1); }, u - width, u, 20000);
    EXPECT_NEAR(LogExpectedImprovement(u, 0, 1).value, expected, 1e-5) << u;
  }
}

TEST(LogExpectedImprovementTest, Derivatives) {
  for (const double mean : {-3.0, 0.0, 1.9, 2.1, 9.0}) {
    const LogImprovement at = LogExpectedImprovement(0.5, mean, 0.6);
    const double step = 1e-6;
    EXPECT_NEAR(at.by_mean,
                (LogExpectedImprovement(0.5, mean + step, 0.6).value -
                 LogExpectedImprovement(0.5, mean - step, 0.6).value) /
                    (2 * step),
                1e-6 * (1 + std::abs(at.by_mean)));
    EXPECT_NEAR(at.by_variance,
                (LogExpectedImprovement(0.5, mean, 0.6 + step).value -
                 LogExpectedImprovement(0.5, mean, 0.6 - step).value) /
                    (2 * step),
                1e-6 * (1 + std::abs(at.by_variance)));
  }
}

TEST(CompositeTest, OneResponseAgreesWithQuadrature) {
  RandomStream random(11);
  for (int trial = 0; trial < 300; ++trial) {
    const double best = std::exp(random.Uniform(-10, 8));
    const double weight = std::exp(random.Uniform(-3, 3));
    const double sd = std::exp(random.Uniform(-5, 4));
    const double half = std::sqrt(best / weight);
    const double residual = random.Uniform(-1, 1) * (half + 20 * sd);
    const double low = std::max(-half, residual - 40 * sd);
    const double high = std::min(half, residual + 40 * sd);
    const double expected = LogIntegral(
        [&](double f) {
          return std::log(best - weight * f * f) + LogDensity(f, residual, sd * sd);
        },
        low, high, 20000);
    EXPECT_NEAR(Composite(best, residual, sd * sd, weight), expected, 2e-5)
        << "best " << best << " residual " << residual << " sd " << sd << " weight " << weight;
  }
}

TEST(CompositeTest, SeveralResponsesAgreeWithNestedQuadrature) {
  // E over two responses: the inner one by quadrature of the outer's remainder.
  const double best = 3;
  const Eigen::Array2d residuals(0.8, -1.5);
  const Eigen::Array2d variances(0.5, 0.2);
  const Eigen::Array2d weights(1.5, 2);
  const double half = std::sqrt(best / weights[0]);
  const double expected = LogIntegral(
      [&](double f) {
        return LogDensity(f, residuals[0], variances[0]) +
               Composite(best - weights[0] * f * f, residuals[1], variances[1], weights[1]);
      },
      -half, half, 4000);
  EXPECT_NEAR(
      CompositeLogExpectedImprovement(best, residuals, variances, weights, nullptr, nullptr),
      expected, 1e-5);
}

TEST(CompositeTest, TwelveResponsesAgreeWithSampling) {
  RandomStream random(5);
  const int count = 12;
  Eigen::ArrayXd residuals(count);
  Eigen::ArrayXd variances(count);
  Eigen::ArrayXd weights(count);
  for (int j = 0; j < count; ++j) {
    residuals[j] = random.Uniform(-0.5, 0.5);
    variances[j] = random.Uniform(0.05, 0.4);
    weights[j] = random.Uniform(0.5, 2);
  }
  const double best = 4;
  double sum = 0;
  double squares = 0;
  const int samples = 200000;
  for (int i = 0; i < samples; ++i) {
    double c = 0;
    for (int j = 0; j < count; ++j) {
      const double f = residuals[j] + std::sqrt(variances[j]) * random.Normal();
      c += weights[j] * f * f;
    }
    const double improvement = std::max(0.0, best - c);
    sum += improvement / samples;
    squares += improvement * improvement / samples;
  }
  const double error = std::sqrt((squares - sum * sum) / samples);
  EXPECT_NEAR(std::exp(CompositeLogExpectedImprovement(best, residuals, variances, weights, nullptr,
                                                       nullptr)),
              sum, 5 * error);
}

TEST(CompositeTest, CertainImprovement) {
  // Without variance to speak of: best − chi².
  EXPECT_NEAR(Composite(10, 2, 1e-12, 1.5), std::log(4), 1e-6);
}

TEST(CompositeTest, StaysFiniteFarFromAnyHope) {
  const double far = Composite(1e-12, 3, 1e-10, 1e4);
  EXPECT_TRUE(std::isfinite(far));
  EXPECT_LT(far, -1e9);
  EXPECT_GT(Composite(1e-12, 2.9, 1e-10, 1e4), far);
}

TEST(CompositeTest, DerivativesAgreeWithCentralDifferences) {
  RandomStream random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const int count = 1 + trial % 5;
    Eigen::ArrayXd residuals(count);
    Eigen::ArrayXd variances(count);
    Eigen::ArrayXd weights(count);
    for (int j = 0; j < count; ++j) {
      residuals[j] = random.Uniform(-3, 3);
      variances[j] = std::exp(random.Uniform(-4, 1));
      weights[j] = std::exp(random.Uniform(-1, 1));
    }
    const double best = std::exp(random.Uniform(-4, 3));
    Eigen::ArrayXd by_residual;
    Eigen::ArrayXd by_variance;
    CompositeLogExpectedImprovement(best, residuals, variances, weights, &by_residual,
                                    &by_variance);
    for (int j = 0; j < count; ++j) {
      const auto at = [&](double residual_step, double variance_step) {
        Eigen::ArrayXd r = residuals;
        Eigen::ArrayXd v = variances;
        r[j] += residual_step;
        v[j] += variance_step;
        return CompositeLogExpectedImprovement(best, r, v, weights, nullptr, nullptr);
      };
      const double step = 1e-5;
      EXPECT_NEAR(by_residual[j], (at(step, 0) - at(-step, 0)) / (2 * step),
                  1e-5 * (1 + std::abs(by_residual[j])));
      const double scaled = step * variances[j];
      EXPECT_NEAR(by_variance[j], (at(0, scaled) - at(0, -scaled)) / (2 * scaled),
                  1e-4 * (1 + std::abs(by_variance[j])));
    }
  }
}

}  // namespace
}  // namespace powdercal

#include "optimizers/bayesian/sampled_acquisition.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "optimizers/bayesian/trust_region.h"
#include "optimizers/pareto.h"

namespace powdercal {
namespace {

ObjectiveTerm Linear(std::size_t process) {
  return {.linear = true,
          .processes = {process},
          .targets = Eigen::ArrayXd::Zero(1),
          .weights = Eigen::ArrayXd::Ones(1)};
}

ObjectiveTerm Squares() {
  return {
      .processes = {0, 1}, .targets = Eigen::Array2d(0.2, -0.4), .weights = Eigen::Array2d(2, 0.5)};
}

double Softplus(double x) { return std::log1p(std::exp(x)); }

struct UtilityCase {
  std::string name;
  std::vector<ObjectiveTerm> terms;
  std::unique_ptr<SampleUtility> utility;
  Eigen::MatrixXd evaluated;  // objectives
  // Gain of objectives drawn for the new point.
  std::function<double(const Eigen::VectorXd&)> gain;
};

UtilityCase Improvement() {
  UtilityCase result{.name = "improvement", .terms = {Squares()}};
  result.evaluated = Eigen::Vector3d(3, 1.2, 2);
  result.utility = MakeImprovementUtility(Squares(), 1);
  result.gain = [](const Eigen::VectorXd& c) { return std::max(0.0, 1.2 - c[0]); };
  return result;
}

UtilityCase GainOfHypervolume(std::vector<ObjectiveTerm> terms, const Eigen::MatrixXd& evaluated,
                              const Eigen::VectorXd& reference) {
  UtilityCase result{.name = "hypervolume", .terms = terms, .evaluated = evaluated};
  result.utility = MakeHypervolumeUtility(terms, reference, 1);
  result.gain = [evaluated, reference](const Eigen::VectorXd& c) {
    Eigen::MatrixXd more(evaluated.rows() + 1, evaluated.cols());
    more << evaluated, c.transpose();
    return Hypervolume(more, reference) - Hypervolume(evaluated, reference);
  };
  return result;
}

std::vector<UtilityCase> Cases() {
  std::vector<UtilityCase> cases;
  cases.push_back(Improvement());
  cases.push_back(GainOfHypervolume({Linear(0), Linear(1)},
                                    Eigen::MatrixXd{{0.1, 0.9}, {0.5, 0.4}, {0.8, 0.1}},
                                    Eigen::Vector2d(1, 1)));
  cases.push_back(GainOfHypervolume({Linear(2), Squares()},
                                    Eigen::MatrixXd{{0.1, 0.9}, {0.5, 0.4}, {0.8, 0.1}},
                                    Eigen::Vector2d(1, 1)));
  cases.push_back(GainOfHypervolume(
      {Linear(0), Linear(1), Linear(2)},
      Eigen::MatrixXd{{0.1, 0.9, 0.5}, {0.5, 0.4, 0.2}, {0.3, 0.3, 0.6}, {0.8, 0.1, 0.7}},
      Eigen::Vector3d(1, 1, 1)));
  return cases;
}

const Eigen::Array3d kMeans(0.3, -0.1, 0.4);
const Eigen::Array3d kVariances(0.04, 0.09, 0.06);

TEST(SampleUtilityTest, GainsAreExpectations) {
  for (UtilityCase& entry : Cases()) {
    entry.utility->SetSample(0, entry.evaluated);
    RandomStream random(2);
    constexpr int kDraws = 200'000;
    double sum = 0;
    double squares = 0;
    Eigen::VectorXd objectives(static_cast<Eigen::Index>(entry.terms.size()));
    for (int i = 0; i < kDraws; ++i) {
      Eigen::Array3d responses;
      for (Eigen::Index j = 0; j < 3; ++j) {
        responses[j] = kMeans[j] + std::sqrt(kVariances[j]) * random.Normal();
      }
      for (std::size_t o = 0; o < entry.terms.size(); ++o) {
        objectives[static_cast<Eigen::Index>(o)] = entry.terms[o].ValueOf(responses);
      }
      const double gain = entry.gain(objectives);
      sum += gain;
      squares += gain * gain;
    }
    const double mean = sum / kDraws;
    const double error = std::sqrt((squares / kDraws - mean * mean) / kDraws);
    EXPECT_NEAR(std::exp(entry.utility->LogGain(0, kMeans, kVariances, nullptr, nullptr)), mean,
                5 * error)
        << entry.name << " of " << entry.terms.size();
  }
}

TEST(SampleUtilityTest, DerivativesAreDifferences) {
  std::vector<UtilityCase> cases = Cases();
  UtilityCase chebyshev{.name = "chebyshev", .terms = {Linear(2), Squares()}};
  chebyshev.evaluated = Eigen::MatrixXd{{0.1, 0.9}, {0.5, 0.4}, {0.8, 0.1}};
  chebyshev.utility = MakeChebyshevUtility(chebyshev.terms, Eigen::Array2d(0.4, 0.6),
                                           Eigen::Vector3d(0.3, -0.5, 0.2));
  cases.push_back(std::move(chebyshev));
  for (UtilityCase& entry : cases) {
    entry.utility->SetSample(0, entry.evaluated);
    Eigen::ArrayXd by_mean;
    Eigen::ArrayXd by_variance;
    entry.utility->LogGain(0, kMeans, kVariances, &by_mean, &by_variance);
    constexpr double kStep = 1e-6;
    const auto difference = [&](bool of_mean, Eigen::Index j) {
      Eigen::ArrayXd values[2];
      double results[2];
      for (const int side : {0, 1}) {
        values[side] = of_mean ? kMeans : kVariances;
        values[side][j] += (2 * side - 1) * kStep;
        results[side] = entry.utility->LogGain(0, of_mean ? values[side] : Eigen::ArrayXd(kMeans),
                                               of_mean ? Eigen::ArrayXd(kVariances) : values[side],
                                               nullptr, nullptr);
      }
      return (results[1] - results[0]) / (2 * kStep);
    };
    for (Eigen::Index j = 0; j < 3; ++j) {
      EXPECT_NEAR(by_mean[j], difference(true, j), 2e-4) << entry.name << " mean " << j;
      EXPECT_NEAR(by_variance[j], difference(false, j), 2e-4) << entry.name << " variance " << j;
    }
  }
}

TEST(SampleUtilityTest, ChebyshevGainIsOfTheNorm) {
  const std::vector<ObjectiveTerm> terms = {Linear(0), Linear(1)};
  const auto utility = MakeChebyshevUtility(terms, Eigen::Array2d(0.5, 0.5), Eigen::Vector2d(0, 0));
  utility->SetSample(0, Eigen::MatrixXd{{0, 1}, {1, 0}});  // norm 0.5 + 0.025 of both
  const Eigen::ArrayXd means = Eigen::Array2d(0.4, 0.2);
  const double gain = 0.525 - (0.2 + 0.05 * 0.3);
  EXPECT_NEAR(utility->LogGain(0, means, Eigen::Array2d(1, 1), nullptr, nullptr),
              std::log(Softplus(gain / 0.01)), 1e-9);
}

TEST(TrustRegionTest, GrowsAndShrinks) {
  const Eigen::VectorXd centre = Eigen::VectorXd::Constant(12, 0.5);
  const Eigen::VectorXd lengthscales = Eigen::VectorXd::Ones(12);
  EXPECT_EQ(FindTrustRegion(centre, 10, {}, lengthscales).length, 0.8);
  EXPECT_EQ(FindTrustRegion(centre, 10, {9, 8, 7}, lengthscales).length, 1.6);
  EXPECT_EQ(FindTrustRegion(centre, 10, std::vector<double>(12, 11), lengthscales).length, 0.4);
  // After seven halvings and one more it starts anew.
  EXPECT_EQ(FindTrustRegion(centre, 10, std::vector<double>(12 * 7, 11), lengthscales).length, 0.8);
  Eigen::VectorXd uneven = lengthscales;
  uneven[0] = 4;
  const TrustRegion region = FindTrustRegion(centre, 10, std::vector<double>(24, 11), uneven);
  const double geometric = std::pow(4.0, 1.0 / 12);
  EXPECT_NEAR(region.upper[1] - region.lower[1], 0.2 / geometric, 1e-12);
  EXPECT_NEAR(region.upper[0] - region.lower[0], 0.8 / geometric, 1e-12);
}

}  // namespace
}  // namespace powdercal

#include "surrogates/ridge.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cassert>
#include <limits>

#include "surrogates/fitting.h"

namespace powdercal {
namespace {

// A point that decides its own prediction says nothing of the others' ability to predict it.
constexpr double kSmallestFreedom = 1e-6;

// All exponents of total degree 1 … degree; empty if there are more than max_terms.
std::vector<std::vector<int>> TermsUpTo(Eigen::Index dimension, int degree, int max_terms) {
  std::vector<std::vector<int>> terms = {std::vector<int>(static_cast<std::size_t>(dimension), 0)};
  std::size_t last_begin = 0;
  for (int order = 1; order <= degree; ++order) {
    const std::size_t begin = terms.size();
    for (std::size_t t = last_begin; t < begin; ++t) {
      // Raising only from the last coordinate in use on makes each product once.
      std::size_t first = 0;
      for (std::size_t k = 0; k < terms[t].size(); ++k) {
        if (terms[t][k] > 0) first = k;
      }
      for (std::size_t k = first; k < terms[t].size(); ++k) {
        terms.push_back(terms[t]);
        ++terms.back()[k];
        if (static_cast<int>(terms.size()) - 1 > max_terms && degree > 1) return {};
      }
    }
    last_begin = begin;
  }
  terms.erase(terms.begin());
  return terms;
}

// Legendre polynomials 0 … degree of x in a row.
Eigen::RowVectorXd Legendre(double x, int degree) {
  Eigen::RowVectorXd values(degree + 1);
  values[0] = 1;
  if (degree > 0) values[1] = x;
  for (int k = 2; k <= degree; ++k) {
    values[k] = ((2 * k - 1) * x * values[k - 1] - (k - 1) * values[k - 2]) / k;
  }
  return values;
}

struct Residuals {
  double leave_one_out = std::numeric_limits<double>::infinity();  // mean square
  double noise_variance = 0;
};

// `along`: n × terms, the centred terms along the eigenvectors; `centred`: values less their mean.
Residuals ResidualsOf(const Eigen::MatrixXd& along, const Eigen::VectorXd& squares, double lambda,
                      const Eigen::VectorXd& centred) {
  const auto n = static_cast<double>(centred.size());
  const Eigen::VectorXd inverse = (squares.array() + lambda).inverse();
  const Eigen::VectorXd residuals =
      centred - along * inverse.cwiseProduct(along.transpose() * centred);
  const Eigen::ArrayXd freedom = 1 - 1 / n - (along.array().square().matrix() * inverse).array();
  if (freedom.minCoeff() < kSmallestFreedom) return {};
  return {.leave_one_out = (residuals.array() / freedom).square().mean(),
          .noise_variance = (residuals.array().square() / freedom).mean()};
}

}  // namespace

Ridge::Ridge(Options options) : options_(std::move(options)) {
  assert(options_.max_degree >= 1 && options_.max_degree <= 6 && options_.max_terms >= 1);
  assert(!options_.penalties.empty());
}

const std::string& Ridge::name() const {
  static const std::string kName = "ridge";
  return kName;
}

Eigen::RowVectorXd Ridge::Terms(const Eigen::RowVectorXd& point) const {
  Eigen::MatrixXd polynomials(point.size(), degree_ + 1);
  for (Eigen::Index k = 0; k < point.size(); ++k) {
    polynomials.row(k) = Legendre(2 * point[k] - 1, degree_);
  }
  Eigen::RowVectorXd values = Eigen::RowVectorXd::Ones(static_cast<Eigen::Index>(terms_.size()));
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    for (std::size_t k = 0; k < terms_[t].size(); ++k) {
      values[static_cast<Eigen::Index>(t)] *=
          polynomials(static_cast<Eigen::Index>(k), terms_[t][k]);
    }
  }
  return values;
}

void Ridge::Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
                const Eigen::VectorXd& noise_variances) {
  CheckObservations(name(), points, values, noise_variances);
  Ridge best(options_);
  best.least_error_ = std::numeric_limits<double>::infinity();
  for (int degree = 1; degree <= options_.max_degree; ++degree) {
    Ridge tried(options_);
    tried.terms_ = TermsUpTo(points.cols(), degree, options_.max_terms);
    if (tried.terms_.empty()) break;
    tried.degree_ = degree;
    tried.Solve(points, values);
    // The first also where leave-one-out says nothing.
    if (degree == 1 || tried.least_error_ < best.least_error_) best = std::move(tried);
  }
  *this = std::move(best);
}

void Ridge::Solve(const Eigen::MatrixXd& points, const Eigen::VectorXd& values) {
  count_ = points.rows();
  mean_ = values.mean();
  Eigen::MatrixXd terms(count_, static_cast<Eigen::Index>(terms_.size()));
  for (Eigen::Index i = 0; i < count_; ++i) terms.row(i) = Terms(points.row(i));
  centre_ = terms.colwise().mean();
  terms.rowwise() -= centre_;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(terms.transpose() * terms);
  directions_ = solver.eigenvectors();
  squares_ = solver.eigenvalues().cwiseMax(0);
  const Eigen::MatrixXd along = terms * directions_;
  const Eigen::VectorXd centred = values.array() - mean_;
  penalty_ = options_.penalties.front();
  least_error_ = std::numeric_limits<double>::infinity();
  noise_variance_ = kUnknownVariance;
  for (const double penalty : options_.penalties) {
    const Residuals residuals =
        ResidualsOf(along, squares_, penalty * static_cast<double>(count_), centred);
    if (!(residuals.leave_one_out < least_error_)) continue;
    penalty_ = penalty;
    least_error_ = residuals.leave_one_out;
    noise_variance_ = residuals.noise_variance;
  }
  shrunk_ = (squares_.array() + penalty_ * static_cast<double>(count_)).inverse();
  coefficients_ = directions_ * shrunk_.cwiseProduct(along.transpose() * centred);
}

Prediction Ridge::Predict(const Eigen::VectorXd& point) const {
  assert(count_ > 0 && static_cast<Eigen::Index>(terms_.front().size()) == point.size());
  const Eigen::VectorXd terms = (Terms(point.transpose()) - centre_).transpose();
  const Eigen::ArrayXd along = directions_.transpose() * terms;
  const double posterior = (along.square() * shrunk_.array()).sum();
  return {.mean = mean_ + terms.dot(coefficients_),
          .variance = noise_variance_ * (1 / static_cast<double>(count_) + posterior)};
}

std::string Ridge::Describe() const {
  if (count_ == 0) return "ridge regression, not fitted";
  return fmt::format(
      "ridge regression, {} points, polynomial of degree {} ({} terms), lambda/n {:g}", count_,
      degree_, terms_.size(), penalty_);
}

}  // namespace powdercal

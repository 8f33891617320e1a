#include "optimizers/metaheuristics/cma_es.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <deque>

#include "optimizers/metaheuristics/pagmo_methods.h"

namespace powdercal {
namespace {

constexpr double kFlat = 1e-12;
constexpr double kWorstCondition = 1e14;
constexpr double kSmallestLevelShare = 0.3;
constexpr int kLargestPopulation = 100000;

// Strategy parameters of a generation of λ points in d dimensions; symbols and equations of Hansen
// 2016, table 1.
struct Rates {
  Eigen::VectorXd weights;  // best first; those of the worse half negative
  int parents = 0;          // μ
  double mu_eff = 0;
  double c_sigma = 0, d_sigma = 0, c_c = 0, c_1 = 0, c_mu = 0;

  Rates(int lambda, int dimension);
};

Rates::Rates(int lambda, int dimension) : weights(lambda), parents(lambda / 2) {
  const double n = dimension;
  for (int i = 0; i < lambda; ++i) weights[i] = std::log((lambda + 1) / 2.0) - std::log(i + 1.0);
  const auto better = weights.head(parents);
  const auto worse = weights.tail(lambda - parents);
  mu_eff = better.sum() * better.sum() / better.squaredNorm();
  c_c = (4 + mu_eff / n) / (n + 4 + 2 * mu_eff / n);
  c_sigma = (mu_eff + 2) / (n + mu_eff + 5);
  d_sigma = 1 + 2 * std::max(0.0, std::sqrt((mu_eff - 1) / (n + 1)) - 1) + c_sigma;
  c_1 = 2 / ((n + 1.3) * (n + 1.3) + mu_eff);
  c_mu = std::min(1 - c_1, 2 * (0.25 + mu_eff + 1 / mu_eff - 2) / ((n + 2) * (n + 2) + mu_eff));
  // The negative ones are limited so that the covariance stays positive definite.
  const double squares = worse.squaredNorm();
  const double mu_eff_worse = squares > 0 ? worse.sum() * worse.sum() / squares : 0;
  const double limit = std::min(
      {1 + c_1 / c_mu, 1 + 2 * mu_eff_worse / (mu_eff + 2), (1 - c_1 - c_mu) / (n * c_mu)});
  const double positive = better.sum();
  const double negative = -weights.cwiseMin(0).sum();
  for (double& w : weights) {
    if (w >= 0) {
      w /= positive;
    } else {
      w *= limit / negative;
    }
  }
}

// y of a point x = mean + σ y: as it was drawn, and as far as the box allowed.
struct Steps {
  Eigen::VectorXd drawn;
  Eigen::VectorXd taken;
};

class CmaEs final : public Strategy {
 public:
  CmaEs(const CmaEsOptions& options, const SearchProblem& problem)
      : options_(options),
        space_(problem.space),
        dimension_(problem.dimension()),
        lambda_(problem.population),
        random_(problem.random) {}

  void Begin(std::vector<Individual> population) override { StartRun(population.front().point); }
  std::vector<Eigen::VectorXd> Propose() override;
  void Learn(std::span<const Individual> generation) override;
  std::string Message() const override { return fmt::format("run {}", run_); }

 private:
  void StartRun(const Eigen::VectorXd& mean);
  void Restart();
  void Update(const std::vector<Steps>& steps);
  void UpdateCovariance(const Rates& rates, const std::vector<Steps>& steps, double h_sigma);
  void KeepLevelsInReach();
  void Decompose();
  bool Exhausted(std::span<const Individual> generation, const std::vector<std::size_t>& ranking);

  CmaEsOptions options_;
  SearchSpace space_;
  int dimension_;
  int lambda_;
  RandomStream random_;
  int run_ = 0;

  // State of a run.
  int generation_ = 0;
  bool succeeded_ = false;
  Eigen::VectorXd mean_;
  double sigma_ = 0;
  Eigen::VectorXd path_sigma_;
  Eigen::VectorXd path_c_;
  Eigen::MatrixXd covariance_;  // C = B D² Bᵀ
  Eigen::MatrixXd axes_;        // B
  Eigen::VectorXd deviations_;  // D
  std::vector<Steps> steps_;    // of the generation
  std::deque<double> best_values_;
};

void CmaEs::StartRun(const Eigen::VectorXd& mean) {
  ++run_;
  generation_ = 0;
  succeeded_ = false;
  mean_ = mean;
  sigma_ = options_.initial_step;
  path_sigma_ = Eigen::VectorXd::Zero(dimension_);
  path_c_ = Eigen::VectorXd::Zero(dimension_);
  covariance_ = Eigen::MatrixXd::Identity(dimension_, dimension_);
  axes_ = covariance_;
  deviations_ = Eigen::VectorXd::Ones(dimension_);
  best_values_.clear();
}

void CmaEs::Restart() {
  const double grown = std::min(lambda_ * options_.population_factor, kLargestPopulation + 0.0);
  lambda_ = 2 * static_cast<int>(std::lround(grown / 2));  // even: no core idles
  Eigen::VectorXd mean(dimension_);
  for (double& u : mean) u = random_.Uniform();
  StartRun(mean);
}

std::vector<Eigen::VectorXd> CmaEs::Propose() {
  steps_.clear();
  std::vector<Eigen::VectorXd> points;
  for (int i = 0; i < lambda_; ++i) {
    Eigen::VectorXd z(dimension_);
    for (double& entry : z) entry = random_.Normal();
    Steps steps{.drawn = axes_ * deviations_.cwiseProduct(z)};
    points.push_back((mean_ + sigma_ * steps.drawn).cwiseMax(0).cwiseMin(1));
    steps.taken = (points.back() - mean_) / sigma_;
    steps_.push_back(std::move(steps));
  }
  return points;
}

void CmaEs::Learn(std::span<const Individual> generation) {
  std::vector<std::size_t> ranking = Ranking(generation);
  std::erase_if(ranking, [&](std::size_t i) { return !generation[i].Complete(); });
  if (ranking.empty()) {
    if (succeeded_) {
      sigma_ /= 2;  // around what has succeeded
    } else {
      Restart();
    }
    return;
  }
  succeeded_ = true;
  ++generation_;
  std::vector<Steps> steps;
  for (const std::size_t i : ranking) steps.push_back(steps_[i]);
  if (steps.size() < 2) {
    mean_ += sigma_ * steps[0].taken;
  } else {
    Update(steps);
  }
  if (Exhausted(generation, ranking)) Restart();
}

// Hansen 2016, equations 38 to 47; steps from the best to the worst.
void CmaEs::Update(const std::vector<Steps>& steps) {
  const Rates rates(static_cast<int>(steps.size()), dimension_);
  const double n = dimension_;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(dimension_);
  for (int i = 0; i < rates.parents; ++i) {
    step += rates.weights[i] * steps[static_cast<std::size_t>(i)].taken;
  }
  mean_ += sigma_ * step;

  const double expected = std::sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n));  // of |N(0, I)|
  const Eigen::VectorXd white = axes_ * (axes_.transpose() * step).cwiseQuotient(deviations_);
  path_sigma_ = (1 - rates.c_sigma) * path_sigma_ +
                std::sqrt(rates.c_sigma * (2 - rates.c_sigma) * rates.mu_eff) * white;
  const double length = path_sigma_.norm();
  const double settled = std::sqrt(1 - std::pow(1 - rates.c_sigma, 2 * generation_));
  const double h_sigma = length / settled < (1.4 + 2 / (n + 1)) * expected ? 1 : 0;
  path_c_ = (1 - rates.c_c) * path_c_ +
            h_sigma * std::sqrt(rates.c_c * (2 - rates.c_c) * rates.mu_eff) * step;
  UpdateCovariance(rates, steps, h_sigma);
  // Beyond the side of the box all samples lie on its surface.
  sigma_ =
      std::min(1.0, sigma_ * std::exp(rates.c_sigma / rates.d_sigma * (length / expected - 1)));
  KeepLevelsInReach();
  Decompose();
}

// What was good is good where it was evaluated; directions that turned out badly are narrowed as
// they were drawn. With the steps as taken in both, the covariance collapses along the bounds
// before the search has reached a corner.
void CmaEs::UpdateCovariance(const Rates& rates, const std::vector<Steps>& steps, double h_sigma) {
  const double lost = (1 - h_sigma) * rates.c_c * (2 - rates.c_c);
  covariance_ *= 1 + rates.c_1 * lost - rates.c_1 - rates.c_mu * rates.weights.sum();
  covariance_ += rates.c_1 * path_c_ * path_c_.transpose();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    double weight = rates.weights[static_cast<Eigen::Index>(i)];
    const Eigen::VectorXd& step = weight < 0 ? steps[i].drawn : steps[i].taken;
    if (weight < 0) {
      const double white = (axes_.transpose() * step).cwiseQuotient(deviations_).squaredNorm();
      weight *= dimension_ / std::max(white, 1e-300);
    }
    covariance_ += rates.c_mu * weight * step * step.transpose();
  }
}

void CmaEs::KeepLevelsInReach() {
  for (Eigen::Index k = 0; k < dimension_; ++k) {
    const int levels = space_.parameters[static_cast<std::size_t>(k)].levels();
    if (levels < 2) continue;
    const double floor = kSmallestLevelShare / levels / sigma_;
    covariance_(k, k) = std::max(covariance_(k, k), floor * floor);
  }
}

void CmaEs::Decompose() {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      0.5 * (covariance_ + covariance_.transpose()));
  axes_ = solver.eigenvectors();
  const double largest = solver.eigenvalues().maxCoeff();
  deviations_ = solver.eigenvalues().cwiseMax(largest * 1e-16).cwiseSqrt();
}

bool CmaEs::Exhausted(std::span<const Individual> generation,
                      const std::vector<std::size_t>& ranking) {
  const auto memory = static_cast<std::size_t>(10 + 30 * dimension_ / lambda_);
  best_values_.push_back(generation[ranking.front()].values[0]);
  if (best_values_.size() > memory) best_values_.pop_front();
  if (best_values_.size() == memory) {
    const auto [low, high] = std::minmax_element(best_values_.begin(), best_values_.end());
    const double worst = std::max(*high, generation[ranking.back()].values[0]);
    if (worst - *low <= kFlat * std::max(1.0, std::abs(*low))) return true;
  }
  double largest = 0;  // standard deviation of a continuous parameter
  for (Eigen::Index k = 0; k < dimension_; ++k) {
    if (space_.parameters[static_cast<std::size_t>(k)].levels() > 0) continue;
    largest = std::max(largest, sigma_ * std::sqrt(covariance_(k, k)));
  }
  const bool continuous = std::any_of(space_.parameters.begin(), space_.parameters.end(),
                                      [](const Parameter& p) { return p.levels() == 0; });
  if (continuous && largest < options_.smallest_step) return true;
  const double ratio = deviations_.maxCoeff() / deviations_.minCoeff();
  return ratio * ratio > kWorstCondition;
}

class CmaEsMethod final : public Method {
 public:
  const std::string& name() const override {
    static const std::string name = "cma_es";
    return name;
  }
  std::string Describe() const override {
    return "covariance matrix adaptation, restarted with growing populations; one objective";
  }
  MethodTraits traits() const override {
    const bool own = options_.implementation == Implementation::own;
    return {.batches = own, .smallest_population = own ? 4 : 5};
  }
  int DefaultPopulation(int dimension, int) const override {
    const int hansen = 4 + static_cast<int>(3 * std::log(std::max(1, dimension)));
    return std::max(6, hansen + hansen % 2);
  }
  void Serialize(Archive& archive) override {
    SerializeImplementation(archive, options_.implementation);
    archive.Number("initial_step", options_.initial_step,
                   {.lower = 0, .upper = 1, .lower_open = true});
    if (options_.implementation == Implementation::pagmo) return;
    archive.Number("population_factor", options_.population_factor, {.lower = 1, .upper = 10});
    archive.Number("smallest_step", options_.smallest_step, kPositive);
  }
  std::unique_ptr<Strategy> MakeStrategy(const SearchProblem& problem) const override {
    return options_.implementation == Implementation::own
               ? MakeCmaEs(options_, problem)
               : MakePagmoCmaEs(options_.initial_step, problem);
  }

 private:
  CmaEsOptions options_;
};

}  // namespace

std::unique_ptr<Strategy> MakeCmaEs(const CmaEsOptions& options, const SearchProblem& problem) {
  return std::make_unique<CmaEs>(options, problem);
}

std::unique_ptr<Method> MakeCmaEsMethod() { return std::make_unique<CmaEsMethod>(); }

}  // namespace powdercal

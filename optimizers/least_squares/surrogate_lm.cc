#include "optimizers/least_squares/surrogate_lm.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/random.h"
#include "optimizers/least_squares/bounded_lm.h"
#include "optimizers/least_squares/identifiability.h"
#include "optimizers/least_squares/residuals.h"
#include "optimizers/least_squares/response_models.h"
#include "optimizers/observations.h"

namespace powdercal {
namespace {

const std::array<std::string, 2> kKernelNames = {"matern52", "rbf"};
constexpr int kSobolPoints = 256;
constexpr int kValleyPoints = 256;
constexpr int kEvaluatedStarts = 4;
constexpr int kSobolStarts = 6;
constexpr double kSameMinimum = 1e-3;
constexpr int kMaxIterations = 50;

struct Minimum {
  Eigen::VectorXd point;
  double chi2 = 0;
};

class SurrogateLm final : public Optimizer {
 public:
  SurrogateLm(const SurrogateLmOptions& options, const SearchSpace& space,
              const Objectives& objectives, std::uint64_t seed)
      : options_(options),
        space_(space),
        dimension_(space.dimension()),
        objectives_(objectives),
        stream_(RandomStream(seed).Split("surrogate_lm")) {
    if (ExplainUnsupported(space, objectives).empty()) {
      design_ = MakeDesign(options.initial_design, space, seed);
    }
    for (const Parameter& parameter : space.parameters) symbols_.push_back(parameter.symbol);
  }

  std::vector<Candidate> Ask(int max_count) override;
  void Tell(std::span<const Observation> observations) override;
  Status status() const override { return {Status::Phase::ready, message_}; }
  Capabilities capabilities() const override {
    return {.noise = true, .asynchronous = true, .failures = true};
  }
  std::string ExplainUnsupported(const SearchSpace& space,
                                 const Objectives& objectives) const override {
    const std::string reason = ExplainNoLeastSquares("surrogate_lm", space, objectives);
    return reason.empty() ? options_.initial_design.ExplainUnsupported(space) : reason;
  }

 private:
  Candidate Propose();
  void Model();
  Eigen::MatrixXd Starts(const Eigen::MatrixXd& sobol) const;
  void FindMinima(const Eigen::MatrixXd& starts);
  Eigen::VectorXd UncertainPoint(const Feasibility& feasibility, RandomStream random) const;
  Eigen::MatrixXd ValleyPoints(RandomStream* random) const;
  Eigen::VectorXd FillSpace(std::uint64_t seed) const {
    return FarthestPoint(Taken(), dimension_, kSobolPoints, seed);
  }
  Eigen::MatrixXd Taken() const { return TakenPoints(observations_, pending_, dimension_); }

  SurrogateLmOptions options_;
  SearchSpace space_;
  int dimension_;
  Objectives objectives_;
  RandomStream stream_;
  std::vector<std::string> symbols_;
  std::vector<DesignPoint> design_;
  std::size_t design_next_ = 0;
  std::int64_t asked_ = 0;
  PointsById pending_;
  ObservationsById observations_;
  // Of all observations; empty: to be made.
  std::optional<ResponseModels> models_;
  std::vector<Minimum> minima_;  // of models_, the lowest first
  std::string message_;
};

std::vector<Candidate> SurrogateLm::Ask(int max_count) {
  std::vector<Candidate> candidates;
  while (static_cast<int>(candidates.size()) < max_count) {
    Candidate candidate;
    if (design_next_ < design_.size()) {
      const DesignPoint& next = design_[design_next_++];
      if (IsTaken(Taken(), next.point)) continue;
      candidate.point = next.point;
      candidate.origin = "initial design: " + next.label;
    } else {
      candidate = Propose();
    }
    candidate.id = asked_++;
    pending_[candidate.id] = candidate.point;
    candidates.push_back(std::move(candidate));
  }
  return candidates;
}

void SurrogateLm::Tell(std::span<const Observation> observations) {
  for (const Observation& observation : observations) {
    observations_[observation.id] =
        CheckedObservation("surrogate_lm", observation, dimension_, objectives_);
    pending_.erase(observation.id);
  }
  models_.reset();
}

Candidate SurrogateLm::Propose() {
  const RandomStream stream = stream_.Split(static_cast<std::uint64_t>(asked_));
  try {
    if (!models_) Model();
  } catch (const std::exception& error) {
    models_.reset();
    message_ = fmt::format("no surrogate could be fitted ({})", error.what());
  }
  if (!models_ || models_->size() == 0) {
    if (models_) message_ = "no response has two values";
    return {.point = FillSpace(stream.seed()), .origin = "space filling: " + message_};
  }
  const Feasibility feasibility = LearnFeasibility(observations_, dimension_);
  const Eigen::MatrixXd taken = Taken();
  const double likely = std::log(0.5);
  std::vector<Eigen::VectorXd> points;
  for (const Minimum& minimum : minima_) points.push_back(minimum.point);
  const ResponseModels::Outlook outlook = models_->Predict(Rows(points, dimension_));
  for (std::size_t i = 0; i < minima_.size(); ++i) {
    if (i > 0 && outlook.optimistic[static_cast<Eigen::Index>(i)] > minima_.front().chi2) continue;
    if (IsTaken(taken, points[i]) || feasibility.LogProbability(points[i], nullptr) < likely) continue;
    return {.point = points[i],
            .origin = i == 0 ? "surrogate_lm: minimum" : "surrogate_lm: another minimum"};
  }
  const Eigen::VectorXd point = UncertainPoint(feasibility, stream.Split("valley"));
  if (point.size() > 0) return {.point = point, .origin = "surrogate_lm: uncertain in the valley"};
  return {.point = FillSpace(stream.seed()), .origin = "space filling: every point is taken"};
}

void SurrogateLm::Model() {
  models_.emplace(space_, objectives_, observations_, options_.kernel);
  minima_.clear();
  message_.clear();
  if (models_->size() == 0) return;
  // The same set for all that is asked between two tells.
  const auto told = static_cast<std::uint64_t>(observations_.size());
  const Eigen::MatrixXd sobol =
      SobolPoints(kSobolPoints, dimension_, stream_.Split("starts").Split(told).seed());
  FindMinima(Starts(sobol));
  const Minimum& lowest = minima_.front();
  Eigen::VectorXd residuals;
  Eigen::MatrixXd jacobian;
  models_->Evaluate(lowest.point, &residuals, &jacobian);
  const std::string findings =
      Describe(Identify(lowest.point, jacobian, Eigen::ArrayXd::Zero(dimension_)), symbols_);
  message_ = fmt::format("minimum of the model, chi² {:.4g}", lowest.chi2) +
             (findings.empty() ? "" : ": " + findings);
}

// The best evaluations, by the model and as told, and the best of a set over the box.
Eigen::MatrixXd SurrogateLm::Starts(const Eigen::MatrixXd& sobol) const {
  std::vector<Eigen::VectorXd> evaluated;
  std::vector<std::pair<double, std::size_t>> told;
  for (const auto& [id, observation] : observations_) {
    if (observation.failed) continue;
    if (observation.responses.allFinite()) {
      told.emplace_back(ChiSquared(objectives_, observation.responses, observation.variances),
                        evaluated.size());
    }
    evaluated.push_back(observation.point);
  }
  std::vector<Eigen::VectorXd> starts;
  std::sort(told.begin(), told.end());
  for (const auto& [chi2, index] : told) {
    if (starts.size() == kEvaluatedStarts) break;
    starts.push_back(evaluated[index]);
  }
  const auto add_best = [&](const Eigen::MatrixXd& points, int count) {
    const Eigen::ArrayXd chi2 = models_->Predict(points).chi2;
    std::vector<std::pair<double, Eigen::Index>> ranked;
    for (Eigen::Index i = 0; i < points.rows(); ++i) ranked.emplace_back(chi2[i], i);
    std::sort(ranked.begin(), ranked.end());
    for (int i = 0; i < std::min(count, static_cast<int>(ranked.size())); ++i) {
      starts.push_back(points.row(ranked[static_cast<std::size_t>(i)].second).transpose());
    }
  };
  add_best(Rows(evaluated, dimension_), 1);
  add_best(sobol, kSobolStarts);
  return Rows(starts, dimension_);
}

void SurrogateLm::FindMinima(const Eigen::MatrixXd& starts) {
  const auto function = [&](const Eigen::VectorXd& x, Eigen::VectorXd* residuals,
                            Eigen::MatrixXd* jacobian) {
    models_->Evaluate(x, residuals, jacobian);
    return residuals->allFinite();
  };
  for (Eigen::Index i = 0; i < starts.rows(); ++i) {
    Eigen::VectorXd x = starts.row(i).transpose();
    LevenbergMarquardt(function, models_->size(), {.max_iterations = kMaxIterations}, &x);
    Eigen::VectorXd residuals;
    models_->Evaluate(x, &residuals, nullptr);
    minima_.push_back({x, residuals.squaredNorm()});
  }
  std::stable_sort(minima_.begin(), minima_.end(),
                   [](const Minimum& a, const Minimum& b) { return a.chi2 < b.chi2; });
  std::vector<Minimum> distinct;
  for (const Minimum& minimum : minima_) {
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const Minimum& other) {
      return (other.point - minimum.point).norm() < kSameMinimum;
    });
    if (!known) distinct.push_back(minimum);
  }
  minima_ = std::move(distinct);
}

// Normal steps from the lowest minimum with the covariance (JᵀJ + 1)⁻¹ of the linearised model (χ²
// rises by about d), a third and a tenth of it; and a set over the box.
Eigen::MatrixXd SurrogateLm::ValleyPoints(RandomStream* random) const {
  const Minimum& lowest = minima_.front();
  Eigen::VectorXd residuals;
  Eigen::MatrixXd jacobian;
  models_->Evaluate(lowest.point, &residuals, &jacobian);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      jacobian.transpose() * jacobian + Eigen::MatrixXd::Identity(dimension_, dimension_));
  const Eigen::MatrixXd root =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal();
  Eigen::MatrixXd points(kValleyPoints + kSobolPoints, dimension_);
  constexpr double kLengths[] = {1, 0.3, 0.1};
  for (Eigen::Index i = 0; i < kValleyPoints; ++i) {
    Eigen::VectorXd z(dimension_);
    for (double& entry : z) entry = random->Normal();
    const Eigen::VectorXd point = lowest.point + kLengths[i % 3] * (root * z);
    points.row(i) = point.cwiseMax(0).cwiseMin(1).transpose();
  }
  points.bottomRows(kSobolPoints) = SobolPoints(kSobolPoints, dimension_, random->seed());
  return points;
}

Eigen::VectorXd SurrogateLm::UncertainPoint(const Feasibility& feasibility,
                                            RandomStream random) const {
  const Eigen::MatrixXd points = ValleyPoints(&random);
  const Eigen::MatrixXd taken = Taken();
  std::vector<Eigen::VectorXd> pending;
  for (const auto& [id, point] : pending_) pending.push_back(point);
  const ResponseModels::Outlook outlook = models_->Predict(points);
  const Eigen::ArrayXd variance =
      models_->ConditionedOn(Rows(pending, dimension_)).Predict(points).variance;
  const double limit = minima_.front().chi2 + 1;
  // In the valley and likely to succeed; the most promising that is likely to; the most promising.
  Eigen::Index best = -1;
  int best_rank = 3;
  double best_value = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::VectorXd point = points.row(i).transpose();
    if (IsTaken(taken, point)) continue;
    const bool in_valley = outlook.optimistic[i] <= limit;
    const bool likely = feasibility.LogProbability(point, nullptr) >= std::log(0.5);
    const int rank = likely ? (in_valley ? 0 : 1) : 2;
    const double value = rank == 0 ? variance[i] : -outlook.optimistic[i];
    if (best < 0 || rank < best_rank || (rank == best_rank && value > best_value)) {
      best = i;
      best_rank = rank;
      best_value = value;
    }
  }
  return best < 0 ? Eigen::VectorXd() : Eigen::VectorXd(points.row(best).transpose());
}

class SurrogateLmFactory final : public OptimizerFactory {
 public:
  const std::string& name() const override {
    static const std::string name = "surrogate_lm";
    return name;
  }
  std::string Describe() const override {
    return "Levenberg-Marquardt on Gaussian processes of the responses, refitted each round";
  }
  void Serialize(Archive& archive, const SearchSpace& space) override {
    options_.Serialize(archive, space);
  }
  std::unique_ptr<Optimizer> Make(const SearchSpace& space, const Objectives& objectives,
                                  std::uint64_t seed) const override {
    return MakeSurrogateLm(options_, space, objectives, seed);
  }
  DesignOptions* initial_design() override { return &options_.initial_design; }

 private:
  SurrogateLmOptions options_;
};

}  // namespace

void SurrogateLmOptions::Serialize(Archive& archive, const SearchSpace& space) {
  initial_design.SerializeSection(archive, "initial_design", space);
  archive.Enumeration("kernel", kernel, "kernel", kKernelNames);
}

std::unique_ptr<Optimizer> MakeSurrogateLm(const SurrogateLmOptions& options,
                                           const SearchSpace& space, const Objectives& objectives,
                                           std::uint64_t seed) {
  return std::make_unique<SurrogateLm>(options, space, objectives, seed);
}

std::unique_ptr<OptimizerFactory> MakeSurrogateLmFactory() {
  return std::make_unique<SurrogateLmFactory>();
}

}  // namespace powdercal

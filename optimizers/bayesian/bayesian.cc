#include "optimizers/bayesian/bayesian.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include "core/random.h"
#include "optimizers/bayesian/acquisition.h"
#include "optimizers/bayesian/scalarisation.h"

namespace powdercal {
namespace {

const std::array<std::string, 2> kAcquisitionNames = {"composite_log_ei", "ei"};
const std::array<std::string, 2> kKernelNames = {"matern52", "rbf"};
constexpr double kDuplicateRadius = 1e-6;  // in the unit box
constexpr int kMinObservations = 2;        // for a process
constexpr int kSpaceFillingTrials = 512;

Eigen::MatrixXd Rows(const std::vector<Eigen::VectorXd>& points, Eigen::Index dimension) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(points.size()), dimension);
  for (std::size_t i = 0; i < points.size(); ++i) {
    rows.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
  }
  return rows;
}

// Observations of one scalar.
struct Series {
  std::vector<Eigen::VectorXd> points;
  std::vector<double> values;
  std::vector<double> variances;

  void Add(const Eigen::VectorXd& point, double value, double variance) {
    points.push_back(point);
    values.push_back(value);
    variances.push_back(std::isfinite(variance) && variance > 0 ? variance : 0);
  }
};

Eigen::VectorXd Vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

class Bayesian final : public Optimizer {
 public:
  Bayesian(const BayesianOptions& options, const SearchSpace& space, const Objectives& objectives,
           std::uint64_t seed)
      : options_(options),
        dimension_(space.dimension()),
        objectives_(Numbered(objectives)),
        objective_count_(ObjectiveCount(objectives_)),
        stream_(RandomStream(seed).Split("bayesian")) {
    if (ExplainUnsupported(space, objectives).empty()) {
      design_ = MakeDesign(options.initial_design, space, seed);
    }
  }

  std::vector<Candidate> Ask(int max_count) override;
  void Tell(std::span<const Observation> observations) override;
  Status status() const override { return {Status::Phase::ready, message_}; }
  Capabilities capabilities() const override {
    return {.noise = true,
            .asynchronous = true,
            .pareto = options_.acquisition == BayesianOptions::Acquisition::composite_log_ei,
            .failures = true};
  }
  std::string ExplainUnsupported(const SearchSpace& space,
                                 const Objectives& objectives) const override;

 private:
  Candidate Propose();
  Scalarisation Scalarise() const;
  double Scalarised(const Observation& observation, const Eigen::ArrayXd& weights) const;
  std::optional<Acquisition> MakeAcquisition(const Scalarisation& scalarisation) const;
  GaussianProcess FitProcess(const Series& series, double fallback_scale) const;
  void FitResponses(const Scalarisation& scalarisation, std::vector<GaussianProcess>* processes,
                    Acquisition::Objective* objective) const;
  void FitObjective(std::vector<GaussianProcess>* processes,
                    Acquisition::Objective* objective) const;
  Eigen::VectorXd FarthestPoint(std::uint64_t seed) const;
  Eigen::MatrixXd Anchors(const Scalarisation& scalarisation) const;
  Eigen::MatrixXd Taken() const;
  bool IsTaken(const Eigen::VectorXd& point) const;
  bool TooManyFailures() const;
  bool Complete(const Observation& observation) const {
    return !observation.failed && observation.responses.allFinite();
  }

  BayesianOptions options_;
  int dimension_;
  Objectives objectives_;
  int objective_count_;
  RandomStream stream_;
  std::vector<DesignPoint> design_;
  std::size_t design_next_ = 0;
  std::int64_t asked_ = 0;
  std::map<std::int64_t, Eigen::VectorXd> pending_;
  // By id, so that the order of telling makes no difference, not even of rounding.
  std::map<std::int64_t, Observation> observations_;
  std::optional<Acquisition> acquisition_;  // given observations_ and pending_; none: to be made
  std::string message_;
};

std::string Bayesian::ExplainUnsupported(const SearchSpace& space,
                                         const Objectives& objectives) const {
  if (space.dimension() == 0) return "there is no parameter to search";
  if (objectives.targets.empty()) return "there is no observed response to match";
  if (options_.acquisition == BayesianOptions::Acquisition::ei &&
      ObjectiveCount(Numbered(objectives)) > 1) {
    return "`acquisition: ei` models one chi² and the study has several objectives; use "
           "`acquisition: composite_log_ei`, or `objective: joint`";
  }
  return options_.initial_design.ExplainUnsupported(space);
}

std::vector<Candidate> Bayesian::Ask(int max_count) {
  std::vector<Candidate> candidates;
  while (static_cast<int>(candidates.size()) < max_count) {
    Candidate candidate;
    if (design_next_ < design_.size()) {
      const DesignPoint& next = design_[design_next_++];
      // Known from an earlier run or from the user.
      if (options_.de_duplication && IsTaken(next.point)) continue;
      candidate.point = next.point;
      candidate.origin = "initial design: " + next.label;
      acquisition_.reset();
    } else {
      candidate = Propose();
      if (objective_count_ > 1) {
        acquisition_.reset();  // the next proposal has weights of its own
      } else if (acquisition_) {
        acquisition_->AddPending(candidate.point);
      }
    }
    candidate.id = asked_++;
    pending_[candidate.id] = candidate.point;
    candidates.push_back(std::move(candidate));
  }
  return candidates;
}

void Bayesian::Tell(std::span<const Observation> observations) {
  const auto count = static_cast<Eigen::Index>(objectives_.targets.size());
  for (const Observation& observation : observations) {
    const bool sizes_agree =
        observation.failed ||
        (observation.responses.size() == count &&
         (observation.variances.size() == 0 || observation.variances.size() == count));
    if (observation.point.size() != dimension_ || !sizes_agree) {
      throw std::invalid_argument(
          fmt::format("bayesian: observation {} has {} parameters, {} responses and {} variances, "
                      "expected {}, {} and {}",
                      observation.id, observation.point.size(), observation.responses.size(),
                      observation.variances.size(), dimension_, count, count));
    }
    pending_.erase(observation.id);
    Observation& kept = observations_[observation.id] = observation;
    if (kept.failed) continue;
    if (kept.variances.size() == 0) kept.variances = Eigen::VectorXd::Zero(count);
    // Infinite responses are as absent as NaN ones; without any response it is a failure.
    for (double& response : kept.responses) {
      if (!std::isfinite(response)) response = std::numeric_limits<double>::quiet_NaN();
    }
    kept.failed = kept.responses.array().isNaN().all();
  }
  acquisition_.reset();
}

Scalarisation Bayesian::Scalarise() const {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  Eigen::MatrixXd chi2 = Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(observations_.size()),
                                                   objective_count_, kNaN);
  Eigen::Index row = 0;
  for (const auto& [id, observation] : observations_) {
    if (Complete(observation)) {
      for (int o = 0; o < objective_count_; ++o) {
        chi2(row, o) = ChiSquared(objectives_, observation.responses, observation.variances, o);
      }
    }
    ++row;
  }
  return MakeScalarisation(chi2, asked_,
                           stream_.Split(static_cast<std::uint64_t>(asked_)).Split("objectives"));
}

double Bayesian::Scalarised(const Observation& observation, const Eigen::ArrayXd& weights) const {
  double sum = 0;
  for (int o = 0; o < objective_count_; ++o) {
    sum += weights[o] * ChiSquared(objectives_, observation.responses, observation.variances, o);
  }
  return sum;
}

Candidate Bayesian::Propose() {
  const RandomStream stream = stream_.Split(static_cast<std::uint64_t>(asked_));
  const Scalarisation scalarisation = Scalarise();
  message_.clear();
  if (!acquisition_) {
    try {
      acquisition_ = MakeAcquisition(scalarisation);
      if (!acquisition_) message_ = "fewer than two evaluations have succeeded";
    } catch (const std::exception& error) {
      message_ = fmt::format("no surrogate could be fitted ({})", error.what());
    }
  }
  if (acquisition_) {
    MaximisationLimits limits{.taken = Taken(),
                              .radius = options_.de_duplication ? kDuplicateRadius : -1,
                              .min_feasibility = TooManyFailures() ? 0.5 : 0};
    const Eigen::MatrixXd anchors = Anchors(scalarisation);
    Eigen::VectorXd point = MaximiseAcquisition(*acquisition_, anchors, limits, stream.seed());
    if (point.size() == 0 && limits.min_feasibility > 0) {
      limits.min_feasibility = 0;
      point = MaximiseAcquisition(*acquisition_, anchors, limits, stream.seed());
    }
    if (point.size() > 0) {
      std::string origin = kAcquisitionNames[static_cast<std::size_t>(options_.acquisition)];
      if (objective_count_ > 1) {
        const std::vector<double> shares(scalarisation.shares.begin(), scalarisation.shares.end());
        origin += fmt::format(", weights {:.2f}", fmt::join(shares, " : "));
      }
      return {.point = point, .origin = std::move(origin)};
    }
    message_ = "the acquisition has no usable maximum";
  }
  message_ += "; filling space instead";
  return {.point = FarthestPoint(stream.seed()), .origin = "space filling: " + message_};
}

GaussianProcess Bayesian::FitProcess(const Series& series, double fallback_scale) const {
  GaussianProcess::Options options;
  options.model.kernel = options_.kernel;
  // Simulations are often free of noise, and then a handful of points cannot show it: the process's
  // own prior, LogNormal(−4, 1), makes it miss targets by a tenth of the spread of the responses.
  // This one is lower, and wide enough for the noise that is there: medians of chi² on the
  // environmental model of 4 parameters fall tenfold at 30 evaluations. The weaker tie of the
  // lengthscales finds inputs that do nothing sooner.
  options.model.noise_location = -6;
  options.model.noise_scale = 2;
  options.model.lengthscale_spread = 1;
  options.fallback_scale = fallback_scale;
  // Without any spread in the data the learned scale of the function would shrink to nothing.
  const auto [low, high] = std::minmax_element(series.values.begin(), series.values.end());
  if (*low == *high) options.model.signal_variance = 1;
  GaussianProcess process(options);
  process.Fit(Rows(series.points, dimension_), Vector(series.values), Vector(series.variances));
  return process;
}

void Bayesian::FitResponses(const Scalarisation& scalarisation,
                            std::vector<GaussianProcess>* processes,
                            Acquisition::Objective* objective) const {
  std::vector<double> targets;
  std::vector<double> weights;
  std::set<int> known;  // objectives
  for (std::size_t j = 0; j < objectives_.targets.size(); ++j) {
    const Target& target = objectives_.targets[j];
    const auto index = static_cast<Eigen::Index>(j);
    Series series;
    for (const auto& [id, observation] : observations_) {
      if (observation.failed || std::isnan(observation.responses[index])) continue;
      series.Add(observation.point, observation.responses[index], observation.variances[index]);
    }
    // A response that has not been seen yet waits; the others go on.
    if (series.values.size() < kMinObservations) continue;
    // As in ChiSquared, with one weight for all points.
    targets.push_back(target.value);
    weights.push_back(scalarisation.weights[target.objective] /
                      (target.sd * target.sd + Median(series.variances)));
    // If all values are equal they differ from the target by the scale that matters.
    const double scale = std::max(std::abs(series.values.front() - target.value), target.sd);
    processes->push_back(FitProcess(series, scale));
    known.insert(target.objective);
  }
  // Nothing can be weighed against an objective of which nothing is known.
  if (static_cast<int>(known.size()) < objective_count_) processes->clear();
  objective->composite = true;
  objective->targets = Vector(targets);
  objective->weights = Vector(weights);
}

void Bayesian::FitObjective(std::vector<GaussianProcess>* processes,
                            Acquisition::Objective* objective) const {
  Series series;
  for (const auto& [id, observation] : observations_) {
    if (!Complete(observation)) continue;
    // Variance of chi² from those of the responses: w (f − t)², f normal.
    double variance = 0;
    for (std::size_t j = 0; j < objectives_.targets.size(); ++j) {
      const Target& target = objectives_.targets[j];
      const auto index = static_cast<Eigen::Index>(j);
      const double v = observation.variances[index];
      if (!(v > 0)) continue;
      const double w = 1 / (target.sd * target.sd + v);
      const double residual = observation.responses[index] - target.value;
      variance += w * w * (4 * residual * residual * v + 2 * v * v);
    }
    series.Add(observation.point,
               ChiSquared(objectives_, observation.responses, observation.variances), variance);
  }
  if (series.values.size() < kMinObservations) return;
  const Eigen::ArrayXd values = Vector(series.values).array();
  const double sd =
      std::sqrt((values - values.mean()).square().sum() / static_cast<double>(values.size() - 1));
  objective->composite = false;
  objective->margin = options_.jitter * sd;
  processes->push_back(FitProcess(series, std::max(1.0, series.values.front())));
}

std::optional<Acquisition> Bayesian::MakeAcquisition(const Scalarisation& scalarisation) const {
  std::vector<GaussianProcess> processes;
  Acquisition::Objective objective;
  if (options_.acquisition == BayesianOptions::Acquisition::ei) {
    FitObjective(&processes, &objective);
  } else {
    FitResponses(scalarisation, &processes, &objective);
  }
  if (processes.empty()) return std::nullopt;

  std::vector<Eigen::VectorXd> all;
  std::vector<double> successes;
  std::vector<Eigen::VectorXd> evaluated;
  std::vector<Eigen::VectorXd> partly;
  std::vector<Eigen::VectorXd> failed;
  for (const auto& [id, observation] : observations_) {
    all.push_back(observation.point);
    successes.push_back(
        observation.failed ? 0 : observation.responses.array().isFinite().cast<double>().mean());
    if (observation.failed) {
      failed.push_back(observation.point);
    } else {
      (Complete(observation) ? evaluated : partly).push_back(observation.point);
    }
  }
  if (evaluated.empty()) evaluated = partly;
  Acquisition acquisition(std::move(objective), std::move(processes),
                          Feasibility(Rows(all, dimension_), Vector(successes)),
                          Rows(evaluated, dimension_), Rows(failed, dimension_),
                          stream_.Split("pending").seed());
  for (const auto& [id, point] : pending_) acquisition.AddPending(point);
  return acquisition;
}

Eigen::MatrixXd Bayesian::Anchors(const Scalarisation& scalarisation) const {
  // The best evaluations as they came out, and the best by the model.
  constexpr std::size_t kAnchors = 4;
  std::vector<std::pair<double, std::int64_t>> ranked;
  for (const auto& [id, observation] : observations_) {
    if (!Complete(observation)) continue;
    ranked.emplace_back(Scalarised(observation, scalarisation.weights), id);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<Eigen::VectorXd> points = {acquisition_->best_point()};
  for (std::size_t i = 0; i < std::min(kAnchors, ranked.size()); ++i) {
    points.push_back(observations_.at(ranked[i].second).point);
  }
  return Rows(points, dimension_);
}

Eigen::MatrixXd Bayesian::Taken() const {
  std::vector<Eigen::VectorXd> points;
  for (const auto& [id, observation] : observations_) points.push_back(observation.point);
  for (const auto& [id, point] : pending_) points.push_back(point);
  return Rows(points, dimension_);
}

bool Bayesian::IsTaken(const Eigen::VectorXd& point) const {
  const Eigen::MatrixXd taken = Taken();
  return taken.rows() > 0 &&
         (taken.rowwise() - point.transpose()).rowwise().norm().minCoeff() <= kDuplicateRadius;
}

// The share of failures that is risked: an acquisition that is all but exhausted where evaluations
// succeed would go on for ever where they fail, however unlikely success.
bool Bayesian::TooManyFailures() const {
  const auto failures = std::count_if(observations_.begin(), observations_.end(),
                                      [](const auto& item) { return item.second.failed; });
  return 4 * failures > static_cast<std::ptrdiff_t>(observations_.size());
}

Eigen::VectorXd Bayesian::FarthestPoint(std::uint64_t seed) const {
  const Eigen::MatrixXd trials = SobolPoints(kSpaceFillingTrials, dimension_, seed);
  const Eigen::MatrixXd taken = Taken();
  if (taken.rows() == 0) return trials.row(0).transpose();
  Eigen::Index farthest = 0;
  double distance = -1;
  for (Eigen::Index i = 0; i < trials.rows(); ++i) {
    const double nearest = (taken.rowwise() - trials.row(i)).rowwise().squaredNorm().minCoeff();
    if (nearest > distance) {
      distance = nearest;
      farthest = i;
    }
  }
  return trials.row(farthest).transpose();
}

class BayesianFactory final : public OptimizerFactory {
 public:
  const std::string& name() const override {
    static const std::string name = "bayesian";
    return name;
  }
  std::string Describe() const override {
    return "Bayesian optimization with Gaussian processes; a process per response by default";
  }
  void Serialize(Archive& archive, const SearchSpace& space) override {
    options_.Serialize(archive, space);
  }
  std::unique_ptr<Optimizer> Make(const SearchSpace& space, const Objectives& objectives,
                                  std::uint64_t seed) const override {
    return MakeBayesian(options_, space, objectives, seed);
  }

 private:
  BayesianOptions options_;
};

}  // namespace

void BayesianOptions::Serialize(Archive& archive, const SearchSpace& space) {
  archive.Enumeration("acquisition", acquisition, "acquisition", kAcquisitionNames);
  if (acquisition == Acquisition::ei) {
    archive.Number("jitter", jitter, kNonNegative);
  } else if (archive.Has("jitter")) {
    throw archive.ErrorAt("jitter", "only for `acquisition: ei`");
  }
  archive.Enumeration("kernel", kernel, "kernel", kKernelNames);
  initial_design.SerializeSection(archive, "initial_design", space);
  archive.Flag("de_duplication", de_duplication);
}

std::unique_ptr<Optimizer> MakeBayesian(const BayesianOptions& options, const SearchSpace& space,
                                        const Objectives& objectives, std::uint64_t seed) {
  return std::make_unique<Bayesian>(options, space, objectives, seed);
}

std::unique_ptr<OptimizerFactory> MakeBayesianFactory() {
  return std::make_unique<BayesianFactory>();
}

}  // namespace powdercal

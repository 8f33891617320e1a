#include "optimizers/bayesian/bayesian.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/random.h"
#include "optimizers/bayesian/fidelity.h"
#include "optimizers/bayesian/improvement.h"
#include "optimizers/bayesian/sampled_acquisition.h"
#include "optimizers/bayesian/scalarisation.h"
#include "optimizers/bayesian/search_region.h"
#include "optimizers/models.h"
#include "optimizers/observations.h"
#include "optimizers/pareto.h"

namespace powdercal {
namespace {

using Kind = BayesianOptions::Acquisition;

const std::array<std::string, 7> kAcquisitionNames = {
    "automatic", "composite_log_ei", "ei", "log_ei", "qlog_nei", "qlog_nehvi", "qlog_nparego"};
const std::array<std::string, 2> kKernelNames = {"matern52", "rbf"};
const std::array<std::string, 3> kTrustRegionNames = {"automatic", "on", "off"};
constexpr int kSpaceFillingTrials = 512;
constexpr int kMaxHypervolumeObjectives = 4;
constexpr int kTrustRegionDimension = 10;  // above it
constexpr int kFirstAtTarget = 2;          // proposals, for what tells the fidelities apart
constexpr Eigen::Index kNoiseSamples = 16;
constexpr Eigen::Index kChebyshevSamples = 64;

// Sums of squares are weighed exactly and fast, and their fronts are convex where responses are
// nearly linear; of responses to be minimised nothing of the kind is known.
Kind Resolve(Kind kind, const Objectives& objectives) {
  if (kind != Kind::automatic) return kind;
  const int count = ObjectiveCount(objectives);
  const bool minimised = std::any_of(objectives.targets.begin(), objectives.targets.end(),
                                     [](const Target& target) { return target.minimise; });
  if (count == 1 || !minimised) return Kind::composite_log_ei;
  return count <= kMaxHypervolumeObjectives ? Kind::qlog_nehvi : Kind::qlog_nparego;
}

bool ForSeveral(Kind kind) { return kind == Kind::qlog_nehvi || kind == Kind::qlog_nparego; }

// Modelled as one number.
bool ForScalar(Kind kind) { return kind == Kind::ei || kind == Kind::log_ei; }

class Bayesian final : public Optimizer {
 public:
  Bayesian(const BayesianOptions& options, const SearchSpace& space, const Objectives& objectives,
           std::uint64_t seed)
      : options_(options),
        space_(space),
        dimension_(space.dimension()),
        modelled_space_(options.fidelities.empty() ? space : WithFidelity(space)),
        objectives_(Numbered(objectives)),
        objective_count_(ObjectiveCount(objectives_)),
        kind_(Resolve(options.acquisition, objectives_)),
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
            .pareto = options_.acquisition == Kind::automatic || kind_ == Kind::composite_log_ei ||
                      ForSeveral(kind_),
            .failures = true,
            .discrete = true};
  }
  std::string ExplainUnsupported(const SearchSpace& space,
                                 const Objectives& objectives) const override;

 private:
  Candidate Propose();
  Scalarisation Scalarise() const;
  double Scalarised(const Observation& observation, const Eigen::ArrayXd& weights) const;
  /// Objectives of the complete observations, in the order of ids; rows of NaN for the others.
  Eigen::MatrixXd ObjectiveRows() const;
  Models FitModels() const;
  std::unique_ptr<Acquisition> MakeAcquisition(const Scalarisation& scalarisation) const;
  std::unique_ptr<Acquisition> MakeSampledAcquisition(const Scalarisation& scalarisation) const;
  std::vector<ObjectiveTerm> Terms() const;
  Eigen::VectorXd Reference() const;
  Eigen::MatrixXd Anchors(const Scalarisation& scalarisation, const Acquisition& acquisition) const;
  void LimitSearch(MaximisationLimits* limits) const;
  bool SeveralFidelities() const { return !options_.fidelities.empty(); }
  Eigen::VectorXd Modelled(const Eigen::VectorXd& point, double fidelity) const {
    return SeveralFidelities() ? WithFidelity(point, fidelity) : point;
  }
  Eigen::VectorXd InBox(const Eigen::VectorXd& modelled) const { return modelled.head(dimension_); }
  int ModelledDimension() const { return modelled_space_.dimension(); }
  double CheapestFidelity() const;
  double FidelityFor(const Eigen::VectorXd& point) const;
  Eigen::ArrayXd ObjectiveWeights() const;
  /// Modelled points that are evaluated or under way; those of the box that are so at the target.
  Eigen::MatrixXd Taken() const {
    return TakenPoints(observations_, pending_, ModelledDimension());
  }
  Eigen::MatrixXd TakenAtTarget() const {
    return SeveralFidelities() ? AtTarget(Taken()) : Taken();
  }
  bool TooManyFailures() const;

  BayesianOptions options_;
  SearchSpace space_;
  int dimension_;
  SearchSpace modelled_space_;  // with the fidelity, where there are several
  Objectives objectives_;
  int objective_count_;
  Kind kind_;
  RandomStream stream_;
  std::vector<DesignPoint> design_;
  std::size_t design_next_ = 0;
  std::int64_t asked_ = 0;
  PointsById pending_;             // modelled points
  ObservationsById observations_;  // of modelled points
  std::optional<Models> models_;   // of observations_; none: to be fitted
  std::string message_;
};

std::string Bayesian::ExplainUnsupported(const SearchSpace& space,
                                         const Objectives& objectives) const {
  if (space.dimension() == 0) return "there is no parameter to search";
  if (objectives.targets.empty()) return "there is no observed response to match";
  const Objectives numbered = Numbered(objectives);
  const int count = ObjectiveCount(numbered);
  const Kind kind = Resolve(options_.acquisition, numbered);
  const std::string& name = kAcquisitionNames[static_cast<std::size_t>(kind)];
  if (ForScalar(kind) && count > 1) {
    return fmt::format(
        "`acquisition: {}` models one chi² and the study has several objectives; use `acquisition: "
        "qlog_nehvi`, qlog_nparego or composite_log_ei, or `objective: joint`",
        name);
  }
  if (kind == Kind::qlog_nei && count > 1) {
    return "`acquisition: qlog_nei` improves one objective and the study has several; use "
           "`acquisition: qlog_nehvi`, or `objective: joint`";
  }
  if (ForSeveral(kind) && count == 1) {
    return fmt::format(
        "`acquisition: {}` is for several objectives and the study has one; use `acquisition: "
        "composite_log_ei` or qlog_nei, or `objective: pareto`",
        name);
  }
  if (kind == Kind::qlog_nehvi && count > kMaxHypervolumeObjectives) {
    return fmt::format(
        "`acquisition: qlog_nehvi` takes up to {} objectives and the study has {}; use "
        "`acquisition: qlog_nparego`",
        kMaxHypervolumeObjectives, count);
  }
  if (!options_.fidelities.empty()) {
    const std::string reason = ExplainBadFidelities(options_.fidelities);
    if (!reason.empty()) return reason;
    if (count > 1 || ForSeveral(kind) || kind == Kind::qlog_nei) {
      return "several fidelities need one objective and `acquisition: composite_log_ei`, ei or "
             "log_ei";
    }
  }
  for (const Target& target : numbered.targets) {
    if (!target.minimise) continue;
    if (kind == Kind::composite_log_ei && count > 1) {
      return "`acquisition: composite_log_ei` weighs sums of squares and an objective is a "
             "response "
             "to be minimised; use `acquisition: qlog_nehvi` or qlog_nparego";
    }
    const auto same =
        std::count_if(numbered.targets.begin(), numbered.targets.end(),
                      [&](const Target& other) { return other.objective == target.objective; });
    if (same > 1) return "an objective that is a response to be minimised can have no other target";
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
      candidate.fidelity = CheapestFidelity();
      if (options_.de_duplication && IsTaken(Taken(), Modelled(next.point, candidate.fidelity))) {
        continue;
      }
      candidate.point = next.point;
      candidate.origin = "initial design: " + next.label;
    } else {
      candidate = Propose();
    }
    candidate.id = asked_++;
    pending_[candidate.id] = Modelled(candidate.point, candidate.fidelity);
    candidates.push_back(std::move(candidate));
  }
  return candidates;
}

void Bayesian::Tell(std::span<const Observation> observations) {
  for (const Observation& observation : observations) {
    Observation& kept = observations_[observation.id] =
        CheckedObservation("bayesian", observation, dimension_, objectives_);
    kept.point = Modelled(observation.point, observation.fidelity);
    pending_.erase(observation.id);
  }
  models_.reset();
}

Eigen::MatrixXd Bayesian::ObjectiveRows() const {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  Eigen::MatrixXd rows = Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(observations_.size()),
                                                   objective_count_, kNaN);
  Eigen::Index row = 0;
  for (const auto& [id, observation] : observations_) {
    for (int o = 0; o < objective_count_ && Complete(observation); ++o) {
      rows(row, o) = ChiSquared(objectives_, observation.responses, observation.variances, o);
    }
    ++row;
  }
  return rows;
}

Scalarisation Bayesian::Scalarise() const {
  return MakeScalarisation(ObjectiveRows(), asked_,
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
  std::unique_ptr<Acquisition> acquisition;
  try {
    if (!models_) models_ = FitModels();
    if (!models_->processes.empty()) acquisition = MakeAcquisition(scalarisation);
    if (!acquisition) message_ = "fewer than two evaluations have succeeded";
  } catch (const std::exception& error) {
    message_ = fmt::format("no surrogate could be fitted ({})", error.what());
  }
  if (acquisition) {
    MaximisationLimits limits{.space = &space_,
                              .lower = Eigen::VectorXd::Zero(dimension_),
                              .upper = Eigen::VectorXd::Ones(dimension_),
                              .taken = TakenAtTarget(),
                              .radius = options_.de_duplication ? kDuplicateRadius : -1,
                              .min_feasibility = TooManyFailures() ? 0.5 : 0};
    LimitSearch(&limits);
    const Eigen::MatrixXd anchors = Anchors(scalarisation, *acquisition);
    Eigen::VectorXd point = MaximiseAcquisition(*acquisition, anchors, limits, stream.seed());
    if (point.size() == 0 && limits.min_feasibility > 0) {
      limits.min_feasibility = 0;
      point = MaximiseAcquisition(*acquisition, anchors, limits, stream.seed());
    }
    if (point.size() > 0) {
      std::string origin = kAcquisitionNames[static_cast<std::size_t>(kind_)];
      if (objective_count_ > 1 && kind_ != Kind::qlog_nehvi) {
        const std::vector<double> shares(scalarisation.shares.begin(), scalarisation.shares.end());
        origin += fmt::format(", weights {:.2f}", fmt::join(shares, " : "));
      }
      Candidate candidate{.point = point, .origin = std::move(origin)};
      if (SeveralFidelities()) candidate.fidelity = FidelityFor(point);
      return candidate;
    }
    message_ = "the acquisition has no usable maximum";
  }
  message_ += "; filling space instead";
  return {.point = space_.Snap(FarthestPoint(Taken().leftCols(dimension_), dimension_,
                                             kSpaceFillingTrials, stream.seed())),
          .origin = "space filling: " + message_,
          .fidelity = CheapestFidelity()};
}

double Bayesian::CheapestFidelity() const {
  const auto cheapest = std::min_element(
      options_.fidelities.begin(), options_.fidelities.end(),
      [](const FidelityLevel& a, const FidelityLevel& b) { return a.cost < b.cost; });
  return cheapest == options_.fidelities.end() ? 1 : cheapest->fidelity;
}

// Of the processes, in a single objective.
Eigen::ArrayXd Bayesian::ObjectiveWeights() const {
  if (ForScalar(kind_)) return Eigen::ArrayXd::Ones(1);
  return Terms().front().weights;
}

double Bayesian::FidelityFor(const Eigen::VectorXd& point) const {
  const auto at_target = std::count_if(observations_.begin(), observations_.end(),
                                       [&](const auto& item) { return item.second.fidelity == 1; });
  const auto under_way = std::count_if(pending_.begin(), pending_.end(), [&](const auto& item) {
    return item.second[dimension_] == 1;
  });
  if (at_target + under_way < kFirstAtTarget) return 1;
  std::vector<Eigen::VectorXd> rows;
  for (const auto& [id, pending] : pending_) rows.push_back(pending);
  std::vector<GaussianProcess> processes;
  for (const GaussianProcess& process : models_->processes) {
    processes.push_back(process.ConditionedOn(Rows(rows, ModelledDimension())));
  }
  return ChooseFidelity(processes, ObjectiveWeights(), models_->noise_variances, point,
                        options_.fidelities, Taken());
}

Models Bayesian::FitModels() const {
  const ModelOptions options{.kernel = options_.kernel, .warp = options_.input_warping};
  return ForScalar(kind_) ? FitObjective(modelled_space_, objectives_, observations_, options)
                          : FitResponses(modelled_space_, objectives_, observations_, options);
}

// Of each objective. Weights are those of ChiSquared, with one for all points.
std::vector<ObjectiveTerm> Bayesian::Terms() const {
  std::vector<ObjectiveTerm> terms(static_cast<std::size_t>(objective_count_));
  for (std::size_t i = 0; i < models_->targets.size(); ++i) {
    const Target& target = objectives_.targets[models_->targets[i]];
    ObjectiveTerm& term = terms[static_cast<std::size_t>(target.objective)];
    term.linear = target.minimise;
    term.processes.push_back(i);
    const auto size = static_cast<Eigen::Index>(term.processes.size());
    term.targets.conservativeResize(size);
    term.weights.conservativeResize(size);
    term.targets[size - 1] = target.value;
    const double noise = models_->noise_variances[static_cast<Eigen::Index>(i)];
    term.weights[size - 1] = target.minimise ? 1 / target.sd : 1 / (target.sd * target.sd + noise);
  }
  return terms;
}

std::unique_ptr<Acquisition> Bayesian::MakeAcquisition(const Scalarisation& scalarisation) const {
  if (kind_ == Kind::qlog_nei || ForSeveral(kind_)) return MakeSampledAcquisition(scalarisation);
  ImprovementAcquisition::Objective objective;
  if (ForScalar(kind_) || objectives_.targets.front().minimise) {
    objective.composite = false;
    if (kind_ == Kind::ei) {
      const Eigen::ArrayXd values = ObjectiveRows().col(0).array();
      const Eigen::ArrayXd known = values.isNaN().select(0, values);
      const double count = static_cast<double>((!values.isNaN()).count());
      const double mean = known.sum() / count;
      const double squares = values.isNaN().select(0, (values - mean).square()).sum();
      objective.margin = options_.jitter * std::sqrt(squares / (count - 1));
    }
  } else {
    const auto count = static_cast<Eigen::Index>(models_->processes.size());
    objective.targets.resize(count);
    objective.weights.resize(count);
    const std::vector<ObjectiveTerm> terms = Terms();
    for (std::size_t o = 0; o < terms.size(); ++o) {
      for (std::size_t j = 0; j < terms[o].processes.size(); ++j) {
        const auto process = static_cast<Eigen::Index>(terms[o].processes[j]);
        const auto index = static_cast<Eigen::Index>(j);
        objective.targets[process] = terms[o].targets[index];
        objective.weights[process] =
            scalarisation.weights[static_cast<Eigen::Index>(o)] * terms[o].weights[index];
      }
    }
  }
  // Below the target nothing counts as reached, unless there is nothing else.
  std::vector<Eigen::VectorXd> evaluated;
  std::vector<Eigen::VectorXd> partly;
  std::vector<Eigen::VectorXd> failed;
  for (const auto& [id, observation] : observations_) {
    if (observation.failed) {
      failed.push_back(observation.point);
    } else {
      const bool reached = Complete(observation) && observation.fidelity == 1;
      (reached ? evaluated : partly).push_back(Modelled(InBox(observation.point), 1));
    }
  }
  if (evaluated.empty()) evaluated = partly;
  auto acquisition = std::make_unique<ImprovementAcquisition>(
      std::move(objective), models_->processes,
      LearnFeasibility(observations_, ModelledDimension()), Rows(evaluated, ModelledDimension()),
      Rows(failed, ModelledDimension()), stream_.Split("pending").seed());
  for (const auto& [id, point] : pending_) {
    acquisition->AddPending(point, !SeveralFidelities() || point[dimension_] == 1);
  }
  if (SeveralFidelities()) return MakeTargetAcquisition(std::move(acquisition));
  return acquisition;
}

std::unique_ptr<Acquisition> Bayesian::MakeSampledAcquisition(
    const Scalarisation& scalarisation) const {
  SampledAcquisition::Data data{.processes = models_->processes,
                                .terms = Terms(),
                                .feasibility = LearnFeasibility(observations_, dimension_)};
  std::vector<Eigen::VectorXd> counted;
  for (const auto& [id, observation] : observations_) {
    if (!observation.failed) counted.push_back(observation.point);
  }
  for (const auto& [id, point] : pending_) counted.push_back(point);
  for (const std::size_t target : models_->targets) {
    std::vector<Eigen::VectorXd> unobserved;
    for (const auto& [id, observation] : observations_) {
      if (observation.failed ||
          std::isnan(observation.responses[static_cast<Eigen::Index>(target)])) {
        unobserved.push_back(observation.point);
      }
    }
    for (const auto& [id, point] : pending_) unobserved.push_back(point);
    data.unobserved.push_back(Rows(unobserved, dimension_));
  }
  data.counted = Rows(counted, dimension_);
  Eigen::Index samples = kNoiseSamples;
  std::unique_ptr<SampleUtility> utility;
  if (kind_ == Kind::qlog_nei) {
    utility = MakeImprovementUtility(data.terms[0], samples);
  } else if (kind_ == Kind::qlog_nehvi) {
    utility = MakeHypervolumeUtility(data.terms, Reference(), samples);
  } else {
    samples = kChebyshevSamples;
    RandomStream random = stream_.Split(static_cast<std::uint64_t>(asked_)).Split("outcomes");
    Eigen::MatrixXd normals(static_cast<Eigen::Index>(data.processes.size()), samples);
    for (double& z : normals.reshaped()) z = random.Normal();
    utility = MakeChebyshevUtility(data.terms, scalarisation.shares, normals);
  }
  return std::make_unique<SampledAcquisition>(std::move(data), std::move(utility), samples,
                                              stream_.Split("samples").seed());
}

// The user's, or a tenth of the front's extent beyond its worst values. A front of one point has no
// extent: then beyond the worst that was seen.
Eigen::VectorXd Bayesian::Reference() const {
  if (static_cast<int>(objectives_.reference.size()) == objective_count_) {
    return Eigen::Map<const Eigen::VectorXd>(objectives_.reference.data(), objective_count_);
  }
  constexpr double kMargin = 0.1;
  const Eigen::MatrixXd rows = ObjectiveRows();
  std::vector<std::size_t> front = NonDominated(rows);
  if (front.size() < 2) {
    front.clear();
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      if (rows.row(i).allFinite()) front.push_back(static_cast<std::size_t>(i));
    }
  }
  Eigen::VectorXd reference(objective_count_);
  for (int o = 0; o < objective_count_; ++o) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const std::size_t i : front) {
      low = std::min(low, rows(static_cast<Eigen::Index>(i), o));
      high = std::max(high, rows(static_cast<Eigen::Index>(i), o));
    }
    reference[o] = high + kMargin * std::max(high - low, 1e-6 * std::max(1.0, std::abs(high)));
  }
  return reference;
}

Eigen::MatrixXd Bayesian::Anchors(const Scalarisation& scalarisation,
                                  const Acquisition& acquisition) const {
  // The best evaluations as they came out, and the best by the model; of several objectives the
  // front.
  constexpr std::size_t kAnchors = 4;
  constexpr std::size_t kFrontAnchors = 12;
  std::vector<Eigen::VectorXd> points = {acquisition.best_point()};
  if (ForSeveral(kind_)) {
    std::vector<Eigen::VectorXd> all;
    for (const auto& [id, observation] : observations_) all.push_back(observation.point);
    const std::vector<std::size_t> front = NonDominated(ObjectiveRows());
    const std::size_t step = front.size() / kFrontAnchors + 1;
    for (std::size_t i = 0; i < front.size(); i += step) points.push_back(all[front[i]]);
    return Rows(points, dimension_);
  }
  std::vector<std::pair<double, std::int64_t>> ranked;
  for (const auto& [id, observation] : observations_) {
    if (!Complete(observation) || observation.fidelity < 1) continue;
    ranked.emplace_back(Scalarised(observation, scalarisation.weights), id);
  }
  std::sort(ranked.begin(), ranked.end());
  for (std::size_t i = 0; i < std::min(kAnchors, ranked.size()); ++i) {
    points.push_back(InBox(observations_.at(ranked[i].second).point));
  }
  return Rows(points, dimension_);
}

// Of one objective: around the best point, but not where the search creeps.
void Bayesian::LimitSearch(MaximisationLimits* limits) const {
  if (objective_count_ > 1) return;
  std::vector<SearchStep> steps;
  bool any = false;
  for (const auto& [id, observation] : observations_) {
    if (observation.fidelity < 1) continue;
    SearchStep step{.point = InBox(observation.point),
                    .value = std::numeric_limits<double>::infinity(),
                    .proposed = id >= static_cast<std::int64_t>(design_.size())};
    if (Complete(observation)) {
      step.value = ChiSquared(objectives_, observation.responses, observation.variances);
      any = true;
    }
    steps.push_back(std::move(step));
  }
  if (const std::optional<Eigen::VectorXd> creep = FindCreep(steps)) {
    limits->avoided = *creep;
    limits->avoided_radius = kElsewhere * std::sqrt(static_cast<double>(dimension_));
  }
  const bool trusted = options_.trust_region == BayesianOptions::TrustRegion::on ||
                       (options_.trust_region == BayesianOptions::TrustRegion::automatic &&
                        dimension_ > kTrustRegionDimension);
  if (!trusted || !any) return;
  // Geometric means over the responses; those of categories have no length in the box.
  Eigen::ArrayXd logarithms = Eigen::ArrayXd::Zero(dimension_);
  if (!space_.discrete()) {
    for (const GaussianProcess& process : models_->processes) {
      logarithms += process.hyperparameters().lengthscales.head(dimension_).array().log();
    }
    logarithms /= static_cast<double>(models_->processes.size());
  }
  const TrustRegion region = FindTrustRegion(steps, logarithms.exp().matrix());
  limits->lower = region.lower;
  limits->upper = region.upper;
}

// The share of failures that is risked: an acquisition that is all but exhausted where evaluations
// succeed would go on for ever where they fail, however unlikely success.
bool Bayesian::TooManyFailures() const {
  const auto failures = std::count_if(observations_.begin(), observations_.end(),
                                      [](const auto& item) { return item.second.failed; });
  return 4 * failures > static_cast<std::ptrdiff_t>(observations_.size());
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
  DesignOptions* initial_design() override { return &options_.initial_design; }
  std::vector<FidelityLevel>* fidelities() override { return &options_.fidelities; }

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
  archive.Flag("input_warping", input_warping);
  archive.Enumeration("trust_region", trust_region, "trust region", kTrustRegionNames);
}

std::unique_ptr<Optimizer> MakeBayesian(const BayesianOptions& options, const SearchSpace& space,
                                        const Objectives& objectives, std::uint64_t seed) {
  return std::make_unique<Bayesian>(options, space, objectives, seed);
}

std::unique_ptr<OptimizerFactory> MakeBayesianFactory() {
  return std::make_unique<BayesianFactory>();
}

}  // namespace powdercal

// MakeMetaheuristic: the ask/tell side of all strategies.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "optimizers/metaheuristics/metaheuristic.h"
#include "optimizers/observations.h"

namespace powdercal {
namespace {

class Generational final : public Optimizer {
 public:
  Generational(const Method& method, const MetaheuristicOptions& options, const SearchSpace& space,
               const Objectives& objectives, std::uint64_t seed);

  std::vector<Candidate> Ask(int max_count) override;
  void Tell(std::span<const Observation> observations) override;
  Status status() const override;
  Capabilities capabilities() const override {
    return {.asynchronous = traits_.batches, .pareto = traits_.pareto, .discrete = true};
  }
  std::string ExplainUnsupported(const SearchSpace& space,
                                 const Objectives& objectives) const override;

 private:
  void Check(const Observation& observation) const;
  Individual Evaluated(const Observation& observation) const;
  void StartBatch(const std::vector<Eigen::VectorXd>& points, const std::string& origin);
  void StartDesign();
  void StartUniformPopulation();
  void EndInitialBatch();
  void EndBatch();
  void StartNextBatch();
  int Generation() const { return evaluations_ / generation_size_ + 1; }
  bool Supported() const { return strategy_ != nullptr; }

  std::string name_;
  MethodTraits traits_;
  MetaheuristicOptions options_;
  SearchSpace space_;
  Objectives objectives_;
  int objective_count_;
  int population_;
  RandomStream stream_;
  std::uint64_t seed_;
  std::unique_ptr<Strategy> strategy_;  // none: the problem is not supported

  std::vector<Candidate> batch_;
  std::size_t next_ = 0;                         // of the batch, to be asked for
  std::map<std::int64_t, Individual> outcomes_;  // of the batch
  bool begun_ = false;                           // the initial population is complete
  std::vector<Individual> initial_;              // of the batches before that
  std::map<std::int64_t, Individual> outside_;   // told with negative ids
  std::int64_t first_id_ = 0;                    // of the batch
  int uniform_populations_ = 0;
  // A strategy of single points has its generations counted by the population.
  int generation_size_ = 1;
  int evaluations_ = 0;  // batches since the search began, or points
  std::string end_;      // why the search ended; "" while it goes on
};

Generational::Generational(const Method& method, const MetaheuristicOptions& options,
                           const SearchSpace& space, const Objectives& objectives,
                           std::uint64_t seed)
    : name_(method.name()),
      traits_(method.traits()),
      options_(options),
      space_(space),
      objectives_(Numbered(objectives)),
      objective_count_(ObjectiveCount(objectives_)),
      population_(options.population > 0
                      ? options.population
                      : method.DefaultPopulation(space.dimension(), objective_count_)),
      stream_(RandomStream(seed).Split(name_)),
      seed_(seed) {
  if (!ExplainUnsupported(space, objectives).empty()) return;
  if (!traits_.batches) generation_size_ = population_;
  strategy_ = method.MakeStrategy({.space = space_,
                                   .objectives = objective_count_,
                                   .population = population_,
                                   .random = stream_.Split("strategy")});
  StartDesign();
}

std::string Generational::ExplainUnsupported(const SearchSpace& space,
                                             const Objectives& objectives) const {
  if (space.dimension() == 0) return "there is no parameter to search";
  if (objectives.targets.empty()) return "there is no observed response to match";
  const int count = ObjectiveCount(Numbered(objectives));
  if (traits_.pareto && count < 2) {
    return fmt::format(
        "{} searches for a front of several objectives, and the study has one; use bayesian, "
        "cma_es, differential_evolution or genetic, or `objective: pareto` with two experiments or "
        "more",
        name_);
  }
  if (!traits_.pareto && count > 1) {
    return fmt::format(
        "{} searches for one objective, and the study has {}; use bayesian, moead, nsga2 or nspso, "
        "or `objective: joint`",
        name_, count);
  }
  for (const Parameter& parameter : space.parameters) {
    if (traits_.categorical || parameter.kind != Parameter::Kind::categorical) continue;
    return fmt::format(
        "{} cannot search categories, which have no order ({}); use {}", name_, parameter.name,
        traits_.pareto ? "moead with `implementation: own`" : "genetic with `implementation: own`");
  }
  return options_.initial_design.ExplainUnsupported(space);
}

void Generational::StartBatch(const std::vector<Eigen::VectorXd>& points,
                              const std::string& origin) {
  first_id_ += static_cast<std::int64_t>(batch_.size());
  batch_.clear();
  outcomes_.clear();
  next_ = 0;
  for (const Eigen::VectorXd& point : points) {
    batch_.push_back(
        {first_id_ + static_cast<std::int64_t>(batch_.size()), space_.Snap(point), origin});
  }
}

void Generational::StartDesign() {
  DesignOptions design = options_.initial_design;
  if (!options_.HasDesign()) design.points = population_;
  std::vector<Eigen::VectorXd> points;
  std::vector<std::string> labels;
  for (DesignPoint& next : MakeDesign(design, space_, seed_)) {
    points.push_back(std::move(next.point));
    labels.push_back("initial design: " + next.label);
  }
  RandomStream random = stream_.Split("fill");
  while (static_cast<int>(points.size()) < population_) {
    points.emplace_back(space_.dimension());
    for (double& u : points.back()) u = random.Uniform();
    labels.emplace_back("initial population: random");
  }
  StartBatch(points, "");
  for (std::size_t i = 0; i < labels.size(); ++i) batch_[i].origin = labels[i];
}

void Generational::StartUniformPopulation() {
  RandomStream random =
      stream_.Split("uniform").Split(static_cast<std::uint64_t>(uniform_populations_++));
  std::vector<Eigen::VectorXd> points(static_cast<std::size_t>(population_),
                                      Eigen::VectorXd(space_.dimension()));
  for (Eigen::VectorXd& point : points) {
    for (double& u : point) u = random.Uniform();
  }
  StartBatch(points, "random: nothing has succeeded yet");
}

void Generational::EndInitialBatch() {
  for (auto& [id, individual] : outcomes_) initial_.push_back(individual);
  std::vector<Individual> all = initial_;
  for (const auto& [id, individual] : outside_) all.push_back(individual);
  if (std::none_of(all.begin(), all.end(), [](const Individual& i) { return i.Complete(); })) {
    StartUniformPopulation();
    return;
  }
  begun_ = true;
  strategy_->Begin(SelectBest(all, static_cast<std::size_t>(population_)));
  StartNextBatch();
}

void Generational::EndBatch() {
  if (!begun_) {
    EndInitialBatch();
    return;
  }
  std::vector<Individual> generation;
  for (auto& [id, individual] : outcomes_) generation.push_back(std::move(individual));
  strategy_->Learn(generation);
  ++evaluations_;
  StartNextBatch();
}

void Generational::StartNextBatch() {
  if (options_.generations > 0 && Generation() > options_.generations) {
    end_ = fmt::format("all {} generations have been evaluated", options_.generations);
    StartBatch({}, "");
    return;
  }
  const std::vector<Eigen::VectorXd> points = strategy_->Propose();
  const std::string message = strategy_->Message();
  StartBatch(points,
             fmt::format("generation {}{}{}", Generation(), message.empty() ? "" : ", ", message));
  if (points.empty()) end_ = message.empty() ? "the search has ended" : message;
}

std::vector<Candidate> Generational::Ask(int max_count) {
  std::vector<Candidate> candidates;
  while (static_cast<int>(candidates.size()) < max_count && next_ < batch_.size()) {
    candidates.push_back(batch_[next_++]);
  }
  return candidates;
}

Status Generational::status() const {
  if (!Supported()) return {Status::Phase::finished, "the problem is not supported"};
  if (!end_.empty()) return {Status::Phase::finished, end_};
  if (next_ < batch_.size()) return {};
  return {Status::Phase::waiting,
          fmt::format("{} of {} points of the {} are still out", batch_.size() - outcomes_.size(),
                      batch_.size(), begun_ ? "generation" : "initial population")};
}

void Generational::Check(const Observation& observation) const {
  CheckSizes(name_, observation, space_.dimension(), objectives_);
  if (observation.id >= first_id_ + static_cast<std::int64_t>(next_)) {
    throw std::invalid_argument(
        fmt::format("{}: candidate {} has not been asked for", name_, observation.id));
  }
}

Individual Generational::Evaluated(const Observation& observation) const {
  Individual individual{.id = observation.id,
                        .point = space_.Snap(observation.point),
                        .values = Eigen::VectorXd::Constant(
                            objective_count_, std::numeric_limits<double>::quiet_NaN())};
  if (observation.failed) return individual;
  for (int o = 0; o < objective_count_; ++o) {
    individual.values[o] = ChiSquared(objectives_, observation.responses, observation.variances, o);
  }
  for (std::size_t t = 0; t < objectives_.targets.size(); ++t) {
    if (std::isfinite(observation.responses[static_cast<Eigen::Index>(t)])) continue;
    individual.values[objectives_.targets[t].objective] = std::numeric_limits<double>::quiet_NaN();
  }
  return individual;
}

void Generational::Tell(std::span<const Observation> observations) {
  if (!Supported()) throw std::logic_error(name_ + ": the problem is not supported");
  for (const Observation& observation : observations) {
    Check(observation);
    Individual individual = Evaluated(observation);
    if (observation.id < 0) {
      outside_[observation.id] = std::move(individual);
    } else if (observation.id >= first_id_) {
      outcomes_[observation.id] = std::move(individual);
    } else if (begun_) {
      strategy_->Revise(individual);
    } else {
      ReviseMembers(initial_, individual);
    }
  }
  if (!batch_.empty() && outcomes_.size() == batch_.size()) EndBatch();
}

}  // namespace

std::unique_ptr<Optimizer> MakeMetaheuristic(const Method& method,
                                             const MetaheuristicOptions& options,
                                             const SearchSpace& space, const Objectives& objectives,
                                             std::uint64_t seed) {
  return std::make_unique<Generational>(method, options, space, objectives, seed);
}

}  // namespace powdercal

#include "optimizers/least_squares/least_squares.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "core/errors.h"
#include "optimizers/blocking_solver.h"
#include "optimizers/least_squares/identifiability.h"
#include "optimizers/least_squares/local_search.h"
#include "optimizers/least_squares/residuals.h"

namespace powdercal {
namespace {

constexpr double kSameStart = 0.05;  // of the box
constexpr double kNothingLeft = 1e-3;

class LeastSquares final : public Optimizer {
 public:
  LeastSquares(const LeastSquaresOptions& options, const SearchSpace& space,
               const Objectives& objectives, std::uint64_t seed)
      : options_(options), space_(space), objectives_(objectives) {
    supported_ = ExplainUnsupported(space, objectives).empty();
    if (supported_) design_ = MakeDesign(options.initial_design, space, seed);
    for (const Parameter& parameter : space.parameters) symbols_.push_back(parameter.symbol);
  }

  std::vector<Candidate> Ask(int max_count) override;
  void Tell(std::span<const Observation> observations) override;
  Status status() const override;
  Capabilities capabilities() const override { return {.noise = true, .asynchronous = true}; }
  std::string ExplainUnsupported(const SearchSpace& space,
                                 const Objectives& objectives) const override {
    const std::string reason = ExplainNoLeastSquares("least_squares", space, objectives);
    return reason.empty() ? options_.initial_design.ExplainUnsupported(space) : reason;
  }

 private:
  // In the solver's thread, which has the members to itself while it runs.
  void Minimise(BlockingSolver::Channel& channel);
  bool EvaluateDesign(BlockingSolver::Channel& channel);
  std::optional<std::vector<Observation>> Evaluate(BlockingSolver::Channel& channel,
                                                   const std::vector<Eigen::VectorXd>& points,
                                                   const std::vector<std::string>& origins);
  const Observation* Known(const Eigen::VectorXd& point) const;
  std::vector<Observation> Starts() const;
  void Report(const LocalSearchEnd& end, const Residuals& residuals);
  std::string MissingResponses() const;

  LeastSquaresOptions options_;
  SearchSpace space_;
  Objectives objectives_;
  bool supported_ = false;
  std::vector<DesignPoint> design_;
  std::vector<std::string> symbols_;

  std::int64_t asked_ = 0;
  std::map<std::int64_t, std::int64_t> tickets_;  // by id
  ObservationsById observations_;
  int searches_ = 0;
  double lowest_ = 0;     // chi² of the best search
  std::string findings_;  // of the best search
  std::string message_;
  std::unique_ptr<BlockingSolver> solver_;  // the last member: its thread uses the others
};

std::vector<Candidate> LeastSquares::Ask(int max_count) {
  std::vector<Candidate> candidates;
  if (!supported_ || max_count <= 0) return candidates;
  if (!solver_) {
    solver_ = std::make_unique<BlockingSolver>(
        [this](BlockingSolver::Channel& channel) { Minimise(channel); });
  }
  while (static_cast<int>(candidates.size()) < max_count) {
    const auto ticket = solver_->Take();
    if (!ticket) break;
    tickets_[asked_] = ticket->number;
    candidates.push_back({asked_, ticket->request.point, ticket->request.origin});
    ++asked_;
  }
  return candidates;
}

void LeastSquares::Tell(std::span<const Observation> observations) {
  // All are known before any of them wakes the solver.
  std::vector<Observation> checked;
  for (const Observation& observation : observations) {
    checked.push_back(
        CheckedObservation("least_squares", observation, space_.dimension(), objectives_));
  }
  for (const Observation& observation : checked) observations_[observation.id] = observation;
  for (const Observation& observation : checked) {
    const auto ticket = tickets_.find(observation.id);
    if (ticket == tickets_.end()) continue;
    const std::int64_t number = ticket->second;
    tickets_.erase(ticket);
    solver_->Give(number, {.failed = observation.failed,
                           .values = observation.responses,
                           .variances = observation.variances});
  }
}

Status LeastSquares::status() const {
  if (!solver_ || solver_->ready()) return {Status::Phase::ready, message_};
  return {solver_->finished() ? Status::Phase::finished : Status::Phase::waiting, message_};
}

const Observation* LeastSquares::Known(const Eigen::VectorXd& point) const {
  for (const auto& [id, observation] : observations_) {
    if (observation.point == point) return &observation;
  }
  return nullptr;
}

std::optional<std::vector<Observation>> LeastSquares::Evaluate(
    BlockingSolver::Channel& channel, const std::vector<Eigen::VectorXd>& points,
    const std::vector<std::string>& origins) {
  std::vector<Observation> answers(points.size());
  std::vector<BlockingSolver::Request> batch;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (const Observation* known = Known(points[i])) {
      answers[i] = *known;
    } else {
      batch.push_back({points[i], origins[i]});
      places.push_back(i);
    }
  }
  if (batch.empty()) return answers;
  const auto given = channel.Evaluate(std::move(batch));
  if (!given) return std::nullopt;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const BlockingSolver::Answer& answer = (*given)[i];
    answers[places[i]] = {.point = points[places[i]],
                          .responses = answer.values,
                          .variances = answer.variances,
                          .failed = answer.failed};
  }
  return answers;
}

bool LeastSquares::EvaluateDesign(BlockingSolver::Channel& channel) {
  std::vector<Eigen::VectorXd> points;
  std::vector<std::string> origins;
  for (const DesignPoint& point : design_) {
    points.push_back(point.point);
    origins.push_back("initial design: " + point.label);
  }
  return Evaluate(channel, points, origins).has_value();
}

// Usable points, the most promising first: fewest responses missing, then lowest chi².
std::vector<Observation> LeastSquares::Starts() const {
  std::vector<std::tuple<std::ptrdiff_t, double, std::int64_t>> ranked;
  for (const auto& [id, observation] : observations_) {
    if (observation.failed) continue;
    ranked.emplace_back(observation.responses.array().isNaN().count(),
                        ChiSquared(objectives_, observation.responses, observation.variances), id);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<Observation> starts;
  for (const auto& [missing, chi2, id] : ranked) starts.push_back(observations_.at(id));
  return starts;
}

void LeastSquares::Minimise(BlockingSolver::Channel& channel) {
  if (!EvaluateDesign(channel)) return;
  const EvaluateBatch evaluate = [&](const auto& points, const auto& origins) {
    return Evaluate(channel, points, origins);
  };
  const std::vector<Observation> starts = Starts();
  std::vector<Eigen::VectorXd> ends;
  for (const Observation& start : starts) {
    if (searches_ == options_.starts) break;
    const bool near = std::any_of(ends.begin(), ends.end(), [&](const Eigen::VectorXd& end) {
      return (end - start.point).norm() < kSameStart;
    });
    if (near) continue;
    Residuals residuals(objectives_, observations_);
    residuals.Restrict(start);
    StepRule rule(residuals, observations_, space_.dimension(), options_.precision);
    rule.fixed = options_.step;
    const LocalSearchEnd end = SearchLocally({.tolerance = options_.tolerance, .symbols = symbols_},
                                             residuals, rule, evaluate, start);
    if (end.reason == LocalSearchEnd::Reason::cancelled) return;
    Report(end, residuals);
    ends.push_back(end.point);
    const bool all = residuals.size() == static_cast<Eigen::Index>(objectives_.targets.size());
    if (all && end.residuals.cwiseAbs().maxCoeff() < kNothingLeft) break;
  }
  if (searches_ == 0) {
    message_ =
        fmt::format("no search could start: all {} evaluations have failed", observations_.size());
  }
}

void LeastSquares::Report(const LocalSearchEnd& end, const Residuals& residuals) {
  using Reason = LocalSearchEnd::Reason;
  ++searches_;
  const double chi2 = end.residuals.squaredNorm();
  const bool best = searches_ == 1 || chi2 < lowest_;
  if (best) {
    lowest_ = chi2;
    const Eigen::Index d = space_.dimension();
    Eigen::ArrayXd noise(d);
    // A residual's share of the noise, where it was found in the sum of all.
    const double each = end.rule.noise / std::sqrt(static_cast<double>(residuals.size()));
    for (Eigen::Index k = 0; k < d; ++k) {
      noise[k] = end.rule.noisy ? each * end.jacobian.Noise(k) : 0;
    }
    const Identifiability found = Identify(end.point, end.jacobian.values, noise);
    findings_ = Describe(found, symbols_);
    if (findings_.empty()) {
      findings_ = end.reason == Reason::stalled ? "no step makes chi² smaller" : "converged";
    }
    if (end.reason == Reason::exhausted) findings_ += "; ended by the limit of iterations";
    if (end.noise_found) {
      findings_ +=
          fmt::format("; the responses scatter or jump (about {:.2g} standard deviations)", each);
    }
    for (const Eigen::Index k : end.jacobian.dropped) {
      findings_ += fmt::format("; evaluations on both sides in {} have failed",
                               symbols_[static_cast<std::size_t>(k)]);
    }
  }
  message_ = fmt::format("best of {} searches, chi² {:.4g}: {}", searches_, lowest_, findings_) +
             MissingResponses();
  if (searches_ == 1) message_.replace(0, message_.find(','), "one search");
}

std::string LeastSquares::MissingResponses() const {
  std::string text;
  for (std::size_t j = 0; j < objectives_.targets.size(); ++j) {
    const auto index = static_cast<Eigen::Index>(j);
    const auto count =
        std::count_if(observations_.begin(), observations_.end(), [&](const auto& item) {
          return !item.second.failed && std::isnan(item.second.responses[index]);
        });
    if (count == 0) continue;
    text +=
        fmt::format("; {} was missing in {} evaluations", objectives_.targets[j].response, count);
  }
  return text;
}

class LeastSquaresFactory final : public OptimizerFactory {
 public:
  const std::string& name() const override {
    static const std::string name = "least_squares";
    return name;
  }
  std::string Describe() const override {
    return "Levenberg-Marquardt on the residuals with finite differences, from several starts";
  }
  void Serialize(Archive& archive, const SearchSpace& space) override {
    options_.Serialize(archive, space);
  }
  std::unique_ptr<Optimizer> Make(const SearchSpace& space, const Objectives& objectives,
                                  std::uint64_t seed) const override {
    return MakeLeastSquares(options_, space, objectives, seed);
  }
  DesignOptions* initial_design() override { return &options_.initial_design; }

 private:
  LeastSquaresOptions options_;
};

}  // namespace

void LeastSquaresOptions::Serialize(Archive& archive, const SearchSpace& space) {
  initial_design.SerializeSection(archive, "initial_design", space);
  archive.Integer("starts", starts, {.lower = 1, .upper = 1000});
  archive.Number("tolerance", tolerance, {.lower = 0, .upper = 0.1, .lower_open = true});
  archive.Number("precision", precision, {.lower = 1e-16, .upper = 0.01});
  archive.Quantity("step", step, "1", {.lower = 1e-8, .upper = 0.5});
}

std::unique_ptr<Optimizer> MakeLeastSquares(const LeastSquaresOptions& options,
                                            const SearchSpace& space, const Objectives& objectives,
                                            std::uint64_t seed) {
  return std::make_unique<LeastSquares>(options, space, objectives, seed);
}

std::unique_ptr<OptimizerFactory> MakeLeastSquaresFactory() {
  return std::make_unique<LeastSquaresFactory>();
}

}  // namespace powdercal

#include "studies/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/quantity.h"
#include "studies/evaluation.h"
#include "studies/fidelities.h"
#include "studies/ranking.h"
#include "studies/runner.h"

namespace powdercal {
namespace {

using RunsById = std::map<std::int64_t, LedgerRun>;

// What was told of each point: how many replicates, and their runs.
struct ToldPoint {
  LedgerCandidate entry;
  int replicates = 0;
  std::vector<const LedgerRun*> runs;
  ReducedResponses reduced;
};

// Whether its responses are fitted; the best point may have runs of other experiments, and on other
// backends.
bool IsTarget(const std::string& experiment, const Objectives& objectives) {
  return std::any_of(
      objectives.targets.begin(), objectives.targets.end(),
      [&](const Target& target) { return target.response.starts_with(experiment + "."); });
}

std::vector<ToldPoint> CollectPoints(const Ledger& ledger, const Objectives& objectives,
                                     const RunsById& runs, const std::string& backend) {
  std::map<std::int64_t, int> replicates;
  for (const LedgerEvent& event : ledger.Events()) {
    if (event.kind == LedgerEvent::Kind::tell) {
      replicates[event.observation->id] = event.replicates;
    }
  }
  std::vector<ToldPoint> points;
  for (LedgerCandidate& entry : ledger.Candidates()) {
    const auto told = replicates.find(entry.candidate.id);
    if (told == replicates.end()) continue;
    ToldPoint point{.replicates = told->second};
    for (std::size_t i = 0; i < entry.runs.size(); ++i) {
      const LedgerRun& run = runs.at(entry.runs[i]);
      if (run.backend == backend && entry.replicates[i] >= 0 &&
          entry.replicates[i] < told->second && IsTarget(run.experiment, objectives)) {
        point.runs.push_back(&run);
      }
    }
    point.reduced = Reduce(objectives, point.runs);
    point.entry = std::move(entry);
    points.push_back(std::move(point));
  }
  return points;
}

RunResult MakeRunResult(const LedgerRun& run, int replicate) {
  RunResult result{.id = run.id,
                   .experiment = run.experiment,
                   .backend = run.backend,
                   .replicate = replicate,
                   .seed = run.seed,
                   .program_hash = run.program_hash,
                   .reason = ToString(run.outcome.reason),
                   .message = run.outcome.message,
                   .wall_seconds = run.diagnostics.wall_seconds,
                   .diagnostics = run.measurement.diagnostics,
                   .law = run.diagnostics.law};
  for (const auto& [name, response] : run.measurement.responses) {
    result.responses[name] = response.value;
  }
  return result;
}

ResponseResult MakeResponse(const Target& target, const ObservedResponse* observation,
                            const ReducedResponses& reduced, Eigen::Index index) {
  ResponseResult response{
      .name = target.response, .unit = target.unit, .replicates = reduced.counts[index]};
  if (observation != nullptr) {
    response.observed = observation->value;
    response.sd = observation->sd;
    response.tolerance = observation->tolerance;
    response.source = observation->source;
  }
  if (response.replicates > 0) response.simulated = reduced.means[index];
  if (response.replicates > 1) response.seed_sd = std::sqrt(reduced.sample_variances[index]);
  return response;
}

// "shear: the reason; spreading: the reason", without the name where there is one experiment only.
std::string DescribeFailures(const std::vector<ExperimentFailure>& failures, bool name_them) {
  std::string text;
  for (const ExperimentFailure& failure : failures) {
    if (!text.empty()) text += "; ";
    text += name_them ? failure.experiment + ": " + failure.message : failure.message;
  }
  return text;
}

EvaluationResult MakeEvaluation(const Study& study, const Objectives& objectives,
                                const ToldPoint& point, const Eigen::VectorXd& pooled) {
  EvaluationResult result{.id = point.entry.candidate.id,
                          .origin = point.entry.candidate.origin,
                          .fidelity = FidelityNameAt(study, point.entry.candidate.fidelity)};
  for (std::size_t i = 0; i < point.entry.parameters.size(); ++i) {
    result.parameters[study.space.parameters[i].name] = point.entry.parameters[i];
  }
  const auto observations = study.Observations();
  for (std::size_t t = 0; t < objectives.targets.size(); ++t) {
    const auto index = static_cast<Eigen::Index>(t);
    const Target& target = objectives.targets[t];
    result.responses.push_back(MakeResponse(target, observations[t], point.reduced, index));
  }
  if (point.reduced.complete()) {
    result.outcome = ToString(Reason::ok);
    result.chi2 =
        ChiSquared(objectives, point.reduced.means, VarianceOfMeans(point.reduced, pooled));
  } else {
    result.failures = FailuresOf(objectives, point.reduced, point.runs);
    result.outcome = point.reduced.partial() ? kPartial : result.failures.front().reason;
    result.message = DescribeFailures(result.failures, study.CalibratedExperiments().size() > 1);
  }
  for (std::size_t i = 0; i < point.runs.size(); ++i) {
    const auto link =
        std::find(point.entry.runs.begin(), point.entry.runs.end(), point.runs[i]->id);
    const auto slot = static_cast<std::size_t>(link - point.entry.runs.begin());
    result.runs.push_back(MakeRunResult(*point.runs[i], point.entry.replicates[slot]));
  }
  return result;
}

// The experiment behind each objective; none for the joint one.
std::vector<std::string> ObjectiveNames(const Objectives& objectives) {
  if (objectives.kind == Objectives::Kind::joint) return {};
  std::vector<std::string> names(static_cast<std::size_t>(ObjectiveCount(objectives)));
  for (const Target& target : objectives.targets) {
    names[static_cast<std::size_t>(target.objective)] =
        target.response.substr(0, target.response.find('.'));
  }
  return names;
}

void AddPareto(const Objectives& objectives, const std::vector<ReducedResponses>& points,
               const Eigen::VectorXd& pooled, StudyResults& results) {
  results.objectives = ObjectiveNames(objectives);
  if (results.objectives.empty()) return;
  results.pareto = ParetoFront(objectives, points, pooled);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int o = 0; o < ObjectiveCount(objectives); ++o) {
      ObjectiveResult result;
      const double misfit = ExpectedMisfit(objectives, points[i], pooled, o);
      if (std::isfinite(misfit)) {
        result.misfit = misfit;
        result.chi2 =
            ChiSquared(objectives, points[i].means, VarianceOfMeans(points[i], pooled), o);
      }
      results.history[i].objectives.push_back(result);
    }
  }
}

// An experiment that is not calibrated, at these parameters, as far as the ledger has its runs.
void AddTransfer(const Planner& planner, std::size_t experiment,
                 const std::vector<double>& parameters, const RunsById& all,
                 TransferResult& transfer) {
  const StudyExperiment& entry = planner.study().experiments[experiment];
  const std::string& name = entry.name();
  std::map<std::string, const LedgerRun*> by_program;
  for (const auto& [id, run] : all) {
    if (run.experiment != name || run.backend != planner.backend().name()) continue;
    by_program[run.program_hash] = &run;
  }
  std::vector<const LedgerRun*> runs;
  for (int r = 0; r < planner.study().backend.confirm_replicates && !by_program.empty(); ++r) {
    // By its program: the backend may be absent where a report is made.
    const auto found =
        by_program.find(planner.PlanExperiment(experiment, parameters, r).program_hash);
    if (found == by_program.end()) continue;
    runs.push_back(found->second);
    transfer.runs.push_back(MakeRunResult(*found->second, r));
  }
  if (runs.empty()) return;
  transfer.experiments.push_back(name);
  Objectives measured;
  for (const ResponseDescription& response : entry.experiment->responses()) {
    measured.targets.push_back({.response = name + "." + response.name, .unit = response.unit});
  }
  const ReducedResponses reduced = Reduce(measured, runs);
  std::string missing;  // a response that was observed, or any where there is none at all
  for (std::size_t t = 0; t < measured.targets.size(); ++t) {
    const auto index = static_cast<Eigen::Index>(t);
    const std::string response = measured.targets[t].response.substr(name.size() + 1);
    const auto observed =
        std::find_if(entry.observed.begin(), entry.observed.end(),
                     [&](const ObservedResponse& o) { return o.response == response; });
    const bool known = observed != entry.observed.end();
    if (reduced.counts[index] == 0 && (known || reduced.failed())) missing = response;
    if (reduced.counts[index] == 0 && !known) continue;
    transfer.responses.push_back(
        MakeResponse(measured.targets[t], known ? &*observed : nullptr, reduced, index));
  }
  if (!missing.empty()) transfer.failures.push_back(FailureOf(name, missing, runs));
}

// The programs of the best point by their hashes, as far as another backend may have run them.
std::map<std::string, int> ReplicatesByProgram(const Planner& planner,
                                               const std::vector<double>& parameters) {
  std::map<std::string, int> replicates;
  for (int r = 0; r < planner.study().backend.confirm_replicates; ++r) {
    for (const PlannedRun& run : planner.Plan(parameters, r)) replicates[run.program_hash] = r;
  }
  return replicates;
}

// Of several versions of a backend the last; none is that of one that was absent.
std::string KeepLastVersion(std::vector<const LedgerRun*>& runs) {
  std::string version;
  for (const LedgerRun* run : runs) {
    if (!run->backend_version.empty()) version = run->backend_version;
  }
  std::erase_if(runs, [&](const LedgerRun* run) { return run->backend_version != version; });
  return version;
}

std::vector<ResponseResult> MakeResponses(const Study& study, const Objectives& objectives,
                                          const ReducedResponses& reduced) {
  const auto observations = study.Observations();
  std::vector<ResponseResult> responses;
  for (std::size_t t = 0; t < objectives.targets.size(); ++t) {
    responses.push_back(MakeResponse(objectives.targets[t], observations[t], reduced,
                                     static_cast<Eigen::Index>(t)));
  }
  return responses;
}

// `runs`: all of this backend's at the best point, in the order of the ledger.
ConfirmationResult MakeConfirmation(const Study& study, const Objectives& objectives,
                                    const std::string& backend,
                                    const std::map<std::string, int>& replicates,
                                    std::vector<const LedgerRun*> runs) {
  ConfirmationResult result{.backend = backend, .outcome = kPending};
  if (runs.empty()) return result;
  result.version = KeepLastVersion(runs);
  const ReducedResponses reduced = Reduce(objectives, runs);
  result.responses = MakeResponses(study, objectives, reduced);
  for (const LedgerRun* run : runs) {
    result.runs.push_back(MakeRunResult(*run, replicates.at(run->program_hash)));
    if (!run->diagnostics.law.empty()) result.law = run->diagnostics.law;
  }
  if (reduced.complete()) {
    const auto count = static_cast<int>(objectives.targets.size());
    result.outcome = ToString(Reason::ok);
    result.chi2 = ChiSquared(objectives, reduced.means,
                             VarianceOfMeans(reduced, PooledSeedVariance({reduced}, count)));
  } else if (result.version.empty()) {
    result.outcome = kUnavailable;
    result.message = runs.front()->outcome.message;
  } else {
    result.failures = FailuresOf(objectives, reduced, runs);
    result.outcome = reduced.partial() ? kPartial : result.failures.front().reason;
    result.message = DescribeFailures(result.failures, study.CalibratedExperiments().size() > 1);
  }
  return result;
}

// Of the backends that the study asks, and of others that it asked before.
void AddConfirmations(const Planner& planner, const std::vector<double>& parameters,
                      const RunsById& all, StudyResults& results) {
  const Study& study = planner.study();
  std::vector<std::string> backends;
  for (const auto& other : study.backend.confirm_with) backends.push_back(other->name());
  const std::size_t asked = backends.size();
  std::map<std::string, std::vector<const LedgerRun*>> runs;
  std::map<std::string, int> replicates;
  for (const auto& [id, run] : all) {
    if (run.backend == planner.backend().name()) continue;
    if (replicates.empty()) replicates = ReplicatesByProgram(planner, parameters);
    if (replicates.contains(run.program_hash)) runs[run.backend].push_back(&run);
  }
  for (const auto& [name, ran] : runs) {
    const auto end = backends.begin() + static_cast<std::ptrdiff_t>(asked);
    if (std::find(backends.begin(), end, name) == end) backends.push_back(name);
  }
  for (const std::string& name : backends) {
    results.confirmations.push_back(
        MakeConfirmation(study, study.MakeObjectives(), name, replicates, runs[name]));
  }
}

void AddApproximationEffect(const Planner& planner, const std::vector<double>& parameters,
                            const RunsById& all, StudyResults& results) {
  const Study& study = planner.study();
  if (!study.approximations.any()) return;
  const Planner exact(study, planner.backend(), Planner::Law::exact);
  std::map<std::string, int> exact_programs = ReplicatesByProgram(exact, parameters);
  const std::map<std::string, int> programs = ReplicatesByProgram(planner, parameters);
  std::vector<const LedgerRun*> exact_runs;
  std::vector<const LedgerRun*> runs;
  for (const auto& [id, run] : all) {
    if (run.backend != kReferenceBackend) continue;
    if (exact_programs.contains(run.program_hash)) exact_runs.push_back(&run);
    if (programs.contains(run.program_hash)) runs.push_back(&run);
  }
  if (exact_runs.empty() || runs.empty()) return;
  const Objectives objectives = study.MakeObjectives();
  ApproximationEffect effect{.backend = kReferenceBackend};
  effect.version = KeepLastVersion(exact_runs);
  std::erase_if(runs, [&](const LedgerRun* run) { return run->backend_version != effect.version; });
  const ReducedResponses reduced = Reduce(objectives, exact_runs);
  effect.exact = MakeResponses(study, objectives, reduced);
  effect.approximated = MakeResponses(study, objectives, Reduce(objectives, runs));
  effect.failures = FailuresOf(objectives, reduced, exact_runs);
  for (const LedgerRun* run : exact_runs) {
    effect.runs.push_back(MakeRunResult(*run, exact_programs.at(run->program_hash)));
  }
  results.approximation_effect = std::move(effect);
}

void Count(const ToldPoint& point, const EvaluationResult& evaluation, StudyResults& results) {
  const auto run_count = point.runs.size();
  if (run_count > 0 && static_cast<std::size_t>(point.entry.cached_runs) >= run_count) {
    ++results.cached;
  }
  ++results.total;
  ++(evaluation.chi2                  ? results.ok
     : evaluation.outcome == kPartial ? results.partial
                                      : results.failed);
}

// Takes the points below the study's own fidelity out of `points`.
void AddLowerFidelities(const Study& study, const Objectives& objectives,
                        std::vector<ToldPoint>& points, StudyResults& results) {
  const auto target_count = static_cast<int>(objectives.targets.size());
  for (const double s : LowerFidelityCoordinates(study)) {
    std::vector<ReducedResponses> reduced;
    for (const ToldPoint& point : points) {
      if (point.entry.candidate.fidelity == s) reduced.push_back(point.reduced);
    }
    const Eigen::VectorXd pooled = PooledSeedVariance(reduced, target_count);
    for (const ToldPoint& point : points) {
      if (point.entry.candidate.fidelity != s) continue;
      EvaluationResult evaluation = MakeEvaluation(study, objectives, point, pooled);
      Count(point, evaluation, results);
      results.lower_fidelity.push_back(std::move(evaluation));
    }
  }
  std::sort(results.lower_fidelity.begin(), results.lower_fidelity.end(),
            [](const EvaluationResult& a, const EvaluationResult& b) { return a.id < b.id; });
  std::erase_if(points, [](const ToldPoint& point) { return point.entry.candidate.fidelity < 1; });
}

void AddHistory(const Study& study, const Planner& planner, const Ledger& ledger,
                StudyResults& results) {
  const Objectives objectives = study.MakeObjectives();
  RunsById runs;
  for (LedgerRun& run : ledger.Runs()) {
    results.simulation_seconds +=
        study.backend.backend->simulates() ? run.diagnostics.wall_seconds : 0;
    runs.emplace(run.id, std::move(run));
  }
  std::vector<ToldPoint> points = CollectPoints(ledger, objectives, runs, planner.backend().name());
  AddLowerFidelities(study, objectives, points, results);
  std::vector<ReducedResponses> reduced;
  for (const ToldPoint& point : points) reduced.push_back(point.reduced);
  const Eigen::VectorXd pooled =
      PooledSeedVariance(reduced, static_cast<int>(objectives.targets.size()));
  std::vector<Eigen::VectorXd> coordinates;
  for (const ToldPoint& point : points) coordinates.push_back(point.entry.candidate.point);
  const std::vector<double> misfits = RankingMisfits(study.space, objectives, coordinates, reduced);
  double lowest = std::numeric_limits<double>::infinity();
  for (const ToldPoint& point : points) {
    EvaluationResult evaluation = MakeEvaluation(study, objectives, point, pooled);
    const double misfit = misfits[results.history.size()];
    if (misfit < lowest) {
      lowest = misfit;
      results.best = results.history.size();
    }
    if (results.best) {
      evaluation.best_chi2 = *results.best == results.history.size()
                                 ? evaluation.chi2
                                 : results.history[*results.best].chi2;
    }
    Count(point, evaluation, results);
    results.history.push_back(std::move(evaluation));
  }
  AddPareto(objectives, reduced, pooled, results);
  if (results.best) {
    results.converged = WithinTolerance(study, points[*results.best].reduced);
    for (const RunResult& run : results.history[*results.best].runs) {
      if (!run.law.empty()) results.law_as_run = run.law;
    }
    const std::vector<double>& parameters = points[*results.best].entry.parameters;
    AddConfirmations(planner, parameters, runs, results);
    AddApproximationEffect(planner, parameters, runs, results);
    for (std::size_t i = 0; i < study.experiments.size(); ++i) {
      if (study.experiments[i].calibrate) continue;
      AddTransfer(planner, i, parameters, runs, results.transfer);
    }
  }
}

// What only the study knows; reports/statements.h derives the other caveats from the results.
void AddWarnings(const Planner& planner, const std::vector<std::size_t>& evaluated_also,
                 StudyResults& results) {
  results.warnings = planner.Warnings(evaluated_also);
  if (!results.best) return;
  const int wanted = planner.study().backend.confirm_replicates;
  const auto add = [&](const std::vector<ResponseResult>& responses, const std::string& where) {
    for (const ResponseResult& response : responses) {
      if (!response.simulated || response.replicates >= wanted) continue;
      results.warnings.push_back(fmt::format(
          "{} of the best point{} is a mean of {} particle seeds, not of the {} asked for.",
          response.name, where, response.replicates, wanted));
    }
  };
  add(results.history[*results.best].responses, "");
  add(results.transfer.responses, "");
  for (const ConfirmationResult& confirmation : results.confirmations) {
    add(confirmation.responses, " on " + confirmation.backend);
  }
}

// Those that the best point was evaluated on besides.
std::vector<std::size_t> TransferredExperiments(const Study& study,
                                                const TransferResult& transfer) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < study.experiments.size(); ++i) {
    if (std::find(transfer.experiments.begin(), transfer.experiments.end(),
                  study.experiments[i].name()) != transfer.experiments.end()) {
      indices.push_back(i);
    }
  }
  return indices;
}

}  // namespace

StudyResults CollectResults(Study& study, const Ledger& ledger) {
  const Backend& backend = *study.backend.backend;
  StudyResults results{.study = study.name,
                       .description = study.description,
                       .powder = study.powder.name,
                       .fingerprint = ledger.GetMeta("fingerprint").value_or(""),
                       .program_version = ledger.GetMeta("powdercal_version").value_or(""),
                       .seed = study.seed,
                       .parameters = study.space.parameters,
                       .optimizer = study.optimizer->name(),
                       .optimizer_description = study.optimizer->Describe(),
                       .backend = backend.name(),
                       .backend_version = ledger.GetMeta("backend_version").value_or(""),
                       .simulated = backend.simulates(),
                       .fidelity = ToString(study.backend.fidelity),
                       .replicates = study.backend.replicates,
                       .law = study.law.ToString(),
                       .approximations = study.approximations.Describe(study.powder.sizes),
                       .scaling = study.scaling->name(),
                       .scaling_description = study.scaling->Describe(),
                       .study_yaml = study.ToYaml(),
                       .state = ledger.GetMeta("state").value_or("running"),
                       .stop_reason = ledger.GetMeta("stop_reason").value_or("")};
  results.parallel = study.parallel();
  for (std::size_t i = 0; i < study.experiments.size(); ++i) {
    results.experiments.push_back({.name = study.experiments[i].name(),
                                   .fidelity = ToString(study.FidelityOf(i)),
                                   .calibrated = study.experiments[i].calibrate});
  }
  const Planner planner(study);
  AddHistory(study, planner, ledger, results);
  std::vector<double> parameters = planner.Centre();
  if (results.best) {
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      parameters[i] = results.history[*results.best].parameters.at(study.space.parameters[i].name);
    }
    results.law = study.LawAt(parameters).ToString();
  }
  const std::vector<std::size_t> also = TransferredExperiments(study, results.transfer);
  std::vector<std::size_t> evaluated = study.CalibratedExperiments();
  evaluated.insert(evaluated.end(), also.begin(), also.end());
  results.scaling_tables = planner.ScalingTables(evaluated, parameters);
  const Ledger::Times times = ledger.TotalTimes();
  results.wall_seconds = times.wall;
  results.overhead_seconds = times.overhead;
  AddWarnings(planner, also, results);
  return results;
}

}  // namespace powdercal

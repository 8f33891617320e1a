#include "studies/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/quantity.h"
#include "studies/evaluation.h"
#include "studies/runner.h"

namespace powdercal {
namespace {

// What was told of each point: how many replicates, and their runs.
struct ToldPoint {
  LedgerCandidate entry;
  int replicates = 0;
  std::vector<const LedgerRun*> runs;
  ReducedResponses reduced;
};

std::vector<ToldPoint> CollectPoints(const Ledger& ledger, const Objectives& objectives,
                                     const std::map<std::int64_t, LedgerRun>& runs) {
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
      if (entry.replicates[i] < told->second) point.runs.push_back(&runs.at(entry.runs[i]));
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

EvaluationResult MakeEvaluation(const Study& study, const Objectives& objectives,
                                const ToldPoint& point, const Eigen::VectorXd& pooled) {
  EvaluationResult result{.id = point.entry.candidate.id, .origin = point.entry.candidate.origin};
  for (std::size_t i = 0; i < point.entry.parameters.size(); ++i) {
    result.parameters[study.space.parameters[i].name] = point.entry.parameters[i];
  }
  const auto observations = study.Observations();
  for (std::size_t t = 0; t < objectives.targets.size(); ++t) {
    const auto index = static_cast<Eigen::Index>(t);
    const Target& target = objectives.targets[t];
    ResponseResult response{.name = target.response,
                            .unit = target.unit,
                            .replicates = point.reduced.counts[index],
                            .observed = target.value,
                            .sd = target.sd,
                            .tolerance = observations[t]->tolerance,
                            .source = observations[t]->source};
    if (response.replicates > 0) response.simulated = point.reduced.means[index];
    if (response.replicates > 1) {
      response.seed_sd = std::sqrt(point.reduced.sample_variances[index]);
    }
    result.responses.push_back(std::move(response));
  }
  if (point.reduced.complete()) {
    result.outcome = ToString(Reason::ok);
    result.chi2 =
        ChiSquared(objectives, point.reduced.means, VarianceOfMeans(point.reduced, pooled));
  } else {
    const Outcome failure = FailureOf(point.runs);
    result.outcome = ToString(failure.reason);
    result.message = failure.message;
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

void AddHistory(const Study& study, const Ledger& ledger, StudyResults& results) {
  const Objectives objectives = study.MakeObjectives();
  std::map<std::int64_t, LedgerRun> runs;
  for (LedgerRun& run : ledger.Runs()) {
    results.simulation_seconds +=
        study.backend.backend->simulates() ? run.diagnostics.wall_seconds : 0;
    runs.emplace(run.id, std::move(run));
  }
  const std::vector<ToldPoint> points = CollectPoints(ledger, objectives, runs);
  std::vector<ReducedResponses> reduced;
  for (const ToldPoint& point : points) reduced.push_back(point.reduced);
  const Eigen::VectorXd pooled =
      PooledSeedVariance(reduced, static_cast<int>(objectives.targets.size()));
  double lowest = std::numeric_limits<double>::infinity();
  for (const ToldPoint& point : points) {
    EvaluationResult evaluation = MakeEvaluation(study, objectives, point, pooled);
    const double misfit = ExpectedMisfit(objectives, point.reduced, pooled);
    if (misfit < lowest) {
      lowest = misfit;
      results.best = results.history.size();
    }
    if (results.best) {
      evaluation.best_chi2 = *results.best == results.history.size()
                                 ? evaluation.chi2
                                 : results.history[*results.best].chi2;
    }
    const auto run_count = point.runs.size();
    if (run_count > 0 && static_cast<std::size_t>(point.entry.cached_runs) >= run_count) {
      ++results.cached;
    }
    ++results.total;
    ++(evaluation.chi2 ? results.ok : results.failed);
    results.history.push_back(std::move(evaluation));
  }
  AddPareto(objectives, reduced, pooled, results);
  if (results.best) {
    results.converged = WithinTolerance(study, points[*results.best].reduced);
    for (const RunResult& run : results.history[*results.best].runs) {
      if (!run.law.empty()) results.law_as_run = run.law;
    }
  }
}

// What only the study knows; reports/statements.h derives the other caveats from the results.
void AddWarnings(const Planner& planner, StudyResults& results) {
  results.warnings = planner.Warnings();
  if (!results.best) return;
  for (const ResponseResult& response : results.history[*results.best].responses) {
    if (response.replicates < planner.study().backend.confirm_replicates) {
      results.warnings.push_back(fmt::format(
          "{} of the best point is a mean of {} particle seeds, not of the {} asked for.",
          response.name, response.replicates, planner.study().backend.confirm_replicates));
    }
  }
}

}  // namespace

StudyResults CollectResults(Study& study, const Ledger& ledger) {
  const Backend& backend = *study.backend.backend;
  StudyResults results{
      .study = study.name,
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
      .fidelity = FidelityNames()[static_cast<std::size_t>(study.backend.fidelity)],
      .replicates = study.backend.replicates,
      .law = study.law.ToString(),
      .scaling = study.scaling->name(),
      .scaling_description = study.scaling->Describe(),
      .study_yaml = study.ToYaml(),
      .state = ledger.GetMeta("state").value_or("running"),
      .stop_reason = ledger.GetMeta("stop_reason").value_or("")};
  results.parallel = study.parallel();
  AddHistory(study, ledger, results);
  const Planner planner(study);
  std::vector<double> parameters = planner.Centre();
  if (results.best) {
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      parameters[i] = results.history[*results.best].parameters.at(study.space.parameters[i].name);
    }
  }
  results.scaling_tables = planner.ScalingTables(parameters);
  const Ledger::Times times = ledger.TotalTimes();
  results.wall_seconds = times.wall;
  results.overhead_seconds = times.overhead;
  AddWarnings(planner, results);
  return results;
}

}  // namespace powdercal

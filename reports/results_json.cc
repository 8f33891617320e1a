#include "reports/results_json.h"

#include <cmath>
#include <optional>

#include "core/json.h"
#include "reports/statements.h"

namespace powdercal {
namespace {

using nlohmann::json;

json Numbers(const std::map<std::string, double>& values) {
  json object = json::object();
  for (const auto& [name, value] : values) object[name] = JsonNumber(value);
  return object;
}

// Of a point: numbers, and names of categories.
json Values(const std::vector<Parameter>& parameters, const std::map<std::string, double>& values) {
  json object = Numbers(values);
  for (const Parameter& parameter : parameters) {
    const auto found = values.find(parameter.name);
    if (found != values.end()) object[parameter.name] = ValueToJson(parameter, found->second);
  }
  return object;
}

json Parameters(const std::vector<Parameter>& parameters) {
  json list = json::array();
  for (const Parameter& parameter : parameters) {
    if (parameter.categorical()) {
      list.push_back({{"name", parameter.name},
                      {"symbol", parameter.symbol},
                      {"unit", parameter.unit},
                      {"choices", parameter.categories}});
      continue;
    }
    list.push_back({{"name", parameter.name},
                    {"symbol", parameter.symbol},
                    {"unit", parameter.unit},
                    {"lower", JsonNumber(parameter.lower)},
                    {"upper", JsonNumber(parameter.upper)},
                    {"scale", parameter.logarithmic ? "log" : "linear"}});
  }
  return list;
}

json Targets(const StudyResults& results) {
  json list = json::array();
  for (const ResponseResult& target : TargetResponses(results)) {
    list.push_back({{"response", target.name},
                    {"unit", target.unit},
                    {"observed", JsonNumber(target.observed)},
                    {"sd", JsonNumber(target.sd)},
                    {"tolerance", JsonNumber(target.tolerance)},
                    {"source", target.source}});
  }
  return list;
}

json Experiments(const StudyResults& results) {
  json list = json::array();
  for (const ExperimentResult& experiment : results.experiments) {
    list.push_back({{"name", experiment.name},
                    {"fidelity", experiment.fidelity},
                    {"calibrated", experiment.calibrated}});
  }
  return list;
}

json StudyObject(const StudyResults& results) {
  return {{"name", results.study},
          {"objective", results.objectives.empty() ? "joint" : "pareto"},
          {"description", results.description},
          {"powder", results.powder},
          {"fingerprint", results.fingerprint},
          {"seed", results.seed},
          {"parameters", Parameters(results.parameters)},
          {"targets", Targets(results)},
          {"experiments", Experiments(results)},
          {"contact_law", results.law},
          {"approximations", ApproximationsToJson(results.approximations)},
          {"scaling", {{"mode", results.scaling}, {"description", results.scaling_description}}}};
}

json BackendObject(const StudyResults& results) {
  return {{"name", results.backend},          {"version", results.backend_version},
          {"simulated", results.simulated},   {"fidelity", results.fidelity},
          {"replicates", results.replicates}, {"contact_law_as_run", results.law_as_run}};
}

json FittedResponses(const std::vector<ResponseResult>& responses) {
  json object = json::object();
  for (const ResponseResult& response : responses) {
    const Fit fit = JudgeFit(response);
    const bool observed = response.was_observed();
    object[response.name] = {
        {"simulated", JsonNumber(response.simulated)},
        {"seed_sd", JsonNumber(response.seed_sd)},
        {"replicates", response.replicates},
        {"observed", observed ? JsonNumber(response.observed) : json(nullptr)},
        {"sd", observed ? JsonNumber(response.sd) : json(nullptr)},
        {"unit", response.unit},
        {"deviation", JsonNumber(fit.deviation)},
        {"standard_deviations_off", JsonNumber(StandardDeviationsOff(response))},
        {"tolerance", JsonNumber(response.tolerance)},
        {"within", observed ? json(fit.within) : json(nullptr)},
        {"source", response.source}};
  }
  return object;
}

json Failures(const std::vector<ExperimentFailure>& failures) {
  json list = json::array();
  for (const ExperimentFailure& failure : failures) {
    list.push_back({{"experiment", failure.experiment},
                    {"outcome", failure.reason},
                    {"message", failure.message},
                    {"failed_runs", failure.failed_runs},
                    {"runs", failure.runs}});
  }
  return list;
}

// Adds `objectives`, keyed by experiment, where a study has them.
void AddObjectives(const StudyResults& results, const EvaluationResult& evaluation, json& object) {
  for (std::size_t o = 0; o < results.objectives.size(); ++o) {
    const ObjectiveResult& objective = evaluation.objectives[o];
    object["objectives"][results.objectives[o]] = {{"chi2", JsonNumber(objective.chi2)},
                                                   {"misfit", JsonNumber(objective.misfit)}};
  }
}

json FittedPoint(const StudyResults& results, const EvaluationResult& evaluation) {
  json point = {{"evaluation", evaluation.id},
                {"parameters", Values(results.parameters, evaluation.parameters)},
                {"responses", FittedResponses(evaluation.responses)},
                {"chi2", JsonNumber(evaluation.chi2)}};
  AddObjectives(results, evaluation, point);
  return point;
}

json Pareto(const StudyResults& results) {
  json list = json::array();
  for (const std::size_t index : results.pareto) {
    if (index < results.history.size())
      list.push_back(FittedPoint(results, results.history[index]));
  }
  return list;
}

// Compared bit for bit between an interrupted and an uninterrupted study.
json HistoryEntry(const StudyResults& results, const EvaluationResult& evaluation) {
  json responses = json::object();
  for (const ResponseResult& response : evaluation.responses) {
    responses[response.name] = {{"simulated", JsonNumber(response.simulated)},
                                {"seed_sd", JsonNumber(response.seed_sd)},
                                {"replicates", response.replicates}};
  }
  json entry = {{"evaluation", evaluation.id},
                {"parameters", Values(results.parameters, evaluation.parameters)},
                {"origin", evaluation.origin},
                {"fidelity", evaluation.fidelity},
                {"outcome", evaluation.outcome},
                {"responses", std::move(responses)},
                {"chi2", JsonNumber(evaluation.chi2)},
                {"best_chi2", JsonNumber(evaluation.best_chi2)}};
  AddObjectives(results, evaluation, entry);
  return entry;
}

json BestPoint(const StudyResults& results, const EvaluationResult& best) {
  json point = FittedPoint(results, best);
  point["transfer"] = FittedResponses(results.transfer.responses);
  point["transfer_failures"] = Failures(results.transfer.failures);
  return point;
}

json Effect(const ApproximationEffect& effect) {
  json responses = json::object();
  for (std::size_t i = 0; i < effect.exact.size(); ++i) {
    const ResponseResult& exact = effect.exact[i];
    const ResponseResult& approximated = effect.approximated[i];
    const BackendDifference difference = CompareBackends(approximated, exact);
    const auto side = [](const ResponseResult& response) -> json {
      return {{"simulated", JsonNumber(response.simulated)},
              {"seed_sd", JsonNumber(response.seed_sd)},
              {"replicates", response.replicates}};
    };
    responses[exact.name] = {{"unit", exact.unit},
                             {"exact", side(exact)},
                             {"approximated", side(approximated)},
                             {"difference", JsonNumber(difference.value)},
                             {"difference_sd", JsonNumber(difference.sd)}};
  }
  return {{"backend", effect.backend},
          {"version", effect.version},
          {"responses", std::move(responses)},
          {"failures", Failures(effect.failures)}};
}

json Confirmations(const StudyResults& results, const EvaluationResult& best) {
  json list = json::array();
  for (const ConfirmationResult& confirmation : results.confirmations) {
    json responses = FittedResponses(confirmation.responses);
    for (std::size_t i = 0; i < confirmation.responses.size() && i < best.responses.size(); ++i) {
      const BackendDifference difference =
          CompareBackends(confirmation.responses[i], best.responses[i]);
      json& response = responses[confirmation.responses[i].name];
      response["difference"] = JsonNumber(difference.value);
      response["difference_sd"] = JsonNumber(difference.sd);
    }
    list.push_back({{"backend", confirmation.backend},
                    {"version", confirmation.version},
                    {"outcome", confirmation.outcome},
                    {"message", confirmation.message},
                    {"agrees", Agrees(results, confirmation)},
                    {"conclusion", ConfirmationHeadline(results, confirmation)},
                    {"contact_law_as_run", confirmation.law},
                    {"responses", std::move(responses)},
                    {"chi2", JsonNumber(confirmation.chi2)},
                    {"failures", Failures(confirmation.failures)}});
  }
  return list;
}

json RunEntry(const EvaluationResult& evaluation, const RunResult& run) {
  return {{"id", run.id},
          {"evaluation", evaluation.id},
          {"experiment", run.experiment},
          {"backend", run.backend},
          {"replicate", run.replicate},
          {"seed", run.seed},
          {"program_hash", run.program_hash},
          {"outcome", run.reason},
          {"message", run.message},
          {"wall_s", JsonNumber(run.wall_seconds)},
          {"responses", Numbers(run.responses)},
          {"diagnostics", Numbers(run.diagnostics)},
          {"law", run.law}};
}

}  // namespace

json ValueToJson(const Parameter& parameter, double value) {
  return parameter.categorical() ? json(parameter.CategoryAt(value)) : JsonNumber(value);
}

json ApproximationsToJson(const std::vector<ApproximationStatement>& approximations) {
  json list = json::array();
  for (const ApproximationStatement& one : approximations) {
    list.push_back({{"part", one.part}, {"name", one.name}, {"text", one.text}});
  }
  return list;
}

json PiGroupsToJson(const std::vector<ScalingTable>& tables) {
  json list = json::array();
  for (const ScalingTable& table : tables) {
    json groups = json::array();
    for (const GroupComparison& group : table.groups) {
      groups.push_back({{"symbol", group.symbol},
                        {"meaning", group.meaning},
                        {"experiment", JsonNumber(group.experiment)},
                        {"simulation", JsonNumber(group.simulation)},
                        {"ratio", JsonNumber(group.ratio)},
                        {"verdict", ToString(group.verdict)},
                        {"remark", group.remark},
                        {"tolerance", JsonNumber(group.tolerance)},
                        {"source", group.source},
                        {"numerical", group.numerical}});
    }
    json entry = {{"experiment", table.experiment}, {"groups", std::move(groups)}};
    if (table.cohesion) {
      entry["effective_surface_energy"] = {{"value", JsonNumber(table.cohesion->surface_energy)},
                                           {"unit", "J/m2"},
                                           {"kept", table.cohesion->kept}};
    }
    list.push_back(std::move(entry));
  }
  return list;
}

json ResultsToJson(const StudyResults& results) {
  const EvaluationResult* best = BestEvaluation(results);
  json history = json::array();
  json failures = json::array();
  json runs = json::array();
  json lower_fidelity = json::array();
  const auto add = [&](const EvaluationResult& evaluation, json& list) {
    list.push_back(HistoryEntry(results, evaluation));
    if (evaluation.outcome != "ok") {
      failures.push_back({{"evaluation", evaluation.id},
                          {"outcome", evaluation.outcome},
                          {"message", evaluation.message},
                          {"experiments", Failures(evaluation.failures)}});
    }
    for (const RunResult& run : evaluation.runs) runs.push_back(RunEntry(evaluation, run));
  };
  for (const EvaluationResult& evaluation : results.history) add(evaluation, history);
  for (const EvaluationResult& evaluation : results.lower_fidelity) {
    add(evaluation, lower_fidelity);
  }
  if (best != nullptr) {
    for (const ConfirmationResult& confirmation : results.confirmations) {
      for (const RunResult& run : confirmation.runs) runs.push_back(RunEntry(*best, run));
    }
    if (results.approximation_effect) {
      for (const RunResult& run : results.approximation_effect->runs) {
        runs.push_back(RunEntry(*best, run));
      }
    }
    for (const RunResult& run : results.transfer.runs) runs.push_back(RunEntry(*best, run));
  }
  const std::optional<double> overhead =
      results.wall_seconds > 0 ? std::optional(results.overhead_seconds / results.wall_seconds)
                               : std::nullopt;
  json root = {
      {"schema", 1},
      {"powdercal", {{"version", results.program_version}}},
      {"study", StudyObject(results)},
      {"status",
       {{"state", results.state},
        {"stop_reason", results.stop_reason},
        {"converged", results.converged}}},
      {"optimizer", {{"name", results.optimizer}, {"description", results.optimizer_description}}},
      {"backend", BackendObject(results)},
      {"evaluations",
       {{"total", results.total},
        {"ok", results.ok},
        {"partial", results.partial},
        {"failed", results.failed},
        {"cached", results.cached}}},
      {"best", best ? BestPoint(results, *best) : json(nullptr)},
      {"confirmations", best ? Confirmations(results, *best) : json::array()},
      {"approximation_effect",
       results.approximation_effect ? Effect(*results.approximation_effect) : json(nullptr)},
      {"pareto", Pareto(results)},
      {"history", std::move(history)},
      {"lower_fidelity", std::move(lower_fidelity)},
      {"failures", std::move(failures)},
      {"runs", std::move(runs)},
      {"pi_groups", PiGroupsToJson(results.scaling_tables)},
      {"caveats", Caveats(results)},
      {"warnings", results.warnings},
      {"wall_s", JsonNumber(results.wall_seconds)},
      {"simulation_s", JsonNumber(results.simulation_seconds)},
      {"overhead_s", JsonNumber(results.overhead_seconds)},
      {"overhead_fraction", JsonNumber(overhead)},
      {"parallel", results.parallel}};
  if (!results.simulated) root["notice"] = NoSimulationNotice(results);
  return root;
}

std::string JsonText(const json& value) {
  return value.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace powdercal

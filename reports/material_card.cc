#include "reports/material_card.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <optional>

#include "reports/statements.h"

namespace powdercal {
namespace {

// Numbers are written as the shortest text that reads back to the same double.
void Key(YAML::Emitter& out, const char* key) { out << YAML::Key << key << YAML::Value; }

void Text(YAML::Emitter& out, const char* key, const std::string& value) {
  Key(out, key);
  out << YAML::DoubleQuoted << value;
}

void Number(YAML::Emitter& out, std::optional<double> value) {
  if (value && std::isfinite(*value)) {
    out << fmt::format("{}", *value);
  } else {
    out << YAML::Null;
  }
}

void Number(YAML::Emitter& out, const char* key, std::optional<double> value) {
  Key(out, key);
  Number(out, value);
}

std::string CardStatus(const StudyResults& results) {
  const Conclusion conclusion = Conclude(results);
  if (conclusion.kind == Conclusion::Kind::nothing) return "nothing_calibrated";
  if (!results.simulated) return "no_simulation";
  if (results.state != "finished") return "provisional";
  return conclusion.kind == Conclusion::Kind::fits ? "calibrated" : "not_converged";
}

void EmitParameters(YAML::Emitter& out, const StudyResults& results, const EvaluationResult& best) {
  Key(out, "parameters");
  out << YAML::BeginMap;
  for (const Parameter& parameter : results.parameters) {
    const auto found = best.parameters.find(parameter.name);
    Key(out, parameter.name.c_str());
    out << YAML::BeginMap;
    Text(out, "symbol", parameter.symbol);
    if (parameter.categorical()) {
      if (found != best.parameters.end()) Text(out, "value", parameter.CategoryAt(found->second));
      Key(out, "searched");
      out << YAML::Flow << parameter.categories << YAML::EndMap;
      continue;
    }
    Number(out, "value",
           found == best.parameters.end() ? std::nullopt : std::optional<double>(found->second));
    Text(out, "unit", parameter.unit);
    Key(out, "searched");
    out << YAML::Flow << YAML::BeginSeq;
    Number(out, parameter.lower);
    Number(out, parameter.upper);
    out << YAML::EndSeq << YAML::EndMap;
  }
  out << YAML::EndMap;
}

// `own`: of the study's own backend, to compare with; or empty.
void EmitResponses(YAML::Emitter& out, const std::vector<ResponseResult>& responses,
                   const std::vector<ResponseResult>& own = {}) {
  Key(out, "responses");
  out << YAML::BeginMap;
  for (std::size_t i = 0; i < responses.size(); ++i) {
    const ResponseResult& response = responses[i];
    const Fit fit = JudgeFit(response);
    Key(out, response.name.c_str());
    out << YAML::BeginMap;
    Number(out, "simulated", response.simulated);
    Text(out, "unit", response.unit);
    if (response.was_observed()) {
      Number(out, "observed", response.observed);
      Number(out, "sd", response.sd);
      Number(out, "deviation", fit.deviation);
      Number(out, "standard_deviations_off", StandardDeviationsOff(response));
      if (response.tolerance) Number(out, "tolerance", response.tolerance);
      Key(out, "within");
      out << fit.within;
    }
    Key(out, "replicates");
    out << response.replicates;
    if (response.replicates > 1) Number(out, "seed_sd", response.seed_sd);
    if (i < own.size()) {
      const BackendDifference difference = CompareBackends(response, own[i]);
      Number(out, "difference", difference.value);
      Number(out, "difference_sd", difference.sd);
    }
    if (!response.source.empty()) Text(out, "source", response.source);
    out << YAML::EndMap;
  }
  out << YAML::EndMap;
}

void EmitFit(YAML::Emitter& out, const EvaluationResult& best) {
  Key(out, "fit");
  out << YAML::BeginMap;
  Number(out, "chi2", best.chi2);
  EmitResponses(out, best.responses);
  out << YAML::EndMap;
}

// What of the contact law is not what the parameters are called after.
void EmitApproximations(YAML::Emitter& out, const StudyResults& results) {
  if (results.approximations.empty()) return;
  Key(out, "approximations");
  out << YAML::BeginSeq;
  for (const ApproximationStatement& approximation : results.approximations) {
    out << YAML::BeginMap;
    Text(out, "part", approximation.part);
    Text(out, "name", approximation.name);
    Text(out, "text", approximation.text);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq;
  Key(out, "approximation_effect");
  out << YAML::BeginSeq;
  for (const std::string& statement : ApproximationStatements(results)) {
    out << YAML::DoubleQuoted << statement;
  }
  out << YAML::EndSeq;
}

// What other backends make of the parameters.
void EmitConfirmations(YAML::Emitter& out, const StudyResults& results,
                       const EvaluationResult& best) {
  if (results.confirmations.empty()) return;
  Key(out, "confirmations");
  out << YAML::BeginSeq;
  for (const ConfirmationResult& confirmation : results.confirmations) {
    out << YAML::BeginMap;
    Text(out, "backend", confirmation.backend);
    Text(out, "version", confirmation.version);
    Text(out, "outcome", confirmation.outcome);
    Text(out, "conclusion", ConfirmationHeadline(results, confirmation));
    Text(out, "contact_law_as_run", confirmation.law);
    Number(out, "chi2", confirmation.chi2);
    EmitResponses(out, confirmation.responses, best.responses);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq;
}

// What the parameters give where they were not fitted.
void EmitTransfer(YAML::Emitter& out, const StudyResults& results) {
  if (results.transfer.experiments.empty()) return;
  Key(out, "transfer");
  out << YAML::BeginMap;
  Text(out, "conclusion", TransferHeadline(results));
  EmitResponses(out, results.transfer.responses);
  Key(out, "statements");
  out << YAML::BeginSeq;
  for (const std::string& statement : TransferStatements(results)) {
    out << YAML::DoubleQuoted << statement;
  }
  out << YAML::EndSeq << YAML::EndMap;
}

void EmitProvenance(YAML::Emitter& out, const StudyResults& results, const EvaluationResult* best) {
  Key(out, "provenance");
  out << YAML::BeginMap;
  Text(out, "study", results.study);
  Text(out, "fingerprint", results.fingerprint);
  Text(out, "powdercal", results.program_version);
  Key(out, "backend");
  out << YAML::BeginMap;
  Text(out, "name", results.backend);
  Text(out, "version", results.backend_version);
  Key(out, "simulated");
  out << results.simulated << YAML::EndMap;
  Text(out, "fidelity", FidelityText(results));
  Text(out, "optimizer", results.optimizer);
  Key(out, "study_seed");
  out << results.seed;
  if (best != nullptr) {
    Key(out, "best_evaluation");
    out << best->id;
    Key(out, "particle_seeds");
    out << YAML::Flow << YAML::BeginSeq;
    for (const RunResult& run : best->runs) out << run.seed;
    out << YAML::EndSeq;
  }
  Key(out, "evaluations");
  out << YAML::Flow << YAML::BeginMap;
  out << YAML::Key << "total" << YAML::Value << results.total;
  out << YAML::Key << "ok" << YAML::Value << results.ok;
  out << YAML::Key << "partial" << YAML::Value << results.partial;
  out << YAML::Key << "failed" << YAML::Value << results.failed;
  out << YAML::Key << "cached" << YAML::Value << results.cached << YAML::EndMap;
  Text(out, "state", results.state);
  Text(out, "stop_reason", results.stop_reason);
  out << YAML::EndMap;
}

}  // namespace

std::string MaterialCard(const StudyResults& results) {
  const EvaluationResult* best = BestEvaluation(results);
  YAML::Emitter out;
  out << YAML::Comment(
      "Material card written by powdercal. SI units; docs/results.md explains it.");
  out << YAML::Newline << YAML::BeginMap;
  Key(out, "material_card");
  out << 1;
  Text(out, "powder", results.powder);
  Text(out, "status", CardStatus(results));
  Text(out, "conclusion", Conclude(results).headline);
  if (best != nullptr) EmitParameters(out, results, *best);
  Key(out, "contact_law");
  out << YAML::BeginMap;
  Text(out, "canonical", results.law);
  Text(out, "as_run", results.law_as_run);
  out << YAML::EndMap;
  EmitApproximations(out, results);
  Key(out, "scaling");
  out << YAML::BeginMap;
  Text(out, "mode", results.scaling);
  Text(out, "description", results.scaling_description);
  out << YAML::EndMap;
  if (best != nullptr) {
    EmitFit(out, *best);
    EmitConfirmations(out, results, *best);
    EmitTransfer(out, results);
  }
  EmitProvenance(out, results, best);
  Key(out, "caveats");
  out << YAML::BeginSeq;
  for (const std::string& caveat : Caveats(results)) out << YAML::DoubleQuoted << caveat;
  out << YAML::EndSeq << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

}  // namespace powdercal

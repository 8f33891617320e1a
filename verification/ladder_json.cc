#include "verification/ladder_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/json.h"

namespace powdercal::verification {
namespace {

using nlohmann::json;

json ToJson(const SeedStatistics& s) {
  return {{"n", s.n},
          {"mean_a", JsonNumber(s.mean_a)},
          {"mean_b", JsonNumber(s.mean_b)},
          {"sd_a", JsonNumber(s.sd_a)},
          {"sd_b", JsonNumber(s.sd_b)},
          {"sd_difference", JsonNumber(s.sd_difference)},
          {"lower", JsonNumber(s.lower)},
          {"upper", JsonNumber(s.upper)},
          {"p", JsonNumber(s.p)},
          {"seeds_needed", s.seeds_needed == 0 ? json() : json(s.seeds_needed)}};
}

json ToJson(const Quantity& quantity) {
  json object = {{"name", quantity.name},
                 {"unit", quantity.unit},
                 {"scale", quantity.scale},
                 {"difference", JsonNumber(quantity.difference)},
                 {"tolerance", JsonNumber(quantity.tolerance)},
                 {"tolerance_reason", quantity.tolerance_reason},
                 {"verdict", ToString(quantity.verdict)},
                 {"counts", quantity.counts},
                 {"note", quantity.note}};
  if (quantity.seeds) object["seeds"] = ToJson(*quantity.seeds);
  return object;
}

json ToJson(const Finding& finding) {
  json quantities = json::array();
  for (const Quantity& quantity : finding.quantities) quantities.push_back(ToJson(quantity));
  return {{"rung", ToString(finding.rung)},
          {"case", finding.name},
          {"level", finding.level},
          {"backends", {finding.a, finding.b}},
          {"verdict", ToString(finding.verdict)},
          {"reason", finding.reason},
          {"note", finding.note},
          {"laws", {finding.law_a, finding.law_b}},
          {"quantities", quantities}};
}

}  // namespace

json LadderToJson(const LadderReport& report) {
  json backends = json::array();
  for (const ContenderInfo& contender : report.contenders) {
    backends.push_back({{"name", contender.name},
                        {"available", contender.why_not.empty()},
                        {"version", contender.version},
                        {"description", contender.description},
                        {"why_not", contender.why_not}});
  }
  json rungs = json::array();
  for (const Rung rung : report.options.rungs) rungs.push_back(ToString(rung));
  json findings = json::array();
  for (const Finding& finding : report.findings) findings.push_back(ToJson(finding));
  json failures = json::array();
  for (const FailedRun& run : report.failures) {
    failures.push_back({{"rung", ToString(run.rung)},
                        {"run", run.name},
                        {"backend", run.backend},
                        {"outcome", run.reason},
                        {"message", run.message}});
  }
  json parameters = report.parameters;
  for (const auto& [name, choice] : report.choices) parameters[name] = choice;
  json counts = json::object();
  for (std::size_t i = 0; i < VerdictNames().size(); ++i) {
    counts[VerdictNames()[i]] = report.Count(static_cast<Verdict>(i));
  }
  return {
      {"schema", 1},
      {"subject", report.subject},
      {"description", report.description},
      {"law", report.law},
      {"powdercal_version", report.program_version},
      {"backends", backends},
      {"rungs", rungs},
      {"seeds", report.options.seeds},
      {"level", report.options.level},
      {"margins", report.options.margins},
      {"parameters", parameters},
      {"parameters_source", report.parameters_source},
      {"passed", report.passed()},
      {"compared", static_cast<int>(report.findings.size()) - report.Count(Verdict::unsupported)},
      {"counts", counts},
      {"findings", findings},
      {"failed_runs", failures},
      {"interrupted", report.interrupted},
      {"wall_s", JsonNumber(report.wall_seconds)}};
}

}  // namespace powdercal::verification

#include "reports/comparison_json.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/json.h"

namespace powdercal {
namespace {

using namespace comparison;
using nlohmann::json;

json Numbers(const std::vector<double>& values) {
  json list = json::array();
  for (const double value : values) list.push_back(JsonNumber(value));
  return list;
}

double ToNumber(const json& value) { return value.is_null() ? kNone : value.get<double>(); }

json ToJson(const Quartiles& q) {
  return {{"lower", JsonNumber(q.lower)},
          {"median", JsonNumber(q.median)},
          {"upper", JsonNumber(q.upper)}};
}

json ToJson(const Band& band) {
  json object = {{"x", Numbers(band.x)},
                 {"lower", json::array()},
                 {"median", json::array()},
                 {"upper", json::array()}};
  for (const Quartiles& q : band.y) {
    object["lower"].push_back(JsonNumber(q.lower));
    object["median"].push_back(JsonNumber(q.median));
    object["upper"].push_back(JsonNumber(q.upper));
  }
  return object;
}

json ToJson(const FriedmanTest& test) {
  return {{"blocks", test.blocks},
          {"treatments", test.treatments},
          {"chi_squared", JsonNumber(test.chi_squared)},
          {"chi_squared_p", JsonNumber(test.chi_squared_p)},
          {"f", JsonNumber(test.f)},
          {"f_p", JsonNumber(test.f_p)}};
}

json ToJson(const Contestant& contestant) {
  return {{"label", contestant.label},
          {"name", contestant.name},
          {"description", contestant.description},
          {"options", contestant.options},
          {"study_options", contestant.study_options},
          {"initial_design", contestant.initial_design}};
}

json ToJson(const Standing& standing, const Comparison& comparison) {
  json hold_out = json::array();
  for (std::size_t i = 0; i < standing.hold_out.size(); ++i) {
    hold_out.push_back(
        {{"fidelity", comparison.hold_out_fidelities[i]}, {"chi2", ToJson(standing.hold_out[i])}});
  }
  json object = ToJson(standing.contestant);
  object.update({{"final", ToJson(standing.final_value)},
                 {"within_core_seconds", ToJson(standing.within_core_seconds)},
                 {"evaluations_to_level", ToJson(standing.to_level)},
                 {"seeds_that_reached_level", standing.reached},
                 {"mean_rank", JsonNumber(standing.mean_rank)},
                 {"mean_rank_by_cost", JsonNumber(standing.mean_rank_by_cost)},
                 {"evaluations", ToJson(standing.evaluations)},
                 {"core_seconds", ToJson(standing.core_seconds)},
                 {"parallel_efficiency", ToJson(standing.parallel_efficiency)},
                 {"failed_share", standing.failed_share},
                 {"fit", ToJson(standing.fit)},
                 {"hold_out", std::move(hold_out)},
                 {"optimizer_s_per_evaluation", standing.optimizer_seconds},
                 {"by_evaluations", ToJson(standing.by_evaluations)},
                 {"by_core_seconds", ToJson(standing.by_core_seconds)},
                 {"share_of_targets", Numbers(standing.share_of_targets)},
                 {"errors", standing.errors}});
  return object;
}

json ToJson(const ContestRecord& record) {
  json judged = json::array();
  json reported = json::array();
  json core_seconds = json::array();
  json told_at = json::array();
  json failed = json::array();
  for (const Step& step : record.steps) {
    judged.push_back(Numbers(step.judged));
    reported.push_back(step.reported);
    core_seconds.push_back(step.core_seconds);
    told_at.push_back(step.told_at);
    failed.push_back(step.failed);
  }
  json hold_out = json::array();
  for (const HoldOut& one : record.hold_out) {
    hold_out.push_back(
        {{"fidelity", one.fidelity}, {"seeds", one.seeds}, {"chi2", JsonNumber(one.chi2)}});
  }
  return {{"optimizer", record.label},
          {"seed", record.seed},
          {"key", record.key},
          {"judged", std::move(judged)},
          {"reported", std::move(reported)},
          {"spent", std::move(core_seconds)},
          {"told_at", std::move(told_at)},
          {"failed", std::move(failed)},
          {"end", record.end},
          {"error", record.error},
          {"parameters", Numbers(record.parameters)},
          {"fit", JsonNumber(record.fit)},
          {"hold_out", std::move(hold_out)},
          {"core_seconds", record.core_seconds},
          {"busy_s", record.busy_seconds},
          {"makespan_s", record.makespan},
          {"optimizer_s", record.optimizer_seconds}};
}

ContestRecord ContestFromJson(const json& object) {
  ContestRecord record{.label = object.at("optimizer"),
                       .seed = object.at("seed"),
                       .key = object.at("key"),
                       .end = object.at("end"),
                       .error = object.at("error"),
                       .fit = ToNumber(object.at("fit")),
                       .core_seconds = object.at("core_seconds"),
                       .busy_seconds = object.at("busy_s"),
                       .makespan = object.at("makespan_s"),
                       .optimizer_seconds = object.at("optimizer_s")};
  for (const json& value : object.at("parameters")) record.parameters.push_back(ToNumber(value));
  for (std::size_t i = 0; i < object.at("judged").size(); ++i) {
    Step step{.reported = object.at("reported").at(i),
              .core_seconds = object.at("spent").at(i),
              .told_at = object.at("told_at").at(i),
              .failed = object.at("failed").at(i)};
    for (const json& value : object.at("judged").at(i)) step.judged.push_back(ToNumber(value));
    if (step.judged.empty() || step.reported > static_cast<int>(i)) {
      throw InputError("comparison.json is damaged: a step of a contest is not whole");
    }
    record.steps.push_back(std::move(step));
  }
  for (const json& one : object.at("hold_out")) {
    record.hold_out.push_back({one.at("fidelity"), one.at("seeds"), ToNumber(one.at("chi2"))});
  }
  return record;
}

const char* ToString(Source source) {
  switch (source) {
    case Source::emulator:
      return "emulator";
    case Source::simulator:
      return "simulator";
    case Source::table:
      break;
  }
  return "table";
}

json SourceToJson(const Setting& setting) {
  json object = {{"kind", ToString(setting.source)},
                 {"text", setting.source_text},
                 {"backend", setting.backend},
                 {"noisy", setting.noisy}};
  if (setting.source != Source::emulator) return object;
  json responses = json::array();
  for (const Emulator::Quality& one : setting.emulator) {
    responses.push_back({{"response", one.response},
                         {"unit", one.unit},
                         {"points", one.points},
                         {"leave_one_out_r2", JsonNumber(one.leave_one_out_r2)},
                         {"seed_sd", one.seed_sd},
                         {"sd_from_replicates", one.from_replicates},
                         {"residuals_over_sd", JsonNumber(one.share_of_sd)}});
  }
  object.update({{"points", setting.emulator_points},
                 {"runs", setting.emulator_runs},
                 {"failed_runs", setting.emulator_failed_runs},
                 {"responses", std::move(responses)}});
  return object;
}

json RulesToJson(const Setting& setting) {
  return {{"evaluations", setting.rules.evaluations},
          {"core_seconds", JsonNumber(setting.rules.core_seconds)},
          {"replicates", setting.rules.replicates},
          {"slots", setting.rules.slots},
          {"cores_per_simulation", setting.rules.cores},
          {"initial_design", setting.initial_design},
          {"seeds", setting.seeds},
          {"hold_out_seeds", setting.hold_out_seeds}};
}

json RecommendationToJson(const Comparison& comparison) {
  const Recommendation words = Recommend(comparison);
  return {{"headline", words.headline}, {"statements", words.statements}, {"limits", words.limits}};
}

}  // namespace

json ComparisonToJson(const Comparison& comparison) {
  const Setting& setting = comparison.setting;
  json standings = json::array();
  for (const Standing& one : comparison.standings) standings.push_back(ToJson(one, comparison));
  json refused = json::array();
  for (const Refusal& one : comparison.refused) {
    refused.push_back({{"label", one.label}, {"reason", one.reason}});
  }
  json contests = json::array();
  for (const ContestRecord& record : comparison.contests) contests.push_back(ToJson(record));
  json parameters = json::array();
  for (const Parameter& parameter : setting.parameters) {
    parameters.push_back({{"name", parameter.name}, {"unit", parameter.unit}});
  }
  return {{"schema", 1},
          {"powdercal_version", setting.program_version},
          {"study", setting.study},
          {"description", setting.description},
          {"source", SourceToJson(setting)},
          {"rules", RulesToJson(setting)},
          {"objectives", setting.objectives},
          {"parameters", std::move(parameters)},
          {"measure", comparison.pareto ? "lost_hypervolume" : "chi2"},
          {"judged_by", setting.source == Source::simulator ? "observation" : "truth"},
          {"interrupted", comparison.interrupted},
          {"seeds", comparison.seeds},
          {"recommendation", RecommendationToJson(comparison)},
          {"optimizers", std::move(standings)},
          {"refused", std::move(refused)},
          {"level", JsonNumber(comparison.level)},
          {"negligible", comparison.negligible},
          {"core_seconds", JsonNumber(comparison.core_seconds)},
          {"targets", Numbers(comparison.targets)},
          {"friedman", ToJson(comparison.friedman)},
          {"friedman_by_cost", ToJson(comparison.friedman_by_cost)},
          {"critical_difference", JsonNumber(comparison.critical_difference)},
          {"alpha", kAlpha},
          {"warnings", setting.warnings},
          {"command", setting.command},
          {"contests", std::move(contests)}};
}

std::vector<ContestRecord> ContestsFromJson(const json& document) {
  std::vector<ContestRecord> records;
  try {
    for (const json& contest : document.at("contests")) {
      records.push_back(ContestFromJson(contest));
    }
  } catch (const json::exception& error) {
    throw InputError(fmt::format("not a comparison.json of this version: {}", error.what()));
  }
  return records;
}

}  // namespace powdercal

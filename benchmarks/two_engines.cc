// The embedded engine against LIGGGHTS, experiment by experiment: difference of the means over
// particle seeds with its 95 % confidence interval (Welch 1947). Both engines run the same
// programs. See docs/validation/experiments_liggghts.md.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "benchmarks/campaign.h"

namespace {

using namespace powdercal;
using namespace powdercal::benchmarks;
using nlohmann::json;

struct Experiment {
  std::string name;
  Overrides overrides;  // what LIGGGHTS needs
  std::vector<std::string> responses;
};

const std::vector<Experiment>& Experiments() {
  static const std::vector<Experiment> kExperiments = {
      {"consolidation", {}, {"void_ratio"}},
      {"shear",
       {{"cell", "platens"}},
       {"steady_state_angle", "phi", "cohesion", "steady_state_void_ratio"}},
      {"spreading", {}, {"coverage", "packing_density"}},
      {"angle_of_repose", {}, {"poured_void_ratio", "retained_mass"}}};
  return kExperiments;
}

struct Options {
  CampaignOptions campaign;
  std::vector<std::string> experiments = {"shear", "spreading"};
  std::vector<double> points = {15'833, 0.25};
  bool as_json = false;
};

json Row(const std::string& experiment, const std::string& response, double cohesion,
         double rolling, const Sample& embedded, const Sample& liggghts) {
  json row = {
      {"experiment", experiment}, {"response", response}, {"k", cohesion}, {"mu_r", rolling}};
  const auto a = embedded.responses.find(response);
  const auto b = liggghts.responses.find(response);
  if (a != embedded.responses.end()) row["embedded"] = Statistics(a->second);
  if (b != liggghts.responses.end()) row["liggghts"] = Statistics(b->second);
  const bool both = a != embedded.responses.end() && b != liggghts.responses.end() &&
                    a->second.size() > 1 && b->second.size() > 1;
  if (both) {
    const Difference difference = Welch(a->second, b->second);
    row["difference"] = {{"value", difference.value},
                         {"lower", difference.value - difference.half_width},
                         {"upper", difference.value + difference.half_width}};
  }
  row["outcomes"] = {{"embedded", embedded.outcomes}, {"liggghts", liggghts.outcomes}};
  return row;
}

void Print(const json& row) {
  const auto side = [&](const char* name) {
    if (!row.contains(name)) return std::string("-");
    return fmt::format("{:.4g} ± {:.2g} ({})", row[name]["mean"].get<double>(),
                       row[name]["sd"].get<double>(), row[name]["n"].get<int>());
  };
  std::string difference = "-";
  if (row.contains("difference")) {
    const json& d = row["difference"];
    difference = fmt::format("{:+.2g} [{:+.2g}, {:+.2g}]", d["value"].get<double>(),
                             d["lower"].get<double>(), d["upper"].get<double>());
  }
  fmt::print("| {}.{} | {:g} | {:g} | {} | {} | {} |\n", row["experiment"].get<std::string>(),
             row["response"].get<std::string>(), row["k"].get<double>(), row["mu_r"].get<double>(),
             side("embedded"), side("liggghts"), difference);
}

json Run(const Options& options) {
  const Study study = LoadShipped(options.campaign.study);
  std::vector<Case> cases;
  std::vector<std::pair<const Experiment*, std::size_t>> order;  // with the index of the point
  for (const Experiment& experiment : Experiments()) {
    if (std::ranges::find(options.experiments, experiment.name) == options.experiments.end()) {
      continue;
    }
    const std::string section = SectionOf(study, experiment.name);
    for (std::size_t p = 0; p + 1 < options.points.size(); p += 2) {
      order.emplace_back(&experiment, p);
      for (const char* backend : {"embedded", "liggghts"}) {
        Overrides overrides = {{"backend.name", backend}};
        for (const auto& [key, value] : experiment.overrides) {
          overrides[fmt::format("{}.{}", section, key)] = value;
        }
        cases.push_back({.name = fmt::format("{} {}", experiment.name, backend),
                         .experiment = experiment.name,
                         .parameters = {options.points[p], options.points[p + 1]},
                         .overrides = std::move(overrides)});
      }
    }
  }
  const std::vector<Sample> samples = RunCampaign(cases, options.campaign);
  json rows = json::array();
  json failures = json::array();
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto& [experiment, p] = order[i];
    for (const std::string& response : experiment->responses) {
      rows.push_back(Row(experiment->name, response, options.points[p], options.points[p + 1],
                         samples[2 * i], samples[2 * i + 1]));
    }
    for (std::size_t side : {2 * i, 2 * i + 1}) {
      for (const std::string& message : samples[side].failures) {
        failures.push_back(cases[side].name + ": " + message);
      }
    }
  }
  return {{"study", options.campaign.study},
          {"seeds", options.campaign.seeds},
          {"rows", std::move(rows)},
          {"failures", std::move(failures)}};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program{"The embedded engine against LIGGGHTS, response by response"};
  Options options;
  program.add_option("--experiments", options.experiments, "of the study")->capture_default_str();
  program.add_option("--points", options.points, "k and mu_r, pair after pair");
  program.add_option("--study", options.campaign.study, "shipped study")->capture_default_str();
  program.add_option("--seeds", options.campaign.seeds, "particle seeds of each case")
      ->capture_default_str();
  program.add_option("--first-seed", options.campaign.first_seed, "the first of them")
      ->capture_default_str();
  program.add_option("--parallel", options.campaign.parallel, "simulations at a time")
      ->capture_default_str();
  program.add_flag("--json", options.as_json, "print JSON");
  CLI11_PARSE(program, argc, argv);
  const json report = Run(options);
  if (options.as_json) {
    fmt::print("{}\n", report.dump(2));
    return 0;
  }
  fmt::print("| response | k [J/m³] | mu_r | embedded (n) | LIGGGHTS (n) | difference [95 %] |\n");
  fmt::print("|---|---|---|---|---|---|\n");
  for (const json& row : report["rows"]) Print(row);
  for (const json& message : report["failures"]) fmt::print("{}\n", message.get<std::string>());
}

// What the declared approximation `approximate: {cohesion: dmt_pull_off}` changes: every response
// of the embedded engine under SJKR2 and under DMT of equal pull-off force, at given points, with
// the same particle seeds. Intervals are Welch's. See docs/validation/approximation.md.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "benchmarks/campaign.h"
#include "scaling/groups.h"
#include "studies/planner.h"

namespace {

using namespace powdercal;
using namespace powdercal::benchmarks;
using nlohmann::json;

const Overrides kApproximated = {{"approximate.cohesion", "dmt_pull_off"}};

// "15833,0.25": k [J/m3] and mu_r.
std::vector<double> ParsePoint(const std::string& text) {
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos) throw CLI::ValidationError("--points", "expected K,MU_R");
  return {std::stod(text.substr(0, comma)), std::stod(text.substr(comma + 1))};
}

// approximated − exact, with Welch's 95 % interval; null where a side has fewer than two values.
json Compared(const std::vector<double>& exact, const std::vector<double>& approximated) {
  if (exact.size() < 2 || approximated.size() < 2) return nullptr;
  const auto [difference, half_width] = Welch(approximated, exact);
  json result = {{"value", difference}, {"relative", difference / Mean(exact)}};
  if (half_width == 0) return result;
  result["half_width"] = half_width;
  result["interval"] = {difference - half_width, difference + half_width};
  result["significant"] = std::abs(difference) > half_width;
  return result;
}

json Compare(const Sample& exact, const Sample& approximated) {
  json responses = json::object();
  for (const auto& [name, values] : exact.responses) {
    const auto other = approximated.responses.find(name);
    if (other == approximated.responses.end()) continue;
    responses[name] = {{"sjkr2", Statistics(values)},
                       {"dmt_pull_off", Statistics(other->second)},
                       {"difference", Compared(values, other->second)}};
  }
  json overlaps = json::object();  // of consolidation: mean over the contacts, in diameters
  for (const auto& [law, sample] :
       {std::pair("sjkr2", &exact), std::pair("dmt_pull_off", &approximated)}) {
    const auto found = sample->diagnostics.find("mean_relative_overlap");
    if (found != sample->diagnostics.end()) overlaps[law] = Statistics(found->second);
  }
  return {{"responses", responses},
          {"mean_relative_overlap", overlaps},
          {"outcomes", {{"sjkr2", exact.outcomes}, {"dmt_pull_off", approximated.outcomes}}},
          {"failures", {{"sjkr2", exact.failures}, {"dmt_pull_off", approximated.failures}}}};
}

// Mean pull-off force of DMT over that of SJKR2, of two spheres drawn at random and of one at a
// wall, by number; and of two of the smallest and two of the largest.
json ForceRatios(const SizeDistribution& sizes) {
  constexpr int kPoints = 400;
  std::vector<double> radii;
  for (int i = 0; i < kPoints; ++i) radii.push_back(sizes.Quantile((i + 0.5) / kPoints) / 2);
  const double mean = sizes.Moment(1);
  double sum = 0;
  double squares = 0;
  double wall_sum = 0;
  double wall_squares = 0;
  for (const double a : radii) {
    wall_sum += a;
    wall_squares += a * a;
    for (const double b : radii) {
      const double reduced = a * b / (a + b);
      sum += reduced;
      squares += reduced * reduced;
    }
  }
  return {{"random_pairs", sum * mean / 4 / squares},
          {"at_walls", wall_sum * mean / 2 / wall_squares},
          {"smallest", mean / sizes.Quantile(0)},
          {"largest", mean / sizes.Quantile(1)}};
}

// The surface energies that take the place of k.
json Replacement(const CampaignOptions& options, const std::string& experiment,
                 const std::vector<double>& point) {
  const Study study = LoadShipped(options.study, kApproximated);
  const double diameter = study.powder.sizes.Moment(1);
  const Program program =
      Planner(study).PlanExperiment(IndexOf(study, experiment), point, 0).program;
  return {{"surface_energy", program.materials.particle_particle.surface_energy},
          {"surface_energy_at_walls", program.materials.particle_wall.surface_energy},
          {"law", program.law.ToString()},
          {"sjkr2_overlap_at_rest",
           EquilibriumOverlapSjkr2(
               point[0], diameter / 4,
               EffectiveModulus(program.materials.young_modulus, program.materials.poisson_ratio)) /
               diameter}};
}

void PrintTable(const json& report) {
  for (const auto& [which, ratio] : report["force_ratios"].items()) {
    fmt::print("pull-off force of dmt_pull_off over that of sjkr2, {}: {:.3f}\n", which,
               ratio.get<double>());
  }
  for (const json& entry : report["cases"]) {
    fmt::print("{} at k = {:g} J/m3, mu_r = {:g}\n", entry["experiment"].get<std::string>(),
               entry["point"]["k"].get<double>(), entry["point"]["mu_r"].get<double>());
    for (const auto& [name, response] : entry["responses"].items()) {
      const json& difference = response["difference"];
      if (difference.is_null() || !difference.contains("half_width")) continue;
      fmt::print("  {:32} sjkr2 {:>11.5g}  dmt_pull_off {:>11.5g}  difference {:+.3g} ± {:.2g}{}\n",
                 name, response["sjkr2"]["mean"].get<double>(),
                 response["dmt_pull_off"]["mean"].get<double>(), difference["value"].get<double>(),
                 difference["half_width"].get<double>(),
                 difference["significant"].get<bool>() ? " *" : "");
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program{"SJKR2 against DMT of equal pull-off force, on the embedded engine"};
  CampaignOptions options{.seeds = 5};
  std::vector<std::string> experiments = {"consolidation", "shear", "spreading"};
  std::vector<std::string> points = {"5000,0.4", "15833,0.25"};
  bool as_json = false;
  program.add_option("--study", options.study, "a shipped study with cohesion: sjkr2")
      ->capture_default_str();
  program.add_option("--seeds", options.seeds, "particle seeds of each case")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  program.add_option("--parallel", options.parallel, "simulations at a time")
      ->capture_default_str();
  program.add_option("--experiments", experiments, "of the study");
  program.add_option("--points", points, "K,MU_R with k in J/m3");
  program.add_flag("--json", as_json, "print JSON");
  CLI11_PARSE(program, argc, argv);
  std::vector<Case> cases;
  for (const std::string& text : points) {
    for (const std::string& experiment : experiments) {
      for (const bool approximated : {false, true}) {
        cases.push_back({.name = fmt::format("{} at {}, {}", experiment, text,
                                             approximated ? "dmt_pull_off" : "sjkr2"),
                         .experiment = experiment,
                         .parameters = ParsePoint(text),
                         .overrides = approximated ? kApproximated : Overrides{}});
      }
    }
  }
  const std::vector<Sample> samples = RunCampaign(cases, options);
  json report = {{"study", options.study},
                 {"seeds", options.seeds},
                 {"force_ratios", ForceRatios(LoadShipped(options.study).powder.sizes)},
                 {"cases", json::array()}};
  for (std::size_t i = 0; i < cases.size(); i += 2) {
    json entry = Compare(samples[i], samples[i + 1]);
    entry["experiment"] = cases[i].experiment;
    entry["point"] = {{"k", cases[i].parameters[0]}, {"mu_r", cases[i].parameters[1]}};
    entry["replacement"] = Replacement(options, cases[i].experiment, cases[i].parameters);
    report["cases"].push_back(std::move(entry));
  }
  if (as_json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    PrintTable(report);
  }
}

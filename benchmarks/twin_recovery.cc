// Does a calibration find the parameters behind its observations, and which experiments does it
// take? The observations of twin_joint and twin_consolidation_only were made by the embedded engine
// at known parameters (`--observe` repeats them); their studies are run here with several optimizer
// seeds, each from nothing. The observations' scatter: docs/validation/protocols.md.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "benchmarks/campaign.h"
#include "benchmarks/run_program.h"
#include "core/errors.h"
#include "studies/runner.h"

namespace {

using namespace powdercal;
using namespace powdercal::benchmarks;
namespace fs = std::filesystem;
using nlohmann::json;

// What the optimizers are not told.
constexpr double kCohesion = 30'000;       // [J/m3]
constexpr double kRollingFriction = 0.25;  // [-]
// Within what a study counts as having recovered them.
constexpr double kCohesionMargin = 0.10;  // relative
constexpr double kRollingMargin = 0.08;

struct Options {
  int seeds = 10;
  int first_seed = 1;
  int parallel = 2;
  bool as_json = false;
  std::string only;
  std::string keep;  // folder of the runs
  std::optional<int> evaluations;
};

struct Recovery {
  int seed = 0;
  int evaluations = 0;
  double cohesion = NAN;
  double rolling = NAN;
  double chi2 = NAN;
  double simulation_seconds = 0;
  double wall_seconds = 0;

  double CohesionError() const { return std::abs(cohesion / kCohesion - 1); }
  double RollingError() const { return std::abs(rolling - kRollingFriction); }
  bool Recovered() const {
    return CohesionError() <= kCohesionMargin && RollingError() <= kRollingMargin;
  }
};

Recovery Recover(const std::string& name, int seed, const fs::path& folder,
                 const Options& options) {
  Overrides overrides = {{"seed", std::to_string(seed)},
                         {"budget.parallel", std::to_string(options.parallel)}};
  if (options.evaluations) overrides["budget.evaluations"] = std::to_string(*options.evaluations);
  Study study = LoadShipped(name, overrides);
  StudyRunner(study, {.folder = folder}).Run();
  const StudyResults results =
      CollectResults(study, Ledger(folder / "ledger.sqlite", Ledger::Mode::read_write));
  Recovery recovery{.seed = seed,
                    .evaluations = results.total,
                    .simulation_seconds = results.simulation_seconds,
                    .wall_seconds = results.wall_seconds};
  if (results.best) {
    const EvaluationResult& best = results.history[*results.best];
    recovery.cohesion = best.parameters.at("cohesion_energy_density");
    recovery.rolling = best.parameters.at("rolling_friction");
    recovery.chi2 = best.chi2.value_or(NAN);
  }
  fmt::print(stderr, "{} seed {}: k = {:.0f}, mu_r = {:.3f} after {} evaluations, {:.0f} s\n", name,
             seed, recovery.cohesion, recovery.rolling, recovery.evaluations,
             recovery.wall_seconds);
  return recovery;
}

json Summarise(const std::vector<Recovery>& runs) {
  std::vector<double> cohesion;
  std::vector<double> rolling;
  std::vector<double> found;
  std::vector<double> costs;
  json list = json::array();
  int recovered = 0;
  for (const Recovery& run : runs) {
    cohesion.push_back(run.CohesionError());
    rolling.push_back(run.RollingError());
    found.push_back(run.rolling);
    costs.push_back(run.simulation_seconds / run.evaluations);
    recovered += run.Recovered() ? 1 : 0;
    list.push_back({{"seed", run.seed},
                    {"k", run.cohesion},
                    {"mu_r", run.rolling},
                    {"chi2", run.chi2},
                    {"evaluations", run.evaluations},
                    {"recovered", run.Recovered()},
                    {"simulation_s", run.simulation_seconds},
                    {"wall_s", run.wall_seconds}});
  }
  return {
      {"k_rel_error", {{"median", Median(cohesion)}, {"max", *std::ranges::max_element(cohesion)}}},
      {"mu_r_error", {{"median", Median(rolling)}, {"max", *std::ranges::max_element(rolling)}}},
      {"mu_r_sd", StandardDeviation(found)},
      {"simulation_s_per_evaluation", Median(costs)},
      {"recovered", recovered},
      {"of", runs.size()},
      {"runs", list}};
}

// The observations: means over particle seeds that no study uses.
void Observe(const Options& options) {
  std::vector<Case> cases;
  const Study study = LoadShipped("twin_joint");
  for (const StudyExperiment& entry : study.experiments) {
    cases.push_back({.name = entry.experiment->name(),
                     .experiment = entry.experiment->name(),
                     .parameters = {kCohesion, kRollingFriction}});
  }
  const std::vector<Sample> samples = RunCampaign(cases, {.study = "twin_joint",
                                                          .first_seed = 90'001,
                                                          .seeds = options.seeds,
                                                          .parallel = options.parallel});
  json report;
  for (std::size_t i = 0; i < cases.size(); ++i) report[cases[i].name] = ToJson(samples[i]);
  fmt::print("{}\n", report.dump(2));
}

int Run(int argc, char** argv) {
  CLI::App program{"Recovery of known parameters by the twin studies"};
  Options options;
  bool observe = false;
  program.add_option("--seeds", options.seeds, "optimizer seeds (or particle seeds of --observe)")
      ->capture_default_str();
  program.add_option("--first-seed", options.first_seed, "the first of them")
      ->capture_default_str();
  program.add_option("--parallel", options.parallel, "simulations at a time")
      ->capture_default_str();
  program.add_option("--evaluations", options.evaluations, "instead of the studies' own budget");
  program.add_option("--only", options.only, "joint or consolidation_only")
      ->check(CLI::IsMember({"joint", "consolidation_only"}));
  program.add_option("--keep", options.keep, "run folders go here, and are resumed from here");
  program.add_flag("--observe", observe, "make the observations anew and print them");
  program.add_flag("--json", options.as_json, "print JSON");
  CLI11_PARSE(program, argc, argv);
  if (observe) {
    Observe(options);
    return 0;
  }
  const fs::path folder = options.keep.empty()
                              ? fs::temp_directory_path() / fmt::format("twin-{}", getpid())
                              : fs::path(options.keep);
  json report = {{"truth", {{"k", kCohesion}, {"mu_r", kRollingFriction}}},
                 {"margins", {{"k_rel", kCohesionMargin}, {"mu_r", kRollingMargin}}}};
  for (const std::string kind : {"joint", "consolidation_only"}) {
    if (!options.only.empty() && kind != options.only) continue;
    std::vector<Recovery> runs;
    for (int i = 0; i < options.seeds; ++i) {
      const int seed = options.first_seed + i;
      runs.push_back(
          Recover("twin_" + kind, seed, folder / fmt::format("{}-{}", kind, seed), options));
    }
    report[kind] = Summarise(runs);
    if (!options.as_json) {
      const json& summary = report[kind];
      fmt::print(
          "{:19} recovered {} of {}; median error: k {:.1f} %, mu_r {:.3f}; sd of mu_r {:.3f}\n",
          kind, summary["recovered"].get<int>(), summary["of"].get<int>(),
          100 * summary["k_rel_error"]["median"].get<double>(),
          summary["mu_r_error"]["median"].get<double>(), summary["mu_r_sd"].get<double>());
    }
  }
  if (report.contains("joint") && report.contains("consolidation_only")) {
    report["mu_r_sd_ratio"] = report["consolidation_only"]["mu_r_sd"].get<double>() /
                              report["joint"]["mu_r_sd"].get<double>();
  }
  if (options.as_json) fmt::print("{}\n", report.dump(2));
  std::error_code ignored;
  if (options.keep.empty()) fs::remove_all(folder, ignored);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return Main(Run, argc, argv); }

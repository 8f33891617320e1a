// What the void ratio of the consolidation test depends on besides the powder: preparation,
// numerics, number of particles, particle seed. Simulations of the quickstart study, several
// particle seeds each. See docs/validation/consolidation.md.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "studies/executor.h"
#include "studies/planner.h"

namespace {

using namespace powdercal;
namespace fs = std::filesystem;

struct Variant {
  const char* name;
  Overrides overrides;
};

const char* kInitialFraction = "experiments[0].consolidation.initial_solid_fraction";
const char* kInitialVelocity = "experiments[0].consolidation.initial_velocity";

const std::vector<Variant> kVariants = {
    {"base", {}},
    {"initial_solid_fraction 0.20", {{kInitialFraction, "0.20"}}},
    {"initial_solid_fraction 0.34", {{kInitialFraction, "0.34"}}},
    {"initial_velocity 0", {{kInitialVelocity, "0 m/s"}}},
    {"initial_velocity 0.3 m/s", {{kInitialVelocity, "0.3 m/s"}}},
    {"time step 0.1 Rayleigh", {{"numerics.rayleigh_fraction", "0.1"}}},
    {"time step 0.4 Rayleigh", {{"numerics.rayleigh_fraction", "0.4"}}},
    {"limit_force on", {{"contact_law.limit_force", "true"}}},
    {"torsion off", {{"contact_law.torsion", "false"}}},
    {"rolling cdt", {{"contact_law.rolling", "cdt"}}},
    {"tangential no_history", {{"contact_law.tangential", "no_history"}}},
    {"fidelity standard", {{"backend.fidelity", "standard"}}},
};

struct Point {
  double cohesion;  // [J/m3]
  double rolling;   // [-]
};
const std::vector<Point> kPoints = {{7000, 0.4}, {47500, 0.5}};

nlohmann::json Statistics(const std::vector<double>& values) {
  if (values.empty()) return nullptr;
  double mean = 0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  const double sd = values.size() > 1 ? std::sqrt(sum / static_cast<double>(values.size() - 1)) : 0;
  return {{"mean", mean}, {"sd", sd}, {"n", values.size()}};
}

struct Options {
  std::string backend = "embedded";
  int seeds = 5;
  int parallel = 2;
};

nlohmann::json Measure(const Variant& variant, const Point& point, const Options& options) {
  const int seeds = options.seeds;
  Overrides overrides = variant.overrides;
  overrides["backend.name"] = options.backend;
  overrides["backend.replicates"] = "1";
  overrides["backend.confirm_replicates"] = "1";
  const Study study =
      Study::Load(POWDERCAL_SOURCE_DIR "/studies/library/quickstart.yaml", overrides);
  const Planner planner(study);
  LocalExecutor executor(options.parallel);
  const fs::path folder = fs::temp_directory_path() / fmt::format("protocol-{}", getpid());
  for (int seed = 0; seed < seeds; ++seed) {
    const auto run = planner.PlanExperiment(0, {point.cohesion, point.rolling}, seed,
                                            static_cast<std::uint64_t>(seed) + 1);
    executor.Submit(seed, [&planner, run, folder, seed](std::stop_token stop) {
      return planner.Execute(run, {.work_folder = folder / std::to_string(seed),
                                   .time_limit = std::chrono::minutes(10),
                                   .stop = std::move(stop)});
    });
  }
  std::map<std::string, std::vector<double>> figures;
  std::map<std::string, int> outcomes;
  for (int seed = 0; seed < seeds; ++seed) {
    auto finished = executor.Wait(std::chrono::hours(1));
    if (!finished) break;
    const LedgerRun& run = finished->run;
    ++outcomes[ToString(run.outcome.reason)];
    if (!run.outcome.ok()) continue;
    for (const auto& [name, response] : run.measurement.responses) {
      figures[name].push_back(response.value);
    }
    for (const auto& [name, value] : run.measurement.diagnostics) figures[name].push_back(value);
    figures["simulator_seconds"].push_back(run.diagnostics.wall_seconds);
    figures["steps"].push_back(static_cast<double>(run.diagnostics.steps));
  }
  fs::remove_all(folder);
  nlohmann::json result = {{"variant", variant.name},
                           {"cohesion_energy_density", point.cohesion},
                           {"rolling_friction", point.rolling},
                           {"outcomes", outcomes}};
  for (const auto& [name, values] : figures) result["figures"][name] = Statistics(values);
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program{"What the void ratio depends on besides the powder"};
  Options options;
  bool json = false;
  std::string only;
  program.add_option("--backend", options.backend, "simulator")
      ->check(CLI::IsMember({"embedded", "liggghts"}))
      ->capture_default_str();
  program.add_option("--seeds", options.seeds, "particle seeds of each variant");
  program.add_option("--parallel", options.parallel, "simulations at a time");
  program.add_option("--only", only, "variants whose name contains this");
  program.add_flag("--json", json, "print JSON");
  CLI11_PARSE(program, argc, argv);
  nlohmann::json cases = nlohmann::json::array();
  for (const Variant& variant : kVariants) {
    if (std::string(variant.name).find(only) == std::string::npos) continue;
    for (const Point& point : kPoints) {
      const nlohmann::json result = Measure(variant, point, options);
      cases.push_back(result);
      if (json) continue;
      const nlohmann::json e =
          result.contains("figures") ? result["figures"]["void_ratio"] : nullptr;
      fmt::print(
          "{:28} k={:<6g} mu_r={:<4g} e={} {}\n", variant.name, point.cohesion, point.rolling,
          e.is_null()
              ? "-"
              : fmt::format("{:.4f} ± {:.4f}", e["mean"].get<double>(), e["sd"].get<double>()),
          result["outcomes"].dump());
      std::fflush(stdout);
    }
  }
  if (!json) return 0;
  const nlohmann::json report = {
      {"backend", options.backend}, {"seeds", options.seeds}, {"cases", cases}};
  fmt::print("{}\n", report.dump(2));
}

// What the responses of an experiment depend on besides the powder: size, rate, time step,
// geometry, preparation, particle seed. One thing at a time is varied about the study's own
// setting, several particle seeds each. See docs/validation/protocols.md; benchmarks/plot.mjs draws
// the JSON.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "benchmarks/campaign.h"
#include "benchmarks/run_program.h"
#include "core/errors.h"

namespace {

using namespace powdercal;
using namespace powdercal::benchmarks;
using nlohmann::json;

struct Setting {
  std::string label;    // on the axis of the plot; "" with every sweep: the study's own setting
  Overrides overrides;  // {EXPERIMENT} stands for the path of the experiment's section
};

struct Sweep {
  std::string name;
  std::vector<Setting> settings;
};

// One option of the experiment, at several values.
Sweep Vary(const std::string& name, const std::string& option,
           const std::vector<std::string>& values) {
  Sweep sweep{.name = name, .settings = {}};
  for (const std::string& value : values) {
    sweep.settings.push_back({value, {{fmt::format("{{EXPERIMENT}}.{}", option), value}}});
  }
  return sweep;
}

Sweep VaryStudy(const char* name, const char* key, const std::vector<const char*>& values) {
  Sweep sweep{.name = name, .settings = {}};
  for (const char* value : values) sweep.settings.push_back({value, {{key, value}}});
  return sweep;
}

Overrides With(Overrides overrides, const std::string& key, const std::string& value) {
  overrides[key] = value;
  return overrides;
}

// Of the shear test.
const Overrides kMany = {{"{EXPERIMENT}.fidelity", "standard"},
                         {"{EXPERIMENT}.inertial_number", "0.004"},
                         {"{EXPERIMENT}.preshear_strain", "2.4"}};
const Overrides kChatter = {{"contact_law.rolling", "cdt"}};

std::vector<Sweep> SweepsOf(const std::string& experiment) {
  std::vector<Sweep> sweeps = {
      {"the study's own", {{"", {}}}},
      VaryStudy("time step [Rayleigh times]", "numerics.rayleigh_fraction", {"0.1", "0.2", "0.4"})};
  const auto add = [&](Sweep sweep) { sweeps.push_back(std::move(sweep)); };
  if (experiment == "consolidation") {
    add(Vary("fidelity", "fidelity", {"quick", "standard"}));
    add(Vary("initial solid fraction", "initial_solid_fraction", {"0.20", "0.30", "0.34"}));
    add(Vary("initial velocity", "initial_velocity", {"0 m/s", "0.1 m/s", "0.3 m/s"}));
    add(VaryStudy("limit_force", "contact_law.limit_force", {"false", "true"}));
    add(VaryStudy("torsion", "contact_law.torsion", {"true", "false"}));
    add(VaryStudy("rolling", "contact_law.rolling", {"epsd2", "cdt"}));
    add(VaryStudy("tangential", "contact_law.tangential", {"history", "no_history"}));
  } else if (experiment == "shear") {
    // `standard` has more particles, and a slower and longer preshear, which are put back here.
    add({"particles", {{"1000", {{"{EXPERIMENT}.fidelity", "quick"}}}, {"3000", kMany}}});
    add(Vary("inertial number", "inertial_number", {"0.002", "0.004", "0.008"}));
    add(Vary("preshear strain", "preshear_strain", {"2.4", "4"}));
    add(Vary("yield strain", "yield_strain", {"0.05", "0.1", "0.2"}));
    add(Vary("presheared states", "repeats", {"3", "5", "9"}));
    add(Vary("cell", "cell", {"periodic", "platens"}));
    add({"cell of 3000",
         {{"periodic", kMany}, {"platens", With(kMany, "{EXPERIMENT}.cell", "platens")}}});
    const auto load = [](const char* preshear, const char* normal_stresses) {
      return Setting{
          preshear,
          {{"{EXPERIMENT}.preshear", preshear}, {"{EXPERIMENT}.normal_stresses", normal_stresses}}};
    };
    add({"load",
         {load("3 kPa", "[1 kPa, 1.7 kPa, 2.3 kPa]"), load("9 kPa", "[3 kPa, 5 kPa, 7 kPa]"),
          load("27 kPa", "[9 kPa, 15 kPa, 21 kPa]")}});
    add(VaryStudy("friction", "material.friction.particle", {"0.15", "0.3", "0.45"}));
    add({"cdt: time step [Rayleigh times]",
         {{"0.1", With(kChatter, "numerics.rayleigh_fraction", "0.1")},
          {"0.2", With(kChatter, "numerics.rayleigh_fraction", "0.2")},
          {"0.36", With(kChatter, "numerics.rayleigh_fraction", "0.36")}}});
    add({"cdt: inertial number",
         {{"0.002", With(kChatter, "{EXPERIMENT}.inertial_number", "0.002")},
          {"0.004", kChatter},
          {"0.008", With(kChatter, "{EXPERIMENT}.inertial_number", "0.008")}}});
  } else if (experiment == "spreading") {
    add(Vary("gap", "gap", {"60 um", "80 um", "120 um"}));
    add(Vary("sweep", "sweep", {"1.04 mm", "2 mm"}));
    add(Vary("width", "width", {"120 um", "174 um", "290 um"}));
    add(Vary("powder surplus", "powder_surplus", {"0.9", "1.1", "1.5"}));
    add(Vary("start margin [gaps]", "start_margin", {"1.5", "3", "4.5"}));
    add(Vary("density cell [d]", "density_cell", {"2", "3", "5"}));
    add(Vary("blade speed", "blade_speed", {"12.5 mm/s", "25 mm/s", "50 mm/s"}));
    add(Vary("plate", "plate", {"rough", "smooth"}));
  } else if (experiment == "angle_of_repose") {
    add(Vary("fidelity", "fidelity", {"quick", "standard"}));
    add(Vary("bed aspect", "bed_aspect", {"0.6", "0.8", "1"}));
    add(Vary("flow time", "flow_time", {"30 ms", "65 ms", "100 ms"}));
  }
  return sweeps;
}

struct Point {
  double cohesion;  // [J/m3]
  double rolling;   // [-]
};

Overrides Resolve(const Overrides& overrides, const std::string& path) {
  static const std::string kPlace = "{EXPERIMENT}";
  Overrides resolved;
  for (const auto& [key, value] : overrides) {
    const bool own = key.starts_with(kPlace);
    resolved[own ? path + key.substr(kPlace.size()) : key] = value;
  }
  return resolved;
}

struct Options {
  CampaignOptions campaign{.seeds = 4};
  std::string experiment = "shear";
  std::string only;
  std::vector<std::string> vary;  // an option and its values, in place of the sweeps here
  std::vector<double> points = {15'833, 0.25, 47'500, 0.5};
  std::string backend = "embedded";
  std::vector<std::string> set;  // KEY=VALUE, for all cases
  bool as_json = false;
};

json Run(const Options& options) {
  const Study study = LoadShipped(options.campaign.study);
  const std::string path = SectionOf(study, options.experiment);
  Overrides common;
  AddOverrides(options.set, &common);
  std::vector<Case> cases;
  json sweeps = json::array();
  std::vector<Sweep> chosen;
  if (options.vary.empty()) {
    for (Sweep& sweep : SweepsOf(options.experiment)) {
      if (sweep.name.find(options.only) != std::string::npos) chosen.push_back(std::move(sweep));
    }
  } else {
    const std::string& option = options.vary.front();
    chosen.push_back(Vary(option, option, {options.vary.begin() + 1, options.vary.end()}));
  }
  for (const Sweep& sweep : chosen) {
    for (const Setting& setting : sweep.settings) {
      for (std::size_t p = 0; p + 1 < options.points.size(); p += 2) {
        Overrides overrides = Resolve(setting.overrides, path);
        overrides.insert(common.begin(), common.end());
        overrides["backend.name"] = options.backend;
        cases.push_back({.name = fmt::format("{} {}", sweep.name, setting.label),
                         .experiment = options.experiment,
                         .parameters = {options.points[p], options.points[p + 1]},
                         .overrides = std::move(overrides)});
      }
    }
  }
  const std::vector<Sample> samples = RunCampaign(cases, options.campaign);
  std::size_t next = 0;
  for (const Sweep& sweep : chosen) {
    json entries = json::array();
    for (const Setting& setting : sweep.settings) {
      for (std::size_t p = 0; p + 1 < options.points.size(); p += 2) {
        json entry = ToJson(samples[next++]);
        entry["setting"] = setting.label;
        entry["point"] = {{"k", options.points[p]}, {"mu_r", options.points[p + 1]}};
        entries.push_back(std::move(entry));
      }
    }
    sweeps.push_back({{"sweep", sweep.name}, {"cases", std::move(entries)}});
  }
  json units = json::object();
  const StudyExperiment& entry = study.experiments[IndexOf(study, options.experiment)];
  for (const ResponseDescription& response : entry.experiment->responses()) {
    units[response.name] = response.unit;
  }
  return {{"experiment", options.experiment}, {"units", std::move(units)},
          {"study", options.campaign.study},  {"backend", options.backend},
          {"seeds", options.campaign.seeds},  {"sweeps", std::move(sweeps)}};
}

void PrintTable(const json& report) {
  for (const json& sweep : report["sweeps"]) {
    fmt::print("{}\n", sweep["sweep"].get<std::string>());
    for (const json& entry : sweep["cases"]) {
      fmt::print("  {:>14} k={:<6g} mu_r={:<5g}", entry["setting"].get<std::string>(),
                 entry["point"]["k"].get<double>(), entry["point"]["mu_r"].get<double>());
      for (const auto& [name, value] : entry["responses"].items()) {
        fmt::print("  {} {:.4g}±{:.2g}", name, value["mean"].get<double>(),
                   value["sd"].get<double>());
      }
      const json& seconds = entry["diagnostics"].value("simulator_seconds", json());
      if (!seconds.is_null()) fmt::print("  {:.1f} s", seconds["mean"].get<double>());
      fmt::print("  {}\n", entry["outcomes"].dump());
    }
  }
}

int RunProgram(int argc, char** argv) {
  CLI::App program{"What an experiment's responses depend on besides the powder"};
  Options options;
  program.add_option("--experiment", options.experiment, "of the study")->capture_default_str();
  program.add_option("--study", options.campaign.study, "shipped study with that experiment")
      ->capture_default_str();
  program.add_option("--backend", options.backend, "simulator")->capture_default_str();
  program.add_option("--seeds", options.campaign.seeds, "particle seeds of each case")
      ->capture_default_str();
  program.add_option("--parallel", options.campaign.parallel, "simulations at a time")
      ->capture_default_str();
  program.add_option("--only", options.only, "sweeps whose name contains this");
  program.add_option("--vary", options.vary,
                     "only one sweep: an option of the experiment, and its values");
  program.add_option("--set", options.set,
                     "KEY=VALUE of the study, for all cases that do not vary KEY themselves");
  program.add_option("--points", options.points, "k and mu_r, pair after pair");
  program.add_flag("--json", options.as_json, "print JSON");
  CLI11_PARSE(program, argc, argv);
  const json report = Run(options);
  if (options.as_json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    PrintTable(report);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return Main(RunProgram, argc, argv); }

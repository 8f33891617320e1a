#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <numeric>

#include "cli/collapse.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "cli/parameters.h"
#include "cli/scaling_text.h"
#include "cli/text.h"
#include "reports/results_json.h"
#include "scaling/pi_engine.h"
#include "studies/planner.h"

namespace powdercal::cli {
namespace {

using nlohmann::json;

std::string List(const std::vector<std::string>& names) {
  return names.empty() ? "none" : JoinNames(names);
}

void PrintGroups(const VariablesFile& file, const PiBasis& basis) {
  Print("{} variables of {} base quantities ({}), rank {}: {} groups\n", basis.variables.size(),
        basis.dimensions.size(), List(basis.dimensions), basis.rank, basis.groups.size());
  Print("repeating: {}\n", List(basis.repeating));
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < basis.groups.size(); ++i) {
    const std::string name = basis.names[i].empty() ? fmt::format("Pi_{}", i + 1) : basis.names[i];
    rows.push_back({name, "=", ToString(basis.groups[i])});
  }
  Print("{}", AlignedTable(rows));
  if (!file.prefer.empty() && !basis.not_repeating.empty()) {
    Print("note: {} cannot repeat: the preferred variables before span the same dimensions\n",
          JoinNames(basis.not_repeating));
  }
  if (!basis.unused.empty()) {
    Print(
        "note: {} in no group: no product of the other variables has such a dimension. Either it "
        "has no influence, or a variable is missing\n",
        basis.unused.size() == 1 ? basis.unused[0] + " is" : JoinNames(basis.unused) + " are");
  }
  if (basis.rank_deficient()) {
    Print(
        "note: the base quantities {} occur in {} independent combinations only, hence {} more "
        "than the usual number of groups\n",
        JoinNames(basis.dimensions), basis.rank,
        static_cast<int>(basis.dimensions.size()) - basis.rank);
  }
}

json GroupsToJson(const PiBasis& basis) {
  return {{"schema", 1},
          {"variables", basis.variables},
          {"dimensions", basis.dimensions},
          {"rank", basis.rank},
          {"rank_deficient", basis.rank_deficient()},
          {"repeating", basis.repeating},
          {"not_repeating", basis.not_repeating},
          {"unused", basis.unused},
          {"names", basis.names},
          {"groups", basis.groups}};
}

void ScaleVariables(const std::string& path, bool as_json) {
  const VariablesFile file = ReadVariables(path);
  const PiBasis basis = FindGroups(file.variables, file.prefer, file.named);
  if (as_json) {
    Print("{}\n", GroupsToJson(basis).dump(2));
  } else {
    PrintGroups(file, basis);
  }
}

std::vector<std::size_t> AllExperiments(const Study& study) {
  std::vector<std::size_t> all(study.experiments.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

// Why the study's scaling cannot be had, or "".
std::string ExplainImpossible(const Study& study, const Planner& planner) {
  for (const std::size_t i : AllExperiments(study)) {
    if (std::string reason = planner.ExplainUnplanned(i); !reason.empty()) return reason;
  }
  std::vector<Conditions> all;
  for (const std::size_t i : AllExperiments(study)) all.push_back(planner.Laboratory(i));
  const std::string reason = study.scaling->ExplainWithoutEffect(all);
  return reason.empty() ? "" : fmt::format("scaling '{}': {}", study.scaling->name(), reason);
}

void PrintStudy(const Study& study, const std::vector<double>& parameters,
                const std::vector<ScalingTable>& tables, const std::vector<ModeCost>& costs) {
  Print("# scaling '{}': {}\n", study.scaling->name(), study.scaling->Describe());
  for (const ScalingTable& table : tables) {
    Print("\n# {} at {}\n{}\n{}", table.experiment,
          DescribePoint(study.space.parameters, parameters), ConditionsTable(table),
          GroupTable(table, OutputIsTerminal()));
  }
  const std::string cohesion = CohesionText(tables);
  if (!cohesion.empty())
    Print("\n# what the simulation's cohesion says of the powder\n{}", cohesion);
  Print("\n# one run of each experiment by scaling mode{}\n{}", kModeTableRemark, ModeTable(costs));
}

json ConditionsToJson(const Conditions& conditions) {
  json object = json::object();
  const auto add = [&](const char* name, const std::optional<double>& value) {
    if (value) object[name] = *value;
  };
  add("stress", conditions.stress);
  add("young_modulus", conditions.young_modulus);
  add("poisson_ratio", conditions.poisson_ratio);
  add("density", conditions.density);
  add("diameter", conditions.diameter);
  add("gravity", conditions.gravity);
  add("cohesion_energy_density", conditions.cohesion_energy_density);
  add("surface_energy", conditions.surface_energy);
  add("velocity", conditions.velocity);
  add("shear_rate", conditions.shear_rate);
  add("time_step", conditions.time_step);
  object["speed_ratio"] = conditions.speed_ratio;
  return object;
}

json StudyToJson(const Study& study, const std::vector<double>& parameters,
                 const std::vector<ScalingTable>& tables, const std::vector<ModeCost>& costs) {
  json document = {{"schema", 1},
                   {"study", study.name},
                   {"mode", study.scaling->name()},
                   {"description", study.scaling->Describe()},
                   {"experiments", PiGroupsToJson(tables)},
                   {"modes", ModesToJson(costs)}};
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Parameter& parameter = study.space.parameters[i];
    document["parameters"][parameter.name] = ValueToJson(parameter, parameters[i]);
  }
  std::vector<PowderCohesion> readings;
  for (std::size_t i = 0; i < tables.size(); ++i) {
    document["experiments"][i]["laboratory"] = ConditionsToJson(tables[i].laboratory);
    document["experiments"][i]["simulation"] = ConditionsToJson(tables[i].simulation);
    if (tables[i].cohesion) readings.push_back(*tables[i].cohesion);
  }
  document["cohesion"] = Describe(readings);
  return document;
}

void ScaleStudy(const Study& study, const std::vector<std::string>& texts, bool as_json) {
  const Planner planner(study);
  const std::string reason = ExplainImpossible(study, planner);
  if (!reason.empty()) throw InputError(reason, {.location = {study.file}});
  const std::vector<double> parameters = ReadParameters(study, texts, planner.Centre());
  const std::vector<std::size_t> all = AllExperiments(study);
  const std::vector<ScalingTable> tables = planner.ScalingTables(all, parameters);
  const std::vector<ModeCost> costs = CompareModes(study, all);
  if (as_json) {
    Print("{}\n", StudyToJson(study, parameters, tables, costs).dump(2));
  } else {
    PrintStudy(study, parameters, tables, costs);
  }
}

}  // namespace

void AddScale(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand(
      "scale", "Print what a study's scaling keeps and costs, or the groups of any variables.");
  struct Options {
    StudyOptions study;
    std::string variables;
    std::vector<std::string> parameters;
    bool collapse = false;
    CollapseCommand simulations;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  options->study.Declare(*command, false);
  command
      ->add_option("--variables", options->variables,
                   "in place of a study: file of variables and their units, of any problem")
      ->type_name("FILE")
      ->check(NotEmpty);
  command
      ->add_option("-p,--parameter", options->parameters,
                   "value of a free parameter by name or symbol, in place of the centre of its "
                   "range")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  CLI::Option* collapse = command->add_flag(
      "--collapse", options->collapse,
      "simulate the experiments under several scalings, and tell which groups they follow");
  command
      ->add_option("--kappa", options->simulations.kappas,
                   "with --collapse: floors of kappa for rigid_limit; 250 500 1000 2000 4000")
      ->needs(collapse)
      ->check(CLI::Range(1.0, 1e8));
  command
      ->add_option("--replicates", options->simulations.replicates,
                   "with --collapse: number of particle seeds")
      ->needs(collapse)
      ->check(CLI::Range(2, 1000));
  command
      ->add_option("--experiment", options->simulations.experiments,
                   "with --collapse: only this experiment of the study; may be repeated")
      ->type_name("EXPERIMENT")
      ->needs(collapse)
      ->allow_extra_args(false);
  command
      ->add_option("--out", options->simulations.folder,
                   "with --collapse: folder for collapse.json and the plots, collapse.html")
      ->type_name("FOLDER")
      ->needs(collapse)
      ->check(NotEmpty);
  command->add_flag("--json", options->json, "for machines");
  command->callback([options, &status] {
    if (options->collapse && options->study.file().empty()) {
      throw InputError("--collapse needs a STUDY", {.location = {"command line"}});
    }
    if (options->study.file().empty() == options->variables.empty()) {
      throw InputError("expected either a STUDY or --variables FILE",
                       {.location = {"command line"}});
    }
    if (options->collapse) {
      const Study study = options->study.Load();
      CollapseCommand simulations = options->simulations;
      simulations.parameters = ReadParameters(study, options->parameters, Planner(study).Centre());
      simulations.json = options->json;
      status = RunCollapse(study, simulations);
      return;
    }
    if (!options->study.file().empty()) {
      ScaleStudy(options->study.Load(), options->parameters, options->json);
    } else {
      ScaleVariables(options->variables, options->json);
    }
    status = kDone;
  });
}

}  // namespace powdercal::cli

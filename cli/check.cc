#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/output.h"
#include "cli/scaling_text.h"
#include "cli/text.h"
#include "core/quantity.h"
#include "reports/results_json.h"
#include "reports/text.h"
#include "studies/fidelities.h"
#include "studies/planner.h"
#include "studies/run_directory.h"

namespace powdercal::cli {
namespace {

using nlohmann::json;

// What would stop `run`, or "".
std::string ExplainBlocked(Study& study, const Planner& planner,
                           const std::vector<std::size_t>& evaluate_also,
                           const std::filesystem::path& folder) {
  const Availability& availability = planner.availability();
  if (!availability.available) {
    return fmt::format("backend '{}' is not available: {}", study.backend.backend->name(),
                       availability.why_not);
  }
  if (const std::string reason = planner.ExplainUnsupported(); !reason.empty()) return reason;
  if (const std::string reason = planner.ExplainUnsupported(evaluate_also); !reason.empty()) {
    return reason;
  }
  return RunDirectory::Explain(folder, study.Fingerprint());
}

std::string DescribeProgram(const Study& study, const Planner::ExperimentCost& cost,
                            const Program& program) {
  const Materials& m = program.materials;
  const double rayleigh =
      RayleighTime(study.powder.sizes.Quantile(0) / 2, m.density, m.young_modulus, m.poisson_ratio);
  return fmt::format(
      "  {}{}: {} particles ({}), cell {} wide, E = {}, time step {} ({:.2g} of the Rayleigh "
      "time)\n"
      "    law: {}\n",
      program.experiment, study.experiments[cost.experiment].calibrate ? "" : ", not calibrated",
      cost.particles, ToString(program.fidelity), HumanQuantity(program.domain.Lengths()[0], "m"),
      HumanQuantity(m.young_modulus, "Pa"), HumanQuantity(program.time_step, "s", 3),
      program.time_step / rayleigh, program.law.ToString());
}

std::vector<std::string> Concatenated(std::vector<std::string> first,
                                      const std::vector<std::string>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

std::vector<std::size_t> ExperimentsOf(const Planner::Cost& cost) {
  std::vector<std::size_t> experiments;
  for (const Planner::ExperimentCost& one : cost.experiments) {
    experiments.push_back(one.experiment);
  }
  return experiments;
}

void PrintCost(const Study& study, const Planner::Cost& cost) {
  const bool simulates = study.backend.backend->simulates();
  Print("\n# cost (right within a factor of about 2)\n");
  const auto print = [&](const Planner::ExperimentCost& one, const std::string& where) {
    Print("  {}{}: {} runs", study.experiments[one.experiment].name(), where, one.runs);
    if (simulates) Print(", {:.2g} steps and {} each", one.steps, DurationText(one.seconds));
    Print("\n");
  };
  for (const Planner::ExperimentCost& one : cost.experiments) print(one, "");
  for (const Planner::ConfirmationCost& confirmation : cost.confirmations) {
    for (const Planner::ExperimentCost& one : confirmation.experiments) {
      print(one, " on " + confirmation.backend);
    }
  }
  for (const Planner::ExperimentCost& one : cost.approximation) {
    print(one, fmt::format(", what the approximation changes, on {}", kReferenceBackend));
  }
  if (simulates) {
    Print("  {} runs, {} in all with {} at a time\n", cost.runs, DurationText(cost.seconds),
          study.parallel());
  } else {
    Print("  {}\n", kNoSimulation);
  }
}

void PrintFidelities(const Study& study, const Planner& planner) {
  const StudyFidelities fidelities(study, planner);
  for (const FidelityLevel& level : fidelities.levels()) {
    if (level.fidelity == 1) continue;
    Print("  the optimizer may evaluate at {} instead, which counts as {:.2g} of an evaluation\n",
          FidelityNameAt(study, level.fidelity), level.cost);
  }
}

// Where the best point will be confirmed, and where it cannot be.
void PrintConfirmations(const Study& study) {
  for (const auto& other : study.backend.confirm_with) {
    const Availability availability = other->availability();
    Print("  confirmation: {} {}, {} particle seeds\n", other->name(),
          availability.available ? availability.version : "(absent)",
          study.backend.confirm_replicates);
  }
}

void PrintText(Study& study, const Planner& planner, const std::vector<std::size_t>& evaluate_also,
               const std::string& blocked) {
  Print("# resolved study\n{}\n# plan\n", study.ToYaml());
  const std::vector<double> centre = planner.Centre();
  const Planner::Cost cost = planner.EstimateCost(evaluate_also);
  for (const Planner::ExperimentCost& one : cost.experiments) {
    if (!planner.ExplainUnplanned(one.experiment).empty()) continue;
    Print("{}",
          DescribeProgram(study, one, planner.PlanExperiment(one.experiment, centre, 0).program));
  }
  const Backend& backend = *study.backend.backend;
  const Availability& availability = planner.availability();
  const std::string how = backend.Describe();
  Print("  backend: {} {}{}\n  optimizer: {}\n", backend.name(),
        availability.available ? availability.version : "(absent)",
        how.empty() ? "" : " (" + how + ")", study.optimizer->Describe());
  PrintFidelities(study, planner);
  for (const auto& one : study.approximations.Describe(study.powder.sizes)) {
    Print("  approximation of {}: {}\n    {}\n", one.part, one.name, one.text);
  }
  PrintConfirmations(study);
  Print("\n# scaling '{}': {}\n", study.scaling->name(), study.scaling->Describe());
  const std::vector<ScalingTable> tables = planner.ScalingTables(ExperimentsOf(cost), centre);
  for (const ScalingTable& table : tables) {
    Print("  {} at {}\n{}", table.experiment, DescribePoint(study.space.parameters, centre),
          GroupTable(table, OutputIsTerminal()));
  }
  PrintCost(study, cost);
  Print("\n# one run of each experiment by scaling mode{}\n{}", kModeTableRemark,
        ModeTable(CompareModes(study, ExperimentsOf(cost))));
  for (const std::string& warning : planner.Warnings(evaluate_also))
    Print("warning: {}\n", warning);
  for (const std::string& warning : planner.ConfirmationWarnings()) Print("warning: {}\n", warning);
  if (blocked.empty()) {
    Print("\nready to run\n");
  } else {
    Say("powdercal: {}\n", blocked);
  }
}

json CostToJson(const Study& study, const Planner::Cost& cost) {
  const auto list = [&](const std::vector<Planner::ExperimentCost>& costs) {
    json experiments = json::array();
    for (const Planner::ExperimentCost& one : costs) {
      experiments.push_back({{"experiment", study.experiments[one.experiment].name()},
                             {"runs", one.runs},
                             {"particles", one.particles},
                             {"steps", one.steps},
                             {"seconds", one.seconds}});
    }
    return experiments;
  };
  json confirmations = json::array();
  for (const Planner::ConfirmationCost& one : cost.confirmations) {
    confirmations.push_back({{"backend", one.backend}, {"experiments", list(one.experiments)}});
  }
  return {{"runs", cost.runs},
          {"steps_per_run", cost.steps_per_run},
          {"seconds_per_run", cost.seconds_per_run},
          {"seconds", cost.seconds},
          {"experiments", list(cost.experiments)},
          {"confirmations", std::move(confirmations)},
          {"approximation", list(cost.approximation)}};
}

void PrintJson(Study& study, const Planner& planner, const std::vector<std::size_t>& evaluate_also,
               const std::string& blocked) {
  const Planner::Cost cost = planner.EstimateCost(evaluate_also);
  json programs = json::array();
  for (const Planner::ExperimentCost& one : cost.experiments) {
    if (!planner.ExplainUnplanned(one.experiment).empty()) continue;
    const PlannedRun run = planner.PlanExperiment(one.experiment, planner.Centre(), 0);
    programs.push_back({{"experiment", run.program.experiment},
                        {"calibrated", study.experiments[one.experiment].calibrate},
                        {"fidelity", ToString(run.program.fidelity)},
                        {"particles", one.particles},
                        {"time_step", run.program.time_step},
                        {"law", run.program.law.ToString()},
                        {"hash", run.program_hash}});
  }
  json confirmations = json::array();
  for (const auto& other : study.backend.confirm_with) {
    const Planner elsewhere(study, *other);
    confirmations.push_back(
        {{"backend", other->name()},
         {"available", elsewhere.availability().available},
         {"version", elsewhere.availability().version},
         {"problem", elsewhere.availability().available ? elsewhere.ExplainUnsupported()
                                                        : elsewhere.availability().why_not}});
  }
  json lower_fidelities = json::array();
  const StudyFidelities fidelities(study, planner);
  for (const FidelityLevel& level : fidelities.levels()) {
    if (level.fidelity == 1) continue;
    lower_fidelities.push_back(
        {{"fidelity", FidelityNameAt(study, level.fidelity)}, {"cost", level.cost}});
  }
  const json groups = PiGroupsToJson(planner.ScalingTables(ExperimentsOf(cost), planner.Centre()));
  const Availability& availability = planner.availability();
  const json document = {
      {"schema", 1},
      {"study", study.name},
      {"fingerprint", study.Fingerprint()},
      {"resolved", study.ToYaml()},
      {"ready", blocked.empty()},
      {"problem", blocked},
      {"warnings", Concatenated(planner.Warnings(evaluate_also), planner.ConfirmationWarnings())},
      {"backend",
       {{"name", study.backend.backend->name()},
        {"available", availability.available},
        {"version", availability.version},
        {"description", study.backend.backend->Describe()},
        {"simulates", study.backend.backend->simulates()}}},
      {"approximations", ApproximationsToJson(study.approximations.Describe(study.powder.sizes))},
      {"confirmations", confirmations},
      {"programs", programs},
      {"lower_fidelities", lower_fidelities},
      {"pi_groups", groups},
      {"cost", CostToJson(study, cost)},
      {"modes", ModesToJson(CompareModes(study, ExperimentsOf(cost)))}};
  Print("{}\n", document.dump(2));
}

}  // namespace

void AddCheck(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand(
      "check", "Print the resolved study, the plan, the Pi groups and the cost; start nothing.");
  struct Options {
    StudyOptions study;
    std::string folder;
    std::vector<std::string> evaluate_also;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  options->study.Declare(*command);
  command->add_option("--out", options->folder, "run folder that `run` would use")
      ->type_name("FOLDER")
      ->check(NotEmpty);
  DeclareEvaluateAlso(*command, options->evaluate_also);
  command->add_flag("--json", options->json, "for machines");
  command->callback([options, &status] {
    Study study = options->study.Load();
    const Planner planner(study);
    const std::filesystem::path folder = options->folder.empty()
                                             ? options->study.DefaultFolder(study)
                                             : std::filesystem::path(options->folder);
    const std::vector<std::size_t> also = study.TransferExperiments(options->evaluate_also);
    const std::string blocked = ExplainBlocked(study, planner, also, folder);
    if (options->json) {
      PrintJson(study, planner, also, blocked);
    } else {
      PrintText(study, planner, also, blocked);
    }
    status = blocked.empty() ? kDone : kBadInput;
  });
}

}  // namespace powdercal::cli

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/output.h"
#include "cli/text.h"
#include "core/quantity.h"
#include "reports/results_json.h"
#include "reports/text.h"
#include "studies/planner.h"
#include "studies/run_directory.h"

namespace powdercal::cli {
namespace {

using nlohmann::json;

// What would stop `run`, or "".
std::string ExplainBlocked(Study& study, const Planner& planner,
                           const std::filesystem::path& folder) {
  const Availability& availability = planner.availability();
  if (!availability.available) {
    return fmt::format("backend '{}' is not available: {}", study.backend.backend->name(),
                       availability.why_not);
  }
  if (const std::string reason = planner.ExplainUnsupported(); !reason.empty()) return reason;
  return RunDirectory::Explain(folder, study.Fingerprint());
}

std::string DescribeProgram(const Program& program) {
  const Materials& m = program.materials;
  const double rayleigh = RayleighTime(program.particles.sizes.Quantile(0) / 2, m.density,
                                       m.young_modulus, m.poisson_ratio);
  return fmt::format(
      "  {}: {} particles, cell {} wide, E = {}, time step {} ({:.2g} of the Rayleigh time)\n"
      "    law: {}\n",
      program.experiment, program.particles.count, HumanQuantity(program.domain.Lengths()[0], "m"),
      HumanQuantity(m.young_modulus, "Pa"), HumanQuantity(program.time_step, "s", 3),
      program.time_step / rayleigh, program.law.ToString());
}

void PrintText(Study& study, const Planner& planner, const std::string& blocked) {
  Print("# resolved study\n{}\n# plan\n", study.ToYaml());
  const std::vector<double> centre = planner.Centre();
  for (const PlannedRun& run : planner.Plan(centre, 0)) Print("{}", DescribeProgram(run.program));
  const Backend& backend = *study.backend.backend;
  const Availability& availability = planner.availability();
  const std::string how = backend.Describe();
  Print("  backend: {} {}{}\n  optimizer: {}\n", backend.name(),
        availability.available ? availability.version : "(absent)",
        how.empty() ? "" : " (" + how + ")", study.optimizer->Describe());
  Print("\n# scaling '{}': {}\n", study.scaling->name(), study.scaling->Describe());
  if (study.scaling->ExplainUnsupported(planner.Laboratory(0)).empty()) {
    for (const ScalingTable& table : planner.ScalingTables(centre)) {
      Print("  {} at {}\n{}", table.experiment, DescribePoint(study.space.parameters, centre),
            GroupTable(table));
    }
  }
  const Planner::Cost cost = planner.EstimateCost();
  Print("\n# cost (right within a factor of about 2)\n  {} runs", cost.runs);
  if (backend.simulates()) {
    Print(", {:.2g} steps and {} each, {} in all with {} at a time\n", cost.steps_per_run,
          DurationText(cost.seconds_per_run), DurationText(cost.seconds), study.parallel());
  } else {
    Print("; {}\n", kNoSimulation);
  }
  for (const std::string& warning : planner.Warnings()) Print("warning: {}\n", warning);
  if (blocked.empty()) {
    Print("\nready to run\n");
  } else {
    Say("powdercal: {}\n", blocked);
  }
}

void PrintJson(Study& study, const Planner& planner, const std::string& blocked) {
  const Planner::Cost cost = planner.EstimateCost();
  json programs = json::array();
  for (const PlannedRun& run : planner.Plan(planner.Centre(), 0)) {
    programs.push_back({{"experiment", run.program.experiment},
                        {"particles", run.program.particles.count},
                        {"time_step", run.program.time_step},
                        {"law", run.program.law.ToString()},
                        {"hash", run.program_hash}});
  }
  json groups = json::array();
  if (study.scaling->ExplainUnsupported(planner.Laboratory(0)).empty()) {
    groups = PiGroupsToJson(planner.ScalingTables(planner.Centre()));
  }
  const Availability& availability = planner.availability();
  const json document = {{"schema", 1},
                         {"study", study.name},
                         {"fingerprint", study.Fingerprint()},
                         {"resolved", study.ToYaml()},
                         {"ready", blocked.empty()},
                         {"problem", blocked},
                         {"warnings", planner.Warnings()},
                         {"backend",
                          {{"name", study.backend.backend->name()},
                           {"available", availability.available},
                           {"version", availability.version},
                           {"description", study.backend.backend->Describe()},
                           {"simulates", study.backend.backend->simulates()}}},
                         {"programs", programs},
                         {"pi_groups", groups},
                         {"cost",
                          {{"runs", cost.runs},
                           {"steps_per_run", cost.steps_per_run},
                           {"seconds_per_run", cost.seconds_per_run},
                           {"seconds", cost.seconds}}}};
  Print("{}\n", document.dump(2));
}

}  // namespace

void AddCheck(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand(
      "check", "Print the resolved study, the plan, the Pi groups and the cost; start nothing.");
  struct Options {
    StudyOptions study;
    std::string folder;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  options->study.Declare(*command);
  command->add_option("--out", options->folder, "run folder that `run` would use")
      ->type_name("FOLDER")
      ->check(NotEmpty);
  command->add_flag("--json", options->json, "for machines");
  command->callback([options, &status] {
    Study study = options->study.Load();
    const Planner planner(study);
    const std::filesystem::path folder = options->folder.empty()
                                             ? options->study.DefaultFolder(study)
                                             : std::filesystem::path(options->folder);
    const std::string blocked = ExplainBlocked(study, planner, folder);
    if (options->json) {
      PrintJson(study, planner, blocked);
    } else {
      PrintText(study, planner, blocked);
    }
    status = blocked.empty() ? kDone : kBadInput;
  });
}

}  // namespace powdercal::cli

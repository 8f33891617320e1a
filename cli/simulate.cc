#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "backends/registry.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "cli/parameters.h"
#include "cli/signals.h"
#include "cli/text.h"
#include "core/quantity.h"
#include "reports/results_json.h"
#include "studies/executor.h"
#include "studies/planner.h"

namespace powdercal::cli {
namespace {

using nlohmann::json;

struct Options {
  StudyOptions study;
  std::vector<std::string> parameters;
  std::vector<std::string> experiment_names;
  std::vector<std::size_t> experiments;  // of the study; those named, or all
  std::optional<std::int64_t> particle_seed;
  int replicates = 1;
  std::string folder;
  std::string snapshots;
  bool json = false;
};

// [s]; 0 without the option.
double ReadSnapshotInterval(const std::string& text) {
  if (text.empty()) return 0;
  const InputError::Details details{
      .location = {"command line"}, .key = "--snapshots", .value = text};
  double interval = 0;
  try {
    interval = ParseQuantity(text, "s");
  } catch (const InputError& error) {
    throw InputError(error.problem(), details);
  }
  if (interval <= 0) throw InputError("must be above 0 s", details);
  return interval;
}

void RequireSnapshots(const Backend& backend) {
  if (backend.writes_snapshots()) return;
  std::vector<std::string> able;
  for (const std::string& name : BackendNames()) {
    if (MakeBackend(name)->writes_snapshots()) able.push_back(name);
  }
  throw InputError(
      fmt::format("backend '{}' writes no snapshots; {}", backend.name(),
                  able.empty() ? "so far, no backend does"
                               : fmt::format("use --backend {}", fmt::join(able, " or "))),
      {.location = {"command line"}, .key = "--snapshots"});
}

json ToJson(const LedgerRun& run) {
  json responses = json::object();
  for (const auto& [name, response] : run.measurement.responses) responses[name] = response.value;
  json diagnostics = run.measurement.diagnostics;
  diagnostics["steps"] = run.diagnostics.steps;
  diagnostics["time_step"] = run.diagnostics.time_step;
  diagnostics["kinetic_energy_ratio"] = run.diagnostics.kinetic_energy_ratio;
  return {{"experiment", run.experiment},
          {"seed", run.seed},
          {"outcome", ToString(run.outcome.reason)},
          {"message", run.outcome.message},
          {"responses", responses},
          {"diagnostics", diagnostics},
          {"figures", run.diagnostics.figures},
          {"law", run.diagnostics.law},
          {"program_hash", run.program_hash},
          {"backend", run.backend},
          {"backend_version", run.backend_version},
          {"wall_s", run.diagnostics.wall_seconds}};
}

void PrintText(const LedgerRun& run) {
  Print("{}, particle seed {}: {}{}{} ({} {}, {:.2f} s)\n", run.experiment, run.seed,
        ToString(run.outcome.reason), run.outcome.message.empty() ? "" : ", ", run.outcome.message,
        run.backend, run.backend_version, run.diagnostics.wall_seconds);
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, response] : run.measurement.responses) {
    rows.push_back({name, fmt::format("{:.6g}", response.value)});
  }
  if (!rows.empty()) Print(" responses (SI)\n{}", AlignedTable(rows));
  rows.clear();
  for (const auto& [name, value] : run.measurement.diagnostics) {
    rows.push_back({name, fmt::format("{:.6g}", value)});
  }
  rows.push_back({"steps", fmt::format("{}", run.diagnostics.steps)});
  rows.push_back({"time_step", fmt::format("{:.4g}", run.diagnostics.time_step)});
  rows.push_back(
      {"kinetic_energy_ratio", fmt::format("{:.3g}", run.diagnostics.kinetic_energy_ratio)});
  for (const auto& [name, value] : run.diagnostics.figures) {
    rows.push_back({name, fmt::format("{:.6g}", value)});
  }
  rows.push_back({"law", run.diagnostics.law});
  Print(" diagnostics (SI)\n{}", AlignedTable(rows));
}

std::filesystem::path MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || access(folder.c_str(), W_OK | X_OK) != 0) {
    throw InputError(
        fmt::format("cannot write the folder: {}", error ? error.message() : std::strerror(errno)),
        {.location = {folder.string()}});
  }
  return folder;
}

// Hands in all runs, each with a folder of its own in that of `common`. Returns these, by ticket.
std::vector<std::filesystem::path> SubmitRuns(const Options& options, const Planner& planner,
                                              const std::vector<double>& values,
                                              const RunContext& common, Executor& executor) {
  std::vector<std::filesystem::path> folders;
  for (int replicate = 0; replicate < options.replicates; ++replicate) {
    std::optional<std::uint64_t> seed;
    if (options.particle_seed) {
      seed = static_cast<std::uint64_t>(*options.particle_seed + replicate);
    }
    for (const std::size_t experiment : options.experiments) {
      const PlannedRun run = planner.PlanExperiment(experiment, values, replicate, seed);
      RunContext context = common;
      context.work_folder /= fmt::format("{}-{}", run.program.experiment, replicate);
      if (const auto& limit = planner.study().budget.run_timeout) {
        context.time_limit = std::chrono::duration<double>(*limit);
      }
      const auto ticket = static_cast<std::int64_t>(folders.size());
      folders.push_back(context.work_folder);
      executor.Submit(ticket, [&planner, run, context](std::stop_token stop) mutable {
        context.stop = std::move(stop);
        return planner.Execute(run, context);
      });
    }
  }
  return folders;
}

// By ticket. A first signal ends the runs, which are still collected.
std::map<std::int64_t, LedgerRun> CollectRuns(std::size_t count, const SignalStop& signals,
                                              Executor& executor) {
  std::map<std::int64_t, LedgerRun> runs;
  while (runs.size() < count) {
    if (signals.token().stop_requested()) executor.Cancel();
    auto finished = executor.Wait(std::chrono::milliseconds(200));
    if (finished) runs.emplace(finished->ticket, std::move(finished->run));
  }
  return runs;
}

int Simulate(Options options) {
  const double interval = ReadSnapshotInterval(options.snapshots);
  const Study study = options.study.Load();
  options.experiments = ReadExperiments(study, options.experiment_names);
  if (interval > 0) RequireSnapshots(*study.backend.backend);
  const Planner planner(study);
  if (!planner.availability().available) {
    throw InputError(fmt::format("backend '{}' is not available: {}", study.backend.backend->name(),
                                 planner.availability().why_not));
  }
  if (const std::string reason = planner.ExplainUnsupported(options.experiments); !reason.empty()) {
    throw InputError(reason, {.location = {study.file}});
  }
  const std::vector<double> values = ReadParameters(study, options.parameters);
  SignalStop signals;
  const std::filesystem::path folder =
      options.folder.empty() ? MakeTemporaryFolder() : MakeFolder(options.folder);
  const bool keep = !options.folder.empty() || interval > 0;
  LocalExecutor executor(study.parallel());
  const std::vector<std::filesystem::path> folders = SubmitRuns(
      options, planner, values,
      {.work_folder = folder, .keep_files = keep, .snapshot_interval = interval}, executor);
  if (!study.backend.backend->simulates()) Say("{}\n", kNoSimulation);
  const auto approximations = study.approximations.Describe(study.powder.sizes);
  for (const auto& one : approximations) Say("approximation: {}\n", one.text);
  if (interval > 0) {
    for (const auto& work_folder : folders) {
      Say("snapshots: {}\n", (work_folder / kSnapshotFolder).string());
    }
  }
  const auto runs = CollectRuns(folders.size(), signals, executor);
  json list = json::array();
  bool ok = true;
  for (const auto& [ticket, run] : runs) {
    ok = ok && run.outcome.ok();
    if (options.json) {
      list.push_back(ToJson(run));
      if (interval > 0) {
        const auto& work_folder = folders[static_cast<std::size_t>(ticket)];
        list.back()["snapshots"] = (work_folder / kSnapshotFolder).string();
      }
    } else {
      PrintText(run);
    }
  }
  if (options.json) {
    json document = {{"schema", 1},
                     {"study", study.name},
                     {"simulated", study.backend.backend->simulates()},
                     {"approximations", ApproximationsToJson(approximations)},
                     {"runs", list}};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Parameter& parameter = study.space.parameters[i];
      document["parameters"][parameter.name] = ValueToJson(parameter, values[i]);
    }
    Print("{}\n", document.dump(2));
  }
  if (!keep && (ok || !study.backend.backend->simulates())) {
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
  } else {
    Say("files: {}\n", folder.string());
  }
  if (signals.token().stop_requested()) return kInterrupted;
  return ok ? kDone : kFellShort;
}

}  // namespace

void AddSimulate(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand(
      "simulate", "Run the experiments of a study once, at given parameters; no calibration.");
  auto options = std::make_shared<Options>();
  options->study.Declare(*command);
  command
      ->add_option("-p,--parameter", options->parameters,
                   "value of a free parameter by name or symbol, e.g. -p k=47500 -p mu_r=0.5; a "
                   "bare number is in SI")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  command
      ->add_option("--experiment", options->experiment_names,
                   "only this experiment of the study; may be repeated")
      ->type_name("EXPERIMENT")
      ->allow_extra_args(false);
  command
      ->add_option("--particle-seed", options->particle_seed,
                   "seed of the first replicate's particles; the next ones count up")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{std::numeric_limits<std::int32_t>::max()}));
  command->add_option("--replicates", options->replicates, "number of particle seeds")
      ->check(CLI::Range(1, 1000));
  command->add_option("--out", options->folder, "keep the simulator's files in this folder")
      ->type_name("FOLDER")
      ->check(NotEmpty);
  command
      ->add_option("--snapshots", options->snapshots,
                   "write the particles and walls for ParaView, after each such simulated time, "
                   "e.g. '0.1 ms', and keep the simulator's files")
      ->type_name("INTERVAL")
      ->check(NotEmpty);
  command->add_flag("--json", options->json, "for machines");
  command->callback([options, &status] { status = Simulate(*options); });
}

}  // namespace powdercal::cli

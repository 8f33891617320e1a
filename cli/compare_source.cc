#include "cli/compare_source.h"

#include <fmt/format.h>

#include "cli/output.h"
#include "cli/progress.h"
#include "optimizers/optimizer_text.h"
#include "studies/runner.h"

namespace powdercal::cli {
namespace {

namespace fs = std::filesystem;

// Scatter between particle seeds cannot be known from one.
constexpr int kFewestReplicates = 2;

Study DesignStudy(Study& study, int points) {
  Study design = Study::Parse(study.ToYaml(), study.file, study.base_folder);
  design.optimizer = ParseOptimizer(fmt::format("sobol:points={}", points), design.space, nullptr);
  design.budget.evaluations = points;
  design.budget.wall_time.reset();
  design.backend.replicates = std::max(study.backend.replicates, kFewestReplicates);
  design.backend.confirm_replicates = design.backend.replicates;
  design.backend.confirm_with.clear();
  for (StudyExperiment& entry : design.experiments) {
    // A study ends when its tolerances are reached; a design goes on.
    for (ObservedResponse& observed : entry.observed) observed.tolerance.reset();
  }
  return design;
}

Ledger OpenLedger(const fs::path& folder) {
  return Ledger(folder / "ledger.sqlite", Ledger::Mode::read_only);
}

bool IsFinishedRun(Study& study, const fs::path& folder) {
  if (!fs::exists(folder / "ledger.sqlite") || !fs::exists(folder / "study.yaml")) return false;
  try {
    Study other = LoadFromFolder(folder);
    return OpenLedger(folder).GetMeta("state").value_or("") == "finished" &&
           comparison::ExplainOtherProblem(study, other).empty();
  } catch (const InputError&) {
    return false;  // of another version of the program, or damaged
  }
}

}  // namespace

EmulatorData ReadRuns(Study& study, const std::vector<std::string>& folders) {
  EmulatorData data;
  for (const std::string& folder : folders) {
    Study other = LoadFromFolder(folder);
    const std::string reason = comparison::ExplainOtherProblem(study, other);
    if (!reason.empty()) {
      throw InputError(reason, {.location = {folder}, .key = "--emulate"});
    }
    comparison::Merge(comparison::ReadKnownPoints(study, OpenLedger(folder)), &data.points);
  }
  data.text = JoinNames(folders);
  if (data.points.empty()) {
    throw InputError("there is no simulation to fit an emulator to",
                     {.location = {data.text}, .key = "--emulate"});
  }
  return data;
}

fs::path FindFinishedRun(Study& study, const fs::path& folder) {
  fs::path newest;
  fs::file_time_type time;
  const std::string name = folder.filename().string();
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder.parent_path(), error)) {
    const std::string other = entry.path().filename().string();
    if (other != name && !other.starts_with(name + "-seed")) continue;
    if (!IsFinishedRun(study, entry.path())) continue;
    const auto written = fs::last_write_time(entry.path() / "ledger.sqlite", error);
    if (!newest.empty() && written <= time) continue;
    newest = entry.path();
    time = written;
  }
  return newest;
}

EmulatorData SimulateDesign(Study& study, int points, const fs::path& folder,
                            std::stop_token stop) {
  Study design = DesignStudy(study, points);
  StudyRunner::End end;
  {
    ProgressDisplay display(design);
    StudyRunner runner(design, {.folder = folder, .stop = std::move(stop), .listener = &display});
    display.Begin(fmt::format(
        "no finished run to fit an emulator to: simulating a Sobol' design of {} points with {} "
        "particle seeds each, in {}",
        points, design.backend.replicates, folder.string()));
    end = runner.Run();
  }
  EmulatorData data{.points = comparison::ReadKnownPoints(study, OpenLedger(folder)),
                    .text = fmt::format("a Sobol' design, {}", folder.string()),
                    .interrupted = end == StudyRunner::End::interrupted};
  return data;
}

}  // namespace powdercal::cli

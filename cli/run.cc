#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/output.h"
#include "cli/progress.h"
#include "cli/signals.h"
#include "cli/text.h"
#include "core/version.h"
#include "reports/results_json.h"
#include "reports/write.h"
#include "studies/runner.h"

namespace powdercal::cli {

void PublishResults(const StudyResults& results, const std::filesystem::path& folder, bool json) {
  WriteReports(results, folder);
  if (json) {
    Print("{}\n", ResultsToJson(results).dump(2));
  } else {
    Print("{}report: {}\n", Summary(results), (folder / "report.html").string());
  }
}

int RunStudy(Study& study, const std::filesystem::path& folder, bool json) {
  SignalStop signals;
  const Availability availability = study.backend.backend->availability();
  StudyRunner::End end;
  {
    ProgressDisplay display(study);
    StudyRunner runner(study, {.folder = folder, .stop = signals.token(), .listener = &display});
    display.Begin(fmt::format("powdercal {}: {} with {} on {} {}, {} at a time, in {}", kVersion,
                              study.name, study.optimizer->name(), study.backend.backend->name(),
                              availability.version, study.parallel(), folder.string()));
    if (!study.backend.backend->simulates()) Say("{}\n", kNoSimulation);
    for (const std::string& warning : Planner(study).Warnings()) Say("warning: {}\n", warning);
    end = runner.Run();
  }
  // Opened for writing, so that SQLite folds its side files into the ledger when it closes.
  const StudyResults results =
      CollectResults(study, Ledger(folder / "ledger.sqlite", Ledger::Mode::read_write));
  PublishResults(results, folder, json);
  if (end == StudyRunner::End::interrupted) return kInterrupted;
  return results.best ? kDone : kFellShort;
}

void AddRun(CLI::App& program, int& status) {
  CLI::App* command =
      program.add_subcommand("run", "Calibrate a study. Run it again to resume where it stopped.");
  struct Options {
    StudyOptions study;
    std::string folder;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  options->study.Declare(*command);
  command->add_option("--out", options->folder, "run folder (default: runs/NAME)")
      ->type_name("FOLDER")
      ->check(NotEmpty);
  command->add_flag("--json", options->json, "print results.json to standard output");
  command->callback([options, &status] {
    Study study = options->study.Load();
    const std::filesystem::path folder = options->folder.empty()
                                             ? options->study.DefaultFolder(study)
                                             : std::filesystem::path(options->folder);
    status = RunStudy(study, folder, options->json);
  });
}

}  // namespace powdercal::cli

#include <fmt/format.h>

#include <algorithm>
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

namespace {

// Whether each of these experiments gave some value at the best point.
bool AllTransferred(const Study& study, const std::vector<std::size_t>& experiments,
                    const StudyResults& results) {
  return std::all_of(experiments.begin(), experiments.end(), [&](std::size_t i) {
    const auto& responses = results.transfer.responses;
    return std::any_of(responses.begin(), responses.end(), [&](const ResponseResult& response) {
      return response.simulated && response.name.starts_with(study.experiments[i].name() + ".");
    });
  });
}

}  // namespace

void PublishResults(const StudyResults& results, const std::filesystem::path& folder, bool json) {
  WriteReports(results, folder);
  if (json) {
    Print("{}\n", ResultsToJson(results).dump(2));
  } else {
    Print("{}report: {}\n", Summary(results), (folder / "report.html").string());
  }
}

void DeclareEvaluateAlso(CLI::App& command, std::vector<std::string>& names) {
  command
      .add_option("--evaluate-also", names,
                  "when the study has ended, evaluate its best point on these experiments, which "
                  "the study lists but does not calibrate")
      ->type_name("EXPERIMENT…")
      ->check(NotEmpty);
}

int RunStudy(Study& study, const std::filesystem::path& folder,
             const std::vector<std::string>& evaluate_also, bool json) {
  const std::vector<std::size_t> transfer = study.TransferExperiments(evaluate_also);
  SignalStop signals;
  const Availability availability = study.backend.backend->availability();
  StudyRunner::End end;
  {
    ProgressDisplay display(study);
    StudyRunner runner(study, {.folder = folder,
                               .stop = signals.token(),
                               .listener = &display,
                               .evaluate_also = transfer});
    display.Begin(fmt::format("powdercal {}: {} with {} on {} {}, {} at a time, in {}", kVersion,
                              study.name, study.optimizer->name(), study.backend.backend->name(),
                              availability.version, study.parallel(), folder.string()));
    if (!study.backend.backend->simulates()) Say("{}\n", kNoSimulation);
    for (const auto& approximation : study.approximations.Describe(study.powder.sizes)) {
      Say("approximation: {}\n", approximation.text);
    }
    const Planner planner(study);
    for (const std::string& warning : planner.Warnings(transfer)) Say("warning: {}\n", warning);
    for (const std::string& warning : planner.ConfirmationWarnings()) {
      Say("warning: {}\n", warning);
    }
    end = runner.Run();
  }
  // Opened for writing, so that SQLite folds its side files into the ledger when it closes.
  const StudyResults results =
      CollectResults(study, Ledger(folder / "ledger.sqlite", Ledger::Mode::read_write));
  PublishResults(results, folder, json);
  if (end == StudyRunner::End::interrupted) return kInterrupted;
  return results.best && AllTransferred(study, transfer, results) ? kDone : kFellShort;
}

void AddRun(CLI::App& program, int& status) {
  CLI::App* command =
      program.add_subcommand("run", "Calibrate a study. Run it again to resume where it stopped.");
  struct Options {
    StudyOptions study;
    std::string folder;
    std::vector<std::string> evaluate_also;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  options->study.Declare(*command);
  command->add_option("--out", options->folder, "run folder (default: runs/NAME)")
      ->type_name("FOLDER")
      ->check(NotEmpty);
  DeclareEvaluateAlso(*command, options->evaluate_also);
  command->add_flag("--json", options->json, "print results.json to standard output");
  command->callback([options, &status] {
    Study study = options->study.Load();
    const std::filesystem::path folder = options->folder.empty()
                                             ? options->study.DefaultFolder(study)
                                             : std::filesystem::path(options->folder);
    status = RunStudy(study, folder, options->evaluate_also, options->json);
  });
}

}  // namespace powdercal::cli

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/output.h"
#include "cli/text.h"
#include "core/files.h"
#include "studies/runner.h"

namespace powdercal::cli {

Study LoadFromFolder(const std::filesystem::path& folder) {
  if (!std::filesystem::exists(folder / "ledger.sqlite") ||
      !std::filesystem::exists(folder / "study.yaml")) {
    throw InputError("not a run folder: it has no study.yaml and ledger.sqlite",
                     {.location = {folder.string()}});
  }
  const std::filesystem::path file = folder / "study.yaml";
  const Ledger ledger(folder / "ledger.sqlite", Ledger::Mode::read_only);
  return Study::Parse(ReadFile(file), file.string(), ledger.GetMeta("base_folder").value_or(""));
}

void AddResume(CLI::App& program, int& status) {
  CLI::App* command =
      program.add_subcommand("resume", "Go on with the study of a run folder, as it was started.");
  struct Options {
    std::string folder;
    std::vector<std::string> evaluate_also;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  command->add_option("folder", options->folder, "run folder")->required()->type_name("FOLDER");
  DeclareEvaluateAlso(*command, options->evaluate_also);
  command->add_flag("--json", options->json, "print results.json to standard output");
  command->callback([options, &status] {
    Study study = LoadFromFolder(options->folder);
    status = RunStudy(study, options->folder, options->evaluate_also, options->json);
  });
}

void AddReport(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand(
      "report",
      "Write results.json, report.html and material_card.yaml from a run folder's ledger.");
  struct Options {
    std::string folder;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  command->add_option("folder", options->folder, "run folder, also of a study that still runs")
      ->required()
      ->type_name("FOLDER");
  command->add_flag("--json", options->json, "print results.json to standard output");
  command->callback([options, &status] {
    const std::filesystem::path folder = options->folder;
    Study study = LoadFromFolder(folder);
    const StudyResults results =
        CollectResults(study, Ledger(folder / "ledger.sqlite", Ledger::Mode::read_only));
    PublishResults(results, folder, options->json);
    status = kDone;
  });
}

}  // namespace powdercal::cli

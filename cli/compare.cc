#include "cli/commands.h"
#include "cli/compare_surrogates.h"

namespace powdercal::cli {

void AddCompare(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand(
      "compare", "Compare regressions on known evaluations, and say which predicts best.");
  struct Options {
    CompareSurrogatesCommand surrogates;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  options->surrogates.Declare(*command);
  command->get_option("--surrogates")->required();
  command->add_option("--seed", options->surrogates.options.seed, "of the random partitions")
      ->capture_default_str();
  command
      ->add_option("--out", options->surrogates.folder,
                   "folder for the plots (default: the run folder, or runs/NAME-surrogates)")
      ->type_name("FOLDER")
      ->check(NotEmpty);
  command->add_flag("--json", options->json, "for machines");
  command->callback(
      [options, &status] { status = CompareSurrogates(options->surrogates, options->json); });
}

}  // namespace powdercal::cli

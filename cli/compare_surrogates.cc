#include "cli/compare_surrogates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/output.h"
#include "cli/text.h"
#include "core/files.h"
#include "reports/results_json.h"
#include "reports/surrogates_page.h"
#include "studies/runner.h"

namespace powdercal::cli {
namespace {

namespace fs = std::filesystem;

KnownEvaluations ReadRun(const CompareSurrogatesCommand& command) {
  const fs::path folder = command.source;
  Study study = LoadFromFolder(folder);
  const StudyResults results =
      CollectResults(study, Ledger(folder / "ledger.sqlite", Ledger::Mode::read_only));
  return EvaluationsOf(study, results, command.responses, command.logarithmic);
}

KnownEvaluations ReadSource(const CompareSurrogatesCommand& command) {
  if (fs::is_directory(command.source)) return ReadRun(command);
  return EvaluationsOf(Table::ReadCsv(command.source), command.responses, command.logarithmic);
}

fs::path FolderOf(const CompareSurrogatesCommand& command) {
  if (!command.folder.empty()) return command.folder;
  if (fs::is_directory(command.source)) return command.source;
  return fs::path("runs") / (fs::path(command.source).stem().string() + "-surrogates");
}

std::string WithUnit(const std::string& name, const std::string& unit) {
  return unit == "1" ? name : fmt::format("{} [{}]", name, unit);
}

std::string Partitions(const RepeatedAccuracy& accuracy) {
  if (accuracy.r2.empty()) return "-";
  const auto [low, high] = std::minmax_element(accuracy.r2.begin(), accuracy.r2.end());
  return fmt::format("{:.3f} ({:.2f} … {:.2f})", accuracy.median_r2(), *low, *high);
}

void PrintComparison(const KnownEvaluations& known, const ComparisonOptions& options,
                     const ResponseComparison& comparison) {
  std::vector<std::string> inputs;
  for (const Parameter& parameter : known.space.parameters) {
    inputs.push_back(WithUnit(parameter.name, parameter.unit) +
                     (parameter.logarithmic ? " (log)" : ""));
  }
  Print("\n# {} over {}, {} points\n", WithUnit(comparison.response, comparison.unit),
        JoinNames(inputs), comparison.values.size());
  std::vector<std::vector<std::string>> rows = {
      {"surrogate", "R2 leave-one-out", "RMSE",
       fmt::format("R2 {} folds x {}", comparison.folds, options.repeats),
       fmt::format("R2 hold-out {:g} x {}", options.hold_out, options.repeats), "fitted to all"}};
  for (const SurrogateAccuracy& one : comparison.surrogates) {
    if (one.why_not.empty()) {
      rows.push_back({one.name, fmt::format("{:.3f}", one.leave_one_out.r2),
                      fmt::format("{:.3g}", one.leave_one_out.rmse), Partitions(one.k_fold),
                      Partitions(one.hold_out), one.description});
    } else {
      rows.push_back({one.name, "-", "-", "-", "-", one.why_not});
    }
  }
  Print("{}", AlignedTable(rows));
  if (!comparison.best.empty()) {
    Print("best: {} (highest R2 by leave-one-out; of those within {} the simplest)\n",
          comparison.best, kEqualR2);
  }
}

}  // namespace

void CompareSurrogatesCommand::Declare(CLI::App& command) {
  command
      .add_option("--surrogates", source,
                  "compare regressions on the evaluations of a run folder or a CSV file")
      ->type_name("RUN|CSV")
      ->check(NotEmpty);
  command
      .add_option("--response", responses,
                  "with --surrogates: response, as experiment.response or by its column (default: "
                  "all of a run, the last column of a CSV); may be repeated")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command
      .add_option("--log", logarithmic,
                  "with --surrogates: an input on a log scale; may be repeated")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command.add_option("--folds", options.folds, "with --surrogates: folds of cross-validation")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  command
      .add_option("--repeats", options.repeats,
                  "with --surrogates: random partitions for k folds and for hold-out")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command.add_option("--hold-out", options.hold_out, "with --surrogates: share held out")
      ->check(CLI::Range(0.01, 0.9))
      ->capture_default_str();
}

int CompareSurrogates(const CompareSurrogatesCommand& command, bool json) {
  const KnownEvaluations known = ReadSource(command);
  for (const std::string& note : known.notes) Say("note: {}\n", note);
  std::vector<ResponseComparison> comparisons;
  for (const KnownEvaluations::Response& response : known.responses) {
    comparisons.push_back(CompareOn(response, command.options, [&](const std::string& surrogate) {
      Say("  {}: {}\n", response.name, surrogate);
    }));
    if (!json) PrintComparison(known, command.options, comparisons.back());
  }
  const nlohmann::json document =
      SurrogatesToJson(command.source, known, command.options, comparisons);
  if (json) Print("{}", JsonText(document));
  const fs::path folder = FolderOf(command);
  fs::create_directories(folder);
  WriteFileAtomically(folder / "surrogates.json", JsonText(document));
  WriteFileAtomically(folder / "surrogates.html", SurrogatesPage(document));
  Say("plots: {}\n", (folder / "surrogates.html").string());
  const bool any = std::any_of(comparisons.begin(), comparisons.end(),
                               [](const ResponseComparison& one) { return !one.best.empty(); });
  return any ? kDone : kFellShort;
}

}  // namespace powdercal::cli

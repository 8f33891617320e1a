#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "studies/surrogate_comparison.h"

namespace powdercal::cli {

/// `powdercal compare --surrogates RUN|CSV`.
struct CompareSurrogatesCommand {
  std::string source;                    ///< run folder or CSV file; "": not asked for
  std::vector<std::string> responses;    ///< names; empty: all of a run, the last column of a CSV
  std::vector<std::string> logarithmic;  ///< names of inputs
  ComparisonOptions options;
  std::string
      folder;  ///< for surrogates.json and .html; "": the run folder, or runs/NAME-surrogates

  /// Declares --surrogates and the options that only it has, all but --out, --seed and --json.
  void Declare(CLI::App& command);
};

/// Compares all surrogates on known evaluations, prints a table for each response (with `json` the
/// document), and writes both with plots into the folder. Returns an ExitStatus: kFellShort where
/// no surrogate has an R² on any response. Throws InputError.
int CompareSurrogates(const CompareSurrogatesCommand& command, bool json);

}  // namespace powdercal::cli

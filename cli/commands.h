#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "studies/results.h"
#include "studies/study.h"

namespace powdercal::cli {

/// What the program returns to the shell.
enum ExitStatus : int {
  kDone = 0,         ///< done
  kFellShort = 1,    ///< the study failed, or a check fell short
  kBadInput = 2,     ///< nothing was started
  kInterrupted = 3,  ///< stopped before its end; the same command goes on
};

/// Options that change a study from the command line, shared by all commands that read one.
class StudyOptions {
 public:
  /// Declares STUDY, --set and the named shorthands.
  void Declare(CLI::App& command, bool required = true);
  Study Load() const;
  /// STUDY as it was given, or "".
  const std::string& file() const { return file_; }
  /// What a shorthand ("--parallel") was given, or "".
  std::string Given(const std::string& shorthand) const;
  /// The options that were given and change a study, but for those in `except`.
  std::vector<std::string> GivenOptions(const std::vector<std::string>& except) const;
  /// Where `run` keeps the study unless --out says otherwise: runs/NAME, with the seed if it was
  /// given. Throws InputError for a name that is not one of a folder.
  std::filesystem::path DefaultFolder(const Study& study) const;
  /// STUDY and the options that were given, as words of a command line that repeats them.
  std::vector<std::string> Words() const;

 private:
  Overrides Collect() const;

  std::string file_;
  std::vector<std::string> sets_;
  std::map<std::string, std::string> shorthands_;  // key path → value; "" when not given
  bool deterministic_ = false;
};

/// For options: `--out ""` (`--out $FOLDER`, of a variable that is not set) is an error.
std::string NotEmpty(const std::string& value);

/// Each declares a subcommand; `status` receives what it returns once CLI11 has called it.
void AddCheck(CLI::App& program, int& status);
void AddCompare(CLI::App& program, int& status);
void AddList(CLI::App& program, int& status);
void AddReport(CLI::App& program, int& status);
void AddResume(CLI::App& program, int& status);
void AddRun(CLI::App& program, int& status);
void AddScale(CLI::App& program, int& status);
void AddSimulate(CLI::App& program, int& status);
void AddVerify(CLI::App& program, int& status);

/// The resolved study of a run folder. Throws InputError where it is none.
Study LoadFromFolder(const std::filesystem::path& folder);

/// Writes the reports into the run folder, and prints results.json or the summary.
void PublishResults(const StudyResults& results, const std::filesystem::path& folder, bool json);

/// Declares --evaluate-also: experiments that the best point is evaluated on at the end.
void DeclareEvaluateAlso(CLI::App& command, std::vector<std::string>& names);

/// Runs or resumes a study in `folder`, with progress, evaluates its best point on the experiments
/// `evaluate_also`, and writes its reports.
int RunStudy(Study& study, const std::filesystem::path& folder,
             const std::vector<std::string>& evaluate_also, bool json);

}  // namespace powdercal::cli

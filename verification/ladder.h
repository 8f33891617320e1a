#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "studies/planner.h"
#include "verification/finding.h"
#include "verification/laws.h"
#include "verification/runs.h"

namespace powdercal::verification {

/// What is to be compared, and how closely.
struct LadderOptions {
  std::vector<Rung> rungs = {Rung::contact, Rung::packing};  ///< ascending
  int seeds = 10;       ///< particle seeds 1, 2, … of every case from the second rung on, ≥ 2
  double level = 0.05;  ///< of each one-sided test, and of the chi-squared bound of rung 4
  /// Margins of equivalence [SI] that replace those of docs/validation/cross_backend.md, by the
  /// name of the quantity: "void_ratio", "coordination", "consolidation.void_ratio".
  std::map<std::string, double> margins;
};

/// What the ladder is climbed with: a law, and for the upper rungs a study at a point.
struct LadderSubject {
  Subject law;
  const Planner* planner = nullptr;  ///< null: a law alone, which has rungs 1 and 2
  std::vector<double> parameters;    ///< SI, in the order of the study's search space
  std::string parameters_source;     ///< "the command line", "the best point of runs/x"
};

/// A backend as the report names it.
struct ContenderInfo {
  std::string name;
  std::string version;
  std::string description;  ///< how it runs, "" where there is nothing to say
  std::string why_not;      ///< "" when available
};

struct FailedRun {
  Rung rung = Rung::contact;
  std::string name;
  std::string backend;
  std::string reason;  ///< reason code
  std::string message;
};

/// What the ladder found.
struct LadderReport {
  std::string subject;  ///< name of the law or the study
  std::string description;
  std::string law;  ///< canonical
  std::string program_version;
  std::vector<ContenderInfo> contenders;
  LadderOptions options;
  std::map<std::string, double> parameters;    ///< SI, of the upper rungs
  std::map<std::string, std::string> choices;  ///< of the upper rungs, parameters that are names
  std::string parameters_source;
  std::vector<Finding> findings;
  std::vector<FailedRun> failures;
  bool interrupted = false;
  double wall_seconds = 0;

  int Count(Verdict verdict) const;
  /// Whether no finding speaks against any backend.
  bool passed() const;
};

/// Climbs the rungs with every pair of contenders, the earlier one in the list being the reference.
/// Runs that fail are findings; what throws is a mistake of the caller's.
LadderReport ClimbLadder(const LadderSubject& subject, std::span<const Contender> contenders,
                         const LadderOptions& options, const RunOptions& run_options);

/// For a pair that could not be compared in a case: which third backend agrees with both of them
/// there.
void NoteBridges(std::vector<Finding>& findings);

}  // namespace powdercal::verification

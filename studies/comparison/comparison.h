#pragma once

#include <optional>
#include <string>
#include <vector>

#include "studies/comparison/emulator.h"
#include "studies/comparison/field.h"
#include "studies/comparison/measures.h"
#include "studies/comparison/rank_statistics.h"
#include "studies/comparison/record.h"

namespace powdercal::comparison {

/// What stood in for the simulator.
enum class Source { emulator, simulator, table };

/// What was compared, and how.
struct Setting {
  std::string study;
  std::string description;
  std::string program_version;
  Source source = Source::emulator;
  /// emulator: "runs/hastelloy-x-joint"; simulator: "embedded 1"; table: the backend's statement.
  std::string source_text;
  std::string backend;  ///< of the study
  int seeds = 1;
  Rules rules;
  int hold_out_seeds = 0;
  std::string initial_design;           ///< in words
  std::vector<std::string> objectives;  ///< pareto: the experiment behind each; empty: joint
  int targets = 1;                      ///< responses that count
  std::vector<Parameter> parameters;
  std::vector<std::string> command;  ///< lines that repeat the comparison
  bool noisy = true;                 ///< runs scatter
  // Of the emulator, else empty.
  std::vector<Emulator::Quality> emulator;
  int emulator_points = 0;
  int emulator_runs = 0;
  int emulator_failed_runs = 0;
  std::vector<std::string> warnings;
};

/// How one contestant did, over the seeds that all contestants have ended.
struct Standing {
  Contestant contestant;
  Quartiles final_value;          ///< chi², or lost hypervolume, after the budget of evaluations
  Quartiles within_core_seconds;  ///< the same after Comparison::core_seconds
  Quartiles to_level;        ///< evaluations to Comparison::level; ∞ where it was not reached
  int reached = 0;           ///< seeds in which it was
  double mean_rank = kNone;  ///< by final_value
  double mean_rank_by_cost = kNone;  ///< by within_core_seconds
  Quartiles evaluations;             ///< that the contestant made
  Quartiles core_seconds;            ///< that it spent
  Quartiles parallel_efficiency;     ///< busy time of the slots over slots × makespan
  double failed_share = 0;           ///< of the evaluations
  std::vector<Quartiles> hold_out;   ///< chi² of the reported point at each fidelity
  Quartiles fit;                     ///< of the reported point, as it was observed
  double optimizer_seconds = 0;      ///< for each evaluation, mean
  Band by_evaluations;
  Band by_core_seconds;
  std::vector<double> share_of_targets;  ///< after 1, 2, … evaluations
  std::vector<std::string> errors;       ///< of contests that broke off
};

/// A comparison, evaluated.
struct Comparison {
  Setting setting;
  bool interrupted = false;
  std::vector<int> seeds;           ///< that all contestants have ended
  std::vector<Standing> standings;  ///< by mean rank, the best first
  std::vector<Refusal> refused;
  std::vector<ContestRecord> contests;

  bool pareto = false;  ///< values are lost hypervolume, else chi²
  /// Values below it are equal: no response is off by more than a hundredth of its standard
  /// deviation, or a thousandth of the hypervolume is lost.
  double negligible = 0;
  /// Evaluations are counted to this value. joint: every response one standard deviation off, or,
  /// where no contest comes so far, twice the lowest value of any; pareto: a tenth of the
  /// hypervolume lost.
  double level = 0;
  bool level_is_fit = true;     ///< joint: the first of these
  std::vector<double> targets;  ///< levels of the share of targets
  double core_seconds = 0;      ///< the least that a contest with all its evaluations spent
  std::vector<std::string> hold_out_fidelities;

  FriedmanTest friedman;               ///< on final_value
  FriedmanTest friedman_by_cost;       ///< on within_core_seconds
  double critical_difference = kNone;  ///< Nemenyi, level 0.05; NaN with fewer than 2 seeds
};

/// Level of the tests.
inline constexpr double kAlpha = 0.05;

/// Evaluates contests. `records` of unknown contestants or seeds beyond the setting's are ignored.
Comparison Evaluate(Setting setting, const Field& field, std::vector<ContestRecord> records,
                    bool interrupted);

/// The best in words, and what that does not say.
struct Recommendation {
  std::string headline;
  std::vector<std::string> statements;
  std::vector<std::string> limits;
};
Recommendation Recommend(const Comparison& comparison);

}  // namespace powdercal::comparison

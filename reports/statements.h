#pragma once

#include <optional>
#include <string>
#include <vector>

#include "studies/results.h"

namespace powdercal {

/// How far a response is from its observation, and whether that is near enough.
struct Fit {
  std::optional<double> deviation;  ///< simulated − observed, SI; empty: nothing was simulated
  double limit = 0;                 ///< SI, |deviation| below this counts as a fit
  bool has_tolerance = false;  ///< limit is the study's tolerance, else two standard deviations
  bool within = false;
};

/// The limit is the study's tolerance or, where it gives none, two standard deviations of the
/// difference: 2 √(sd² + seed_sd²/replicates).
Fit JudgeFit(const ResponseResult& response);

/// (simulated − observed)/√(sd² + seed_sd²/replicates); empty where either is missing.
std::optional<double> StandardDeviationsOff(const ResponseResult& response);

/// What the best point gives on experiments that were not calibrated: how many of the observed
/// responses it meets; "" where it was evaluated on none.
std::string TransferHeadline(const StudyResults& results);
/// A sentence on each of these responses that was observed, by how many standard deviations it is
/// off; and on each experiment that failed, why.
std::vector<std::string> TransferStatements(const StudyResults& results);

/// How a response on another backend differs from that of the study's own.
struct BackendDifference {
  std::optional<double> value;  ///< other − own, SI; empty where either is missing
  /// SI, √(s₁²/n₁ + s₂²/n₂) from the scatter between particle seeds; empty with one seed.
  std::optional<double> sd;
};
BackendDifference CompareBackends(const ResponseResult& other, const ResponseResult& own);

/// Whether another backend gives every response at the best point, and passes the same ones as the
/// study's own (JudgeFit).
bool Agrees(const StudyResults& results, const ConfirmationResult& confirmation);
/// What it makes of the best point: "liggghts 3.8.0 confirms the best point: …", or why it could
/// not.
std::string ConfirmationHeadline(const StudyResults& results,
                                 const ConfirmationResult& confirmation);
/// A sentence on each response that both have, by how much they differ.
std::vector<std::string> ConfirmationStatements(const StudyResults& results,
                                                const ConfirmationResult& confirmation);

/// A sentence on each response by how much the study's approximations change it; empty where that
/// was not measured.
std::vector<std::string> ApproximationStatements(const StudyResults& results);

/// "quick", "quick; shear: standard".
std::string FidelityText(const StudyResults& results);

/// "12 of them at a lower fidelity (quick): learnt from, not ranked", or "".
std::string LowerFidelityText(const StudyResults& results);

/// The best evaluation, or nullptr.
const EvaluationResult* BestEvaluation(const StudyResults& results);

/// The study's targets, as far as the evaluations name them: of the best evaluation, or of the
/// first that has any. Without a best evaluation nothing is `simulated`.
std::vector<ResponseResult> TargetResponses(const StudyResults& results);

/// What a reader should take away, in one or two plain sentences.
struct Conclusion {
  enum class Kind {
    fits,       ///< every response is near enough to its observation
    rehearsal,  ///< the same, but no simulation was run
    misses,     ///< there is a best point, and it is not near enough
    nothing,    ///< there is no best point
  };
  Kind kind = Kind::nothing;
  std::string headline;  ///< "Calibrated: the void ratio comes out within the tolerance."
  std::string detail;    ///< why the study ended
};
Conclusion Conclude(const StudyResults& results);

/// Of a study with several objectives: whether its experiments can be fitted together.
struct Compatibility {
  bool together = false;  ///< an evaluation fits every response of every experiment
  /// "Consolidation and shear contradict each other as far as was searched: …"; empty with fewer
  /// than two objectives or without a complete evaluation.
  std::string statement;
  std::string detail;  ///< what each experiment's best fit costs the others
};
Compatibility JudgeCompatibility(const StudyResults& results);

/// Whether the evaluation fits all responses of an objective, by JudgeFit.
bool FitsObjective(const StudyResults& results, const EvaluationResult& evaluation,
                   std::size_t objective);
/// Number of targets of an objective.
int TargetCount(const StudyResults& results, std::size_t objective);

/// "no simulation was run: …", or "" when simulations were.
std::string NoSimulationNotice(const StudyResults& results);

/// What the best point's cohesion says of the powder (scaling/real_powder.h), as sentences.
std::vector<std::string> CohesionStatements(const StudyResults& results);

/// Reasons to be careful with the result, as sentences; empty when there are none.
std::vector<std::string> Caveats(const StudyResults& results);

}  // namespace powdercal

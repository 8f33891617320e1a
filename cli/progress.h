#pragma once

#include <string>

#include "cli/status_line.h"
#include "studies/runner.h"

namespace powdercal::cli {

/// Shows a study's progress on stderr: a line for each evaluation and each failed run, and on a
/// terminal a status line below them that is redrawn in place.
class ProgressDisplay final : public ProgressListener {
 public:
  explicit ProgressDisplay(const Study& study);

  /// Names the study; a study that goes on says so here, below its name.
  void Begin(const std::string& header);

  void OnResume(int evaluations) override;
  void OnRun(const LedgerRun& run, const Progress& progress) override;
  void OnEvaluation(const LedgerCandidate& candidate, const ReducedResponses& responses,
                    const std::vector<ExperimentFailure>& failures,
                    const Progress& progress) override;
  void OnConfirmation(const LedgerCandidate& candidate, const Progress& progress) override;
  void OnTransfer(const LedgerCandidate& candidate, const Progress& progress) override;
  void OnTick(const Progress& progress) override;

 private:
  const Study& study_;
  Objectives objectives_;
  StatusLine status_;
  int resumed_ = 0;  // evaluations that the ledger held
  enum class Phase { calibration, confirmation, transfer } phase_ = Phase::calibration;
};

}  // namespace powdercal::cli

#include "cli/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/output.h"
#include "cli/text.h"
#include "reports/text.h"
#include "studies/fidelities.h"

namespace powdercal::cli {
namespace {

std::string DescribeResponses(const Objectives& objectives, const ReducedResponses& responses,
                              const std::vector<ExperimentFailure>& failures) {
  std::vector<std::string> parts;
  for (std::size_t t = 0; t < objectives.targets.size(); ++t) {
    const auto index = static_cast<Eigen::Index>(t);
    const Target& target = objectives.targets[t];
    if (responses.counts[index] == 0) continue;
    parts.push_back(fmt::format("{} {:.4g} (target {:.4g})", target.response,
                                responses.means[index], target.value));
  }
  for (const ExperimentFailure& failure : failures) {
    parts.push_back(fmt::format("{} failed ({})", failure.experiment, failure.reason));
  }
  return JoinNames(parts);
}

// Evaluations at a lower fidelity count as what they cost, and their sum is no whole number.
std::string UsedText(const Progress& progress) {
  return progress.used == progress.done ? fmt::format("{}", progress.done)
                                        : fmt::format("{:.1f}", progress.used);
}

}  // namespace

ProgressDisplay::ProgressDisplay(const Study& study)
    : study_(study), objectives_(study.MakeObjectives()) {}

void ProgressDisplay::Begin(const std::string& header) {
  status_.Line(header);
  if (resumed_ == 0) return;
  status_.Line(fmt::format("resuming after {} evaluations; what the ledger holds is not repeated",
                           resumed_));
}

void ProgressDisplay::OnResume(int evaluations) { resumed_ = evaluations; }

void ProgressDisplay::OnRun(const LedgerRun& run, const Progress& progress) {
  const bool elsewhere = phase_ == Phase::confirmation;
  const bool own = run.backend == study_.backend.backend->name();
  const std::string what = run.experiment + (!elsewhere ? ""
                                             : own      ? " without the approximation"
                                                        : " on " + run.backend);
  if (!run.outcome.ok()) {
    status_.Line(fmt::format("        {} failed, {}: {}", what, ToString(run.outcome.reason),
                             run.outcome.message));
  } else if (phase_ != Phase::calibration) {
    status_.Line(fmt::format("{:3}/{} {} with particle seed {}: ok, {}",
                             elsewhere ? progress.confirmation_done : progress.transfer_done,
                             elsewhere ? progress.confirmation_runs : progress.transfer_runs, what,
                             run.seed, DurationText(run.diagnostics.wall_seconds)));
  }
}

void ProgressDisplay::OnEvaluation(const LedgerCandidate& candidate,
                                   const ReducedResponses& responses,
                                   const std::vector<ExperimentFailure>& failures,
                                   const Progress& progress) {
  const std::string point = DescribePoint(study_.space.parameters, candidate.parameters);
  const std::string result = failures.size() == 1 && responses.failed()
                                 ? "failed: " + failures[0].reason
                                 : DescribeResponses(objectives_, responses, failures);
  const std::string at = candidate.candidate.fidelity < 1
                             ? " at " + FidelityNameAt(study_, candidate.candidate.fidelity)
                             : "";
  const bool best = progress.best == candidate.candidate.id;
  const int replicates = responses.counts.maxCoeff();
  status_.Line(fmt::format(
      "{:>3}/{} #{} {}{} -> {}{}{}", UsedText(progress), progress.budget, candidate.candidate.id,
      point, at, result,
      replicates > study_.backend.replicates ? fmt::format(" over {} seeds", replicates) : "",
      best ? "  * best so far" : ""));
}

void ProgressDisplay::OnConfirmation(const LedgerCandidate& candidate, const Progress& progress) {
  phase_ = Phase::confirmation;
  std::string where;
  if (!study_.backend.confirm_with.empty()) where = "on other backends";
  if (study_.approximations.any()) {
    where +=
        fmt::format("{}without the approximation of the contact law", where.empty() ? "" : " and ");
  }
  status_.Line(fmt::format("the best point, #{}, {}: {} of {} runs are in the ledger",
                           candidate.candidate.id, where, progress.confirmation_done,
                           progress.confirmation_runs));
}

void ProgressDisplay::OnTransfer(const LedgerCandidate& candidate, const Progress& progress) {
  phase_ = Phase::transfer;
  status_.Line(
      fmt::format("the best point, #{}, on experiments that were not calibrated: {} of {} runs "
                  "are in the ledger",
                  candidate.candidate.id, progress.transfer_done, progress.transfer_runs));
}

void ProgressDisplay::OnTick(const Progress& progress) {
  if (!status_.terminal()) return;
  const int done = phase_ == Phase::calibration    ? static_cast<int>(progress.used)
                   : phase_ == Phase::confirmation ? progress.confirmation_done
                                                   : progress.transfer_done;
  const int all = phase_ == Phase::calibration    ? progress.budget
                  : phase_ == Phase::confirmation ? progress.confirmation_runs
                                                  : progress.transfer_runs;
  std::string text = fmt::format("{}  {} running  {} failed", ProgressBar(done, all),
                                 progress.running, progress.failed);
  if (progress.partial > 0) text += fmt::format("  {} partly", progress.partial);
  if (progress.best) {
    text += "  best " + DescribePoint(study_.space.parameters, progress.best_parameters);
  }
  text += "  " + DurationText(progress.elapsed_seconds);
  if (progress.seconds_left) text += ", at most " + DurationText(*progress.seconds_left) + " left";
  status_.Show(text);
}

}  // namespace powdercal::cli

#include "cli/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "cli/output.h"
#include "cli/text.h"
#include "reports/text.h"

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

// The status line is redrawn in place, which takes a single line of the terminal.
std::string FitTerminal(std::string text) {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return text;
  int columns = size.ws_col;  // the last one stays free: a full line wraps on some terminals
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool starts_character = (static_cast<unsigned char>(text[i]) & 0xC0) != 0x80;
    if (starts_character && --columns == 0) text.resize(i);
  }
  return text;
}

}  // namespace

ProgressDisplay::ProgressDisplay(const Study& study)
    : study_(study), objectives_(study.MakeObjectives()), terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressDisplay::~ProgressDisplay() { ClearStatus(); }

void ProgressDisplay::Begin(const std::string& header) {
  Line(header);
  if (resumed_ == 0) return;
  Line(fmt::format("resuming after {} evaluations; what the ledger holds is not repeated",
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
    Line(fmt::format("        {} failed, {}: {}", what, ToString(run.outcome.reason),
                     run.outcome.message));
  } else if (phase_ != Phase::calibration) {
    Line(fmt::format("{:3}/{} {} with particle seed {}: ok, {}",
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
  const bool best = progress.best == candidate.candidate.id;
  const int replicates = responses.counts.maxCoeff();
  Line(fmt::format(
      "{:3}/{} #{} {} -> {}{}{}", progress.done, progress.budget, candidate.candidate.id, point,
      result,
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
  Line(fmt::format("the best point, #{}, {}: {} of {} runs are in the ledger",
                   candidate.candidate.id, where, progress.confirmation_done,
                   progress.confirmation_runs));
}

void ProgressDisplay::OnTransfer(const LedgerCandidate& candidate, const Progress& progress) {
  phase_ = Phase::transfer;
  Line(
      fmt::format("the best point, #{}, on experiments that were not calibrated: {} of {} runs "
                  "are in the ledger",
                  candidate.candidate.id, progress.transfer_done, progress.transfer_runs));
}

void ProgressDisplay::OnTick(const Progress& progress) {
  if (!terminal_) return;
  constexpr int kWidth = 20;
  const int done = phase_ == Phase::calibration    ? progress.done
                   : phase_ == Phase::confirmation ? progress.confirmation_done
                                                   : progress.transfer_done;
  const int all = phase_ == Phase::calibration    ? progress.budget
                  : phase_ == Phase::confirmation ? progress.confirmation_runs
                                                  : progress.transfer_runs;
  const int filled = all > 0 ? std::min(kWidth, kWidth * done / all) : 0;
  std::string text = fmt::format("[{}{}] {}/{}  {} running  {} failed",
                                 std::string(static_cast<std::size_t>(filled), '#'),
                                 std::string(static_cast<std::size_t>(kWidth - filled), '.'), done,
                                 all, progress.running, progress.failed);
  if (progress.partial > 0) text += fmt::format("  {} partly", progress.partial);
  if (progress.best) {
    text += "  best " + DescribePoint(study_.space.parameters, progress.best_parameters);
  }
  text += "  " + DurationText(progress.elapsed_seconds);
  if (progress.seconds_left) text += ", at most " + DurationText(*progress.seconds_left) + " left";
  Say("\r\033[K{}", FitTerminal(text));
  status_shown_ = true;
}

void ProgressDisplay::Line(const std::string& text) {
  ClearStatus();
  Say("{}\n", text);
}

void ProgressDisplay::ClearStatus() {
  if (!status_shown_) return;
  Say("\r\033[K");
  status_shown_ = false;
}

}  // namespace powdercal::cli

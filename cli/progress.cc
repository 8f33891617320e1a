#include "cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "cli/text.h"

namespace powdercal::cli {
namespace {

std::string DescribeResponses(const Objectives& objectives, const ReducedResponses& responses) {
  std::string text;
  for (std::size_t t = 0; t < objectives.targets.size(); ++t) {
    const auto index = static_cast<Eigen::Index>(t);
    const Target& target = objectives.targets[t];
    if (t > 0) text += ", ";
    if (responses.counts[index] == 0) {
      text += target.response + " failed";
      continue;
    }
    text += fmt::format("{} {:.4g} (target {:.4g})", target.response, responses.means[index],
                        target.value);
  }
  return text;
}

}  // namespace

ProgressDisplay::ProgressDisplay(const Study& study)
    : study_(study), objectives_(study.MakeObjectives()), terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressDisplay::~ProgressDisplay() { ClearStatus(); }

void ProgressDisplay::OnResume(int evaluations) {
  Line(fmt::format("resuming after {} evaluations; what the ledger holds is not repeated",
                   evaluations));
}

void ProgressDisplay::OnRun(const LedgerRun& run, const Progress&) {
  if (run.outcome.ok()) return;
  Line(
      fmt::format("        run failed, {}: {}", ToString(run.outcome.reason), run.outcome.message));
}

void ProgressDisplay::OnEvaluation(const LedgerCandidate& candidate,
                                   const ReducedResponses& responses, const Outcome& failure,
                                   const Progress& progress) {
  const std::string point = DescribePoint(study_.space.parameters, candidate.parameters);
  const std::string result = responses.failed()
                                 ? fmt::format("failed: {}", ToString(failure.reason))
                                 : DescribeResponses(objectives_, responses);
  const bool best = progress.best == candidate.candidate.id;
  const int replicates = responses.counts.maxCoeff();
  Line(fmt::format(
      "{:3}/{} #{} {} -> {}{}{}", progress.done, progress.budget, candidate.candidate.id, point,
      result,
      replicates > study_.backend.replicates ? fmt::format(" over {} seeds", replicates) : "",
      best ? "  * best so far" : ""));
}

void ProgressDisplay::OnTick(const Progress& progress) {
  if (!terminal_) return;
  constexpr int kWidth = 20;
  const int filled = progress.budget > 0 ? kWidth * progress.done / progress.budget : 0;
  std::string text = fmt::format("[{}{}] {}/{}  {} running  {} failed",
                                 std::string(static_cast<std::size_t>(filled), '#'),
                                 std::string(static_cast<std::size_t>(kWidth - filled), '.'),
                                 progress.done, progress.budget, progress.running, progress.failed);
  if (progress.best) {
    text += "  best " + DescribePoint(study_.space.parameters, progress.best_parameters);
  }
  text += "  " + Duration(progress.elapsed_seconds);
  if (progress.seconds_left) text += ", at most " + Duration(*progress.seconds_left) + " left";
  fmt::print(stderr, "\r\033[K{}", text);
  std::fflush(stderr);
  status_shown_ = true;
}

void ProgressDisplay::Line(const std::string& text) {
  ClearStatus();
  fmt::print(stderr, "{}\n", text);
}

void ProgressDisplay::ClearStatus() {
  if (!status_shown_) return;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
  status_shown_ = false;
}

}  // namespace powdercal::cli

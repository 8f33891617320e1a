#include "verification/ladder.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "core/version.h"
#include "verification/contact_rung.h"
#include "verification/packing_rung.h"
#include "verification/study_rungs.h"

namespace powdercal::verification {
namespace {

// Passes on what it hears, and keeps the failures.
class Recorder final : public RunListener {
 public:
  Recorder(RunListener* next, std::vector<FailedRun>& failures)
      : next_(next), failures_(failures) {}

  void OnRung(Rung rung, int runs, int known) override {
    rung_ = rung;
    if (next_ != nullptr) next_->OnRung(rung, runs, known);
  }
  void OnRun(const Job& job, const LedgerRun& run, int done, int all) override {
    if (!run.outcome.ok() && run.outcome.reason != Reason::cancelled) {
      failures_.push_back(
          {rung_, job.name, run.backend, ToString(run.outcome.reason), run.outcome.message});
    }
    if (next_ != nullptr) next_->OnRun(job, run, done, all);
  }
  void OnTick(int done, int all) override {
    if (next_ != nullptr) next_->OnTick(done, all);
  }

 private:
  RunListener* next_;
  std::vector<FailedRun>& failures_;
  Rung rung_ = Rung::contact;
};

void Append(std::vector<Finding>& findings, std::vector<Finding> more) {
  findings.insert(findings.end(), std::make_move_iterator(more.begin()),
                  std::make_move_iterator(more.end()));
}

std::vector<Finding> FindExperiments(const LadderSubject& subject,
                                     std::span<const Contender> contenders,
                                     const LadderOptions& options, const RunOptions& run_options) {
  const std::vector<SeedCase> cases =
      ExperimentCases(*subject.planner, subject.parameters, options.seeds, options.margins);
  std::vector<Finding> findings =
      CompareOverSeeds(Rung::experiment, cases, contenders, options.level, run_options);
  Append(findings, UnplannedExperiments(*subject.planner, contenders));
  return findings;
}

// One rung; `below`: what was found on those before it.
std::vector<Finding> Climb(Rung rung, const LadderSubject& subject,
                           std::span<const Contender> contenders, const LadderOptions& options,
                           const RunOptions& run_options, const std::vector<Finding>& below) {
  switch (rung) {
    case Rung::contact:
      return VerifyContacts(subject.law, contenders, run_options);
    case Rung::packing: {
      const SeedCase bed = PackingCase(subject.law, options.seeds, options.margins);
      return CompareOverSeeds(rung, std::span(&bed, 1), contenders, options.level, run_options);
    }
    case Rung::experiment:
      return FindExperiments(subject, contenders, options, run_options);
    case Rung::calibration:
      break;
  }
  const bool known = std::any_of(below.begin(), below.end(), [](const Finding& finding) {
    return finding.rung == Rung::experiment;
  });
  return JudgeCalibration(
      subject.planner->study(),
      known ? below : FindExperiments(subject, contenders, options, run_options), options.level);
}

}  // namespace

int LadderReport::Count(Verdict verdict) const {
  return static_cast<int>(std::count_if(findings.begin(), findings.end(),
                                        [&](const Finding& f) { return f.verdict == verdict; }));
}

bool LadderReport::passed() const {
  return std::none_of(findings.begin(), findings.end(),
                      [](const Finding& finding) { return SpeaksAgainst(finding.verdict); });
}

void NoteBridges(std::vector<Finding>& findings) {
  const auto agree = [&](const Finding& where, const std::string& x, const std::string& y) {
    return std::any_of(findings.begin(), findings.end(), [&](const Finding& f) {
      return f.rung == where.rung && f.name == where.name && f.verdict == Verdict::equivalent &&
             ((f.a == x && f.b == y) || (f.a == y && f.b == x));
    });
  };
  for (Finding& finding : findings) {
    if (finding.verdict != Verdict::unsupported) continue;
    for (const Finding& other : findings) {
      for (const std::string& third : {other.a, other.b}) {
        if (third == finding.a || third == finding.b || !finding.note.empty()) continue;
        if (!agree(finding, finding.a, third) || !agree(finding, finding.b, third)) continue;
        finding.note = fmt::format(
            "bridged by {}, which agrees with each of them in a form of the law that the two have",
            third);
      }
    }
  }
}

LadderReport ClimbLadder(const LadderSubject& subject, std::span<const Contender> contenders,
                         const LadderOptions& options, const RunOptions& run_options) {
  const auto start = std::chrono::steady_clock::now();
  LadderReport report{.subject = subject.law.name,
                      .description = subject.law.description,
                      .law = subject.law.law.ToString(),
                      .program_version = kVersion,
                      .options = options,
                      .parameters_source = subject.parameters_source};
  if (subject.planner != nullptr) {
    const auto& known = subject.planner->study().space.parameters;
    for (std::size_t i = 0; i < subject.parameters.size(); ++i) {
      const Parameter& parameter = known[i];
      const double value = subject.parameters[i];
      if (parameter.categorical()) {
        report.choices[parameter.name] = parameter.CategoryAt(value);
      } else {
        report.parameters[parameter.name] = value;
      }
    }
  }
  for (const Contender& contender : contenders) {
    const Availability& availability = contender.availability;
    report.contenders.push_back({contender.name, availability.version,
                                 availability.available ? contender.backend->Describe() : "",
                                 availability.available ? "" : availability.why_not});
  }
  Recorder recorder(run_options.listener, report.failures);
  RunOptions common = run_options;
  common.listener = &recorder;
  for (const Rung rung : options.rungs) {
    if (run_options.stop.stop_requested()) break;
    Append(report.findings, Climb(rung, subject, contenders, options, common, report.findings));
  }
  report.interrupted = run_options.stop.stop_requested();
  NoteBridges(report.findings);
  report.wall_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace powdercal::verification

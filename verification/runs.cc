#include "verification/runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/hash.h"
#include "studies/executor.h"

namespace powdercal::verification {
namespace {

// The ledger's runs belong to candidates; here all belong to this one.
constexpr std::int64_t kCandidate = 0;

LedgerRun Begin(const Job& job) {
  const Contender& contender = *job.contender;
  LedgerRun run{.experiment = job.program.experiment,
                .program_hash = job.program.Hash(),
                .seed = job.seed,
                .backend = contender.name,
                .backend_version = contender.availability.version,
                .fidelity = ToString(job.program.fidelity)};
  run.key = Sha256(fmt::format("{}\n{}\n{}\n{}", run.program_hash, run.backend, run.backend_version,
                               contender.backend->Fingerprint()));
  return run;
}

void Execute(const Job& job, const RunContext& context, LedgerRun& run) {
  const auto start = std::chrono::steady_clock::now();
  try {
    const Trace trace = job.contender->backend->Run(job.program, context);
    run.outcome = trace.outcome;
    run.diagnostics = trace.diagnostics;
    if (run.outcome.ok()) run.measurement = job.measure(trace, &run.outcome);
    for (const auto& [name, response] : run.measurement.responses) {
      if (run.outcome.ok() && !std::isfinite(response.value)) {
        run.outcome = {Reason::unstable, fmt::format("{} is not finite", name)};
      }
    }
  } catch (const std::exception& error) {
    run.outcome = {Reason::crashed, error.what()};
  }
  if (!run.outcome.ok()) run.measurement.responses.clear();
  run.total_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

std::string Contender::ExplainUnsupported(const Program& program) const {
  if (!availability.available) return "not available: " + availability.why_not;
  return backend->ExplainUnsupported(program);
}

std::vector<LedgerRun> RunJobs(Rung rung, std::span<const Job> jobs, const RunOptions& options) {
  std::vector<LedgerRun> runs;
  std::vector<std::size_t> left;
  std::map<std::string, std::size_t> first;  // of equal jobs
  std::vector<std::size_t> same(jobs.size());
  for (const Job& job : jobs) {
    const std::size_t n = runs.size();
    LedgerRun& run = runs.emplace_back(Begin(job));
    same[n] = first.emplace(run.key, n).first->second;
    if (same[n] != n) continue;
    std::optional<LedgerRun> known;
    if (options.ledger != nullptr && job.keep) known = options.ledger->FindRun(run.key);
    if (known)
      run = std::move(*known);
    else
      left.push_back(n);
  }
  const int all = static_cast<int>(left.size());
  if (options.listener != nullptr) {
    const auto distinct = static_cast<int>(first.size());
    options.listener->OnRung(rung, distinct, distinct - all);
  }
  if (options.ledger != nullptr && !left.empty() && options.ledger->Candidates().empty()) {
    options.ledger->AddAsk(1, {{.candidate = {kCandidate, {}, "verification"}}});
  }
  LocalExecutor executor(std::max(1, options.parallel));
  for (const std::size_t n : left) {
    executor.Submit(static_cast<std::int64_t>(n), [&, n](std::stop_token stop) {
      LedgerRun run = runs[n];
      if (stop.stop_requested()) {
        run.outcome = {Reason::cancelled, "stopped on request"};
        return run;
      }
      Execute(jobs[n],
              {.work_folder =
                   options.work_folder / fmt::format("{}-{}-{}", ToString(rung), run.backend, n),
               .time_limit = options.time_limit,
               .stop = std::move(stop)},
              run);
      return run;
    });
  }
  for (int done = 0; done < all;) {
    if (options.stop.stop_requested()) executor.Cancel();
    auto finished = executor.Wait(std::chrono::milliseconds(200));
    if (finished) {
      ++done;
      const auto n = static_cast<std::size_t>(finished->ticket);
      runs[n] = std::move(finished->run);
      if (options.ledger != nullptr && jobs[n].keep && runs[n].outcome.ok()) {
        options.ledger->AddRun(runs[n], kCandidate, static_cast<int>(n));
      }
      if (options.listener != nullptr) options.listener->OnRun(jobs[n], runs[n], done, all);
    }
    if (options.listener != nullptr) options.listener->OnTick(done, all);
  }
  for (std::size_t n = 0; n < runs.size(); ++n) {
    if (same[n] != n) runs[n] = runs[same[n]];
  }
  return runs;
}

}  // namespace powdercal::verification

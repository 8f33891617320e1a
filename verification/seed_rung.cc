#include "verification/seed_rung.h"

#include <fmt/format.h>

#include <cmath>

#include "verification/forms.h"

namespace powdercal::verification {
namespace {

class SeedComparer {
 public:
  SeedComparer(Rung rung, std::span<const SeedCase> cases, std::span<const Contender> contenders,
               double level, const RunOptions& options)
      : rung_(rung), cases_(cases), contenders_(contenders), level_(level), options_(options) {}

  std::vector<Finding> Compare() {
    for (const SeedCase& entry : cases_) {
      Prepared& prepared = prepared_.emplace_back();
      // Which forms a backend has is the same for every seed.
      prepared.forms = FormsOf(entry.programs.front());
      for (const Contender& contender : contenders_) {
        prepared.why_not.push_back(ExplainForms(contender, prepared.forms));
      }
    }
    Plan();
    Run();
    std::vector<Finding> findings;
    for (std::size_t c = 0; c < cases_.size(); ++c) {
      ForEachPair([&](std::size_t a, std::size_t b) { findings.push_back(Judge(c, a, b)); });
    }
    return findings;
  }

 private:
  struct Prepared {
    std::vector<Form> forms;
    std::vector<std::vector<std::string>> why_not;  // by contender and form
  };
  struct Key {
    std::size_t entry = 0;
    std::size_t contender = 0;
    std::size_t form = 0;
    auto operator<=>(const Key&) const = default;
  };

  template <typename Visit>
  void ForEachPair(const Visit& visit) const {
    for (std::size_t a = 0; a < contenders_.size(); ++a) {
      for (std::size_t b = a + 1; b < contenders_.size(); ++b) visit(a, b);
    }
  }

  std::optional<FormChoice> Choose(std::size_t entry, std::size_t a, std::size_t b) const {
    const Prepared& prepared = prepared_[entry];
    return ChooseForms(prepared.forms, prepared.why_not[a], prepared.why_not[b]);
  }

  void Plan() {
    for (std::size_t c = 0; c < cases_.size(); ++c) {
      ForEachPair([&](std::size_t a, std::size_t b) {
        const auto choice = Choose(c, a, b);
        if (!choice) return;
        runs_[{c, a, choice->a}];
        runs_[{c, b, choice->b}];
      });
    }
  }

  // Seed after seed, so that what is interrupted has all backends' runs of the first seeds.
  void Run() {
    std::size_t most = 0;
    for (const SeedCase& entry : cases_) most = std::max(most, entry.seeds.size());
    std::vector<Job> jobs;
    std::vector<std::pair<std::vector<LedgerRun>*, std::size_t>> places;
    for (std::size_t s = 0; s < most; ++s) {
      for (auto& [key, runs] : runs_) {
        const SeedCase& entry = cases_[key.entry];
        if (s >= entry.seeds.size()) continue;
        runs.resize(entry.seeds.size());
        Program program = FormsOf(entry.programs[s])[key.form].program;
        jobs.push_back({.contender = &contenders_[key.contender],
                        .program = program,
                        .seed = entry.seeds[s],
                        .name = fmt::format("{}, seed {}", entry.name, entry.seeds[s]),
                        .measure = [&entry, program](const Trace& trace, Outcome* outcome) {
                          return entry.measure(program, trace, outcome);
                        }});
        places.emplace_back(&runs, s);
      }
    }
    std::vector<LedgerRun> done = RunJobs(rung_, jobs, options_);
    for (std::size_t n = 0; n < done.size(); ++n) {
      (*places[n].first)[places[n].second] = std::move(done[n]);
    }
  }

  Finding Judge(std::size_t c, std::size_t a, std::size_t b) const {
    const SeedCase& entry = cases_[c];
    Finding finding{
        .rung = rung_, .name = entry.name, .a = contenders_[a].name, .b = contenders_[b].name};
    const auto choice = Choose(c, a, b);
    if (!choice) {
      const Prepared& prepared = prepared_[c];
      finding.reason =
          ExplainNoForm(finding.a, prepared.why_not[a], finding.b, prepared.why_not[b]);
      return finding;
    }
    NoteForms(prepared_[c].forms, *choice, finding);
    const std::vector<LedgerRun>& first = runs_.at({c, a, choice->a});
    const std::vector<LedgerRun>& second = runs_.at({c, b, choice->b});
    for (const Comparison& comparison : entry.comparisons) {
      finding.quantities.push_back(Test(comparison, first, second));
    }
    finding.verdict = Overall(finding.quantities);
    for (const auto& [runs, name] : {std::pair{&first, finding.a}, std::pair{&second, finding.b}}) {
      int failed = 0;
      const LedgerRun* example = nullptr;
      for (const LedgerRun& run : *runs) {
        if (run.outcome.ok()) continue;
        if (failed++ == 0) example = &run;
      }
      if (failed == 0) continue;
      finding.verdict = Verdict::failed;
      finding.reason += fmt::format("{}{} of {} runs failed in {}: {}, {}",
                                    finding.reason.empty() ? "" : "; ", failed, runs->size(), name,
                                    ToString(example->outcome.reason), example->outcome.message);
    }
    if (finding.verdict != Verdict::failed) finding.reason = Explain(finding);
    return finding;
  }

  Quantity Test(const Comparison& comparison, const std::vector<LedgerRun>& first,
                const std::vector<LedgerRun>& second) const {
    std::vector<SeedPair> pairs;
    double scale = 0;
    for (std::size_t s = 0; s < first.size(); ++s) {
      const auto& a = first[s].measurement.responses;
      const auto& b = second[s].measurement.responses;
      const auto in_a = a.find(comparison.name);
      const auto in_b = b.find(comparison.name);
      if (in_a == a.end() || in_b == b.end()) continue;
      pairs.push_back({in_a->second.value, in_b->second.value});
      scale += std::abs(in_a->second.value);
    }
    if (!pairs.empty()) scale /= static_cast<double>(pairs.size());
    Quantity quantity{
        .name = comparison.name,
        .unit = comparison.unit,
        .tolerance = comparison.relative ? comparison.margin * scale : comparison.margin,
        .tolerance_reason = comparison.margin_reason,
        .verdict = Verdict::undecided,
        .counts = comparison.counts};
    if (pairs.size() < first.size()) {
      quantity.note =
          fmt::format("{} of {} seeds gave no value", first.size() - pairs.size(), first.size());
    }
    // A relative margin of a quantity that is zero throughout.
    if (!(quantity.tolerance > 0)) quantity.tolerance = std::numeric_limits<double>::min();
    SeedStatistics statistics;
    quantity.verdict = TestEquivalence(pairs, {quantity.tolerance, level_}, &statistics);
    quantity.difference = statistics.mean_b - statistics.mean_a;
    quantity.seeds = statistics;
    return quantity;
  }

  static std::string Explain(const Finding& finding) {
    std::string text;
    for (const Quantity& q : finding.quantities) {
      if (!q.counts || q.verdict == Verdict::equivalent) continue;
      text += fmt::format("{}{} differs by {:+.2g} [{:+.2g}, {:+.2g}], margin {:.2g}",
                          text.empty() ? "" : "; ", q.name, q.difference, q.seeds->lower,
                          q.seeds->upper, q.tolerance);
      if (q.verdict != Verdict::undecided) continue;
      text += q.seeds->seeds_needed > 0
                  ? fmt::format(": some {} seeds would decide", q.seeds->seeds_needed)
                  : ": the difference is about as large as the margin; more seeds may not decide";
    }
    return text;
  }

  Rung rung_;
  std::span<const SeedCase> cases_;
  std::span<const Contender> contenders_;
  double level_;
  const RunOptions& options_;
  std::vector<Prepared> prepared_;
  std::map<Key, std::vector<LedgerRun>> runs_;
};

}  // namespace

std::vector<Finding> CompareOverSeeds(Rung rung, std::span<const SeedCase> cases,
                                      std::span<const Contender> contenders, double level,
                                      const RunOptions& options) {
  return SeedComparer(rung, cases, contenders, level, options).Compare();
}

}  // namespace powdercal::verification

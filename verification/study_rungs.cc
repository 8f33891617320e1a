#include "verification/study_rungs.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

namespace powdercal::verification {
namespace {

constexpr double kFraction = 0.05;  // margin of what was not observed, of its mean

const ObservedResponse* Find(const StudyExperiment& entry, const std::string& response) {
  const auto found =
      std::find_if(entry.observed.begin(), entry.observed.end(),
                   [&](const ObservedResponse& o) { return o.response == response; });
  return found == entry.observed.end() ? nullptr : &*found;
}

Comparison CompareResponse(const StudyExperiment& entry, const ResponseDescription& response,
                           const std::map<std::string, double>& margins) {
  Comparison comparison{.name = response.name, .unit = response.unit};
  const auto given = margins.find(entry.name() + "." + response.name);
  const ObservedResponse* observed = Find(entry, response.name);
  if (given != margins.end()) {
    comparison.margin = given->second;
    comparison.margin_reason = "as given";
  } else if (observed != nullptr) {
    comparison.margin = observed->sd;
    comparison.margin_reason = "the standard deviation of the observation";
  } else {
    comparison.margin = kFraction;
    comparison.relative = true;
    comparison.counts = false;
    comparison.margin_reason = "5 % of the mean; it was not observed";
  }
  return comparison;
}

// What one backend's runs say of the calibration.
struct Misfit {
  double chi2 = 0;
  std::vector<Quantity> terms;
};

class CalibrationJudge {
 public:
  CalibrationJudge(const Study& study, std::span<const Finding> experiments, double level)
      : study_(study), experiments_(experiments), level_(level) {}

  Finding Judge(const std::string& a, const std::string& b) const {
    Finding finding{.rung = Rung::calibration, .name = "calibration", .a = a, .b = b};
    Misfit first, second;
    for (const std::size_t index : study_.CalibratedExperiments()) {
      const StudyExperiment& entry = study_.experiments[index];
      const Finding* found = FindExperiment(entry.name(), a, b);
      if (found == nullptr) continue;
      if (found->verdict == Verdict::unsupported || found->verdict == Verdict::failed) {
        finding.verdict = found->verdict;
        finding.reason = fmt::format("{}: {}", entry.name(), found->reason);
        return finding;
      }
      finding.law_a = found->law_a;
      finding.law_b = found->law_b;
      if (finding.note.empty()) finding.note = found->note;
      for (const ObservedResponse& observed : entry.observed) {
        Add(entry.name(), observed, *found, first, second);
      }
    }
    if (first.terms.empty()) {
      finding.reason = "no calibrated response has a value in both";
      return finding;
    }
    const boost::math::chi_squared distribution(static_cast<double>(first.terms.size()));
    const double bound = boost::math::quantile(boost::math::complement(distribution, level_));
    Conclude(first, second, bound, finding);
    return finding;
  }

 private:
  const Finding* FindExperiment(const std::string& name, const std::string& a,
                                const std::string& b) const {
    const auto found =
        std::find_if(experiments_.begin(), experiments_.end(), [&](const Finding& f) {
          return f.rung == Rung::experiment && f.name == name && f.a == a && f.b == b;
        });
    return found == experiments_.end() ? nullptr : &*found;
  }

  static void Add(const std::string& experiment, const ObservedResponse& observed,
                  const Finding& found, Misfit& first, Misfit& second) {
    for (const Quantity& quantity : found.quantities) {
      if (quantity.name != observed.response || !quantity.seeds || quantity.seeds->n < 2) continue;
      const SeedStatistics& s = *quantity.seeds;
      const auto term = [&](double mean, double sd, const std::string& backend, Misfit& misfit) {
        const double z =
            (mean - observed.value) / std::sqrt(observed.sd * observed.sd + sd * sd / s.n);
        misfit.chi2 += z * z;
        misfit.terms.push_back(
            {.name = fmt::format("z of {}.{} in {}", experiment, observed.response, backend),
             .unit = "1",
             .difference = z,
             .verdict = Verdict::equivalent,
             .counts = false});
      };
      term(s.mean_a, s.sd_a, found.a, first);
      term(s.mean_b, s.sd_b, found.b, second);
    }
  }

  void Conclude(const Misfit& first, const Misfit& second, double bound, Finding& finding) const {
    for (const auto& [misfit, name] :
         {std::pair{&first, &finding.a}, std::pair{&second, &finding.b}}) {
      finding.quantities.insert(finding.quantities.end(), misfit->terms.begin(),
                                misfit->terms.end());
      finding.quantities.push_back(
          {.name = "chi2 in " + *name,
           .unit = "1",
           .difference = misfit->chi2,
           .tolerance = bound,
           .tolerance_reason =
               fmt::format("{:.3g} quantile of chi-squared with {} degrees of freedom", 1 - level_,
                           misfit->terms.size()),
           .verdict = misfit->chi2 <= bound ? Verdict::equivalent : Verdict::different});
    }
    if (first.chi2 > bound) {
      finding.verdict = Verdict::unsupported;
      finding.reason = fmt::format(
          "nothing to confirm: {} does not accept the parameters itself, chi2 = {:.3g} above "
          "{:.3g}; in {} it is {:.3g}",
          finding.a, first.chi2, bound, finding.b, second.chi2);
      return;
    }
    finding.verdict = second.chi2 <= bound ? Verdict::equivalent : Verdict::different;
    if (finding.verdict == Verdict::different) {
      finding.reason = fmt::format(
          "{} would not have accepted the parameters: chi2 = {:.3g} above {:.3g}, in {} {:.3g}",
          finding.b, second.chi2, bound, finding.a, first.chi2);
    }
  }

  const Study& study_;
  std::span<const Finding> experiments_;
  double level_;
};

}  // namespace

std::map<std::string, std::string> ExperimentQuantities(const Study& study) {
  std::map<std::string, std::string> units;
  for (const StudyExperiment& entry : study.experiments) {
    for (const ResponseDescription& response : entry.experiment->responses()) {
      units[entry.name() + "." + response.name] = response.unit;
    }
  }
  return units;
}

std::vector<Finding> UnplannedExperiments(const Planner& planner,
                                          std::span<const Contender> contenders) {
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < planner.study().experiments.size(); ++i) {
    const std::string reason = planner.ExplainUnplanned(i);
    if (reason.empty()) continue;
    for (std::size_t a = 0; a < contenders.size(); ++a) {
      for (std::size_t b = a + 1; b < contenders.size(); ++b) {
        findings.push_back({.rung = Rung::experiment,
                            .name = planner.study().experiments[i].name(),
                            .a = contenders[a].name,
                            .b = contenders[b].name,
                            .reason = reason});
      }
    }
  }
  return findings;
}

std::vector<SeedCase> ExperimentCases(const Planner& planner, const std::vector<double>& parameters,
                                      int seeds, const std::map<std::string, double>& margins) {
  std::vector<SeedCase> cases;
  const Study& study = planner.study();
  for (std::size_t i = 0; i < study.experiments.size(); ++i) {
    if (!planner.ExplainUnplanned(i).empty()) continue;
    const StudyExperiment& entry = study.experiments[i];
    SeedCase one{.name = entry.name()};
    for (int seed = 1; seed <= seeds; ++seed) {
      one.seeds.push_back(static_cast<std::uint64_t>(seed));
      one.programs.push_back(planner.PlanExperiment(i, parameters, 0, one.seeds.back()).program);
    }
    for (const ResponseDescription& response : entry.experiment->responses()) {
      one.comparisons.push_back(CompareResponse(entry, response, margins));
    }
    one.measure = [experiment = entry.experiment.get()](const Program& program, const Trace& trace,
                                                        Outcome* outcome) {
      return experiment->Measure(program, trace, outcome);
    };
    cases.push_back(std::move(one));
  }
  return cases;
}

std::vector<Finding> JudgeCalibration(const Study& study, std::span<const Finding> experiments,
                                      double level) {
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const Finding& finding : experiments) {
    const std::pair pair(finding.a, finding.b);
    if (finding.rung != Rung::experiment) continue;
    if (std::find(pairs.begin(), pairs.end(), pair) == pairs.end()) pairs.push_back(pair);
  }
  std::vector<Finding> findings;
  const CalibrationJudge judge(study, experiments, level);
  for (const auto& [a, b] : pairs) findings.push_back(judge.Judge(a, b));
  return findings;
}

}  // namespace powdercal::verification

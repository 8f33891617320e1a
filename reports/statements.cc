#include "reports/statements.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "reports/text.h"

namespace powdercal {
namespace {

// "void ratio", with the experiment where another experiment has a response of that name.
std::string ResponseTitle(const ResponseResult& response, const std::vector<ResponseResult>& all) {
  const std::string name = ReadableName(response.name);
  const auto same = std::count_if(all.begin(), all.end(), [&](const ResponseResult& other) {
    return ReadableName(other.name) == name;
  });
  if (same < 2) return name;
  return name + " of " + response.name.substr(0, response.name.rfind('.'));
}

// "void ratio of consolidation".
std::string QualifiedTitle(const ResponseResult& response) {
  const std::size_t dot = response.name.rfind('.');
  const std::string name = ReadableName(response.name);
  return dot == std::string::npos ? name
                                  : name + " of " + ReadableName(response.name.substr(0, dot));
}

// A parameter within 1 % of the end of its searched range, or "".
std::string EdgeOfRange(const Parameter& parameter, double value) {
  if (parameter.categorical()) return "";
  const bool logarithmic = parameter.logarithmic && parameter.lower > 0 && value > 0;
  const auto map = [&](double x) { return logarithmic ? std::log(x) : x; };
  const double u =
      (map(value) - map(parameter.lower)) / (map(parameter.upper) - map(parameter.lower));
  if (!(u < 0.01) && !(u > 0.99)) return "";
  return fmt::format(
      "{} lies at the {} end of the range that was searched ({}): the best value may be outside "
      "it.",
      Capitalised(ReadableName(parameter.name)), u < 0.5 ? "lower" : "upper",
      ValueText(u < 0.5 ? parameter.lower : parameter.upper, parameter.unit));
}

void AddFitCaveats(const StudyResults& results, const EvaluationResult& best,
                   std::vector<std::string>& caveats) {
  if (best.responses.size() < results.parameters.size()) {
    caveats.push_back(fmt::format(
        "{} were fitted to {}: other combinations fit as well, and these values are one of a "
        "family. An experiment of another kind would tell them apart.",
        CountText(static_cast<int>(results.parameters.size()), "parameter"),
        CountText(static_cast<int>(best.responses.size()), "response")));
  }
  for (const Parameter& parameter : results.parameters) {
    const auto value = best.parameters.find(parameter.name);
    if (value == best.parameters.end()) continue;
    const std::string edge = EdgeOfRange(parameter, value->second);
    if (!edge.empty()) caveats.push_back(edge);
  }
  const bool one_seed =
      std::any_of(best.responses.begin(), best.responses.end(),
                  [](const ResponseResult& r) { return r.simulated && r.replicates < 2; });
  if (results.simulated && one_seed) {
    caveats.push_back(
        "The best point was simulated with one particle seed: how much its responses scatter from "
        "seed to seed is not known.");
  }
}

// Where the parameters have been tried on something else, and failed.
void AddTransferCaveats(const StudyResults& results, std::vector<std::string>& caveats) {
  const auto& responses = results.transfer.responses;
  const bool missed =
      std::any_of(responses.begin(), responses.end(), [](const ResponseResult& response) {
        return response.was_observed() && !JudgeFit(response).within;
      });
  if (missed) caveats.push_back(TransferHeadline(results));
  if (!missed && !results.transfer.failures.empty()) {
    caveats.push_back(fmt::format("At the best point {} failed, which was not fitted.",
                                  ReadableName(results.transfer.failures.front().experiment)));
  }
}

// "liggghts 3.8.0".
std::string NameAndVersion(const ConfirmationResult& confirmation) {
  return confirmation.backend + (confirmation.version.empty() ? "" : " " + confirmation.version);
}

void AddConfirmationCaveats(const StudyResults& results, std::vector<std::string>& caveats) {
  for (const ConfirmationResult& confirmation : results.confirmations) {
    const bool early = confirmation.outcome == kPending && results.state != "finished";
    if (early || Agrees(results, confirmation)) continue;
    caveats.push_back(ConfirmationHeadline(results, confirmation));
  }
}

// What an approximation changes by more than the laboratory's figure is known to.
void AddApproximationCaveats(const StudyResults& results, std::vector<std::string>& caveats) {
  for (const ApproximationStatement& approximation : results.approximations) {
    caveats.push_back(approximation.text);
  }
  if (!results.approximation_effect) return;
  const ApproximationEffect& effect = *results.approximation_effect;
  std::vector<std::string> changed;
  for (std::size_t i = 0; i < effect.exact.size(); ++i) {
    const BackendDifference difference = CompareBackends(effect.approximated[i], effect.exact[i]);
    if (!difference.value || std::abs(*difference.value) < effect.exact[i].sd) continue;
    if (std::abs(*difference.value) < 2 * difference.sd.value_or(0)) continue;
    changed.push_back(fmt::format("the {} by {} standard deviations of the observation",
                                  QualifiedTitle(effect.exact[i]),
                                  NumberText(std::abs(*difference.value) / effect.exact[i].sd, 2)));
  }
  if (changed.empty()) return;
  caveats.push_back(
      fmt::format("The approximation changes {}: the parameters are those of the law that was "
                  "simulated, not of "
                  "the one that it stands for.",
                  Enumerated(changed)));
}

// How two backends judge the responses of the best point that both have: "void ratio", …
struct Verdicts {
  std::vector<std::string> missed;          // by both
  std::vector<std::string> only_own;        // missed by the study's own backend alone
  std::vector<std::string> only_elsewhere;  // by the other one alone
  std::vector<std::string> missing;         // without a value there
  double largest = 0;  // difference of what only one of them missed, in its standard deviations
};

Verdicts CompareVerdicts(const EvaluationResult& best, const ConfirmationResult& confirmation) {
  Verdicts verdicts;
  for (std::size_t i = 0; i < best.responses.size() && i < confirmation.responses.size(); ++i) {
    const ResponseResult& there = confirmation.responses[i];
    const std::string title = ResponseTitle(there, best.responses);
    const bool fits = JudgeFit(there).within;
    const bool fits_here = JudgeFit(best.responses[i]).within;
    if (!there.simulated) {
      verdicts.missing.push_back(title);
    } else if (!fits && !fits_here) {
      verdicts.missed.push_back(title);
    } else if (fits != fits_here) {
      (fits ? verdicts.only_own : verdicts.only_elsewhere).push_back(title);
      const BackendDifference difference = CompareBackends(there, best.responses[i]);
      const double far = std::numeric_limits<double>::infinity();
      verdicts.largest = std::max(
          verdicts.largest,
          difference.sd && *difference.sd > 0 ? std::abs(*difference.value) / *difference.sd : far);
    }
  }
  return verdicts;
}

// "the void ratio is", "the void ratio and the coverage are".
std::string Subject(const std::vector<std::string>& titles) {
  return "the " + Enumerated(titles) + (titles.size() == 1 ? " is" : " are");
}

bool BelongsTo(const ResponseResult& response, const std::string& experiment) {
  return response.name.starts_with(experiment + ".");
}

double Misfit(const EvaluationResult& evaluation, std::size_t objective) {
  return evaluation.objectives[objective].misfit.value_or(std::numeric_limits<double>::infinity());
}

double TotalMisfit(const EvaluationResult& evaluation) {
  double sum = 0;
  for (std::size_t o = 0; o < evaluation.objectives.size(); ++o) sum += Misfit(evaluation, o);
  return sum;
}

// The point of the front that serves an objective best; of equals, the one that serves all best.
const EvaluationResult& BestOf(const StudyResults& results, std::size_t objective) {
  const auto best = std::min_element(
      results.pareto.begin(), results.pareto.end(), [&](std::size_t a, std::size_t b) {
        const EvaluationResult& first = results.history[a];
        const EvaluationResult& second = results.history[b];
        return std::pair(Misfit(first, objective), TotalMisfit(first)) <
               std::pair(Misfit(second, objective), TotalMisfit(second));
      });
  return results.history[*best];
}

// What it costs the others to fit one objective best: the one that loses most, or "".
std::string PriceOf(const StudyResults& results, std::size_t objective, const char* separator) {
  const EvaluationResult& here = BestOf(results, objective);
  std::size_t loser = objective;
  double loss = 0;
  for (std::size_t o = 0; o < results.objectives.size(); ++o) {
    const double difference = Misfit(here, o) - Misfit(BestOf(results, o), o);
    if (difference > loss) {
      loss = difference;
      loser = o;
    }
  }
  if (loser == objective) return "";
  const EvaluationResult& there = BestOf(results, loser);
  return fmt::format(
      "{}Where {} fits best (evaluation {}), the misfit of {} is {} instead of {} (evaluation {}).",
      separator, ReadableName(results.objectives[objective]), here.id,
      ReadableName(results.objectives[loser]), NumberText(Misfit(here, loser), 3),
      NumberText(Misfit(there, loser), 3), there.id);
}

}  // namespace

Fit JudgeFit(const ResponseResult& response) {
  Fit fit;
  if (!response.was_observed()) return fit;
  fit.has_tolerance = response.tolerance.has_value();
  const double seed_variance =
      response.replicates > 1 ? response.seed_sd * response.seed_sd / response.replicates : 0;
  fit.limit = fit.has_tolerance ? *response.tolerance
                                : 2 * std::sqrt(response.sd * response.sd + seed_variance);
  if (!response.simulated || !std::isfinite(*response.simulated)) return fit;
  fit.deviation = *response.simulated - response.observed;
  fit.within = std::abs(*fit.deviation) < fit.limit;
  return fit;
}

std::optional<double> StandardDeviationsOff(const ResponseResult& response) {
  if (!response.simulated || !response.was_observed()) return std::nullopt;
  const double seed_variance =
      response.replicates > 1 ? response.seed_sd * response.seed_sd / response.replicates : 0;
  return (*response.simulated - response.observed) /
         std::sqrt(response.sd * response.sd + seed_variance);
}

std::string TransferHeadline(const StudyResults& results) {
  const TransferResult& transfer = results.transfer;
  if (transfer.experiments.empty()) return "";
  int observed = 0;
  int within = 0;
  for (const ResponseResult& response : transfer.responses) {
    if (!response.was_observed()) continue;
    ++observed;
    if (JudgeFit(response).within) ++within;
  }
  std::vector<std::string> names;
  for (const std::string& name : transfer.experiments) names.push_back(ReadableName(name));
  const std::string where = Enumerated(names);
  const std::string fitted = names.size() == 1 ? "it was not fitted" : "they were not fitted";
  if (observed == 0) {
    return fmt::format("Evaluated on {} as well ({}); nothing was observed to compare with.", where,
                       fitted);
  }
  const std::string compared = CountText(observed, "response");
  if (within == observed) {
    return fmt::format(
        "Transfers to {} ({}): {} as observed.", where, fitted,
        observed == 1 ? "its response comes out" : fmt::format("all {} come out", compared));
  }
  return fmt::format("Does not transfer to {} ({}): {} of {} as observed.", where, fitted,
                     within == 0 ? "none" : fmt::format("{}", within), compared);
}

std::vector<std::string> TransferStatements(const StudyResults& results) {
  std::vector<std::string> statements;
  for (const ResponseResult& response : results.transfer.responses) {
    const std::optional<double> off = StandardDeviationsOff(response);
    if (!off) continue;
    statements.push_back(fmt::format(
        "{}: {} against {} ± {} observed, {} standard deviations too {}; it {}.",
        Capitalised(QualifiedTitle(response)), ValueText(*response.simulated, response.unit),
        ValueText(response.observed, response.unit), ValueText(response.sd, response.unit, 2),
        NumberText(std::abs(*off), 2), *off < 0 ? "low" : "high",
        JudgeFit(response).within ? "agrees" : "does not agree"));
  }
  for (const ExperimentFailure& failure : results.transfer.failures) {
    statements.push_back(Sentence(fmt::format("{} gave no value in {} of {}, {}: {}",
                                              ReadableName(failure.experiment), failure.failed_runs,
                                              CountText(failure.runs, "run"),
                                              ReadableName(failure.reason), failure.message)));
  }
  return statements;
}

BackendDifference CompareBackends(const ResponseResult& other, const ResponseResult& own) {
  BackendDifference difference;
  if (!other.simulated || !own.simulated) return difference;
  difference.value = *other.simulated - *own.simulated;
  if (other.replicates > 1 && own.replicates > 1) {
    difference.sd = std::sqrt(other.seed_sd * other.seed_sd / other.replicates +
                              own.seed_sd * own.seed_sd / own.replicates);
  }
  return difference;
}

bool Agrees(const StudyResults& results, const ConfirmationResult& confirmation) {
  const EvaluationResult* best = BestEvaluation(results);
  if (best == nullptr || confirmation.responses.empty()) return false;
  const Verdicts verdicts = CompareVerdicts(*best, confirmation);
  return verdicts.missing.empty() && verdicts.only_own.empty() && verdicts.only_elsewhere.empty();
}

std::string ConfirmationHeadline(const StudyResults& results,
                                 const ConfirmationResult& confirmation) {
  const std::string name = NameAndVersion(confirmation);
  const EvaluationResult* best = BestEvaluation(results);
  if (confirmation.outcome == kPending || best == nullptr) {
    return fmt::format("The best point has not been simulated on {} yet.", name);
  }
  const Verdicts verdicts = CompareVerdicts(*best, confirmation);
  if (verdicts.missing.size() == confirmation.responses.size()) {
    return WithFullStop(
        fmt::format("{} could not confirm the best point: {}", name, confirmation.message));
  }
  const std::string limit = "outside the accepted deviation";
  std::string text;
  if ((!verdicts.only_elsewhere.empty() || !verdicts.only_own.empty()) && verdicts.largest < 2) {
    const bool there = !verdicts.only_elsewhere.empty();
    text = fmt::format(
        "{} neither confirms nor refutes the best point: {} {} {}, but the two backends differ by "
        "{} standard deviations of the particle seeds only. More seeds would tell.",
        name, Subject(there ? verdicts.only_elsewhere : verdicts.only_own), limit,
        there ? "there, not with " + results.backend : "with " + results.backend + ", not there",
        NumberText(verdicts.largest, 2));
  } else if (!verdicts.only_elsewhere.empty()) {
    text = fmt::format("{} does not confirm the best point: {} {} there, not with {}.", name,
                       Subject(verdicts.only_elsewhere), limit, results.backend);
  } else if (!verdicts.only_own.empty()) {
    text = fmt::format("{} does not agree on the best point: {} {} with {}, not there.", name,
                       Subject(verdicts.only_own), limit, results.backend);
  } else if (!verdicts.missed.empty()) {
    text = fmt::format("{} agrees with {} on the best point: {} {} with both.", name,
                       results.backend, Subject(verdicts.missed), limit);
  } else if (verdicts.missing.empty()) {
    text =
        fmt::format("{} confirms the best point: {} as observed.", name,
                    best->responses.size() == 1
                        ? "the " + ResponseTitle(best->responses[0], best->responses) + " comes out"
                        : fmt::format("all {} responses come out", best->responses.size()));
  } else {
    text = fmt::format("{} confirms the best point in part: {} of {} come out as observed.", name,
                       confirmation.responses.size() - verdicts.missing.size(),
                       CountText(static_cast<int>(best->responses.size()), "response"));
  }
  if (verdicts.missing.empty()) return text;
  return WithFullStop(fmt::format("{} The {} could not be had there: {}", text,
                                  Enumerated(verdicts.missing), confirmation.message));
}

std::vector<std::string> ConfirmationStatements(const StudyResults& results,
                                                const ConfirmationResult& confirmation) {
  std::vector<std::string> statements;
  const EvaluationResult* best = BestEvaluation(results);
  if (best == nullptr) return statements;
  for (std::size_t i = 0; i < best->responses.size() && i < confirmation.responses.size(); ++i) {
    const ResponseResult& own = best->responses[i];
    const ResponseResult& other = confirmation.responses[i];
    const BackendDifference difference = CompareBackends(other, own);
    if (!difference.value) continue;
    std::string text = fmt::format(
        "{}: {} against {} with {}, a difference of {}", Capitalised(QualifiedTitle(other)),
        ValueText(*other.simulated, other.unit), ValueText(*own.simulated, own.unit),
        results.backend, ValueText(*difference.value, other.unit, 2));
    if (difference.sd) {
      text += fmt::format(" ± {} (standard deviation, from the particle seeds)",
                          ValueText(*difference.sd, other.unit, 2));
    }
    statements.push_back(text + ".");
  }
  return statements;
}

std::vector<std::string> ApproximationStatements(const StudyResults& results) {
  std::vector<std::string> statements;
  if (!results.approximation_effect) return statements;
  const ApproximationEffect& effect = *results.approximation_effect;
  for (std::size_t i = 0; i < effect.exact.size(); ++i) {
    const ResponseResult& exact = effect.exact[i];
    const BackendDifference difference = CompareBackends(effect.approximated[i], exact);
    if (!difference.value) continue;
    std::string text = fmt::format("{}: {} with the approximation, {} without, a difference of {}",
                                   Capitalised(QualifiedTitle(exact)),
                                   ValueText(*effect.approximated[i].simulated, exact.unit),
                                   ValueText(*exact.simulated, exact.unit),
                                   ValueText(*difference.value, exact.unit, 2));
    if (difference.sd) {
      text += fmt::format(" ± {} (standard deviation, from the particle seeds)",
                          ValueText(*difference.sd, exact.unit, 2));
    }
    statements.push_back(text + ".");
  }
  for (const ExperimentFailure& failure : effect.failures) {
    statements.push_back(Sentence(fmt::format("{} without the approximation gave no value, {}: {}",
                                              ReadableName(failure.experiment),
                                              ReadableName(failure.reason), failure.message)));
  }
  return statements;
}

std::string FidelityText(const StudyResults& results) {
  std::string text = results.fidelity;
  for (const ExperimentResult& experiment : results.experiments) {
    if (experiment.fidelity == results.fidelity) continue;
    text += fmt::format("; {}: {}", ReadableName(experiment.name), experiment.fidelity);
  }
  return text;
}

std::string LowerFidelityText(const StudyResults& results) {
  if (results.lower_fidelity.empty()) return "";
  std::set<std::string> names;
  for (const EvaluationResult& one : results.lower_fidelity) names.insert(one.fidelity);
  return fmt::format("{} of them at a lower fidelity ({}): learnt from, not ranked",
                     results.lower_fidelity.size(), fmt::join(names, ", "));
}

const EvaluationResult* BestEvaluation(const StudyResults& results) {
  if (!results.best || *results.best >= results.history.size()) return nullptr;
  return &results.history[*results.best];
}

std::vector<ResponseResult> TargetResponses(const StudyResults& results) {
  if (const EvaluationResult* best = BestEvaluation(results)) return best->responses;
  for (const EvaluationResult& evaluation : results.history) {
    if (evaluation.responses.empty()) continue;
    std::vector<ResponseResult> targets = evaluation.responses;
    for (ResponseResult& target : targets) {
      target.simulated.reset();
      target.seed_sd = 0;
      target.replicates = 0;
    }
    return targets;
  }
  return {};
}

Conclusion Conclude(const StudyResults& results) {
  Conclusion conclusion;
  if (!results.stop_reason.empty())
    conclusion.detail = "Stopped: " + WithFullStop(results.stop_reason);
  if (results.state == "interrupted") {
    conclusion.detail = "The study was interrupted and can be resumed. " + conclusion.detail;
  } else if (results.state == "running") {
    conclusion.detail = "The study is still running. " + conclusion.detail;
  }
  const EvaluationResult* best = BestEvaluation(results);
  if (best == nullptr) {
    conclusion.headline =
        results.total == 0 ? "Nothing was calibrated: no evaluation has ended yet."
        : results.partial > 0
            ? fmt::format("Nothing was calibrated: of {} none gave every response.",
                          CountText(results.total, "evaluation"))
            : fmt::format("Nothing was calibrated: {}.",
                          results.total == 1
                              ? std::string("the only evaluation failed")
                              : fmt::format("all {} evaluations failed", results.total));
    return conclusion;
  }
  std::vector<std::string> missed;
  bool tolerances = !best->responses.empty();
  for (const ResponseResult& response : best->responses) {
    const Fit fit = JudgeFit(response);
    tolerances = tolerances && fit.has_tolerance;
    if (!fit.within) missed.push_back(ResponseTitle(response, best->responses));
  }
  const std::string limit = tolerances ? "the tolerance" : "the accepted deviation";
  if (missed.empty()) {
    conclusion.kind = results.simulated ? Conclusion::Kind::fits : Conclusion::Kind::rehearsal;
    const std::string what =
        best->responses.size() == 1
            ? fmt::format("the {} comes", ResponseTitle(best->responses[0], best->responses))
            : fmt::format("all {} responses come", best->responses.size());
    conclusion.headline = fmt::format(
        "{}: {} out within {}.",
        results.simulated ? "Calibrated" : "Target reached, without simulating", what, limit);
    return conclusion;
  }
  conclusion.kind = Conclusion::Kind::misses;
  const std::string which =
      missed.size() > 3
          ? fmt::format("{} of {} responses are", missed.size(), best->responses.size())
          : Enumerated(missed) + (missed.size() == 1 ? " is" : " are");
  conclusion.headline =
      fmt::format("Not calibrated: {} outside {} at the best point.", which, limit);
  return conclusion;
}

bool FitsObjective(const StudyResults& results, const EvaluationResult& evaluation,
                   std::size_t objective) {
  return std::all_of(evaluation.responses.begin(), evaluation.responses.end(),
                     [&](const ResponseResult& response) {
                       return !BelongsTo(response, results.objectives[objective]) ||
                              JudgeFit(response).within;
                     });
}

int TargetCount(const StudyResults& results, std::size_t objective) {
  const std::vector<ResponseResult> targets = TargetResponses(results);
  return static_cast<int>(
      std::count_if(targets.begin(), targets.end(), [&](const ResponseResult& response) {
        return BelongsTo(response, results.objectives[objective]);
      }));
}

Compatibility JudgeCompatibility(const StudyResults& results) {
  const std::size_t count = results.objectives.size();
  if (count < 2 || results.pareto.empty()) return {};
  std::vector<std::string> names;
  for (const std::string& objective : results.objectives) names.push_back(ReadableName(objective));
  const EvaluationResult* together = nullptr;
  std::vector<bool> fitted(count, false);
  for (const EvaluationResult& evaluation : results.history) {
    bool all = true;
    for (std::size_t o = 0; o < count; ++o) {
      const bool fits = FitsObjective(results, evaluation, o);
      fitted[o] = fitted[o] || fits;
      all = all && fits;
    }
    if (all && (together == nullptr || TotalMisfit(evaluation) < TotalMisfit(*together))) {
      together = &evaluation;
    }
  }
  if (together != nullptr) {
    return {.together = true,
            .statement = fmt::format("{} can be fitted together: evaluation {} does.",
                                     Capitalised(Enumerated(names)), together->id)};
  }
  std::string statement;
  for (std::size_t o = 0; o < count; ++o) {
    if (fitted[o]) continue;
    statement += fmt::format(
        "{}No evaluation fits {}, even without regard to the rest: its lowest misfit is {} over "
        "{}.",
        statement.empty() ? "" : " ", names[o], NumberText(Misfit(BestOf(results, o), o), 3),
        CountText(TargetCount(results, o), "response"));
  }
  if (statement.empty()) {
    statement = fmt::format(
        "{} contradict each other as far as was searched: each is fitted by some evaluation, and "
        "none fits {}.",
        Capitalised(Enumerated(names)), count == 2 ? "both" : "all");
  }
  std::string detail;
  for (std::size_t o = 0; o < count; ++o) {
    detail += PriceOf(results, o, detail.empty() ? "" : " ");
  }
  return {false, statement, detail};
}

std::string NoSimulationNotice(const StudyResults& results) {
  if (results.simulated) return "";
  return fmt::format(
      "no simulation was run: the {} backend answered from known results, through a fitted "
      "surrogate. The figures show how the search behaves, not how the powder does.",
      results.backend);
}

std::vector<std::string> CohesionStatements(const StudyResults& results) {
  std::vector<PowderCohesion> readings;
  for (const ScalingTable& table : results.scaling_tables) {
    if (table.cohesion) readings.push_back(*table.cohesion);
  }
  std::vector<std::string> sentences;
  for (const std::string& text : Describe(readings)) sentences.push_back(Sentence(text));
  return sentences;
}

std::vector<std::string> Caveats(const StudyResults& results) {
  std::vector<std::string> caveats;
  if (!results.simulated) caveats.push_back(Sentence(NoSimulationNotice(results)));
  AddApproximationCaveats(results, caveats);
  const EvaluationResult* best = BestEvaluation(results);
  const Conclusion conclusion = Conclude(results);
  if (conclusion.kind == Conclusion::Kind::misses || conclusion.kind == Conclusion::Kind::nothing)
    caveats.push_back(conclusion.headline);
  if (results.state != "finished" && !results.state.empty()) {
    caveats.push_back(fmt::format("The study is {}: the result is provisional.", results.state));
  }
  if (best != nullptr) AddFitCaveats(results, *best, caveats);
  AddConfirmationCaveats(results, caveats);
  AddTransferCaveats(results, caveats);
  const Compatibility compatibility = JudgeCompatibility(results);
  if (!compatibility.together && !compatibility.statement.empty()) {
    caveats.push_back(compatibility.statement);
  }
  for (const ScalingTable& table : results.scaling_tables) {
    for (const GroupComparison& group : table.groups) {
      if (group.verdict != GroupComparison::Verdict::violated) continue;
      const std::string remark = !group.remark.empty() ? group.remark
                                 : group.ratio ? fmt::format("{} times the laboratory's value",
                                                             NumberText(*group.ratio, 3))
                                               : std::string("not the laboratory's value");
      caveats.push_back(fmt::format("{}, {}: {}", Capitalised(ReadableName(table.experiment)),
                                    SymbolText(group.symbol), WithFullStop(remark)));
    }
  }
  for (const std::string& warning : results.warnings) caveats.push_back(Sentence(warning));
  return caveats;
}

}  // namespace powdercal

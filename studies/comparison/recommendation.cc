#include <fmt/format.h>

#include <cmath>

#include "studies/comparison/comparison.h"

namespace powdercal::comparison {
namespace {

std::string Number(double value) {
  return std::isfinite(value) ? fmt::format("{:.3g}", value) : "none";
}

std::string Interval(const Quartiles& q) {
  return fmt::format("{} (quartiles {} to {})", Number(q.median), Number(q.lower), Number(q.upper));
}

const char* Measure(const Comparison& comparison) {
  return comparison.pareto ? "lost hypervolume" : "chi²";
}

// Whether the ranks are shown to differ at all.
bool Significant(const Comparison& comparison) {
  return std::isfinite(comparison.critical_difference) && comparison.friedman.f_p < kAlpha;
}

// The others, by whether the first is shown to be better.
struct Split {
  std::vector<std::string> equal;
  std::vector<std::string> worse;
};
Split Compared(const Comparison& comparison) {
  Split split;
  const double first = comparison.standings.front().mean_rank;
  for (std::size_t i = 1; i < comparison.standings.size(); ++i) {
    const Standing& other = comparison.standings[i];
    const bool equal = other.mean_rank - first < comparison.critical_difference;
    (equal ? split.equal : split.worse).push_back(other.contestant.label);
  }
  return split;
}

std::string LevelText(const Comparison& comparison) {
  if (comparison.pareto) return "a lost hypervolume of 0.1";
  if (comparison.level_is_fit) {
    return fmt::format("chi² = {} (every response one standard deviation off)",
                       Number(comparison.level));
  }
  return fmt::format("chi² = {} (twice the lowest that any contest came to)",
                     Number(comparison.level));
}

std::string Describe(const Comparison& comparison, const Standing& standing) {
  std::string text = fmt::format("With {}: {} {} after {} evaluations; ", standing.contestant.label,
                                 Measure(comparison), Interval(standing.final_value),
                                 comparison.setting.rules.evaluations);
  if (standing.reached == 0) {
    return text + fmt::format("never reached {}", LevelText(comparison));
  }
  text += fmt::format("reached {} in {} of {} seeds", LevelText(comparison), standing.reached,
                      comparison.seeds.size());
  if (std::isfinite(standing.to_level.median)) {
    text += fmt::format(", after {} evaluations in the median", Number(standing.to_level.median));
  }
  return text;
}

std::string Headline(const Comparison& comparison) {
  if (comparison.seeds.empty()) {
    return "Nothing can be said yet: no seed has been ended by all optimizers";
  }
  const std::string& first = comparison.standings.front().contestant.label;
  if (comparison.standings.size() == 1) return fmt::format("Only {} took part", first);
  if (!std::isfinite(comparison.critical_difference)) {
    return fmt::format("First came {}, in a single seed, which shows nothing", first);
  }
  if (!Significant(comparison)) {
    return fmt::format(
        "No optimizer is shown to be better than another on this study ({} came "
        "first)",
        first);
  }
  const Split split = Compared(comparison);
  if (split.worse.empty()) {
    return fmt::format("First came {}, but no single optimizer is shown to be worse", first);
  }
  if (split.equal.empty()) {
    return fmt::format("Use {}: it is shown to be better than all others", first);
  }
  if (split.equal.size() > split.worse.size()) {
    return fmt::format("First came {}; only {} shown to be worse: {}", first,
                       split.worse.size() == 1 ? "this is" : "these are", JoinNames(split.worse));
  }
  return fmt::format("Use {}; not shown to be worse: {}", first, JoinNames(split.equal));
}

void AddFriedman(const Comparison& comparison, std::vector<std::string>* statements) {
  if (!std::isfinite(comparison.critical_difference)) return;
  const FriedmanTest& test = comparison.friedman;
  statements->push_back(
      fmt::format("Ranks over {} seeds {}: Friedman chi² = {}, p = {}; Iman-Davenport F = {}, p = "
                  "{}. Mean ranks "
                  "that lie {} apart differ at the 5 % level (Nemenyi)",
                  test.blocks, Significant(comparison) ? "differ" : "are not shown to differ",
                  Number(test.chi_squared), Number(test.chi_squared_p),
                  std::isfinite(test.f) ? Number(test.f) : "infinite", Number(test.f_p),
                  Number(comparison.critical_difference)));
}

void AddCost(const Comparison& comparison, std::vector<std::string>* statements) {
  if (comparison.setting.source == Source::table) return;
  const Standing* cheapest = &comparison.standings.front();
  for (const Standing& standing : comparison.standings) {
    if (standing.mean_rank_by_cost < cheapest->mean_rank_by_cost) cheapest = &standing;
  }
  const bool same = cheapest == &comparison.standings.front();
  statements->push_back(same ? fmt::format("At {} core-seconds it comes first as well",
                                           Number(comparison.core_seconds))
                             : fmt::format("At {} core-seconds {} comes first, with {} {}",
                                           Number(comparison.core_seconds),
                                           cheapest->contestant.label, Measure(comparison),
                                           Interval(cheapest->within_core_seconds)));
}

void AddHoldOut(const Comparison& comparison, std::vector<std::string>* statements) {
  const Standing& first = comparison.standings.front();
  for (std::size_t i = 0; i < first.hold_out.size(); ++i) {
    statements->push_back(fmt::format(
        "The point that {} reports has chi² {} over {} fresh particle seeds at fidelity {}, where "
        "the search saw {}",
        first.contestant.label, Interval(first.hold_out[i]), comparison.setting.hold_out_seeds,
        comparison.hold_out_fidelities[i], Interval(first.fit)));
  }
}

std::vector<std::string> LimitsOf(const Comparison& comparison) {
  const Setting& setting = comparison.setting;
  std::vector<std::string> limits;
  switch (setting.source) {
    case Source::emulator:
      limits.push_back(fmt::format(
          "No simulation was run: the contests were held on an emulator of {}, {} simulations at "
          "{} "
          "points. It is smooth, and a Gaussian process; methods that assume smoothness, "
          "`bayesian` above all, are favoured. The scatter of its responses is normal, the same "
          "everywhere, and independent between responses",
          setting.source_text, setting.emulator_runs, setting.emulator_points));
      break;
    case Source::table:
      limits.push_back(
          "No simulation was run: the table backend answers, a smooth regression without scatter; "
          "each evaluation is said to cost the same");
      break;
    case Source::simulator:
      limits.push_back(
          "Evaluations are judged by what was observed, scatter included; the hold-out error is "
          "the one to trust");
      break;
  }
  if (!setting.noisy) {
    limits.push_back(
        "Without scatter, and where the initial design is the same for every seed, seeds change "
        "little but the optimizers' own chance: they are not independent problems");
  }
  limits.push_back(
      "All of it is one study: nothing is said of others. Differences of mean ranks below the "
      "critical difference are not findings");
  if (setting.seeds < 10) {
    limits.push_back(fmt::format("{} seeds show large differences only", setting.seeds));
  }
  for (const std::string& warning : setting.warnings) limits.push_back(warning);
  return limits;
}

}  // namespace

Recommendation Recommend(const Comparison& comparison) {
  Recommendation recommendation{.headline = Headline(comparison)};
  std::vector<std::string>& statements = recommendation.statements;
  recommendation.limits = LimitsOf(comparison);
  if (comparison.standings.empty()) return recommendation;
  statements.push_back(Describe(comparison, comparison.standings.front()));
  for (const Standing& standing : comparison.standings) {
    // The baseline that all others have to beat.
    if (&standing != &comparison.standings.front() && standing.contestant.label == "random") {
      statements.push_back(Describe(comparison, standing));
    }
  }
  AddFriedman(comparison, &statements);
  AddCost(comparison, &statements);
  AddHoldOut(comparison, &statements);
  for (const Standing& standing : comparison.standings) {
    if (standing.errors.empty()) continue;
    statements.push_back(fmt::format("In {} of {} contests {} broke off: {}",
                                     standing.errors.size(), comparison.seeds.size(),
                                     standing.contestant.label, standing.errors.front()));
  }
  return recommendation;
}

}  // namespace powdercal::comparison

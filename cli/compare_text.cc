#include "cli/compare_text.h"

#include <fmt/format.h>

#include <cmath>

#include "cli/text.h"
#include "reports/text.h"

namespace powdercal::cli {
namespace {

using namespace comparison;

std::string Number(double value) {
  return std::isfinite(value) ? fmt::format("{:.3g}", value) : "-";
}

std::string Text(const Quartiles& q) {
  return fmt::format("{} ({} to {})", Number(q.median), Number(q.lower), Number(q.upper));
}

std::string Table(const Comparison& comparison) {
  const bool costs = comparison.setting.source != Source::table;
  std::vector<std::string> head = {"optimizer", "mean rank",
                                   comparison.pareto ? "lost hypervolume" : "chi2 at the end",
                                   fmt::format("evaluations to {:.3g}", comparison.level)};
  if (costs) head.push_back(fmt::format("rank at {:.3g} core-s", comparison.core_seconds));
  for (const std::string& fidelity : comparison.hold_out_fidelities) {
    head.push_back(fmt::format("held out ({})", fidelity));
  }
  head.insert(head.end(), {"efficiency", "failed"});
  std::vector<std::vector<std::string>> rows = {head};
  for (const Standing& one : comparison.standings) {
    std::vector<std::string> row = {one.contestant.label, Number(one.mean_rank),
                                    Text(one.final_value),
                                    fmt::format("{} ({}/{} seeds)", Number(one.to_level.median),
                                                one.reached, comparison.seeds.size())};
    if (costs) row.push_back(Number(one.mean_rank_by_cost));
    for (const Quartiles& held_out : one.hold_out) row.push_back(Text(held_out));
    row.push_back(Number(one.parallel_efficiency.median));
    row.push_back(fmt::format("{:.0f} %", 100 * one.failed_share));
    rows.push_back(std::move(row));
  }
  return AlignedTable(rows);
}

}  // namespace

std::string ComparisonText(const Comparison& comparison) {
  const Setting& setting = comparison.setting;
  const Recommendation words = Recommend(comparison);
  std::string text =
      fmt::format("{}: {} optimizers, {} seeds, {} evaluations, {} at a time, on {}\n",
                  setting.study, comparison.standings.size(), comparison.seeds.size(),
                  setting.rules.evaluations, setting.rules.slots, setting.source_text);
  if (!comparison.standings.empty()) text += Table(comparison);
  text += Sentence(words.headline) + "\n";
  for (const std::string& statement : words.statements) {
    text += "  " + Sentence(statement) + "\n";
  }
  for (const std::string& limit : words.limits) text += "note: " + WithFullStop(limit) + "\n";
  for (const Refusal& one : comparison.refused) {
    text += fmt::format("left out: {}: {}\n", one.label, one.reason);
  }
  return text;
}

}  // namespace powdercal::cli

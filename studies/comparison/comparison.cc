#include "studies/comparison/comparison.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

namespace powdercal::comparison {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kTargetLevels = 41;

// Contests of each contestant, one for each seed that all have ended.
using Table = std::vector<std::vector<const ContestRecord*>>;

Table Tabulate(const Field& field, Comparison* comparison) {
  std::map<std::pair<std::string, int>, const ContestRecord*> known;
  for (const ContestRecord& record : comparison->contests) {
    known[{record.label, record.seed}] = &record;
  }
  Table table(field.contestants().size());
  for (int seed = 1; seed <= comparison->setting.seeds; ++seed) {
    const auto ended = [&](const Contestant& c) { return known.contains({c.label, seed}); };
    if (!std::all_of(field.contestants().begin(), field.contestants().end(), ended)) continue;
    comparison->seeds.push_back(seed);
    for (std::size_t c = 0; c < table.size(); ++c) {
      table[c].push_back(known.at({field.contestants()[c].label, seed}));
    }
  }
  return table;
}

std::vector<std::vector<Trajectory>> TrajectoriesOf(const Table& table,
                                                    const Comparison& comparison) {
  const FrontScale scale = comparison.pareto ? ScaleOfFront(comparison.contests) : FrontScale();
  std::vector<std::vector<Trajectory>> all;
  for (const auto& records : table) {
    auto& mine = all.emplace_back();
    for (const ContestRecord* record : records) {
      if (!comparison.pareto) {
        mine.push_back(ReportedChi2(*record));
      } else if (!scale.empty()) {
        mine.push_back(LostHypervolume(*record, scale));
      } else {
        mine.push_back({});
      }
    }
  }
  return all;
}

template <typename F>
std::vector<double> Collect(const std::vector<const ContestRecord*>& records, F value) {
  std::vector<double> values;
  for (const ContestRecord* record : records) values.push_back(value(*record));
  return values;
}

double EfficiencyOf(const ContestRecord& record, int slots) {
  return record.makespan > 0 ? record.busy_seconds / (slots * record.makespan) : kNone;
}

// Without those that are not known.
std::vector<double> Finite(std::vector<double> values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  return values;
}

void AddHoldOut(const std::vector<const ContestRecord*>& records,
                const std::vector<std::string>& fidelities, Standing* standing) {
  for (const std::string& fidelity : fidelities) {
    std::vector<double> values;
    for (const ContestRecord* record : records) {
      double chi2 = kInfinity;  // nothing was found, or the point fails with other seeds
      for (const HoldOut& one : record->hold_out) {
        if (one.fidelity == fidelity && !std::isnan(one.chi2)) chi2 = one.chi2;
      }
      values.push_back(chi2);
    }
    standing->hold_out.push_back(QuartilesOf(values));
  }
}

Standing StandingOf(const Contestant& contestant, const std::vector<const ContestRecord*>& records,
                    const std::vector<Trajectory>& trajectories, const Comparison& comparison) {
  const Setting& setting = comparison.setting;
  Standing standing{.contestant = contestant};
  std::vector<double> to_level, final_values, within;
  for (const Trajectory& trajectory : trajectories) {
    const int count = EvaluationsTo(trajectory, comparison.level);
    to_level.push_back(count == 0 ? kInfinity : count);
    standing.reached += count > 0 ? 1 : 0;
    final_values.push_back(ValueAfter(trajectory, setting.rules.evaluations));
    within.push_back(ValueWithin(trajectory, comparison.core_seconds));
  }
  standing.to_level = QuartilesOf(to_level);
  standing.final_value = QuartilesOf(final_values);
  standing.within_core_seconds = QuartilesOf(within);
  const auto count = [](const ContestRecord& r) { return static_cast<double>(r.steps.size()); };
  standing.evaluations = QuartilesOf(Collect(records, count));
  standing.core_seconds =
      QuartilesOf(Collect(records, [](const ContestRecord& r) { return r.core_seconds; }));
  standing.parallel_efficiency = QuartilesOf(Finite(Collect(
      records, [&](const ContestRecord& r) { return EfficiencyOf(r, setting.rules.slots); })));
  standing.fit =
      QuartilesOf(Finite(Collect(records, [](const ContestRecord& r) { return r.fit; })));
  double evaluations = 0, failed = 0, seconds = 0;
  for (const ContestRecord* record : records) {
    evaluations += count(*record);
    seconds += record->optimizer_seconds;
    for (const Step& step : record->steps) failed += step.failed ? 1 : 0;
    if (!record->error.empty()) standing.errors.push_back(record->error);
  }
  standing.failed_share = evaluations > 0 ? failed / evaluations : 0;
  standing.optimizer_seconds = evaluations > 0 ? seconds / evaluations : 0;
  AddHoldOut(records, comparison.hold_out_fidelities, &standing);
  standing.by_evaluations = BandByEvaluations(trajectories, setting.rules.evaluations);
  standing.share_of_targets =
      ShareOfTargets(trajectories, comparison.targets, setting.rules.evaluations);
  return standing;
}

// seeds × contestants; negligible values are equal.
Eigen::MatrixXd Values(const std::vector<std::vector<Trajectory>>& trajectories, double negligible,
                       const std::function<double(const Trajectory&)>& value) {
  const std::size_t seeds = trajectories.empty() ? 0 : trajectories.front().size();
  Eigen::MatrixXd values(static_cast<Eigen::Index>(seeds),
                         static_cast<Eigen::Index>(trajectories.size()));
  for (Eigen::Index s = 0; s < values.rows(); ++s) {
    for (Eigen::Index c = 0; c < values.cols(); ++c) {
      const auto& mine = trajectories[static_cast<std::size_t>(c)];
      values(s, c) = std::max(negligible, value(mine[static_cast<std::size_t>(s)]));
    }
  }
  return values;
}

void SetLevels(const std::vector<Trajectory>& all, Comparison* comparison) {
  const Setting& setting = comparison->setting;
  comparison->negligible = comparison->pareto ? 1e-3 : 1e-4 * setting.targets;
  comparison->targets = TargetLevels(all, comparison->negligible, kTargetLevels);
  if (comparison->pareto) {
    comparison->level = 0.1;
    return;
  }
  double lowest = kInfinity;
  for (const Trajectory& one : all) {
    for (const double value : one.values) lowest = std::min(lowest, value);
  }
  comparison->level_is_fit = !(lowest > setting.targets);
  comparison->level = comparison->level_is_fit ? setting.targets : 2 * lowest;
}

void SetCoreSeconds(const Table& table, Comparison* comparison) {
  const Rules& rules = comparison->setting.rules;
  if (std::isfinite(rules.core_seconds)) {
    comparison->core_seconds = rules.core_seconds;
    return;
  }
  double least = kInfinity;
  double most = 0;
  for (const auto& records : table) {
    for (const ContestRecord* record : records) {
      most = std::max(most, record->core_seconds);
      if (static_cast<int>(record->steps.size()) < rules.evaluations) continue;
      least = std::min(least, record->core_seconds);
    }
  }
  comparison->core_seconds = std::isfinite(least) ? least : most;
}

void SetFidelities(const Table& table, Comparison* comparison) {
  std::vector<std::string>& names = comparison->hold_out_fidelities;
  for (const auto& records : table) {
    for (const ContestRecord* record : records) {
      for (const HoldOut& one : record->hold_out) {
        if (std::find(names.begin(), names.end(), one.fidelity) == names.end()) {
          names.push_back(one.fidelity);
        }
      }
    }
  }
}

void Rank(const std::vector<std::vector<Trajectory>>& trajectories, Comparison* comparison) {
  const int evaluations = comparison->setting.rules.evaluations;
  const Eigen::MatrixXd values =
      Values(trajectories, comparison->negligible,
             [&](const Trajectory& one) { return ValueAfter(one, evaluations); });
  const Eigen::MatrixXd by_cost =
      Values(trajectories, comparison->negligible,
             [&](const Trajectory& one) { return ValueWithin(one, comparison->core_seconds); });
  const Eigen::VectorXd ranks = MeanRanks(values);
  const Eigen::VectorXd ranks_by_cost = MeanRanks(by_cost);
  for (std::size_t c = 0; c < comparison->standings.size(); ++c) {
    comparison->standings[c].mean_rank = ranks[static_cast<Eigen::Index>(c)];
    comparison->standings[c].mean_rank_by_cost = ranks_by_cost[static_cast<Eigen::Index>(c)];
  }
  comparison->friedman = TestFriedman(values);
  comparison->friedman_by_cost = TestFriedman(by_cost);
  if (values.rows() > 1 && values.cols() > 1) {
    comparison->critical_difference =
        NemenyiDifference(static_cast<int>(values.cols()), static_cast<int>(values.rows()), kAlpha);
  }
}

}  // namespace

Comparison Evaluate(Setting setting, const Field& field, std::vector<ContestRecord> records,
                    bool interrupted) {
  Comparison comparison{.setting = std::move(setting),
                        .interrupted = interrupted,
                        .refused = field.refused(),
                        .contests = std::move(records)};
  comparison.pareto = !comparison.setting.objectives.empty();
  const Table table = Tabulate(field, &comparison);
  if (comparison.seeds.empty()) return comparison;
  const auto trajectories = TrajectoriesOf(table, comparison);
  std::vector<Trajectory> all;
  for (const auto& mine : trajectories) all.insert(all.end(), mine.begin(), mine.end());
  SetLevels(all, &comparison);
  SetCoreSeconds(table, &comparison);
  SetFidelities(table, &comparison);
  double spent = 0;
  for (const auto& contests : table) {
    for (const ContestRecord* record : contests) spent = std::max(spent, record->core_seconds);
  }
  for (std::size_t c = 0; c < table.size(); ++c) {
    comparison.standings.push_back(
        StandingOf(field.contestants()[c], table[c], trajectories[c], comparison));
    comparison.standings.back().by_core_seconds = BandByCoreSeconds(trajectories[c], spent);
  }
  Rank(trajectories, &comparison);
  std::stable_sort(comparison.standings.begin(), comparison.standings.end(),
                   [](const Standing& a, const Standing& b) { return a.mean_rank < b.mean_rank; });
  return comparison;
}

}  // namespace powdercal::comparison

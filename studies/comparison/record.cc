#include "studies/comparison/record.h"

#include <algorithm>
#include <cmath>

#include "studies/ranking.h"

namespace powdercal::comparison {
namespace {

// In the order of telling, as far as the budget of core-seconds goes.
std::vector<const Contest::Evaluation*> Counted(const Contest& contest) {
  std::vector<const Contest::Evaluation*> counted;
  for (const int index : contest.told()) {
    const auto& evaluation = contest.evaluations()[static_cast<std::size_t>(index)];
    if (evaluation.core_seconds <= contest.rules().core_seconds) counted.push_back(&evaluation);
  }
  return counted;
}

std::vector<double> Judge(const Objectives& objectives, const Contest::Evaluation& evaluation,
                          const Eigen::VectorXd& pooled, const Truth& truth) {
  const int count = ObjectiveCount(objectives);
  std::vector<double> judged(static_cast<std::size_t>(count), kNone);
  if (!evaluation.responses.complete()) return judged;
  Eigen::VectorXd responses;
  if (truth) responses = truth(evaluation.candidate.point);
  for (int o = 0; o < count; ++o) {
    const int objective = count == 1 ? -1 : o;
    judged[static_cast<std::size_t>(o)] =
        truth ? ChiSquared(objectives, responses, {}, objective)
              : ExpectedMisfit(objectives, evaluation.responses, pooled, objective);
  }
  return judged;
}

// What a study would report after each evaluation. Ranking takes fits of Gaussian processes, which
// grow with the evaluations: in long searches it is only renewed every few of them.
class Ranking {
 public:
  Ranking(const SearchSpace& space, const Objectives& objectives)
      : space_(space), objectives_(objectives) {}

  void Add(const Contest::Evaluation& evaluation, bool last) {
    points_.push_back(evaluation.candidate.point);
    reduced_.push_back(evaluation.responses);
    const std::size_t count = points_.size();
    if (!last && reported_ >= 0 && count % (1 + count / kRenewals) != 0) return;
    const std::vector<double> misfits = RankingMisfits(space_, objectives_, points_, reduced_);
    const auto lowest = std::min_element(misfits.begin(), misfits.end());
    if (!std::isfinite(*lowest)) return;
    reported_ = static_cast<int>(lowest - misfits.begin());
    misfit_ = *lowest;
  }
  int reported() const { return reported_; }
  double misfit() const { return misfit_; }

 private:
  static constexpr std::size_t kRenewals = 40;

  const SearchSpace& space_;
  const Objectives& objectives_;
  std::vector<Eigen::VectorXd> points_;
  std::vector<ReducedResponses> reduced_;
  int reported_ = -1;
  double misfit_ = kNone;
};

}  // namespace

ContestRecord Summarise(const Contest& contest, const SearchSpace& space, const Truth& truth) {
  const Objectives& objectives = contest.objectives();
  const std::vector<const Contest::Evaluation*> counted = Counted(contest);
  std::vector<ReducedResponses> reduced;
  for (const auto* evaluation : counted) reduced.push_back(evaluation->responses);
  const Eigen::VectorXd pooled =
      PooledSeedVariance(reduced, static_cast<int>(objectives.targets.size()));

  ContestRecord record{.end = contest.end(),
                       .core_seconds = contest.core_seconds(),
                       .busy_seconds = contest.busy_seconds(),
                       .makespan = contest.now()};
  Ranking ranking(space, objectives);
  for (std::size_t i = 0; i < counted.size(); ++i) {
    const Contest::Evaluation& evaluation = *counted[i];
    ranking.Add(evaluation, i + 1 == counted.size());
    record.steps.push_back({.judged = Judge(objectives, evaluation, pooled, truth),
                            .reported = ranking.reported(),
                            .core_seconds = evaluation.core_seconds,
                            .told_at = evaluation.told_at,
                            .failed = !evaluation.responses.complete()});
  }
  if (ranking.reported() < 0) return record;
  record.fit = ranking.misfit();
  const Eigen::VectorXd values = space.FromUnit(ReportedPoint(contest, record));
  record.parameters.assign(values.begin(), values.end());
  return record;
}

Eigen::VectorXd ReportedPoint(const Contest& contest, const ContestRecord& record) {
  if (record.steps.empty() || record.steps.back().reported < 0) return {};
  return Counted(contest)[static_cast<std::size_t>(record.steps.back().reported)]->candidate.point;
}

}  // namespace powdercal::comparison

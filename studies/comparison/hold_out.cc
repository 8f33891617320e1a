#include "studies/comparison/hold_out.h"

#include <algorithm>

namespace powdercal::comparison {

RandomStream WorldOf(const Study& study, int seed) {
  return RandomStream(study.seed).Split("comparison").Split(static_cast<std::uint64_t>(seed));
}

double HoldOutChi2(const Objectives& objectives, const std::vector<LedgerRun>& runs) {
  std::vector<const LedgerRun*> pointers;
  for (const LedgerRun& run : runs) pointers.push_back(&run);
  const ReducedResponses reduced = Reduce(objectives, pointers);
  return reduced.complete() ? ChiSquared(objectives, reduced.means, {}) : kNone;
}

HoldOut HoldOutOnOracle(const Study& study, const Oracle& oracle, const Eigen::VectorXd& point,
                        int seeds, const RandomStream& world) {
  std::vector<LedgerRun> runs;
  for (int s = 0; s < seeds; ++s) {
    for (const std::size_t i : study.CalibratedExperiments()) {
      runs.push_back(oracle.Simulate(i, point, kFirstHoldOut + s, world));
    }
  }
  return {.fidelity = FidelityText(study),
          .seeds = seeds,
          .chi2 = HoldOutChi2(study.MakeObjectives(), runs)};
}

void Sign(const Task& task, double optimizer_seconds, ContestRecord* record) {
  record->label = task.contestant->label;
  record->seed = task.seed;
  record->key = task.key;
  record->optimizer_seconds = optimizer_seconds;
  if (!record->error.empty()) record->end = "the optimizer broke off: " + record->error;
}

std::string FidelityText(const Study& study) {
  std::vector<std::string> names;
  for (const std::size_t i : study.CalibratedExperiments()) {
    const std::string& name = ToString(study.FidelityOf(i));
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return JoinNames(names);
}

std::unique_ptr<Study> RaisedFidelity(Study& study) {
  auto raised =
      std::make_unique<Study>(Study::Parse(study.ToYaml(), study.file, study.base_folder));
  const auto highest = static_cast<std::size_t>(FidelityNames().size() - 1);
  bool any = false;
  for (const std::size_t i : study.CalibratedExperiments()) {
    const auto fidelity = static_cast<std::size_t>(study.FidelityOf(i));
    any = any || fidelity < highest;
    raised->experiments[i].fidelity = static_cast<Fidelity>(std::min(fidelity + 1, highest));
  }
  return any ? std::move(raised) : nullptr;
}

}  // namespace powdercal::comparison

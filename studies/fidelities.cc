#include "studies/fidelities.h"

#include <algorithm>

namespace powdercal {
namespace {

// [particle-steps] of one replicate
double WorkOf(const Planner& planner) {
  double work = 0;
  for (const std::size_t i : planner.study().CalibratedExperiments()) {
    const Planner::ExperimentCost cost = planner.CostOf(i, 1);
    work += cost.steps * cost.particles;
  }
  return work;
}

}  // namespace

StudyFidelities::StudyFidelities(const Study& study, const Planner& target) : target_(target) {
  const std::vector<double> coordinates = LowerFidelityCoordinates(study);
  if (coordinates.empty()) return;
  const double whole = WorkOf(target);
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    lower_.push_back(std::make_unique<Planner>(study, study.backend.lower_fidelities[i]));
    // Without a plan there is nothing to run, either.
    const double cost = whole > 0 ? WorkOf(*lower_.back()) / whole : coordinates[i];
    levels_.push_back({coordinates[i], cost});
  }
  levels_.push_back({1, 1});
}

std::size_t StudyFidelities::IndexOf(double s) const {
  const auto found = std::find_if(levels_.begin(), levels_.end(),
                                  [s](const FidelityLevel& level) { return level.fidelity == s; });
  return found == levels_.end() ? lower_.size() : static_cast<std::size_t>(found - levels_.begin());
}

const Planner& StudyFidelities::PlannerAt(double s) const {
  const std::size_t index = IndexOf(s);
  return index < lower_.size() ? *lower_[index] : target_;
}

double StudyFidelities::CostAt(double s) const {
  const std::size_t index = IndexOf(s);
  return index < lower_.size() ? levels_[index].cost : 1;
}

std::vector<double> LowerFidelityCoordinates(const Study& study) {
  const std::size_t count = study.backend.lower_fidelities.size();
  std::vector<double> coordinates;
  for (std::size_t i = 0; i < count; ++i) {
    coordinates.push_back(static_cast<double>(i + 1) / static_cast<double>(count + 1));
  }
  return coordinates;
}

const std::string& FidelityNameAt(const Study& study, double s) {
  const std::vector<double> coordinates = LowerFidelityCoordinates(study);
  const auto found = std::find(coordinates.begin(), coordinates.end(), s);
  const Fidelity fidelity =
      found == coordinates.end()
          ? study.backend.fidelity
          : study.backend.lower_fidelities[static_cast<std::size_t>(found - coordinates.begin())];
  return ToString(fidelity);
}

}  // namespace powdercal

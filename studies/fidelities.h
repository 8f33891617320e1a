#pragma once

#include <memory>
#include <string>
#include <vector>

#include "optimizers/optimizer.h"
#include "studies/planner.h"
#include "studies/study.h"

namespace powdercal {

/// The fidelities between which a study's optimizer chooses (`backend.lower_fidelities` and the
/// study's own), as it sees them: one of n stands at s = 1/n, 2/n, …, 1. Their order is all that a
/// process with a lengthscale of its own over s needs; distances it learns. Costs are what one
/// replicate of all calibrated experiments takes, steps times particles at the centre of the box,
/// over the same at the study's own fidelity.
class StudyFidelities {
 public:
  /// `target`: of the study at its own fidelity; both must outlive this.
  StudyFidelities(const Study& study, const Planner& target);

  /// Whether there is a choice.
  bool several() const { return !lower_.empty(); }
  /// Ascending, the last the study's own, at a cost of 1; empty where there is no choice.
  const std::vector<FidelityLevel>& levels() const { return levels_; }
  /// Plans the runs of a candidate that was asked for at s, one of levels() or 1.
  const Planner& PlannerAt(double s) const;
  double CostAt(double s) const;

 private:
  std::size_t IndexOf(double s) const;

  const Planner& target_;
  std::vector<std::unique_ptr<Planner>> lower_;
  std::vector<FidelityLevel> levels_;
};

/// s of each of a study's lower fidelities, ascending.
std::vector<double> LowerFidelityCoordinates(const Study& study);
/// Of one of them, or of 1: "quick".
const std::string& FidelityNameAt(const Study& study, double s);

}  // namespace powdercal

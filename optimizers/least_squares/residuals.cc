#include "optimizers/least_squares/residuals.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "core/statistics.h"

namespace powdercal {

std::string ExplainNoLeastSquares(std::string_view optimizer, const SearchSpace& space,
                                  const Objectives& objectives) {
  if (space.dimension() == 0) return "there is no parameter to search";
  if (objectives.targets.empty()) return "there is no observed response to match";
  for (const Parameter& parameter : space.parameters) {
    if (parameter.levels() == 0) continue;
    return fmt::format(
        "'{}' has {} values, and {} needs the derivative by every parameter; use random or a "
        "design",
        parameter.name, parameter.levels(), optimizer);
  }
  std::set<int> numbers;
  for (const Target& target : objectives.targets) {
    if (target.minimise) {
      return fmt::format(
          "'{}' is to be as low as possible, and {} matches targets with squared residuals; give "
          "it "
          "an observed value, or use random or a design",
          target.response, optimizer);
    }
    numbers.insert(target.objective);
  }
  if (objectives.kind == Objectives::Kind::pareto && numbers.size() > 1) {
    return fmt::format(
        "{} minimises one sum of squares and the study has several objectives; use bayesian, or "
        "`objective: joint`",
        optimizer);
  }
  return "";
}

Residuals::Residuals(const Objectives& objectives, const ObservationsById& observations) {
  const auto count = static_cast<Eigen::Index>(objectives.targets.size());
  targets.resize(count);
  scales.resize(count);
  noise.resize(count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const Target& target = objectives.targets[static_cast<std::size_t>(j)];
    std::vector<double> variances;
    for (const auto& [id, observation] : observations) {
      if (!observation.failed && !std::isnan(observation.responses[j])) {
        variances.push_back(observation.variances[j]);
      }
    }
    const double variance = variances.empty() ? 0 : Median(std::move(variances));
    active.push_back(j);
    targets[j] = target.value;
    scales[j] = std::sqrt(target.sd * target.sd + variance);
    noise[j] = std::sqrt(variance) / scales[j];
  }
}

void Residuals::Restrict(const Observation& observation) {
  std::vector<Eigen::Index> kept;
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < active.size(); ++i) {
    if (std::isnan(observation.responses[active[i]])) continue;
    kept.push_back(active[i]);
    rows.push_back(static_cast<Eigen::Index>(i));
  }
  active = kept;
  targets = Eigen::VectorXd(targets(rows));
  scales = Eigen::VectorXd(scales(rows));
  noise = Eigen::VectorXd(noise(rows));
}

bool Residuals::Complete(const Observation& observation) const {
  return !observation.failed && observation.responses(active).allFinite();
}

Eigen::VectorXd Residuals::Of(const Observation& observation) const {
  return (observation.responses(active) - targets).cwiseQuotient(scales);
}

}  // namespace powdercal

#include "optimizers/optimizer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "core/errors.h"
#include "optimizers/bayesian/bayesian.h"
#include "optimizers/designs/design_optimizer.h"
#include "optimizers/least_squares/least_squares.h"
#include "optimizers/least_squares/surrogate_lm.h"
#include "optimizers/metaheuristics/metaheuristic.h"
#include "optimizers/random_search.h"

namespace powdercal {
namespace {

using Maker = std::unique_ptr<OptimizerFactory> (*)(const std::string& name);

struct Entry {
  const char* name;
  Maker make;
};

constexpr std::array<Entry, 18> kOptimizers = {{
    {"ant_colony", MakeMetaheuristicFactory},
    {"bayesian", [](const std::string&) { return MakeBayesianFactory(); }},
    {"cma_es", MakeMetaheuristicFactory},
    {"corners_and_centre", MakeDesignFactory},
    {"differential_evolution", MakeMetaheuristicFactory},
    {"genetic", MakeMetaheuristicFactory},
    {"grid", MakeDesignFactory},
    {"latin_hypercube", MakeDesignFactory},
    {"least_squares", [](const std::string&) { return MakeLeastSquaresFactory(); }},
    {"list", MakeDesignFactory},
    {"moead", MakeMetaheuristicFactory},
    {"nsga2", MakeMetaheuristicFactory},
    {"nspso", MakeMetaheuristicFactory},
    {"orthogonal_array", MakeDesignFactory},
    {"particle_swarm", MakeMetaheuristicFactory},
    {"random", [](const std::string&) { return MakeRandomSearchFactory(); }},
    {"sobol", MakeDesignFactory},
    {"surrogate_lm", [](const std::string&) { return MakeSurrogateLmFactory(); }},
}};

// SI value at u in [0, 1], and back.
double ValueAt(const Parameter& parameter, double u) {
  if (const int levels = parameter.levels(); levels > 0) {
    return parameter.lower + std::min(std::floor(u * levels), levels - 1.0);
  }
  // The ends exactly, whatever rounding does.
  if (u == 1) return parameter.upper;
  const double value = parameter.logarithmic
                           ? parameter.lower * std::pow(parameter.upper / parameter.lower, u)
                           : parameter.lower + u * (parameter.upper - parameter.lower);
  return std::clamp(value, parameter.lower, parameter.upper);
}

double CoordinateOf(const Parameter& parameter, double value) {
  if (const int levels = parameter.levels(); levels > 0) {
    return (std::round(value - parameter.lower) + 0.5) / levels;
  }
  if (value == parameter.upper) return 1;
  const double u =
      parameter.logarithmic
          ? std::log(value / parameter.lower) / std::log(parameter.upper / parameter.lower)
          : (value - parameter.lower) / (parameter.upper - parameter.lower);
  return std::clamp(u, 0.0, 1.0);
}

}  // namespace

const std::string& Parameter::CategoryAt(double index) const {
  const double last = static_cast<double>(categories.size()) - 1;
  return categories.at(static_cast<std::size_t>(std::clamp(std::round(index), 0.0, last)));
}

int Parameter::levels() const {
  return kind == Kind::continuous ? 0 : static_cast<int>(std::lround(upper - lower)) + 1;
}

bool SearchSpace::discrete() const {
  return std::any_of(parameters.begin(), parameters.end(),
                     [](const Parameter& parameter) { return parameter.levels() > 0; });
}

Eigen::VectorXd SearchSpace::FromUnit(const Eigen::VectorXd& point) const {
  if (point.size() != dimension()) throw std::invalid_argument("FromUnit: wrong dimension");
  Eigen::VectorXd values(point.size());
  for (Eigen::Index i = 0; i < point.size(); ++i) {
    values[i] = ValueAt(parameters[static_cast<std::size_t>(i)], std::clamp(point[i], 0.0, 1.0));
  }
  return values;
}

Eigen::VectorXd SearchSpace::ToUnit(const Eigen::VectorXd& values) const {
  if (values.size() != dimension()) throw std::invalid_argument("ToUnit: wrong dimension");
  Eigen::VectorXd point(values.size());
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const Parameter& parameter = parameters[static_cast<std::size_t>(i)];
    point[i] = CoordinateOf(parameter, std::clamp(values[i], parameter.lower, parameter.upper));
  }
  return point;
}

Eigen::VectorXd SearchSpace::Snap(const Eigen::VectorXd& point) const {
  if (point.size() != dimension()) throw std::invalid_argument("Snap: wrong dimension");
  Eigen::VectorXd snapped = point.cwiseMax(0).cwiseMin(1);
  for (Eigen::Index i = 0; i < point.size(); ++i) {
    const Parameter& parameter = parameters[static_cast<std::size_t>(i)];
    if (parameter.levels() == 0) continue;
    snapped[i] = CoordinateOf(parameter, ValueAt(parameter, snapped[i]));
  }
  return snapped;
}

std::span<const std::string> OptimizerNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const Entry& entry : kOptimizers) result.emplace_back(entry.name);
    return result;
  }();
  return names;
}

std::unique_ptr<OptimizerFactory> MakeOptimizerFactory(const std::string& name) {
  for (const Entry& entry : kOptimizers) {
    if (name == entry.name) return entry.make(name);
  }
  throw UnknownName("optimizer", name, OptimizerNames());
}

int ObjectiveCount(const Objectives& objectives) {
  if (objectives.kind == Objectives::Kind::joint) return 1;
  int count = 1;
  for (const Target& target : objectives.targets) count = std::max(count, target.objective + 1);
  return count;
}

Objectives Numbered(Objectives objectives) {
  std::map<int, int> numbers;
  for (Target& target : objectives.targets) {
    if (objectives.kind == Objectives::Kind::joint) target.objective = 0;
    numbers.emplace(target.objective, 0);
  }
  int next = 0;
  for (auto& [objective, number] : numbers) number = next++;
  for (Target& target : objectives.targets) target.objective = numbers.at(target.objective);
  return objectives;
}

double ChiSquared(const Objectives& objectives, const Eigen::VectorXd& responses,
                  const Eigen::VectorXd& variances, int objective) {
  const std::vector<Target>& targets = objectives.targets;
  const auto count = static_cast<Eigen::Index>(targets.size());
  if (responses.size() != count || (variances.size() != 0 && variances.size() != count)) {
    throw std::invalid_argument("ChiSquared: wrong number of responses or variances");
  }
  double sum = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Target& target = targets[static_cast<std::size_t>(i)];
    if (objective >= 0 && target.objective != objective) continue;
    if (std::isnan(responses[i])) continue;
    if (target.minimise) {
      sum += (responses[i] - target.value) / target.sd;
      continue;
    }
    double variance = target.sd * target.sd;
    if (variances.size() != 0 && variances[i] > 0) variance += variances[i];  // NaN: unknown
    const double residual = responses[i] - target.value;
    sum += residual * residual / variance;
  }
  return sum;
}

}  // namespace powdercal

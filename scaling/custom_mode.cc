#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "core/quantity.h"
#include "scaling/groups.h"
#include "scaling/log_linear.h"
#include "scaling/modes.h"

namespace powdercal {
namespace {

// What may change besides Young's modulus, which the study states.
const std::vector<std::string>& Quantities() {
  static const std::vector<std::string> names = {"cohesion", "gravity", "shear_rate", "stress",
                                                 "velocity"};
  return names;
}

struct Match {
  std::string symbol;
  double weight = 1;
  double tolerance = kMatchFactor;  // factor
  std::optional<double> value;      // the simulation's; empty: the experiment's
};

std::string Factor(double logarithm) { return fmt::format("{:.3g}", std::exp(logarithm)); }

class CustomScaling final : public SofteningScaling {
 public:
  const std::string& name() const override {
    static const std::string kName = "custom";
    return kName;
  }

  std::string Describe() const override {
    std::vector<std::string> symbols;
    for (const Match& match : matches_) symbols.push_back(match.symbol);
    return fmt::format("matches {}{} by {}", symbols.empty() ? "no group" : JoinNames(symbols),
                       young_modulus_ ? " at E = " + HumanQuantity(*young_modulus_, "Pa") : "",
                       keep_.size() == Quantities().size()
                           ? std::string("nothing else: all is kept")
                           : "changing " + fmt::format("{}", fmt::join(Free(), ", ")));
  }

  void Serialize(Archive& archive) override {
    SofteningScaling::Serialize(archive);
    archive.Names("keep", keep_, "quantity", Quantities());
    archive.Require("groups");
    std::vector<std::string> keys;
    for (const Match& match : matches_) keys.push_back(match.symbol);
    std::size_t index = 0;
    archive.Map(
        "groups", keys,
        [&](const std::string& symbol, Archive& section) {
          if (section.reading()) AddMatch(symbol, section);
          Match& match = matches_[index++];
          section.Quantity("weight", match.weight, "1", kPositive);
          section.Quantity("tolerance", match.tolerance, "1", {.lower = 1, .lower_open = true});
          section.Quantity("value", match.value, "1", kPositive);
        },
        "weight");
    if (archive.reading() && matches_.empty()) {
      throw archive.ErrorAt("groups", "mode 'custom' needs a group to match");
    }
  }

  std::string ExplainUnsupported(const Conditions& experiment) const override {
    std::string reason = SofteningScaling::ExplainUnsupported(experiment);
    if (!reason.empty()) return reason;
    const Problem problem = Formulate(experiment);
    const LogLinearSolution solution = SolveLogLinear(problem.equations);
    return solution.within ? "" : ExplainConflict(problem, solution);
  }

  std::string ExplainWithoutEffect(std::span<const Conditions> experiments) const override {
    for (const Match& match : matches_) {
      const bool known = std::any_of(
          experiments.begin(), experiments.end(),
          [&](const Conditions& experiment) { return Reference(match, experiment).has_value(); });
      if (known) continue;
      return fmt::format(
          "no experiment of the study has the group '{}', which is to be matched: {}", match.symbol,
          WhatItNeeds(match.symbol));
    }
    return "";
  }

  bool scales_cohesion() const override { return true; }

  Conditions ToSimulation(const Conditions& experiment) const override {
    assert(ExplainUnsupported(experiment).empty());
    const Problem problem = Formulate(experiment);
    return Apply(experiment, problem.free, SolveLogLinear(problem.equations).x);
  }

 private:
  // The groups that this experiment has, as equations for the free quantities that it has.
  struct Problem {
    std::vector<std::string> free;
    std::vector<Match> matches;
    LogLinearProblem equations;
  };

  void AddMatch(const std::string& symbol, const Archive& section) {
    const auto known = MatchableGroups();
    if (std::find(known.begin(), known.end(), symbol) == known.end()) {
      throw UnknownName("group", symbol, known, {.location = section.LocationOf("")});
    }
    matches_.push_back({.symbol = symbol});
  }

  std::vector<std::string> Free() const {
    std::vector<std::string> free;
    for (const std::string& quantity : Quantities()) {
      if (std::find(keep_.begin(), keep_.end(), quantity) == keep_.end()) free.push_back(quantity);
    }
    return free;
  }

  static std::optional<double> Reference(const Match& match, const Conditions& experiment) {
    const std::optional<double> own = EvaluateGroup(match.symbol, experiment);
    return own && match.value ? match.value : own;
  }

  static std::string WhatItNeeds(const std::string& symbol) {
    const bool cohesive = symbol == "F_c/(sigma d^2)" || symbol == "Bo" || symbol == "W/(m g d)" ||
                          symbol == "delta_0/d";
    return cohesive ? "it needs the powder's surface energy (material.surface_energy) and, where "
                      "it holds a stress or gravity, a test that has them"
                    : "it needs a test that has all of its quantities";
  }

  // The experiment's conditions with the free quantities changed by exp(x).
  Conditions Apply(const Conditions& experiment, const std::vector<std::string>& free,
                   const Eigen::VectorXd& x) const {
    Conditions simulation = experiment;
    simulation.young_modulus = young_modulus_;
    double cohesion = 1;
    for (std::size_t i = 0; i < free.size(); ++i) {
      const double factor = std::exp(x[static_cast<Eigen::Index>(i)]);
      if (free[i] == "cohesion") cohesion = factor;
      if (free[i] == "gravity") *simulation.gravity *= factor;
      if (free[i] == "shear_rate") *simulation.shear_rate *= factor;
      if (free[i] == "stress") *simulation.stress *= factor;
      if (free[i] == "velocity") *simulation.velocity *= factor;
    }
    if (experiment.velocity) {
      simulation.speed_ratio = *simulation.velocity / *experiment.velocity;
    } else if (experiment.gravity) {
      simulation.speed_ratio = std::sqrt(*simulation.gravity / *experiment.gravity);
    }
    KeepCohesion(experiment, cohesion, &simulation);
    return simulation;
  }

  Problem Formulate(const Conditions& experiment) const {
    Problem problem;
    const auto has = [&](const std::string& quantity) {
      if (quantity == "cohesion") return experiment.surface_energy.value_or(0) > 0;
      if (quantity == "gravity") return experiment.gravity.value_or(0) > 0;
      if (quantity == "shear_rate") return experiment.shear_rate.has_value();
      if (quantity == "stress") return experiment.stress.has_value();
      return experiment.velocity.has_value();
    };
    for (const std::string& quantity : Free()) {
      if (has(quantity)) problem.free.push_back(quantity);
    }
    const auto columns = static_cast<Eigen::Index>(problem.free.size());
    const Conditions start = Apply(experiment, problem.free, Eigen::VectorXd::Zero(columns));
    for (const Match& match : matches_) {
      const auto reference = Reference(match, experiment);
      const auto value = EvaluateGroup(match.symbol, start);
      if (reference && value && *reference > 0 && *value > 0) problem.matches.push_back(match);
    }
    const auto rows = static_cast<Eigen::Index>(problem.matches.size());
    LogLinearProblem& equations = problem.equations;
    equations = {.coefficients = Eigen::MatrixXd::Zero(rows, columns),
                 .target = Eigen::VectorXd::Zero(rows),
                 .weight = Eigen::VectorXd::Zero(rows),
                 .tolerance = Eigen::VectorXd::Zero(rows)};
    for (Eigen::Index j = 0; j < rows; ++j) {
      const Match& match = problem.matches[static_cast<std::size_t>(j)];
      const double at_start = *EvaluateGroup(match.symbol, start);
      equations.target[j] = std::log(*Reference(match, experiment) / at_start);
      equations.weight[j] = match.weight;
      equations.tolerance[j] = std::log(match.tolerance);
      for (Eigen::Index i = 0; i < columns; ++i) {
        // Groups are products of powers: the exponent is the change for a factor of e.
        const Conditions moved = Apply(experiment, problem.free, Eigen::VectorXd::Unit(columns, i));
        equations.coefficients(j, i) = std::log(*EvaluateGroup(match.symbol, moved) / at_start);
      }
    }
    return problem;
  }

  std::string ExplainConflict(const Problem& problem, const LogLinearSolution& solution) const {
    std::vector<std::string> conflict;
    for (const int j : solution.conflict) {
      const Match& match = problem.matches[static_cast<std::size_t>(j)];
      conflict.push_back(fmt::format("{} (off {} times, {:.4g} allowed)", match.symbol,
                                     Factor(std::abs(solution.residual[j])), match.tolerance));
    }
    return fmt::format(
        "these groups cannot be matched together by changing {}: {}. Those are the smallest misses "
        "that can be had; raise a tolerance, leave a group out, or keep less as it is",
        problem.free.empty() ? "nothing" : fmt::format("{}", fmt::join(problem.free, ", ")),
        fmt::join(conflict, ", "));
  }

  std::vector<std::string> keep_;
  std::vector<Match> matches_;
};

}  // namespace

std::unique_ptr<Scaling> MakeCustomScaling() { return std::make_unique<CustomScaling>(); }

}  // namespace powdercal

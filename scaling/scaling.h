#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/archive.h"
#include "scaling/conditions.h"

namespace powdercal {

/// A similarity mode: turns the laboratory's conditions into the simulation's. docs/scaling.md has
/// the mathematics of each.
///
///   none          simulation = experiment.
///   given         the study states what differs; all else stays. Options, all optional, at least
///                 one: young_modulus, gravity; stress (the same for every experiment that applies
///                 one) or stress_ratio (simulation/experiment, for studies with several
///                 stresses), not both; velocity and shear_rate (used where an experiment has one).
///   sigma_over_e  option young_modulus, required; the stress, where there is one, follows from
///                 sigma1/E1 = sigma0/E0 (the seed paper, Eq. 3–5). Gravity, cohesion and speeds
///                 are not scaled.
///   exact         option young_modulus, required; with f = E1/E0, stress, gravity and cohesion are
///                 multiplied by f, speeds by the root of f. Keeps every group.
///   rigid_limit   option kappa, the floor of the stiffness number under the study's largest
///                 stress; Young's modulus falls to it. Keeps stress, gravity, speeds and the
///                 pull-off force.
///   custom        options young_modulus and groups, required, and keep: weighted least squares in
///                 logarithms for stress, gravity, cohesion and speeds (but what `keep` names), so
///                 that the groups are matched within their tolerances.
///
/// none, given and sigma_over_e carry the powder's cohesion and rolling friction over unchanged;
/// whoever knows the simulation's contact law then puts in the values that it runs with. The other
/// modes give the simulation a cohesion of its own where the powder's surface energy is known:
/// experiment.law_of_cohesion says in what terms.
class Scaling {
 public:
  virtual ~Scaling() = default;

  virtual const std::string& name() const = 0;
  /// One line on what the mode, with its options, keeps and what it gives up.
  virtual std::string Describe() const = 0;

  /// Reads or writes the mode's own options. Throws InputError for missing or contradictory ones.
  virtual void Serialize(Archive& archive) = 0;

  /// "" if the mode can treat these conditions, else what is missing or contradictory.
  virtual std::string ExplainUnsupported(const Conditions& experiment) const = 0;

  /// "" if every option acts on at least one of a study's experiments, else which does not.
  virtual std::string ExplainWithoutEffect(std::span<const Conditions> /*experiments*/) const {
    return "";
  }

  /// Whether ToSimulation() gives the simulation the cohesion that keeps the powder's pull-off
  /// force in proportion; it is what runs where the study neither frees nor states one.
  virtual bool scales_cohesion() const { return false; }

  /// The simulation's conditions. Requires ExplainUnsupported(experiment) == "".
  virtual Conditions ToSimulation(const Conditions& experiment) const = 0;
};

/// Names of all modes, sorted: custom, exact, given, none, rigid_limit, sigma_over_e.
std::span<const std::string> ScalingNames();
/// Throws InputError for an unknown name.
std::unique_ptr<Scaling> MakeScaling(const std::string& name);

/// Reads or writes the study's `scaling` section: {mode: name, …options of the mode}, or `scaling:
/// name` for a mode without options. Without the section a null `scaling` becomes `none`.
void SerializeScaling(Archive& archive, std::unique_ptr<Scaling>& scaling);

}  // namespace powdercal

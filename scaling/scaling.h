#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/archive.h"
#include "scaling/conditions.h"

namespace powdercal {

/// A similarity mode: turns the laboratory's conditions into the simulation's.
///
///   none          simulation = experiment.
///   given         the study states what differs; all else stays. Options, all optional, at least
///   one:
///                 young_modulus, gravity; stress (the same for every experiment that applies one)
///                 or stress_ratio (simulation/experiment, for studies with several stresses), not
///                 both; velocity and shear_rate (used where an experiment has one).
///   sigma_over_e  option young_modulus, required; the stress, where there is one, follows from
///                 sigma1/E1 = sigma0/E0 (the seed paper, Eq. 3–5). Gravity, cohesion and speeds
///                 are not scaled.
///
/// The three modes carry the powder's cohesion and rolling friction over unchanged; whoever knows
/// the simulation's contact law then puts in the values that it runs with.
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

  /// The simulation's conditions. Requires ExplainUnsupported(experiment) == "".
  virtual Conditions ToSimulation(const Conditions& experiment) const = 0;
};

/// Names of all modes, sorted: given, none, sigma_over_e.
std::span<const std::string> ScalingNames();
/// Throws InputError for an unknown name.
std::unique_ptr<Scaling> MakeScaling(const std::string& name);

/// Reads or writes the study's `scaling` section: {mode: name, …options of the mode}, or `scaling:
/// name` for a mode without options. Without the section a null `scaling` becomes `none`.
void SerializeScaling(Archive& archive, std::unique_ptr<Scaling>& scaling);

}  // namespace powdercal

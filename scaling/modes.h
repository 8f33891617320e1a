#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "scaling/scaling.h"

namespace powdercal {

// The modes that scaling.cc does not hold itself, and what they share.

std::unique_ptr<Scaling> MakeCustomScaling();
std::unique_ptr<Scaling> MakeExactScaling();
std::unique_ptr<Scaling> MakeRigidLimitScaling();
std::unique_ptr<Scaling> MakeSigmaOverEScaling();

/// "" or why the simulation's Young's modulus [Pa] is not possible: a particle is softened to save
/// time steps; one that is stiffer than the powder's is a slip.
std::string ExplainModulus(double simulation, const std::optional<double>& powder);

/// Whether any of them applies a stress.
bool AnyStress(std::span<const Conditions> experiments);

/// A mode that lowers Young's modulus to what the study states, and has to know the powder's.
class SofteningScaling : public Scaling {
 public:
  void Serialize(Archive& archive) override;
  std::string ExplainUnsupported(const Conditions& experiment) const override;

 protected:
  /// " (lowered to 5 MPa)", or "" before it is read.
  std::string LoweredTo() const;

  std::optional<double> young_modulus_;  // [Pa] of the simulated particles
};

/// Gives `simulation` the cohesion whose pull-off force is `factor` times the experiment's, in
/// terms of the simulation's own law and stiffness: k of SJKR2, or the surface energy of DMT. Where
/// the experiment's is not known, or the law has no cohesion, there is none to give.
void KeepCohesion(const Conditions& experiment, double factor, Conditions* simulation);

}  // namespace powdercal

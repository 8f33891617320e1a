#pragma once

#include <memory>
#include <optional>
#include <string>

#include "scaling/scaling.h"

namespace powdercal {

// The modes that scaling.cc does not hold itself, and what they share.

std::unique_ptr<Scaling> MakeCustomScaling();
std::unique_ptr<Scaling> MakeExactScaling();
std::unique_ptr<Scaling> MakeRigidLimitScaling();

/// "" or why the simulation's Young's modulus [Pa] is not possible: a particle is softened to save
/// time steps; one that is stiffer than the powder's is a slip.
std::string ExplainModulus(double simulation, const std::optional<double>& powder);

/// Gives `simulation` the cohesion whose pull-off force is `factor` times the experiment's, in
/// terms of the simulation's own law and stiffness: k of SJKR2, or the surface energy of DMT. Where
/// the experiment's is not known, or the law has no cohesion, there is none to give.
void KeepCohesion(const Conditions& experiment, double factor, Conditions* simulation);

}  // namespace powdercal

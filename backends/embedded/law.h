#pragma once

#include "backends/embedded/kernels.h"

namespace powdercal::embedded {

/// The constants of the contact law between spheres, and between spheres and walls; formulas in
/// docs/physics.md §1. `frictionless` leaves the normal force without cohesion.
LawConstants SphereLaw(const Program& program);
LawConstants WallLaw(const Program& program, bool frictionless);

}  // namespace powdercal::embedded

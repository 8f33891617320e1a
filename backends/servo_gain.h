#pragma once

#include "backends/program.h"

namespace powdercal {

/// Speed P at which a servo's body moves per unit of relative error of its force [m/s]: it moves
/// with v = P (1 − F/F_target), at most the servo's own limit (the proportional controller of
/// LIGGGHTS' servo walls; P is the product of its `vel_max` and `kp`). Each step changes the force
/// by about P · N · gamma_n, so that P N gamma_n/F_target must stay well below 1 (measured with
/// LIGGGHTS: stable up to about 0.8, period-two oscillation at 1.4), with N = A/(2 d²) contacts at
/// the wall, an upper bound of what was measured, and gamma_n that of the mean sphere: 2 √(5/6)
/// beta √(S_n m) under its share of the load, or the constant of the linear law. Chosen: 0.3
/// F_target/(N gamma_n), at most the servo's own limit, which stands alone where walls do not damp.
/// Reads particle_wall of the materials; without cohesion if the servo's wall is a frictionless
/// plane.
double ServoSpeed(const Program& program, const Servo& servo);
/// The gain that this makes, P N gamma_n/F_target [-]; 0 where the wall does not damp.
double ServoGain(const Program& program, const Servo& servo);

}  // namespace powdercal

#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "verification/finding.h"
#include "verification/laws.h"
#include "verification/seed_rung.h"

namespace powdercal::verification {

/// A bed of 1000 spheres in a box 10 diameters wide with frictionless sides, floor and lid with
/// friction: what every simulator can do. It begins with an explicit packing, drops, settles, and
/// is pressed by the lid with 1/2, 1 and 2 times the subject's stress, one after the other, for 60,
/// 30 and 30 d √(rho/stress). By the clock, so that beds which creep are compared at the same age.
Program PackingProgram(const Subject& subject, std::uint64_t seed);

/// Void ratio (central part), coordination number and stress over target at the end of each load.
Measurement MeasurePacking(const Program& program, const Trace& trace, Outcome* outcome);

/// What is compared: void_ratio, coordination and stress_ratio at each stress. `margins` replaces
/// those that are built in, by these three names.
SeedCase PackingCase(const Subject& subject, int seeds,
                     const std::map<std::string, double>& margins);

/// Names that `margins` may have.
std::span<const std::string> PackingQuantities();

}  // namespace powdercal::verification

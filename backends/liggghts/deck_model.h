#pragma once

#include <string>

#include "backends/program.h"

namespace powdercal::liggghts {

/// Atom types of a deck, which has as many as the program's walls need.
inline constexpr int kParticleType = 1;
inline constexpr int kWallType = 2;
inline constexpr int kFrictionlessWallType = 3;
int TypeCount(const Program& program);
int TypeOf(const PlaneWall& wall);

/// The contact law between particles in LIGGGHTS' own words: "gran model hertz tangential history
/// …".
std::string PairStyle(const ContactLaw& law);

/// What stands between `fix ID all` and the wall's geometry, "wall/gran model …", and behind it.
std::string WallStyle(const ContactLaw& law);
std::string WallOptions(const ContactLaw& law);

/// Stiffness number kappa of the bed under a stress [Pa], the reciprocal of a relative overlap.
double StiffnessUnder(const Program& program, double stress);

/// The commands that state the materials' properties, one a line. Requires a supported program and
/// an explicit packing that is not empty, or a valid size distribution.
std::string WriteProperties(const Program& program);

}  // namespace powdercal::liggghts

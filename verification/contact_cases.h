#pragma once

#include <string>
#include <vector>

#include "backends/program.h"
#include "verification/laws.h"

namespace powdercal::verification {

/// Two spheres, or a sphere and a wall, from before they touch until they have parted or swing
/// about each other; a packing at even intervals of steps.
struct ContactCase {
  std::string name;         ///< "oblique"
  std::string description;  ///< one line, for people
  /// What is looked at: L0 the linear law; L1 Hertz alone, head-on; W Hertz at a wall, without
  /// slip; L2 Hertz–Mindlin with history; L3 DMT adhesion, undamped, equal spheres; L4 rolling
  /// resistance of epsd2, undamped, equal spheres; P the seed paper's law; T a tangential spring on
  /// spheres that spin together about the line of their centres; X any other.
  std::string level;
  bool slips = false;   ///< the tangential spring plays a part
  bool twists = false;  ///< spheres turn about the line of their centres
  bool wall = false;    ///< one sphere and a wall
  Program program;      ///< with the subject's own law
};

/// The cases that mean something for a law: pull-off with cohesion only, undamped ones where a
/// level asks for them, several sizes only where the subject has them.
std::vector<ContactCase> ContactCases(const Subject& subject);

/// Bound of all relative differences of a case [-]: L0 1e-7, L1 1e-12, L2 to L4, P and X 1e-9; 1e-6
/// where the tangential spring is `incremental` and plays a part. W 1e-8, as X at walls without
/// slip: YADE's walls are spheres of 1e8 radii, so that R* is 1e-8 too small. T 1e-3: YADE turns
/// the spring with the spheres there, LIGGGHTS and the embedded engine do not, and the law does not
/// say.
double ContactTolerance(const ContactCase& contact, const ContactLaw& law);

}  // namespace powdercal::verification

#pragma once

#include <string>

#include "studies/results.h"

namespace powdercal {

/// The material card, YAML: the calibrated parameters with all that is needed to use them
/// elsewhere, and to judge whether one should: contact law, scaling, fit, provenance, caveats. SI
/// units.
std::string MaterialCard(const StudyResults& results);

}  // namespace powdercal

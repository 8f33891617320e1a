#pragma once

#include <string>
#include <vector>

#include "studies/study.h"

namespace powdercal::cli {

/// Values of a study's free parameters [SI] from the command line, "k=47500" or
/// "cohesion_energy_density=47.5 kJ/m3": names or symbols; a bare number is in SI. `defaults`, in
/// the order of the parameters, may be empty: then each must be given.
std::vector<double> ReadParameters(const Study& study, const std::vector<std::string>& texts,
                                   const std::vector<double>& defaults = {});

}  // namespace powdercal::cli

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "studies/study.h"

namespace powdercal::cli {

/// Values of a study's free parameters [SI], in its order, from the command line: "k=47500" or
/// "cohesion_energy_density=47.5 kJ/m3", names or symbols; a bare number is in SI; the name of a
/// category. `defaults`, in
/// the same order, may be empty: then each must be given. Throws InputError.
std::vector<double> ReadParameters(const Study& study, const std::vector<std::string>& texts,
                                   const std::vector<double>& defaults = {});

/// Indices of the study's experiments of these names, ascending; without names of all. Throws
/// InputError.
std::vector<std::size_t> ReadExperiments(const Study& study, const std::vector<std::string>& names);

/// A folder of its own below the system's for temporary files. Throws InputError.
std::filesystem::path MakeTemporaryFolder();

}  // namespace powdercal::cli

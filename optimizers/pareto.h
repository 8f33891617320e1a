#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace powdercal {

/// Rows of `objectives` (points × objectives, all minimised) that no other row dominates, in
/// ascending order. A row dominates another if it is nowhere higher and somewhere lower, so that
/// equal rows stand or fall together. Rows with an entry that is not finite are left out and
/// dominate nothing.
std::vector<std::size_t> NonDominated(const Eigen::MatrixXd& objectives);

}  // namespace powdercal

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

/// Volume of the region that some row of `objectives` dominates and that dominates `reference`
/// (length: columns of objectives, ≥ 1). Rows that are not finite or not below the reference
/// everywhere add nothing. By slices along the last objective (Knowles 2002, chapter 4): exact, and
/// fast for up to 4 objectives.
double Hypervolume(const Eigen::MatrixXd& objectives, const Eigen::VectorXd& reference);

/// The region below `reference` that no row of `objectives` dominates, as disjoint boxes: what is
/// left to be gained (cf. Lacour, Klamroth & Fonseca 2017). Lower ends may be −∞.
struct Boxes {
  Eigen::MatrixXd lower;  ///< boxes × objectives
  Eigen::MatrixXd upper;
};
Boxes NonDominatedBoxes(const Eigen::MatrixXd& objectives, const Eigen::VectorXd& reference);

}  // namespace powdercal

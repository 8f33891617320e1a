#pragma once

#include <Eigen/Core>
#include <span>

namespace powdercal {

/// Numbers of levels of which there is an array here, ascending: primes and powers of primes from 2
/// to 16.
std::span<const int> OrthogonalArrayLevels();

/// The levels, 0 … levels − 1, of an orthogonal array of strength 2 and index 1: levels² rows,
/// levels + 1 columns; in any two columns each pair of levels stands in exactly one row. By
/// multiplication in the field of `levels` elements (Bose 1938; Hedayat, Sloane & Stufken 1999,
/// chapter 3): row (i, j) has i, then c i + j for each element c. Throws std::invalid_argument
/// unless `levels` is one of OrthogonalArrayLevels().
Eigen::MatrixXi OrthogonalArray(int levels);

}  // namespace powdercal

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/archive.h"
#include "optimizers/optimizer.h"

namespace powdercal {

/// A point of a design with the name it is listed under ("corner 1", "centre", "point 3").
struct DesignPoint {
  Eigen::VectorXd point;  ///< in the unit box
  std::string label;
};

/// A set of points chosen before anything is known; an optimizer of its own, or the initial design
/// of another (`initial_design: sobol`, or `initial_design: {name: sobol, points: 8}`).
struct DesignOptions {
  std::string name = "corners_and_centre";
  int points = 0;  ///< sobol, latin_hypercube: 1 … 100 000; 0: 2 (d + 1), at least 5
  /// Per parameter. grid: at least 2; at most 100 000 points in all. orthogonal_array: one of
  /// OrthogonalArrayLevels(), at least the number of parameters − 1.
  int levels = 3;
  /// list: SI values, in the order of the parameters. In a study file each point names its
  /// parameters:
  ///   points:
  ///     - {cohesion_energy_density: 47500 J/m3, rolling_friction: 0.5}
  std::vector<std::vector<double>> list;

  /// The members that belong to the design called `name`. Throws InputError, also where the design
  /// cannot be made in this space (see MakeDesign).
  void Serialize(Archive& archive, const SearchSpace& space);
  /// `key: sobol` or `key: {name: sobol, …}`.
  void SerializeSection(Archive& archive, std::string_view key, const SearchSpace& space);
  /// "" if MakeDesign can make it, else the reason, with alternatives.
  std::string ExplainUnsupported(const SearchSpace& space) const;
};

/// corners_and_centre, grid, latin_hypercube, list, orthogonal_array, sobol.
std::span<const std::string> DesignNames();

/// The points; the same options, space and seed give the same points.
///  - corners_and_centre: the 2^d corners and the centre of the box (d ≤ 10);
///  - grid: levels^d points, ends included;
///  - latin_hypercube: one point in each of n strata of each parameter, at random: of 50 such
///    designs the one with the largest smallest distance between two points (maximin);
///  - list: the user's;
///  - orthogonal_array: levels² points, ends included; each pair of levels of any two parameters is
///    in exactly one of them (strength 2, see OrthogonalArray). A discrete parameter with another
///    number of levels takes the nearest ones, some more often than others;
///  - sobol: the first points of a Sobol' sequence (Joe & Kuo 2008 direction numbers), digitally
///    shifted by the seed.
/// Throws std::invalid_argument where ExplainUnsupported gives a reason.
std::vector<DesignPoint> MakeDesign(const DesignOptions& options, const SearchSpace& space,
                                    std::uint64_t seed);

/// The first `count` points of the shifted Sobol' sequence in d dimensions; count × d, entries in
/// (0, 1). 1 ≤ d ≤ 3667. The first 2^m points have exactly one in each of 2^m strata of every
/// input.
Eigen::MatrixXd SobolPoints(int count, int dimension, std::uint64_t seed);

}  // namespace powdercal

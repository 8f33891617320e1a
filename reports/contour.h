#pragma once

#include <Eigen/Core>
#include <vector>

namespace powdercal {

/// A straight piece of a contour line, in grid coordinates: node (i, j) of the field lies at x = i,
/// y = j.
struct ContourSegment {
  double x1, y1, x2, y2;
};

/// The line on which the bilinear field(i, j) takes the value `level`, by marching squares: each
/// cell gives up to two segments; a saddle is resolved by the mean of its corners. Cells with a
/// corner that is not finite are left out.
std::vector<ContourSegment> Contour(const Eigen::MatrixXd& field, double level);

}  // namespace powdercal

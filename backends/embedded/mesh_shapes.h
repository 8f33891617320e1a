#pragma once

#include <string>

#include "backends/program.h"

namespace powdercal::embedded {

// Surfaces for experiments and tests. Normals are those of TriangleMesh::Normal().

/// A parallelogram with a corner at `origin` [m], spanned by edge1 and edge2 [m], of n1 by n2 cells
/// with two triangles each; normals along edge1 × edge2. Requires n1, n2 ≥ 1.
Mesh MakeRectangle(std::string name, const Vector3& origin, const Vector3& edge1,
                   const Vector3& edge2, int n1, int n2);

/// A sheet of triangular ridges that run along y: from x0 to x0 + length, y0 to y0 + width; at
/// z0 = origin[2] in the valleys, at z0 + height at the crests in between, normals upward. The
/// length holds a whole number of periods, from valley to valley, the nearest to length / period
/// and at least 1. `height` may be negative, for ridges that hang from a lid. Flanks are cut into
/// `strips` pieces along y. Lengths in m; requires length, width, period > 0, strips ≥ 1.
Mesh MakeRidgedPlate(std::string name, const Vector3& origin, double length, double width,
                     double period, double height, int strips = 1);

}  // namespace powdercal::embedded

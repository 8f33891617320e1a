#include "backends/embedded/mesh_shapes.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "backends/embedded/vector_math.h"

namespace powdercal::embedded {

namespace {

/// The triangles of a sheet whose vertices are (n1 + 1) by (n2 + 1), the second index running
/// first.
std::vector<std::array<int, 3>> SheetTriangles(int n1, int n2) {
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i < n1; ++i) {
    for (int j = 0; j < n2; ++j) {
      const int corner = i * (n2 + 1) + j;
      const int opposite = corner + n2 + 2;
      triangles.push_back({corner, opposite - 1, opposite});
      triangles.push_back({corner, opposite, corner + 1});
    }
  }
  return triangles;
}

}  // namespace

Mesh MakeRectangle(std::string name, const Vector3& origin, const Vector3& edge1,
                   const Vector3& edge2, int n1, int n2) {
  assert(n1 >= 1 && n2 >= 1);
  Mesh mesh{.name = std::move(name), .triangles = SheetTriangles(n1, n2)};
  for (int i = 0; i <= n1; ++i) {
    for (int j = 0; j <= n2; ++j) {
      mesh.vertices.push_back(origin + (static_cast<double>(i) / n1) * edge1 +
                              (static_cast<double>(j) / n2) * edge2);
    }
  }
  return mesh;
}

Mesh MakeRidgedPlate(std::string name, const Vector3& origin, double length, double width,
                     double period, double height, int strips) {
  assert(length > 0 && width > 0 && period > 0 && strips >= 1);
  const int flanks = 2 * std::max(1, static_cast<int>(std::lround(length / period)));
  Mesh mesh = MakeRectangle(std::move(name), origin, {length, 0, 0}, {0, width, 0}, flanks, strips);
  for (int i = 1; i < flanks; i += 2) {
    for (int j = 0; j <= strips; ++j) mesh.vertices[i * (strips + 1) + j][2] += height;
  }
  return mesh;
}

}  // namespace powdercal::embedded

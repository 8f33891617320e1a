#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "backends/embedded/mesh_shapes.h"
#include "backends/embedded/triangle_mesh.h"
#include "core/random.h"

namespace powdercal::embedded {

inline Vector3 RandomPoint(RandomStream& random, double size) {
  return {random.Uniform(-size, size), random.Uniform(-size, size), random.Uniform(-size, size)};
}

inline std::vector<std::uint32_t> All(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> triangles(mesh.triangle_count());
  std::iota(triangles.begin(), triangles.end(), 0u);
  return triangles;
}

inline std::vector<MeshContact> ContactsOf(const TriangleMesh& mesh, const Vector3& centre,
                                           double radius) {
  std::vector<MeshContact> contacts;
  mesh.Contacts(centre, radius, All(mesh), contacts);
  return contacts;
}

inline void ExpectNear(const Vector3& a, const Vector3& b, double tolerance) {
  EXPECT_LE(Length(a - b), tolerance)
      << a[0] << " " << a[1] << " " << a[2] << " instead of " << b[0] << " " << b[1] << " " << b[2];
}

/// Every triangle with vertices of its own, turned over at random.
inline Mesh Shattered(const Mesh& mesh, RandomStream& random) {
  Mesh shattered{.name = mesh.name};
  for (const auto& triangle : mesh.triangles) {
    const int first = static_cast<int>(shattered.vertices.size());
    for (const int v : triangle) shattered.vertices.push_back(mesh.vertices[v]);
    shattered.triangles.push_back({first, first + 1, first + 2});
    if (random.Below(2) == 1)
      std::swap(shattered.triangles.back()[1], shattered.triangles.back()[2]);
  }
  return shattered;
}

/// The unit square of z = 0, triangles split at random points: needles of all kinds.
inline Mesh SplitSquare(int splits, RandomStream& random) {
  Mesh mesh{.name = "plate",
            .vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
            .triangles = {{0, 1, 2}, {0, 2, 3}}};
  for (int n = 0; n < splits; ++n) {
    const auto old = mesh.triangles[random.Below(mesh.triangles.size())];
    const double a = random.Uniform(0.1, 1);
    const double b = random.Uniform(0.1, 1);
    const double c = random.Uniform(0.1, 1);
    const int middle = static_cast<int>(mesh.vertices.size());
    Vector3 point = (1 / (a + b + c)) * (a * mesh.vertices[old[0]] + b * mesh.vertices[old[1]] +
                                         c * mesh.vertices[old[2]]);
    mesh.vertices.push_back(point);
    *std::find(mesh.triangles.begin(), mesh.triangles.end(), old) = {old[0], old[1], middle};
    mesh.triangles.push_back({old[1], old[2], middle});
    mesh.triangles.push_back({old[2], old[0], middle});
  }
  return mesh;
}

/// The unit square again, an even net with its inner vertices shaken and either diagonal.
inline Mesh ShakenSquare(int n, RandomStream& random) {
  Mesh mesh = MakeRectangle("plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, n, n);
  for (int i = 1; i < n; ++i) {
    for (int j = 1; j < n; ++j) {
      Vector3& v = mesh.vertices[i * (n + 1) + j];
      v = v + (0.2 / n) * Vector3{random.Uniform(-1, 1), random.Uniform(-1, 1), 0};
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 2) {
    if (random.Below(2) == 1) continue;
    const auto [a, b, c] = mesh.triangles[t];
    const int d = mesh.triangles[t + 1][2];
    mesh.triangles[t] = {a, b, d};
    mesh.triangles[t + 1] = {b, c, d};
  }
  return mesh;
}

inline Pose SomePose() { return {RotationBy({0.4, -1.1, 0.7}), {0.3, -0.2, 0.9}}; }

}  // namespace powdercal::embedded

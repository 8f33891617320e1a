#include "backends/embedded/triangle_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "backends/embedded/mesh_shapes.h"
#include "core/errors.h"
#include "core/random.h"
#include "tests/backends/sample_meshes.h"

namespace powdercal::embedded {
namespace {

using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

TEST(ClosestPoint, IsTheNearestOfTheTriangle) {
  RandomStream random(1);
  for (int trial = 0; trial < 3000; ++trial) {
    Mesh mesh{.name = "one", .triangles = {{0, 1, 2}}};
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(RandomPoint(random, 1));
    // Every fourth is a needle, or a cap whose third vertex nearly lies on an edge.
    if (trial % 4 == 0) {
      mesh.vertices[2] = mesh.vertices[0] +
                         random.Uniform(0, 1) * (mesh.vertices[1] - mesh.vertices[0]) +
                         RandomPoint(random, 1e-6);
    }
    const TriangleMesh one(mesh);
    Vector3 p = RandomPoint(random, 1.5);
    const Vector3& origin = mesh.vertices[0];
    if (trial % 3 == 0) p = p - Dot(p - origin, one.Normal(0)) * one.Normal(0);
    const SurfacePoint q = one.ClosestPoint(0, p);
    EXPECT_NEAR(q.distance, Length(p - q.point), 1e-12);
    // Of a convex set, the nearest point is the one that no vertex is in front of. A needle's plane
    // is known to some 1e-10 only.
    const double tolerance = trial % 4 == 0 ? 1e-9 : 1e-12;
    for (const Vector3& v : mesh.vertices) EXPECT_LE(Dot(p - q.point, v - q.point), tolerance);
    EXPECT_LE(std::abs(Dot(q.point - origin, one.Normal(0))), tolerance);
    for (int sample = 0; sample < 100; ++sample) {
      double u = random.Uniform();
      double v = random.Uniform();
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vector3 s = origin + u * (mesh.vertices[1] - origin) + v * (mesh.vertices[2] - origin);
      EXPECT_GE(Length(p - s), q.distance - 1e-12);
    }
  }
}

TEST(ClosestPoint, NamesTheFeature) {
  const TriangleMesh mesh({"one", {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  const auto expect = [&](const Vector3& p, const Vector3& q, Feature feature, std::uint32_t id) {
    const SurfacePoint found = mesh.ClosestPoint(0, p);
    ExpectNear(found.point, q, 1e-15);
    EXPECT_EQ(found.feature, feature);
    EXPECT_EQ(found.id, id);
  };
  for (const double z : {-0.5, 0.0, 0.5}) {
    expect({0.3, 0.3, z}, {0.3, 0.3, 0}, Feature::face, 0);
    expect({0.3, -0.3, z}, {0.3, 0, 0}, Feature::edge, mesh.EdgesOf(0)[0]);
    expect({1.5, 1.5, z}, {1, 0.5, 0}, Feature::edge, mesh.EdgesOf(0)[1]);
    expect({-0.1, 0.25, z}, {0, 0.25, 0}, Feature::edge, mesh.EdgesOf(0)[2]);
    expect({-0.1, -0.2, z}, {0, 0, 0}, Feature::vertex, mesh.VerticesOf(0)[0]);
    expect({3, 0.1, z}, {2, 0, 0}, Feature::vertex, mesh.VerticesOf(0)[1]);
    expect({-0.1, 1.5, z}, {0, 1, 0}, Feature::vertex, mesh.VerticesOf(0)[2]);
    expect({1, 0, z}, {1, 0, 0}, Feature::edge, mesh.EdgesOf(0)[0]);
  }
}

TEST(TriangleMesh, WeldsEqualVertices) {
  RandomStream random(2);
  const Mesh whole = MakeRectangle("plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 4, 3);
  Mesh shattered = Shattered(whole, random);
  for (Vector3& v : shattered.vertices) {
    if (v[2] == 0 && random.Below(2) == 1) v[2] = -0.0;
  }
  const TriangleMesh mesh(shattered);
  EXPECT_EQ(mesh.vertex_count(), 20u);
  EXPECT_EQ(mesh.triangle_count(), 24u);
  EXPECT_EQ(mesh.edge_count(), 43u);  // Euler: V − E + F = 1
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    EXPECT_EQ(std::set(mesh.EdgesOf(t).begin(), mesh.EdgesOf(t).end()).size(), 3u);
  }
}

TEST(TriangleMesh, PosesFollowMotions) {
  const Motion motion{"plate", {0.1, 0, -0.2}, {0, 0, kPi / 2}, {1, 0, 0}};
  const Pose pose = Moved({}, motion, 1);
  TriangleMesh mesh(MakeRectangle("plate", {1, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1, 1));
  mesh.Place(pose);
  // A quarter turn about (1, 0), then along.
  ExpectNear(mesh.Vertex(mesh.VerticesOf(0)[0]), {1.1, 0, -0.2}, 1e-15);
  ExpectNear(mesh.Vertex(mesh.VerticesOf(0)[1]), {1.1, 1, -0.2}, 1e-15);
  ExpectNear(mesh.Bounds()[0], {0.1, 0, -0.2}, 1e-15);
  ExpectNear(mesh.Bounds()[1], {1.1, 1, -0.2}, 1e-15);
  const auto contacts = ContactsOf(mesh, {0.5, 0.4, -0.1}, 0.15);
  ASSERT_EQ(contacts.size(), 1u);
  ExpectNear(contacts[0].point, {0.5, 0.4, -0.2}, 1e-15);

  // Stages one after the other are poses one after the other; a full turn leads back.
  const Pose later = Moved(pose, {"plate", {}, {0, kPi, 0}, {3, 1, 2}}, 2);
  for (int row = 0; row < 3; ++row) ExpectNear(later.rotation[row], pose.rotation[row], 1e-14);
  ExpectNear(later.translation, pose.translation, 1e-14);
  EXPECT_EQ(Moved(Pose{}, {"plate", {1, 2, 3}, {}, {}}, 0.5), (Pose{kNoRotation, {0.5, 1, 1.5}}));
}

TEST(TriangleMesh, VelocityIsThatOfTheMotion) {
  RandomStream random(6);
  const Mesh plate = MakeRectangle("plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1, 1);
  const Motion motion{"plate", {0.3, -0.1, 0.2}, {0.5, 0.7, -1}, {0.2, 0.9, 0.4}};
  const Pose start = SomePose();
  TriangleMesh before(plate), now(plate), after(plate);
  constexpr double kTime = 0.8, kStep = 1e-5;
  before.Place(Moved(start, motion, kTime - kStep));
  now.Place(Moved(start, motion, kTime));
  after.Place(Moved(start, motion, kTime + kStep));
  EXPECT_EQ(now.VelocityAt({1, 2, 3}), (Vector3{0, 0, 0}));
  now.SetVelocity(motion.velocity, motion.spin, motion.centre + kTime * motion.velocity);
  for (std::uint32_t v = 0; v < 4; ++v) {
    const Vector3 expected = (0.5 / kStep) * (after.Vertex(v) - before.Vertex(v));
    ExpectNear(now.VelocityAt(now.Vertex(v)), expected, 1e-9);
  }
}

TEST(FindCandidates, AreThoseOfAllPairs) {
  RandomStream random(7);
  std::vector<Mesh> meshes = {MakeRectangle("plate", {-1, -1, 0}, {2, 0, 0.1}, {0, 2, 0}, 1, 1),
                              MakeRidgedPlate("ridges", {-1, -1, 0}, 2, 2, 0.1, 0.05, 2),
                              SplitSquare(200, random)};
  for (const Mesh& shape : meshes) {
    TriangleMesh mesh(shape);
    for (const Pose& pose : {Pose{}, SomePose()}) {
      mesh.Place(pose);
      std::vector<Vector3> centres;
      std::vector<double> radii;
      for (int n = 0; n < 1500; ++n) {
        centres.push_back(RandomPoint(random, 1.4));
        radii.push_back(random.Uniform(0.01, 0.1));
      }
      const double skin = 0.02;
      std::vector<Candidate> expected;
      for (std::uint32_t s = 0; s < centres.size(); ++s) {
        for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
          if (mesh.ClosestPoint(t, centres[s]).distance <= radii[s] + skin) {
            expected.emplace_back(s, t);
          }
        }
      }
      std::vector<Candidate> found = {{7, 7}};
      mesh.FindCandidates(centres, radii, skin, found);
      EXPECT_GT(expected.size(), 10u);
      EXPECT_EQ(found, expected);
      // Contacts from candidates are those from all triangles.
      std::vector<MeshContact> contacts;
      for (auto from = found.begin(); from != found.end();) {
        const std::uint32_t s = from->first;
        auto to = from;
        while (to != found.end() && to->first == s) ++to;
        mesh.Contacts(centres[s], radii[s], std::span<const Candidate>(from, to), contacts);
        EXPECT_EQ(contacts.size(), ContactsOf(mesh, centres[s], radii[s]).size());
        from = to;
      }
    }
  }
}

TEST(FindCandidates, OfNothingAndOfLostSpheres) {
  const TriangleMesh mesh(MakeRectangle("plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 2, 2));
  std::vector<Candidate> found = {{7, 7}};
  mesh.FindCandidates({}, {}, 0.1, found);
  EXPECT_TRUE(found.empty());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<Vector3> centres = {{nan, 0, 0}, {0.5, 0.4, 0.01}, {0.5, infinity, 0}};
  mesh.FindCandidates(centres, std::vector<double>(3, 0.1), 0, found);
  ASSERT_FALSE(found.empty());
  for (const auto& [sphere, triangle] : found) EXPECT_EQ(sphere, 1u);
  EXPECT_TRUE(ContactsOf(mesh, centres[0], 0.1).empty());
  EXPECT_TRUE(ContactsOf(mesh, centres[2], 0.1).empty());
}

TEST(TriangleMesh, RefusesWhatIsNoSurface) {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<Vector3> corners = {
      {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 1e-12, 0}, {0, 0, infinity}};
  const auto problem = [&](std::vector<std::array<int, 3>> triangles) -> std::string {
    try {
      TriangleMesh mesh({"blade", corners, std::move(triangles)});
    } catch (const InputError& error) {
      return error.problem();
    }
    return "";
  };
  EXPECT_EQ(problem({{0, 1, 2}}), "");
  EXPECT_EQ(problem({}), "mesh 'blade' has no triangles");
  EXPECT_EQ(problem({{0, 1, 2}, {0, 1, 5}}),
            "mesh 'blade': triangle 1 has vertex 5, but there are 5");
  EXPECT_THAT(problem({{-1, 1, 2}}), HasSubstr("triangle 0 has vertex -1"));
  EXPECT_EQ(problem({{0, 1, 2}, {2, 1, 0}, {1, 2, 4}}),
            "mesh 'blade': triangle 2: vertex 4 is not finite");
  EXPECT_EQ(problem({{0, 1, 2}, {0, 1, 1}}), "mesh 'blade': triangle 1 is degenerate");
  EXPECT_EQ(problem({{0, 1, 3}}), "mesh 'blade': triangle 0 is degenerate");
}

TEST(MeshShapes, HaveTheRightAreaAndNormals) {
  const TriangleMesh plate(MakeRectangle("plate", {1, 2, 3}, {0, 2, 0}, {0, 0, 3}, 3, 5));
  EXPECT_EQ(plate.triangle_count(), 30u);
  for (std::uint32_t t = 0; t < 30; ++t) ExpectNear(plate.Normal(t), {1, 0, 0}, 1e-15);
  EXPECT_EQ(plate.Bounds(), (std::array<Vector3, 2>{{{1, 2, 3}, {1, 4, 6}}}));

  const Mesh ridges = MakeRidgedPlate("lid", {0, 1, 5}, 3, 2, 1.01, -0.5, 4);
  const TriangleMesh lid(ridges);
  EXPECT_EQ(ridges.name, "lid");
  EXPECT_EQ(lid.triangle_count(), 48u);
  EXPECT_EQ(lid.Bounds(), (std::array<Vector3, 2>{{{0, 1, 4.5}, {3, 3, 5}}}));
  const double s = std::sqrt(0.5);
  for (std::uint32_t t = 0; t < 48; ++t) {
    const Vector3 normal = lid.Normal(t);
    ExpectNear({std::abs(normal[0]), normal[1], normal[2]}, {s, 0, s}, 1e-14);
  }
}

}  // namespace
}  // namespace powdercal::embedded

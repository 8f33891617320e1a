#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>

#include "backends/embedded/mesh_shapes.h"
#include "backends/embedded/triangle_mesh.h"
#include "core/random.h"
#include "tests/backends/sample_meshes.h"

namespace powdercal::embedded {
namespace {

constexpr double kPi = std::numbers::pi;

Vector3 ClosestOfUnitSquare(const Vector3& p) {
  return {std::clamp(p[0], 0.0, 1.0), std::clamp(p[1], 0.0, 1.0), 0};
}

/// Checks the one contact of a sphere with the unit square, placed anyhow.
void ExpectOneOnSquare(const TriangleMesh& mesh, const Vector3& p, double radius) {
  const Pose& pose = mesh.pose();
  const Vector3 centre = pose.rotation * p + pose.translation;
  const std::vector<MeshContact> contacts = ContactsOf(mesh, centre, radius);
  const Vector3 foot = ClosestOfUnitSquare(p);
  const double distance = Length(p - foot);
  if (distance >= radius) {
    EXPECT_TRUE(contacts.empty());
    return;
  }
  ASSERT_EQ(contacts.size(), 1u) << p[0] << " " << p[1] << " " << p[2];
  EXPECT_NEAR(contacts[0].distance, distance, 2e-9 * radius);
  ExpectNear(contacts[0].point, pose.rotation * foot + pose.translation, 1e-6 * radius);
  if (distance > 0.1 * radius) {
    ExpectNear(contacts[0].normal, pose.rotation * ((1 / distance) * (p - foot)), 1e-6);
  }
  EXPECT_NEAR(Length(contacts[0].normal), 1, 1e-14);
}

TEST(Contacts, AFlatPlateGivesOneHoweverItIsCut) {
  RandomStream random(3);
  std::vector<Mesh> plates = {MakeRectangle("plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1, 1),
                              MakeRectangle("plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1, 300)};
  for (int n = 0; n < 4; ++n) plates.push_back(ShakenSquare(5 + 3 * n, random));
  for (int n = 0; n < 4; ++n) plates.push_back(SplitSquare(50 + 100 * n, random));
  for (const Mesh& plate : plates) {
    TriangleMesh mesh(Shattered(plate, random));
    for (const Pose& pose : {Pose{}, Pose{kNoRotation, {5, 7, -3}}, SomePose()}) {
      mesh.Place(pose);
      for (int n = 0; n < 200; ++n) {
        const auto& triangle = plate.triangles[random.Below(plate.triangles.size())];
        const Vector3& a = plate.vertices[triangle[0]];
        const Vector3& b = plate.vertices[triangle[1]];
        const double radius = random.Uniform(0.01, 0.3);
        const double z = random.Uniform(-1, 1) * radius;
        // Anywhere, beyond the rim as well; over an edge; over a vertex; near one.
        const Vector3 above{0, 0, z};
        ExpectOneOnSquare(mesh, Vector3{random.Uniform(-0.2, 1.2), random.Uniform(-0.2, 1.2), z},
                          radius);
        ExpectOneOnSquare(mesh, a + random.Uniform() * (b - a) + above, radius);
        ExpectOneOnSquare(mesh, a + above, radius);
        const double tiny = std::pow(10, random.Uniform(-17, -3));
        ExpectOneOnSquare(mesh, a + above + tiny * Vector3{random.Normal(), random.Normal(), 0},
                          radius);
        ExpectOneOnSquare(mesh, a + random.Uniform() * (b - a), radius);
      }
    }
  }
}

TEST(Contacts, TheNearestPointIsAlwaysOne) {
  RandomStream random(4);
  for (int trial = 0; trial < 1000; ++trial) {
    Mesh soup{.name = "soup"};
    for (int v = 0; v < 9; ++v) soup.vertices.push_back(RandomPoint(random, 1));
    for (int t = 0; t < 12; ++t) {
      std::array<int, 9> order;
      std::iota(order.begin(), order.end(), 0);
      random.Shuffle(std::span<int>(order));
      soup.triangles.push_back({order[0], order[1], order[2]});
    }
    const TriangleMesh mesh(soup);
    const Vector3 centre = RandomPoint(random, 1.5);
    double distance = std::numeric_limits<double>::infinity();
    for (const std::uint32_t t : All(mesh)) {
      distance = std::min(distance, mesh.ClosestPoint(t, centre).distance);
    }
    const auto contacts = ContactsOf(mesh, centre, 0.8);
    ASSERT_EQ(contacts.empty(), distance >= 0.8);
    for (const MeshContact& contact : contacts) {
      EXPECT_NEAR(Length(centre - contact.point), contact.distance, 1e-12);
      ExpectNear(contact.point + contact.distance * contact.normal, centre, 1e-12);
    }
    if (contacts.empty()) continue;
    EXPECT_NEAR(contacts[0].distance, distance, 1e-12);
  }
}

TEST(Contacts, RoundingLosesNoTouch) {
  RandomStream random(8);
  // Some 1e9 radii from the origin, beyond what the tolerances are made for.
  const Rotation turn = RotationBy({0.4, -1.1, 0.7});
  const Vector3 far{1e7, 2e7, -1e7};
  Mesh plate = ShakenSquare(6, random);
  for (Vector3& v : plate.vertices) v = turn * v + far;
  const TriangleMesh mesh(plate);
  for (int n = 0; n < 5000; ++n) {
    const auto& triangle = plate.triangles[random.Below(plate.triangles.size())];
    const Vector3& a = plate.vertices[triangle[0]];
    const Vector3& b = plate.vertices[triangle[1]];
    const Vector3 foot = n % 2 == 0 ? a : a + random.Uniform() * (b - a);
    EXPECT_FALSE(ContactsOf(mesh, foot + turn * Vector3{0, 0, 0.02}, 0.025).empty());
  }
}

TEST(Contacts, ACentreOnTheSurfaceGetsItsNormal) {
  const TriangleMesh mesh(MakeRectangle("plate", {0, 0, 0}, {2, 0, 0}, {0, 2, 0}, 2, 2));
  for (const Vector3& centre : {Vector3{0.7, 0.3, 0}, {0.5, 0.5, 0}, {1, 1, 0}, {1, 0.5, 0}}) {
    const auto contacts = ContactsOf(mesh, centre, 0.1);
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_LT(contacts[0].distance, 1e-15);
    ExpectNear(contacts[0].normal, {0, 0, 1}, 1e-15);
  }
}

TEST(Contacts, BothSidesOfAPlateAct) {
  const TriangleMesh mesh(MakeRectangle("plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 3, 3));
  for (const double side : {1.0, -1.0}) {
    const auto contacts = ContactsOf(mesh, {0.4, 0.45, side * 0.09}, 0.1);
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_EQ(contacts[0].feature, Feature::face);
    EXPECT_EQ(contacts[0].normal, (Vector3{0, 0, side}));
    EXPECT_NEAR(contacts[0].distance, 0.09, 1e-17);
  }
}

TEST(Contacts, TheRimOfAPlateIsAnEdgeAndACorner) {
  const TriangleMesh mesh(MakeRectangle("plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 4, 4));
  const double s = std::sqrt(0.5);
  auto contacts = ContactsOf(mesh, {-0.06, 0.4, 0.06}, 0.1);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_EQ(contacts[0].feature, Feature::edge);
  ExpectNear(contacts[0].point, {0, 0.4, 0}, 1e-15);
  ExpectNear(contacts[0].normal, {-s, 0, s}, 1e-15);

  contacts = ContactsOf(mesh, {-0.06, 0.5, -0.06}, 0.1);  // where two cells meet at the rim
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_EQ(contacts[0].feature, Feature::vertex);
  ExpectNear(contacts[0].normal, {-s, 0, -s}, 1e-15);

  contacts = ContactsOf(mesh, {1.03, 1.06, 0.06}, 0.1);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_EQ(contacts[0].feature, Feature::vertex);
  EXPECT_EQ(mesh.Vertex(contacts[0].id), (Vector3{1, 1, 0}));
  ExpectNear(contacts[0].normal, {1.0 / 3, 2.0 / 3, 2.0 / 3}, 1e-15);
  EXPECT_TRUE(ContactsOf(mesh, {1.08, 1.08, 0}, 0.1).empty());
}

TEST(Contacts, GoOnSmoothlyOverARidge) {
  TriangleMesh mesh(MakeRidgedPlate("ridges", {-1, -1, 0}, 4, 2, 2, 0.5, 3));
  for (const Pose& pose : {Pose{}, SomePose()}) {
    mesh.Place(pose);
    constexpr double kRadius = 0.2;
    constexpr int kSteps = 20000;
    std::set<Feature> seen;
    MeshContact last;
    for (int n = 0; n <= kSteps; ++n) {
      const double x = -0.4 + 0.8 * n / kSteps;  // the crest is at x = 0, z = 0.5
      const Vector3 p{x, 0.1 + 0.3 * x, 0.68 - 0.45 * std::abs(x)};
      const auto contacts = ContactsOf(mesh, pose.rotation * p + pose.translation, kRadius);
      ASSERT_EQ(contacts.size(), 1u) << x;
      seen.insert(contacts[0].feature);
      if (n > 0) {
        EXPECT_NEAR(contacts[0].distance, last.distance, 1e-4);
        ExpectNear(contacts[0].normal, last.normal, 5e-4);
        ExpectNear(contacts[0].point, last.point, 1e-4);
      }
      last = contacts[0];
    }
    EXPECT_TRUE(seen.contains(Feature::face));
    EXPECT_TRUE(seen.contains(Feature::edge));
  }
}

TEST(Contacts, GoOnSmoothlyOverAConvexCorner) {
  // Of a cube: a loop over the face z = 1, the edges and the corner at (1, 1, 1).
  Mesh cube{.name = "cube"};
  for (int side = 0; side < 2; ++side) {
    for (int axis = 0; axis < 3; ++axis) {
      Vector3 origin{}, edge1{}, edge2{};
      origin[axis] = side;
      edge1[(axis + 1) % 3] = 1;
      edge2[(axis + 2) % 3] = 1;
      const Mesh face = MakeRectangle("", origin, edge1, edge2, 5, 5);
      const int first = static_cast<int>(cube.vertices.size());
      cube.vertices.insert(cube.vertices.end(), face.vertices.begin(), face.vertices.end());
      for (const auto& [a, b, c] : face.triangles) {
        cube.triangles.push_back({first + a, first + b, first + c});
      }
    }
  }
  const TriangleMesh mesh(cube);
  EXPECT_EQ(mesh.vertex_count(), 152u);
  std::set<Feature> seen;
  MeshContact last;
  constexpr int kSteps = 20000;
  for (int n = 0; n <= kSteps; ++n) {
    const double angle = 2 * kPi * n / kSteps;
    const Vector3 direction = Unit({1 + 1.3 * std::cos(angle), 1 + 1.3 * std::sin(angle), 1});
    const Vector3 centre = Vector3{0.99, 0.99, 0.99} + 0.09 * direction;
    const auto contacts = ContactsOf(mesh, centre, 0.1);
    ASSERT_EQ(contacts.size(), 1u);
    seen.insert(contacts[0].feature);
    if (n > 0) {
      EXPECT_NEAR(contacts[0].distance, last.distance, 1e-4);
      ExpectNear(contacts[0].normal, last.normal, 2e-3);
    }
    last = contacts[0];
  }
  EXPECT_EQ(seen.size(), 3u);
}

TEST(Contacts, AGrooveGivesOneForEachFlank) {
  RandomStream random(5);
  // A valley of two flanks at 45 degrees, cut finely: its bottom is the y axis.
  const TriangleMesh mesh(
      Shattered(MakeRidgedPlate("ridges", {-1, -1, 0}, 2, 2, 1, 0.5, 7), random));
  const double s = std::sqrt(0.5);
  for (int n = 0; n < 200; ++n) {
    const double y = n == 0 ? -1 + 2.0 / 7 : random.Uniform(-0.9, 0.9);
    const double z = 0.13 / s + random.Uniform(-0.02, 0.01);
    const auto contacts = ContactsOf(mesh, {0, y, z}, 0.14);
    ASSERT_EQ(contacts.size(), 2u);
    for (const MeshContact& contact : contacts) {
      EXPECT_NE(contact.feature, Feature::vertex);
      EXPECT_NEAR(contact.distance, z * s, 1e-12);
      ExpectNear({std::abs(contact.normal[0]), contact.normal[1], contact.normal[2]}, {s, 0, s},
                 1e-9);
    }
    EXPECT_LT(contacts[0].normal[0] * contacts[1].normal[0], 0);
  }
  // On one flank alone, with the bottom within reach: no contact with the bottom's edge.
  const auto contacts = ContactsOf(mesh, {0.06, 0, 0.2}, 0.19);
  ASSERT_EQ(contacts.size(), 2u);
  for (const MeshContact& contact : contacts) EXPECT_EQ(contact.feature, Feature::face);
  EXPECT_EQ(ContactsOf(mesh, {0.06, 0, 0.2}, 0.13).size(), 1u);
}

TEST(Contacts, ASurfaceAcrossPeriodicSidesHasNoRim) {
  RandomStream random(9);
  const Vector3 lower{0.1, -0.7, 0};
  const Vector3 periods{1.3, 0.9, 0};
  const auto count = [&](const TriangleMesh& mesh, const Vector3& centre, double radius) {
    std::vector<MeshContact> contacts;
    for (const double x : {-1, 0, 1}) {
      for (const double y : {-1, 0, 1}) {
        const Vector3 image = centre + Vector3{x * periods[0], y * periods[1], 0};
        for (const MeshContact& contact : ContactsOf(mesh, image, radius)) {
          contacts.push_back(contact);
        }
      }
    }
    mesh.KeepDistinct(radius, contacts);
    return contacts.size();
  };
  for (const auto& [n1, n2] : {std::pair{1, 1}, std::pair{1, 4}, std::pair{5, 7}}) {
    const Mesh plate =
        MakeRectangle("plate", lower, {periods[0], 0, 0}, {0, periods[1], 0}, n1, n2);
    const Mesh hills =
        MakeRidgedPlate("hills", lower, periods[0], periods[1], periods[0] / n1, 0.1, n2);
    TriangleMesh flat(plate, periods);
    TriangleMesh ridged(hills, periods);
    EXPECT_EQ(count(TriangleMesh(plate), lower + Vector3{0.01, 0.3, 0.19}, 0.2), 2u);
    for (const Vector3& displacement : {Vector3{}, Vector3{0.4, -0.2, 0}}) {
      flat.Place({kNoRotation, displacement});
      ridged.Place({kNoRotation, displacement});
      for (int n = 0; n < 300; ++n) {
        const double radius = random.Uniform(0.01, 0.2);
        Vector3 p{random.Uniform(0, periods[0]), random.Uniform(0, periods[1]), 0};
        if (n % 2 == 0) p[0] = random.Uniform(-1, 1) * std::pow(10, random.Uniform(-17, -1));
        if (n % 3 == 0) p[1] = random.Uniform(-1, 1) * std::pow(10, random.Uniform(-17, -1));
        const Vector3 foot = lower + displacement + p;
        EXPECT_EQ(count(flat, foot + Vector3{0, 0, random.Uniform(-1, 1) * radius}, radius), 1u);
        // In the valley that the side cuts, both flanks; without a ridge's end anywhere.
        const Vector3 valley{lower[0] + displacement[0], foot[1], 0};
        const double slope = 0.2 * n1 / periods[0];
        EXPECT_EQ(count(ridged, valley + Vector3{0, 0, 0.03}, 0.0301 / std::hypot(1, slope)), 2u);
      }
    }
  }
}

TEST(Contacts, ASphereWiderThanAGrooveRestsOnBothCrests) {
  const TriangleMesh mesh(MakeRidgedPlate("ridges", {0, 0, 0}, 4, 4, 1, 0.5, 2));
  const double height = 0.5 + std::sqrt(1 - 0.25) - 0.01;
  const auto contacts = ContactsOf(mesh, {2, 1.2, height}, 1);
  ASSERT_EQ(contacts.size(), 2u);
  for (const MeshContact& contact : contacts) {
    EXPECT_EQ(contact.feature, Feature::edge);
    EXPECT_NEAR(std::abs(contact.point[0] - 2), 0.5, 1e-12);
  }
}

TEST(Contacts, ThreeFacesOfAnInnerCorner) {
  Mesh box{.name = "box",
           .vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
           .triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}};
  const auto contacts = ContactsOf(TriangleMesh(box), {0.09, 0.08, 0.07}, 0.1);
  ASSERT_EQ(contacts.size(), 3u);
  EXPECT_NEAR(contacts[0].distance, 0.07, 1e-15);
  EXPECT_NEAR(contacts[2].distance, 0.09, 1e-15);
}

TEST(Contacts, AnEdgeOfThreeSheetsCountsOnce) {
  const Mesh fan{.name = "fan",
                 .vertices = {{0, 0, 0}, {0, 1, 0}, {1, 0.5, -1}, {-1, 0.5, -1}, {0, 0.5, -1}},
                 .triangles = {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}}};
  const TriangleMesh mesh(fan);
  EXPECT_EQ(mesh.edge_count(), 7u);
  const auto contacts = ContactsOf(mesh, {0.01, 0.4, 0.09}, 0.1);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_EQ(contacts[0].feature, Feature::edge);
}

TEST(Contacts, OfAThinPlateTheNearSideCounts) {
  Mesh plate = MakeRectangle("plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 2, 2);
  const Mesh below = MakeRectangle("", {0, 0, -0.001}, {1, 0, 0}, {0, 1, 0}, 3, 3);
  const int first = static_cast<int>(plate.vertices.size());
  plate.vertices.insert(plate.vertices.end(), below.vertices.begin(), below.vertices.end());
  for (const auto& [a, b, c] : below.triangles) {
    plate.triangles.push_back({first + a, first + b, first + c});
  }
  const TriangleMesh mesh(plate);
  const auto contacts = ContactsOf(mesh, {0.6, 0.3, 0.09}, 0.1);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(contacts[0].point[2], 0, 1e-15);
}

}  // namespace
}  // namespace powdercal::embedded

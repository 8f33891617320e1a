#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "backends/embedded/vector_math.h"
#include "backends/program.h"

namespace powdercal::embedded {

/// Where a body is: its reference point x0 is at rotation · x0 + translation.
struct Pose {
  Rotation rotation = kNoRotation;
  Vector3 translation{};  ///< [m]

  friend bool operator==(const Pose&, const Pose&) = default;
};

/// The pose after `time` [s] of a motion that began at `start`. Take `start` from the beginning of
/// the motion, not from the last step, and rounding does not add up.
Pose Moved(const Pose& start, const Motion& motion, double time);

/// What a point of a surface lies on. A face is open: its rim belongs to edges and vertices.
enum class Feature : std::uint8_t { face, edge, vertex };

/// A point of a mesh.
struct SurfacePoint {
  Vector3 point{};      ///< [m]
  double distance = 0;  ///< [m] from the point that was asked about, ≥ 0
  Feature feature = Feature::face;
  std::uint32_t id = 0;  ///< of the triangle, the edge or the vertex
};

/// A contact of a sphere with a mesh.
struct MeshContact {
  Vector3 point{};      ///< [m] of the mesh, nearest to the centre
  Vector3 normal{};     ///< unit vector from the mesh towards the centre
  double distance = 0;  ///< [m] from the point to the centre, in [0, radius)
  Feature feature = Feature::face;
  std::uint32_t id = 0;  ///< of the triangle, the edge or the vertex

  /// See state_stream.h.
  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream) {
    stream(self.point, self.normal, self.distance, self.feature, self.id);
  }
};

/// A sphere's index and that of a triangle near it.
using Candidate = std::pair<std::uint32_t, std::uint32_t>;

/// A rigid surface of triangles that acts on both of its sides, and its contacts with spheres.
///
/// Vertices of exactly equal coordinates are one; an edge is shared by all triangles that have both
/// of its ends. Edges on which a vertex of another triangle lies (T-junctions), gaps within
/// rounding and triangles that cut through each other are not recognised: near them a contact may
/// count twice. A plate of two layers must be thicker than any overlap, or a sphere that touches
/// one side may also feel the other (not where the sides are parallel).
///
/// The surface is stored where the program put it and queries are brought to it, so that moving the
/// mesh costs nothing. Queries change nothing and may run in several threads; they are meant for
/// coordinates up to some 1e5 radii.
class TriangleMesh {
 public:
  /// Throws InputError, naming the mesh and the triangle (counted from 0), if there are no
  /// triangles or one has an index out of range, a coordinate that is not finite, or is degenerate:
  /// its least height below 1e-9 of its longest edge.
  ///
  /// `periods` [m] are the domain's lengths along periodic axes, 0 along others: a surface that
  /// goes on across a periodic side (edges that meet when one is shifted by a period along any of
  /// the axes, within 1e-9 periods) has no rim there. Such a surface must not be turned.
  explicit TriangleMesh(const Mesh& mesh, const Vector3& periods = {});

  const std::string& name() const { return name_; }
  std::size_t triangle_count() const { return triangles_.size(); }
  std::size_t edge_count() const { return edges_.size(); }
  std::size_t vertex_count() const { return vertices_.size(); }
  /// In the order of the mesh's triangle.
  const std::array<std::uint32_t, 3>& VerticesOf(std::uint32_t triangle) const;
  /// Edge k joins vertices k and k + 1 (mod 3) of VerticesOf().
  const std::array<std::uint32_t, 3>& EdgesOf(std::uint32_t triangle) const;

  /// The rest is about the mesh as placed; the first pose is where the program put it.
  void Place(const Pose& pose);
  const Pose& pose() const { return pose_; }
  /// Sets what VelocityAt() gives: a velocity [m/s] and a spin [rad/s] about `centre` [m], where it
  /// is now. At first zero.
  void SetVelocity(const Vector3& velocity, const Vector3& spin, const Vector3& centre);
  /// Velocity [m/s] of the body's point that is at `point` [m].
  Vector3 VelocityAt(const Vector3& point) const;

  Vector3 Vertex(std::uint32_t vertex) const;  ///< [m]
  /// Unit vector; a triangle's corners turn about it in the right-hand sense.
  Vector3 Normal(std::uint32_t triangle) const;
  /// The box of the vertices, {lower, upper} [m].
  std::array<Vector3, 2> Bounds() const;

  /// The triangle's point nearest to `point`: that of the nearest edge among those beyond whose
  /// line the point lies, the projection where there is none. These are the regions of Ericson
  /// (Real-Time Collision Detection, 2005, §5.1.5), told by distances from the edges instead of
  /// products of barycentric coordinates, which lose their digits in needles.
  SurfacePoint ClosestPoint(std::uint32_t triangle, const Vector3& point) const;

  /// Replaces `out` by the contacts of a sphere, nearest first. `triangles` must hold all those
  /// that the sphere touches; more do no harm, their order does not matter. Periodic images are the
  /// caller's: one query for each image of the centre near the mesh, then KeepDistinct() on all
  /// that they gave.
  ///
  /// A contact is a point of the surface where the distance from the centre has a local minimum
  /// below `radius` [m]. Hence each counts once: a flat or convex surface gives one contact however
  /// it is cut, which goes from face to edge to face without a jump, and a groove gives one for
  /// each flank. A minimum at an edge or a vertex is checked against all triangles that share it,
  /// touched or not. Of minima within 1e-6 radii of each other, or in directions within 1e-3 rad
  /// (faces that are coplanar but for rounding, the far side of a thin plate) the nearest counts. A
  /// centre on the surface gets the normal of the face, of an edge or a vertex the mean normal.
  ///
  /// Where two facets meet in a hollow at less than √(2 overlap / radius) rad off flat, the second
  /// contact sets in with an overlap already, and the force jumps; convex surfaces have no such
  /// jumps.
  ///
  /// Features change as a sphere rolls; the contact of the step before is the one of nearest
  /// normal. Allocates only where `out` has to grow.
  void Contacts(const Vector3& centre, double radius, std::span<const std::uint32_t> triangles,
                std::vector<MeshContact>& out) const;
  /// The same for one sphere's stretch of what FindCandidates() found.
  void Contacts(const Vector3& centre, double radius, std::span<const Candidate> candidates,
                std::vector<MeshContact>& out) const;

  /// Sorts the contacts of one sphere of `radius` [m], nearest first, and drops those that repeat a
  /// nearer one, as a contact on a periodic side does that two images see.
  void KeepDistinct(double radius, std::vector<MeshContact>& contacts) const;

  /// Replaces `out` by all pairs of a sphere and a triangle not farther than radius + skin [m] from
  /// its centre, sorted. They serve until a sphere has moved by `skin` relative to the mesh. The
  /// time is nearly linear in spheres and triangles where radii are alike. Centres that are not
  /// finite have no candidates. Requires as many radii as centres, radii > 0, skin ≥ 0; periodic
  /// images are the caller's, as in Contacts().
  void FindCandidates(std::span<const Vector3> centres, std::span<const double> radii, double skin,
                      std::vector<Candidate>& out) const;

  /// Where it is and how it moves; see state_stream.h.
  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream) {
    stream(self.pose_, self.turned_, self.to_reference_, self.velocity_, self.spin_,
           self.spin_centre_);
  }

 private:
  struct Triangle {
    std::array<std::uint32_t, 3> vertices;
    std::array<std::uint32_t, 3> edges;
    Vector3 normal;
    std::array<Vector3, 3> outward;  // unit, in the plane, perpendicular to edge k
  };
  struct Edge {
    std::array<std::uint32_t, 2> vertices;
    Vector3 direction;  // unit, from the first to the second
    double length;
    std::uint32_t sides_begin;
    std::uint32_t sides_end;
  };
  struct Side {
    std::uint32_t triangle;
    std::uint32_t corner;  // the edge is its edges[corner]
  };
  struct Spoke {
    std::uint32_t edge;
    bool starts;  // the edge's direction is away from the vertex
  };
  class Bins;

  void WeldVertices(const Mesh& mesh);
  void MeasureTriangle(std::uint32_t triangle);
  void ConnectEdges();
  void ConnectVertices();
  void ConnectAcross(const Vector3& periods);
  std::vector<std::uint32_t> Counterparts(const Vector3& shift, const Vector3& periods) const;
  std::uint32_t FindEdge(std::uint32_t vertex1, std::uint32_t vertex2) const;
  double Tolerance(double radius) const;

  // All in the frame of the reference points.
  Vector3 ToReference(const Vector3& point) const;
  Vector3 FromReference(const Vector3& point) const;
  Vector3 Turned(const Vector3& direction) const;
  SurfacePoint NearestOnEdge(std::uint32_t edge, const Vector3& point) const;
  SurfacePoint NearestOnTriangle(std::uint32_t triangle, const Vector3& point) const;
  bool IsLocalMinimum(const SurfacePoint& foot, const Vector3& centre, double tolerance) const;
  Vector3 SurfaceNormal(const SurfacePoint& foot) const;
  MeshContact ToContact(const SurfacePoint& foot, const Vector3& centre, double radius) const;
  template <typename Items, typename TriangleOf>
  void CollectContacts(const Vector3& placed_centre, double radius, const Items& items,
                       TriangleOf triangle_of, std::vector<MeshContact>& out) const;

  std::string name_;
  std::vector<Vector3> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<Edge> edges_;                  // in the order of their vertices
  std::vector<Side> sides_;                  // of edges, one after the other
  std::vector<Spoke> spokes_;                // of vertices, one after the other
  std::vector<std::uint32_t> spokes_begin_;  // vertex_count() + 1
  std::array<Vector3, 2> bounds_{};          // of vertices_
  double rounding_ = 0;                      // [m] of coordinates, with a margin
  Pose pose_;
  bool turned_ = false;
  Rotation to_reference_ = kNoRotation;
  Vector3 velocity_{};
  Vector3 spin_{};
  Vector3 spin_centre_{};
};

}  // namespace powdercal::embedded

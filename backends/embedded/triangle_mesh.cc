#include "backends/embedded/triangle_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "backends/cell_grid.h"
#include "core/errors.h"

namespace powdercal::embedded {

namespace {

constexpr double kDegenerate = 1e-9;  // least height over longest edge

// In radii: a foot this far off a minimum still counts as one, so that rounding loses none. On a
// border one minimum may then show as two, which the next two tolerances, much wider, make one
// again.
constexpr double kMinimumTolerance = 1e-9;
constexpr double kSamePoint = 1000;            // of the tolerance
constexpr double kSameDirection = 1 - 0.5e-6;  // cosine of 1e-3 rad

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

struct Box {
  Vector3 lower;
  Vector3 upper;

  void Include(const Vector3& point) {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], point[axis]);
      upper[axis] = std::max(upper[axis], point[axis]);
    }
  }
  bool Contains(const Vector3& point) const {
    for (int axis = 0; axis < 3; ++axis) {
      // Also false where the coordinate is not a number.
      if (!(point[axis] >= lower[axis] && point[axis] <= upper[axis])) return false;
    }
    return true;
  }
  Box Grown(double margin) const {
    const Vector3 by{margin, margin, margin};
    return {lower - by, upper + by};
  }
};

bool IsFinite(const Vector3& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

// Least height over longest edge.
double Slimness(const Vector3& a, const Vector3& b, const Vector3& c) {
  const double longest = std::max({Length(b - a), Length(c - b), Length(a - c)});
  return Length(Cross(b - a, c - a)) / (longest * longest);
}

}  // namespace

Pose Moved(const Pose& start, const Motion& motion, double time) {
  const Vector3 path = time * motion.velocity;
  const Rotation turn = RotationBy(time * motion.spin);
  if (turn == kNoRotation) return {start.rotation, start.translation + path};
  return {turn * start.rotation, turn * (start.translation - motion.centre) + motion.centre + path};
}

TriangleMesh::TriangleMesh(const Mesh& mesh, const Vector3& periods) : name_(mesh.name) {
  if (mesh.triangles.empty()) throw InputError(fmt::format("mesh '{}' has no triangles", name_));
  WeldVertices(mesh);
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) MeasureTriangle(t);
  ConnectEdges();
  ConnectVertices();
  ConnectAcross(periods);
  Box box{vertices_.front(), vertices_.front()};
  for (const Vector3& v : vertices_) {
    box.Include(v);
    for (const double x : v) {
      rounding_ = std::max(rounding_, 32 * std::numeric_limits<double>::epsilon() * std::abs(x));
    }
  }
  bounds_ = {box.lower, box.upper};
}

void TriangleMesh::WeldVertices(const Mesh& mesh) {
  std::map<Vector3, std::uint32_t> ids;
  triangles_.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int index = mesh.triangles[t][k];
      if (index < 0 || static_cast<std::size_t>(index) >= mesh.vertices.size()) {
        throw InputError(fmt::format("mesh '{}': triangle {} has vertex {}, but there are {}",
                                     name_, t, index, mesh.vertices.size()));
      }
      const Vector3& position = mesh.vertices[index];
      if (!IsFinite(position)) {
        throw InputError(
            fmt::format("mesh '{}': triangle {}: vertex {} is not finite", name_, t, index));
      }
      const auto [entry, is_new] = ids.try_emplace(position, vertices_.size());
      if (is_new) vertices_.push_back(position);
      triangles_[t].vertices[k] = entry->second;
    }
  }
}

void TriangleMesh::MeasureTriangle(std::uint32_t triangle) {
  Triangle& t = triangles_[triangle];
  std::array<Vector3, 3> corners;
  for (int k = 0; k < 3; ++k) corners[k] = vertices_[t.vertices[k]];
  if (!(Slimness(corners[0], corners[1], corners[2]) >= kDegenerate)) {
    throw InputError(fmt::format("mesh '{}': triangle {} is degenerate", name_, triangle));
  }
  std::array<Vector3, 3> edges;
  int longest = 0;
  for (int k = 0; k < 3; ++k) {
    edges[k] = corners[(k + 1) % 3] - corners[k];
    if (Dot(edges[k], edges[k]) > Dot(edges[longest], edges[longest])) longest = k;
  }
  // The two shorter edges: the product of least rounding.
  t.normal = Unit(Cross(edges[(longest + 1) % 3], edges[(longest + 2) % 3]));
  for (int k = 0; k < 3; ++k) t.outward[k] = Unit(Cross(edges[k], t.normal));
}

void TriangleMesh::ConnectEdges() {
  struct Use {
    std::array<std::uint32_t, 2> vertices;
    Side side;
  };
  std::vector<Use> uses;
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const auto [low, high] =
          std::minmax(triangles_[t].vertices[k], triangles_[t].vertices[(k + 1) % 3]);
      uses.push_back({{low, high}, {t, k}});
    }
  }
  std::stable_sort(uses.begin(), uses.end(),
                   [](const Use& a, const Use& b) { return a.vertices < b.vertices; });
  for (const Use& use : uses) {
    if (edges_.empty() || edges_.back().vertices != use.vertices) {
      const Vector3 along = vertices_[use.vertices[1]] - vertices_[use.vertices[0]];
      const std::uint32_t begin = sides_.size();
      edges_.push_back({use.vertices, Unit(along), Length(along), begin, begin});
    }
    triangles_[use.side.triangle].edges[use.side.corner] = edges_.size() - 1;
    sides_.push_back(use.side);
    ++edges_.back().sides_end;
  }
}

void TriangleMesh::ConnectVertices() {
  std::vector<std::vector<Spoke>> spokes(vertices_.size());
  for (std::uint32_t e = 0; e < edges_.size(); ++e) {
    spokes[edges_[e].vertices[0]].push_back({e, true});
    spokes[edges_[e].vertices[1]].push_back({e, false});
  }
  spokes_begin_ = {0};
  for (const auto& of_vertex : spokes) {
    spokes_.insert(spokes_.end(), of_vertex.begin(), of_vertex.end());
    spokes_begin_.push_back(spokes_.size());
  }
}

// The vertex that is at each vertex's place when the mesh is shifted, or kNone.
std::vector<std::uint32_t> TriangleMesh::Counterparts(const Vector3& shift,
                                                      const Vector3& periods) const {
  const double tolerance = 1e-9 * std::max({periods[0], periods[1], periods[2]});
  std::vector<std::pair<Vector3, std::uint32_t>> sorted;
  Box box{vertices_[0], vertices_[0]};
  for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
    sorted.emplace_back(vertices_[v], v);
    box.Include(vertices_[v]);
  }
  std::sort(sorted.begin(), sorted.end());
  box = box.Grown(tolerance);
  std::vector<std::uint32_t> counterparts(vertices_.size(), kNone);
  for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
    const Vector3 place = vertices_[v] - shift;
    if (!box.Contains(place)) continue;
    auto near =
        std::lower_bound(sorted.begin(), sorted.end(), place[0] - tolerance,
                         [](const auto& entry, double lower) { return entry.first[0] < lower; });
    for (; near != sorted.end() && near->first[0] <= place[0] + tolerance; ++near) {
      if (Length(near->first - place) <= tolerance) counterparts[v] = near->second;
    }
  }
  return counterparts;
}

std::uint32_t TriangleMesh::FindEdge(std::uint32_t vertex1, std::uint32_t vertex2) const {
  const std::array<std::uint32_t, 2> vertices{std::min(vertex1, vertex2),
                                              std::max(vertex1, vertex2)};
  const auto found =
      std::lower_bound(edges_.begin(), edges_.end(), vertices,
                       [](const Edge& edge, const auto& sought) { return edge.vertices < sought; });
  if (found == edges_.end() || found->vertices != vertices) return kNone;
  return found - edges_.begin();
}

// Gives edges and vertices the sides and spokes of their images on the other periodic sides.
void TriangleMesh::ConnectAcross(const Vector3& periods) {
  std::vector<std::vector<std::uint32_t>> counterparts;  // no shift first
  const auto steps = [&](int axis) { return periods[axis] > 0 ? 3 : 1; };
  constexpr std::array<int, 3> kSteps = {0, -1, 1};
  for (int x = 0; x < steps(0); ++x) {
    for (int y = 0; y < steps(1); ++y) {
      for (int z = 0; z < steps(2); ++z) {
        const Vector3 shift{kSteps[x] * periods[0], kSteps[y] * periods[1], kSteps[z] * periods[2]};
        counterparts.push_back(Counterparts(shift, periods));
      }
    }
  }
  if (counterparts.size() == 1) return;

  std::vector<Side> sides;
  std::vector<std::array<std::uint32_t, 2>> ranges;
  for (const Edge& edge : edges_) {
    const std::uint32_t begin = sides.size();
    for (const auto& at : counterparts) {
      const auto [v, w] = std::pair(at[edge.vertices[0]], at[edge.vertices[1]]);
      const std::uint32_t image = v == kNone || w == kNone ? kNone : FindEdge(v, w);
      if (image == kNone) continue;
      sides.insert(sides.end(), sides_.begin() + edges_[image].sides_begin,
                   sides_.begin() + edges_[image].sides_end);
    }
    ranges.push_back({begin, static_cast<std::uint32_t>(sides.size())});
  }
  std::vector<Spoke> spokes;
  std::vector<std::uint32_t> spokes_begin = {0};
  for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
    for (const auto& at : counterparts) {
      if (at[v] == kNone) continue;
      spokes.insert(spokes.end(), spokes_.begin() + spokes_begin_[at[v]],
                    spokes_.begin() + spokes_begin_[at[v] + 1]);
    }
    spokes_begin.push_back(spokes.size());
  }
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    edges_[e].sides_begin = ranges[e][0];
    edges_[e].sides_end = ranges[e][1];
  }
  sides_ = std::move(sides);
  spokes_ = std::move(spokes);
  spokes_begin_ = std::move(spokes_begin);
}

const std::array<std::uint32_t, 3>& TriangleMesh::VerticesOf(std::uint32_t triangle) const {
  return triangles_[triangle].vertices;
}

const std::array<std::uint32_t, 3>& TriangleMesh::EdgesOf(std::uint32_t triangle) const {
  return triangles_[triangle].edges;
}

void TriangleMesh::Place(const Pose& pose) {
  pose_ = pose;
  turned_ = pose.rotation != kNoRotation;
  to_reference_ = Transposed(pose.rotation);
}

void TriangleMesh::SetVelocity(const Vector3& velocity, const Vector3& spin,
                               const Vector3& centre) {
  velocity_ = velocity;
  spin_ = spin;
  spin_centre_ = centre;
}

Vector3 TriangleMesh::VelocityAt(const Vector3& point) const {
  return velocity_ + Cross(spin_, point - spin_centre_);
}

Vector3 TriangleMesh::ToReference(const Vector3& point) const {
  const Vector3 shifted = point - pose_.translation;
  return turned_ ? to_reference_ * shifted : shifted;
}

Vector3 TriangleMesh::FromReference(const Vector3& point) const {
  return Turned(point) + pose_.translation;
}

Vector3 TriangleMesh::Turned(const Vector3& direction) const {
  return turned_ ? pose_.rotation * direction : direction;
}

Vector3 TriangleMesh::Vertex(std::uint32_t vertex) const {
  return FromReference(vertices_[vertex]);
}

Vector3 TriangleMesh::Normal(std::uint32_t triangle) const {
  return Turned(triangles_[triangle].normal);
}

std::array<Vector3, 2> TriangleMesh::Bounds() const {
  if (!turned_) return {FromReference(bounds_[0]), FromReference(bounds_[1])};
  Box box{Vertex(0), Vertex(0)};
  for (std::uint32_t v = 1; v < vertices_.size(); ++v) box.Include(Vertex(v));
  return {box.lower, box.upper};
}

SurfacePoint TriangleMesh::NearestOnEdge(std::uint32_t edge, const Vector3& point) const {
  const Edge& e = edges_[edge];
  const Vector3& start = vertices_[e.vertices[0]];
  const double along = Dot(point - start, e.direction);
  SurfacePoint foot{.point = start, .feature = Feature::vertex, .id = e.vertices[0]};
  if (along >= e.length) {
    foot.point = vertices_[e.vertices[1]];
    foot.id = e.vertices[1];
  } else if (along > 0) {
    foot.point = start + along * e.direction;
    foot.feature = Feature::edge;
    foot.id = edge;
  }
  foot.distance = Length(point - foot.point);
  return foot;
}

SurfacePoint TriangleMesh::NearestOnTriangle(std::uint32_t triangle, const Vector3& point) const {
  const Triangle& t = triangles_[triangle];
  SurfacePoint nearest;
  bool inside = true;
  for (int k = 0; k < 3; ++k) {
    if (Dot(point - vertices_[t.vertices[k]], t.outward[k]) < 0) continue;
    const SurfacePoint foot = NearestOnEdge(t.edges[k], point);
    if (inside || foot.distance < nearest.distance) nearest = foot;
    inside = false;
  }
  if (!inside) return nearest;
  const double height = Dot(point - vertices_[t.vertices[0]], t.normal);
  return {point - height * t.normal, std::abs(height), Feature::face, triangle};
}

SurfacePoint TriangleMesh::ClosestPoint(std::uint32_t triangle, const Vector3& point) const {
  SurfacePoint nearest = NearestOnTriangle(triangle, ToReference(point));
  nearest.point = FromReference(nearest.point);
  return nearest;
}

double TriangleMesh::Tolerance(double radius) const {
  return kMinimumTolerance * radius + rounding_;
}

// Whether every way along the surface leads away from the centre.
bool TriangleMesh::IsLocalMinimum(const SurfacePoint& foot, const Vector3& centre,
                                  double tolerance) const {
  const Vector3 offset = centre - foot.point;
  if (foot.feature == Feature::edge) {
    const Edge& edge = edges_[foot.id];
    for (std::uint32_t s = edge.sides_begin; s < edge.sides_end; ++s) {
      const Vector3& outward = triangles_[sides_[s].triangle].outward[sides_[s].corner];
      if (Dot(offset, outward) < -tolerance) return false;
    }
  } else if (foot.feature == Feature::vertex) {
    // The ways into a triangle are between those along its edges.
    for (std::uint32_t s = spokes_begin_[foot.id]; s < spokes_begin_[foot.id + 1]; ++s) {
      const double along = Dot(offset, edges_[spokes_[s].edge].direction);
      if ((spokes_[s].starts ? along : -along) > tolerance) return false;
    }
  }
  return true;
}

// The mean over the triangles that share the feature, all turned to the side of the first.
Vector3 TriangleMesh::SurfaceNormal(const SurfacePoint& foot) const {
  if (foot.feature == Feature::face) return triangles_[foot.id].normal;
  const Spoke own{foot.id, true};
  std::span<const Spoke> spokes(&own, 1);
  if (foot.feature == Feature::vertex) {
    spokes = {spokes_.begin() + spokes_begin_[foot.id],
              spokes_.begin() + spokes_begin_[foot.id + 1]};
  }
  const Vector3 first = triangles_[sides_[edges_[spokes[0].edge].sides_begin].triangle].normal;
  Vector3 sum{};
  for (const Spoke& spoke : spokes) {
    const Edge& edge = edges_[spoke.edge];
    for (std::uint32_t s = edge.sides_begin; s < edge.sides_end; ++s) {
      const Vector3& normal = triangles_[sides_[s].triangle].normal;
      sum = sum + (Dot(normal, first) < 0 ? -normal : normal);
    }
  }
  return Unit(sum);
}

MeshContact TriangleMesh::ToContact(const SurfacePoint& foot, const Vector3& centre,
                                    double radius) const {
  const Vector3 offset = centre - foot.point;
  Vector3 normal;
  if (foot.feature != Feature::face && foot.distance > Tolerance(radius)) {
    normal = (1 / foot.distance) * offset;
  } else {
    normal = SurfaceNormal(foot);
    const Vector3& corner =
        foot.feature == Feature::face ? vertices_[triangles_[foot.id].vertices[0]] : foot.point;
    if (Dot(centre - corner, normal) < 0) normal = -normal;
  }
  return {foot.point, normal, foot.distance, foot.feature, foot.id};
}

void TriangleMesh::KeepDistinct(double radius, std::vector<MeshContact>& contacts) const {
  std::sort(contacts.begin(), contacts.end(), [](const MeshContact& a, const MeshContact& b) {
    return std::tie(a.distance, a.feature, a.id) < std::tie(b.distance, b.feature, b.id);
  });
  const double same = kSamePoint * Tolerance(radius);
  std::size_t kept = 0;
  for (const MeshContact& contact : contacts) {
    const bool repeats =
        std::any_of(contacts.begin(), contacts.begin() + kept, [&](const MeshContact& nearer) {
          return Dot(nearer.normal, contact.normal) > kSameDirection ||
                 Length(nearer.distance * nearer.normal - contact.distance * contact.normal) < same;
        });
    if (!repeats) contacts[kept++] = contact;
  }
  contacts.resize(kept);
}

template <typename Items, typename TriangleOf>
void TriangleMesh::CollectContacts(const Vector3& placed_centre, double radius, const Items& items,
                                   TriangleOf triangle_of, std::vector<MeshContact>& out) const {
  out.clear();
  const Vector3 centre = ToReference(placed_centre);
  for (const auto& item : items) {
    const std::uint32_t triangle = triangle_of(item);
    assert(triangle < triangles_.size());
    const Triangle& t = triangles_[triangle];
    if (std::abs(Dot(centre - vertices_[t.vertices[0]], t.normal)) >= radius) continue;
    const SurfacePoint foot = NearestOnTriangle(triangle, centre);
    if (!(foot.distance < radius)) continue;  // nor where it is not a number
    if (!IsLocalMinimum(foot, centre, Tolerance(radius))) continue;
    out.push_back(ToContact(foot, centre, radius));
  }
  if (out.size() > 1) KeepDistinct(radius, out);
  for (MeshContact& contact : out) {
    contact.point = FromReference(contact.point);
    contact.normal = Turned(contact.normal);
  }
}

void TriangleMesh::Contacts(const Vector3& centre, double radius,
                            std::span<const std::uint32_t> triangles,
                            std::vector<MeshContact>& out) const {
  CollectContacts(
      centre, radius, triangles, [](std::uint32_t triangle) { return triangle; }, out);
}

void TriangleMesh::Contacts(const Vector3& centre, double radius,
                            std::span<const Candidate> candidates,
                            std::vector<MeshContact>& out) const {
  CollectContacts(
      centre, radius, candidates, [](const Candidate& pair) { return pair.second; }, out);
}

// The triangles by the cells of a grid in which a sphere's centre may be within `reach` of them.
class TriangleMesh::Bins {
 public:
  Bins(const TriangleMesh& mesh, double reach, std::size_t max_cells)
      : mesh_(mesh),
        reach_(reach * (1 + 1e-9)),  // against rounding
        box_(BoxOf(mesh.vertices_).Grown(reach_)),
        grid_(box_.lower, box_.upper, {false, false, false}, reach, max_cells) {
    const CellGrid::Cell last = grid_.CellOf(box_.upper);
    for (int axis = 0; axis < 3; ++axis) {
      cell_[axis] = (box_.upper[axis] - box_.lower[axis]) / (last[axis] + 1);
    }
    begin_.assign(grid_.size() + 1, 0);
    const auto triangles = static_cast<std::uint32_t>(mesh.triangles_.size());
    for (std::uint32_t t = 0; t < triangles; ++t) {
      ForCells(t, [&](std::size_t cell) { ++begin_[cell + 1]; });
    }
    for (std::size_t cell = 0; cell < grid_.size(); ++cell) begin_[cell + 1] += begin_[cell];
    entries_.resize(begin_.back());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (std::uint32_t t = 0; t < triangles; ++t) {
      ForCells(t, [&](std::size_t cell) { entries_[next[cell]++] = t; });
    }
  }

  /// In ascending order.
  std::span<const std::uint32_t> Near(const Vector3& centre) const {
    if (!box_.Contains(centre)) return {};
    const std::size_t cell = grid_.Index(grid_.CellOf(centre));
    return {entries_.begin() + begin_[cell], entries_.begin() + begin_[cell + 1]};
  }

 private:
  template <typename Points>
  static Box BoxOf(const Points& points) {
    Box box{points[0], points[0]};
    for (const Vector3& point : points) box.Include(point);
    return box;
  }

  template <typename Visit>
  void ForCells(std::uint32_t triangle, Visit&& visit) const {
    const Triangle& t = mesh_.triangles_[triangle];
    std::array<Vector3, 3> corners;
    for (int k = 0; k < 3; ++k) corners[k] = mesh_.vertices_[t.vertices[k]];
    const Box box = BoxOf(corners).Grown(reach_);
    const CellGrid::Cell from = grid_.CellOf(box.lower);
    const CellGrid::Cell to = grid_.CellOf(box.upper);
    const double far = (reach_ + 0.5 * Length(cell_)) * (1 + 1e-9);
    CellGrid::Cell cell;
    for (cell[2] = from[2]; cell[2] <= to[2]; ++cell[2]) {
      for (cell[1] = from[1]; cell[1] <= to[1]; ++cell[1]) {
        for (cell[0] = from[0]; cell[0] <= to[0]; ++cell[0]) {
          Vector3 middle;
          for (int axis = 0; axis < 3; ++axis) {
            middle[axis] = box_.lower[axis] + (cell[axis] + 0.5) * cell_[axis];
          }
          // Most cells of a slanting triangle's box are nowhere near its plane.
          if (std::abs(Dot(middle - corners[0], t.normal)) > far) continue;
          visit(grid_.Index(cell));
        }
      }
    }
  }

  const TriangleMesh& mesh_;
  double reach_;
  Box box_;
  CellGrid grid_;
  Vector3 cell_;  // edges of a cell
  std::vector<std::size_t> begin_;
  std::vector<std::uint32_t> entries_;
};

void TriangleMesh::FindCandidates(std::span<const Vector3> centres, std::span<const double> radii,
                                  double skin, std::vector<Candidate>& out) const {
  assert(centres.size() == radii.size() && skin >= 0);
  out.clear();
  if (centres.empty()) return;
  const double reach = *std::max_element(radii.begin(), radii.end()) + skin;
  const Bins bins(*this, reach, 1000 + 2 * (triangles_.size() + centres.size()));
  for (std::uint32_t s = 0; s < centres.size(); ++s) {
    const Vector3 centre = ToReference(centres[s]);
    for (const std::uint32_t t : bins.Near(centre)) {
      if (NearestOnTriangle(t, centre).distance <= radii[s] + skin) out.emplace_back(s, t);
    }
  }
}

}  // namespace powdercal::embedded

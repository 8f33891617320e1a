#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "backends/program.h"

namespace powdercal {

/// The surface of a wall as it stands at one moment.
struct SnapshotSurface {
  std::string name;
  std::vector<Vector3> vertices;              ///< [m]
  std::vector<std::array<int, 3>> triangles;  ///< indices of vertices
  std::optional<Vector3> force;  ///< [N] that the particles exert on it, where it is known
};

/// The part of an infinite plane that the domain's sides cut out, as a rectangle whose normal
/// points to the particles. `wall.position` may lie outside of the domain.
SnapshotSurface PlaneSurface(const PlaneWall& wall, const Domain& domain);

/// Writes the states of a simulation as VTK XML files, which ParaView shows as an animation.
///
/// `particles_000000.vtp`, …: a point with a vertex at each sphere's centre [m]; point data `id`
/// (Int64), `radius` [m], `diameter` [m], `velocity` [m/s], `spin` [rad/s]; the last three in
/// single precision. `walls_000000.vtp`, …: the triangles of all surfaces [m]; cell data `body`
/// (Int32: place in the span, name in the field data's `body_names`) and `force` [N], the whole
/// body's, NaN where it is not known. Left out while there are no surfaces. `particles.pvd`,
/// `walls.pvd`: the lists of these files with the simulated times [s]. They name finished files
/// only, at any moment, so that a run can be looked at while it goes on or after it was killed.
///
/// Not for several threads at once.
class SnapshotWriter {
 public:
  /// Makes the folder, and removes the snapshots of an earlier run from it.
  /// Throws std::runtime_error, which names the path.
  explicit SnapshotWriter(std::filesystem::path folder);

  /// Adds a snapshot. Times should grow, and the surfaces keep their order. Throws
  /// std::runtime_error, which names the file that could not be written; no list names it then.
  void Write(double time, std::span<const Sphere> spheres,
             std::span<const SnapshotSurface> surfaces);

  const std::filesystem::path& folder() const { return folder_; }

 private:
  /// Writes one file of a series and the list that has grown by it.
  void Add(std::string_view series, double time, std::string_view text, std::string& entries);

  std::filesystem::path folder_;
  int count_ = 0;                 ///< of the snapshots that were begun
  std::string particle_entries_;  ///< of the .pvd file
  std::string wall_entries_;
};

}  // namespace powdercal

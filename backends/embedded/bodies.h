#pragma once

#include <optional>
#include <string>
#include <vector>

#include "backends/embedded/kernels.h"
#include "backends/embedded/triangle_mesh.h"
#include "backends/program.h"

namespace powdercal::embedded {

/// Presses a body down on the bed with a force, by its velocity along z:
/// v = −(P e + ∫ P e dt/T), e = 1 − F/F_target, the particles' force F upward. The integral takes
/// away what a steady dilation or compaction of the bed would otherwise leave as an error; it
/// gathers where the force is within half of the target, so that it does not grow while a bed is
/// being reached or left.
struct ServoControl {
  double target = 0;         ///< [N] compressive, positive
  double speed = 0;          ///< [m/s] P, see ServoSpeed()
  double integral_time = 0;  ///< [s] T
  double max_velocity = 0;   ///< [m/s]
  double integral = 0;       ///< [m/s]

  /// Velocity along z for the next step [m/s] from the force of this one [N, upward].
  double Next(double force, double time_step);
};

/// What particles can touch, or are glued to, and that moves as one piece.
struct Body {
  std::string name;
  Vector3 displacement{};  ///< [m] since it was placed
  Vector3 velocity{};      ///< [m/s]
  Vector3 force{};         ///< [N] of the particles on it, in the last step; gravity of a glued
                           ///< group is not part of it
  std::optional<ServoControl> servo;
  bool removed = false;  ///< nothing touches it any more; not of glued groups

  /// See state_stream.h; so for the bodies below. What the program says is not in it.
  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream) {
    stream(self.displacement, self.velocity, self.force, self.servo, self.removed);
  }
};

struct PlaneBody : Body {
  PlaneWall wall;  ///< position as it is now
  LawConstants law;

  PlaneState State() const;

  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream) {
    Body::Transfer(self, stream);
    stream(self.wall.position);
  }
};

/// Glued particles; `members` are in the present order, of each slab.
struct GroupBody : Body {
  std::vector<std::vector<std::int32_t>> members;

  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream) {
    Body::Transfer(self, stream);
    stream(self.members);
  }
};

struct MeshBody : Body {
  /// `periods` as of TriangleMesh.
  MeshBody(const Mesh& mesh, const Vector3& periods) : surface(mesh, periods) { name = mesh.name; }

  TriangleMesh surface;
  LawConstants law;
  Motion motion;  ///< prescribed; without meaning while `moving` is false
  bool moving = false;
  double motion_time = 0;  ///< [s] since it began
  Pose motion_start;
  double reach = 0;  ///< [m] largest distance of a vertex from the centre of a turn

  /// Begins a prescribed motion from where the mesh is; a servo's velocity adds along z.
  void Start(const Motion& motion);
  void Stop();
  /// Moves on by a step, and tells the surface its velocity.
  void Advance(double time_step);
  /// Bound of the speed of any of its points [m/s].
  double Fastest() const;

  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream) {
    Body::Transfer(self, stream);
    stream(self.surface, self.motion.velocity, self.motion.spin, self.motion.centre, self.moving,
           self.motion_time, self.motion_start, self.reach);
  }
};

}  // namespace powdercal::embedded

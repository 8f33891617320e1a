#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "backends/liggghts/deck.h"
#include "backends/liggghts/stage_states.h"
#include "backends/particle_summary.h"
#include "backends/stage_bodies.h"

namespace powdercal::liggghts {
namespace {

constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
constexpr double kSmallestMesh = 1e-4;  // [m] LIGGGHTS refuses surfaces of less

std::string ExplainDmt(const Program& program) {
  if (program.law.cohesion != ContactLaw::Cohesion::dmt) return "";
  const auto particles = SummariseIfValid(program.particles);
  if (particles && !particles->OneSize()) {
    return "LIGGGHTS has DMT adhesion between spheres of one size only (as a liquid bridge, whose "
           "force goes with another mean of two radii than R*); use cohesion: sjkr2 or none, or "
           "one size";
  }
  const bool sticky = !program.meshes.empty() ||
                      std::any_of(program.walls.begin(), program.walls.end(),
                                  [](const PlaneWall& wall) { return !wall.frictionless; });
  if (sticky && program.materials.particle_wall.surface_energy != 0) {
    return "LIGGGHTS has no DMT adhesion at walls (its liquid bridges leave walls dry); use walls "
           "without surface energy, or cohesion: sjkr2 or none";
  }
  return "";
}

std::string ExplainLaw(const Program& program) {
  const ContactLaw& law = program.law;
  if (law.tangential == ContactLaw::Tangential::history &&
      law.shear_update == ContactLaw::ShearUpdate::incremental) {
    return "LIGGGHTS stores the tangential displacement, not the force; use shear_update: "
           "displacement";
  }
  double restitution = program.materials.particle_particle.restitution;
  if (!program.walls.empty() || !program.meshes.empty()) {
    restitution = std::min(restitution, program.materials.particle_wall.restitution);
  }
  if (law.normal == ContactLaw::Normal::hertz && restitution <= 0.05) {
    return fmt::format("LIGGGHTS takes restitutions above 0.05 only, not {}", restitution);
  }
  return ExplainDmt(program);
}

std::string ExplainMesh(const Mesh& mesh) {
  if (mesh.triangles.empty()) return fmt::format("mesh '{}' has no triangles", mesh.name);
  double lowest = HUGE_VAL;
  double highest = -HUGE_VAL;
  for (const Vector3& vertex : mesh.vertices) {
    for (const double x : vertex) {
      lowest = std::min(lowest, x);
      highest = std::max(highest, x);
    }
  }
  if (highest - lowest >= kSmallestMesh) return "";
  return fmt::format("mesh '{}' is too small for LIGGGHTS, which wants surfaces of 0.1 mm or more",
                     mesh.name);
}

std::string ExplainGroups(const Program& program) {
  if (std::string reason = ExplainGluedGroups(program); !reason.empty()) return reason;
  for (const GluedGroup& group : program.groups) {
    if (group.ids.empty()) return fmt::format("glued group '{}' is empty", group.name);
  }
  return "";
}

// Contacts with walls do not enter LIGGGHTS' stress of a particle.
std::string ExplainSlab(const Program& program) {
  if (!program.stress_slab) return "";
  const auto particles = SummariseIfValid(program.particles);
  if (!particles) return "";
  const double bottom = (*program.stress_slab)[0] - particles->largest_diameter;
  const double top = (*program.stress_slab)[1] + particles->largest_diameter;
  const auto touches = [](const std::string& body) {
    return fmt::format(
        "the slab for the stress is within a diameter of the largest particle of '{}': contacts "
        "with walls and meshes do not enter LIGGGHTS' stress",
        body);
  };
  const Servo* servo = FirstServo(program);
  const auto is_servo = [&](const std::string& body) {
    return servo != nullptr && servo->wall == body;
  };
  for (const PlaneWall& wall : program.walls) {
    if (is_servo(wall.name)) continue;
    const bool inside = wall.position > bottom && wall.position < top;
    if (wall.axis != 2 || inside) return touches(wall.name);
  }
  for (const Mesh& mesh : program.meshes) {
    if (is_servo(mesh.name)) continue;
    double lowest = HUGE_VAL;
    double highest = -HUGE_VAL;
    for (const Vector3& vertex : mesh.vertices) {
      lowest = std::min(lowest, vertex[2]);
      highest = std::max(highest, vertex[2]);
    }
    if (highest > bottom && lowest < top) return touches(mesh.name);
  }
  return "";
}

std::string ExplainGeometry(const Program& program) {
  const Domain& domain = program.domain;
  const auto particles = SummariseIfValid(program.particles);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool periodic = domain.boundaries[axis] == Boundary::periodic;
    // Contacts are told apart by the ids of their partners.
    if (periodic && particles && domain.Lengths()[axis] < 2 * particles->largest_diameter) {
      return fmt::format(
          "the domain is periodic in {} and less than two particles wide: in LIGGGHTS two "
          "particles touch at one place only",
          kAxes[axis]);
    }
    for (const PlaneWall& wall : program.walls) {
      if (periodic && wall.axis == static_cast<int>(axis)) {
        return fmt::format("wall '{}' lies across {}, in which the domain is periodic", wall.name,
                           kAxes[axis]);
      }
    }
  }
  for (const Mesh& mesh : program.meshes) {
    if (std::string reason = ExplainMesh(mesh); !reason.empty()) return reason;
  }
  if (std::string reason = ExplainGroups(program); !reason.empty()) return reason;
  if (std::string reason = ExplainSlab(program); !reason.empty()) return reason;
  if (!program.particles.contacts.empty()) {
    return "LIGGGHTS cannot be handed a contact history: its contacts begin without one";
  }
  return "";
}

// Goes through a program's stages and finds what LIGGGHTS cannot do.
class StageCheck {
 public:
  explicit StageCheck(const Program& program) : program_(program), bodies_(program) {}

  std::string Explain() {
    const std::vector<Stage>& stages = program_.stages;
    const bool inserts = !stages.empty() && std::holds_alternative<Insert>(stages.front());
    if (!inserts && !program_.particles.packing) {
      return "the stages have to begin with insert where no packing is given";
    }
    for (std::size_t i = inserts ? 1 : 0; i < stages.size(); ++i) {
      const std::string reason = std::visit([this](const auto& s) { return Check(s); }, stages[i]);
      if (!reason.empty()) return fmt::format("stage {} ({}): {}", i, StageName(stages[i]), reason);
    }
    return LastMoment(program_) ? "" : "no stage beyond insert";
  }

 private:
  static std::string Check(const Insert&) { return "particles are inserted at the beginning only"; }
  static std::string Check(const Settle&) { return ""; }
  std::string Check(const Servo& servo) {
    if (const std::string& first = FirstServo(program_)->wall; first != servo.wall) {
      return fmt::format("only one servo, and '{}' has it", first);
    }
    if (std::string reason = bodies_.ExplainAbsent(servo.wall); !reason.empty()) return reason;
    if (bodies_.Group(servo.wall)) {
      return fmt::format(
          "'{}' is a glued group: LIGGGHTS controls the stress of planes and meshes only",
          servo.wall);
    }
    if (std::string reason = bodies_.ExplainFacing(servo); !reason.empty()) return reason;
    bodies_.BeginServo();
    return "";
  }
  std::string Check(const Hold&) const { return bodies_.servo() ? "" : "no servo before it"; }
  std::string Check(const Advance& advance) const {
    for (const Motion& motion : advance.motions) {
      const std::string& body = motion.body;
      if (std::string reason = bodies_.ExplainAbsent(body); !reason.empty()) return reason;
      if (bodies_.Plane(body))
        return fmt::format("LIGGGHTS moves meshes and glued groups, not '{}'", body);
      if (const Servo* servo = FirstServo(program_); servo != nullptr && servo->wall == body) {
        return fmt::format("LIGGGHTS cannot move '{}', which has a servo", body);
      }
      if (motion.spin != Vector3{}) {
        return fmt::format("'{}' turns, which is not offered through LIGGGHTS", body);
      }
    }
    return "";
  }
  static std::string Check(const Deform&) {
    return "LIGGGHTS has no cell that deforms under a controlled stress, nor Lees-Edwards shear; "
           "between platens it can shear (shear: cell: platens)";
  }
  std::string Check(const Save& save) {
    if (program_.law.cohesion == ContactLaw::Cohesion::dmt) {
      return "LIGGGHTS' liquid bridges, which stand for DMT adhesion, cannot be saved";
    }
    return bodies_.Pass(save);
  }
  std::string Check(const Restore& restore) { return bodies_.Pass(restore); }
  std::string Check(const Remove& remove) {
    const Servo* servo = FirstServo(program_);
    return bodies_.Pass(remove, servo != nullptr ? servo->wall : "");
  }

  const Program& program_;
  StageBodies bodies_;
};

}  // namespace

std::string ExplainUnsupported(const Program& program) {
  if (std::string reason = ExplainLaw(program); !reason.empty()) return reason;
  if (std::string reason = ExplainGeometry(program); !reason.empty()) return reason;
  return StageCheck(program).Explain();
}

}  // namespace powdercal::liggghts

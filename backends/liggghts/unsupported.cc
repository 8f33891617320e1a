#include <fmt/format.h>

#include <algorithm>

#include "backends/liggghts/deck.h"
#include "backends/particle_summary.h"

namespace powdercal::liggghts {
namespace {

constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};

// Figures of the particles, where they can be told; else whoever places them explains.
std::optional<ParticleSummary> SummariseIfValid(const Particles& particles) {
  const bool valid =
      particles.packing ? !particles.packing->empty() : particles.sizes.ExplainInvalid().empty();
  return valid ? std::optional(Summarise(particles)) : std::nullopt;
}

std::string ExplainDmt(const Program& program) {
  if (program.law.cohesion != ContactLaw::Cohesion::dmt) return "";
  const auto particles = SummariseIfValid(program.particles);
  if (particles && !particles->OneSize()) {
    return "LIGGGHTS has DMT adhesion between spheres of one size only (as a liquid bridge, whose "
           "force goes with another mean of two radii than R*); use cohesion: sjkr2 or none, or "
           "one size";
  }
  const bool sticky = std::any_of(program.walls.begin(), program.walls.end(),
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
  if (!program.walls.empty()) {
    restitution = std::min(restitution, program.materials.particle_wall.restitution);
  }
  if (law.normal == ContactLaw::Normal::hertz && restitution <= 0.05) {
    return fmt::format("LIGGGHTS takes restitutions above 0.05 only, not {}", restitution);
  }
  return ExplainDmt(program);
}

std::string ExplainGeometry(const Program& program) {
  const Domain& domain = program.domain;
  const auto particles = SummariseIfValid(program.particles);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (domain.boundaries[axis] == Boundary::outflow) {
      return fmt::format(
          "the sides of the domain across {} let particles leave, which is not offered through "
          "LIGGGHTS yet",
          kAxes[axis]);
    }
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
  if (!program.meshes.empty()) return "meshes are not offered through LIGGGHTS yet";
  if (!program.groups.empty()) return "glued groups are not offered through LIGGGHTS yet";
  if (!program.particles.contacts.empty()) {
    return "LIGGGHTS cannot be handed a contact history: its contacts begin without one";
  }
  return "";
}

// Goes through a program's stages and finds what LIGGGHTS cannot do.
class StageCheck {
 public:
  explicit StageCheck(const Program& program) : program_(program) {}

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
    return stages.size() > (inserts ? 1 : 0) ? "" : "no stage beyond insert";
  }

 private:
  static std::string Check(const Insert&) { return "particles are inserted at the beginning only"; }
  static std::string Check(const Settle&) { return ""; }
  std::string Check(const Servo& servo) {
    if (servo_) return "only one servo";
    servo_ = true;
    const auto wall =
        std::find_if(program_.walls.begin(), program_.walls.end(),
                     [&](const PlaneWall& plane) { return plane.name == servo.wall; });
    if (wall == program_.walls.end()) return fmt::format("no wall '{}'", servo.wall);
    if (wall->axis != 2 || wall->facing_positive) {
      return fmt::format("the servo's wall '{}' has to face down", servo.wall);
    }
    return "";
  }
  std::string Check(const Hold&) const { return servo_ ? "" : "no servo before it"; }
  static std::string Check(const Advance& advance) {
    return advance.motions.empty() ? "" : "moving bodies are not offered through LIGGGHTS yet";
  }
  static std::string Check(const Deform&) {
    return "LIGGGHTS has no cell that deforms under a controlled stress, nor Lees-Edwards shear";
  }
  static std::string Check(const Save&) { return "not offered through LIGGGHTS yet"; }
  static std::string Check(const Restore&) { return "not offered through LIGGGHTS yet"; }
  static std::string Check(const Remove&) { return "not offered through LIGGGHTS yet"; }

  const Program& program_;
  bool servo_ = false;
};

}  // namespace

std::string ExplainUnsupported(const Program& program) {
  if (std::string reason = ExplainLaw(program); !reason.empty()) return reason;
  if (std::string reason = ExplainGeometry(program); !reason.empty()) return reason;
  return StageCheck(program).Explain();
}

}  // namespace powdercal::liggghts

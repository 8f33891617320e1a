#include "backends/embedded/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "backends/particle_summary.h"

namespace powdercal::embedded {
namespace {

bool FullyPeriodic(const Domain& domain) {
  return std::all_of(domain.boundaries.begin(), domain.boundaries.end(),
                     [](Boundary b) { return b == Boundary::periodic; });
}

// Names of all bodies; the first that is there twice goes to `twice`.
std::set<std::string> BodyNames(const Program& program, std::string* twice) {
  std::set<std::string> names;
  const auto add = [&](const std::string& name) {
    if (!names.insert(name).second && twice->empty()) *twice = name;
  };
  for (const PlaneWall& wall : program.walls) add(wall.name);
  for (const Mesh& mesh : program.meshes) add(mesh.name);
  for (const GluedGroup& group : program.groups) add(group.name);
  return names;
}

std::string ExplainNumbers(const Program& program) {
  const Materials& m = program.materials;
  if (!(program.time_step > 0)) return "the time step must be positive";
  if (!(m.density > 0)) return "the density must be positive";
  if (program.law.normal == ContactLaw::Normal::linear) {
    if (!(m.linear.normal > 0)) return "the linear normal law needs a positive stiffness";
    return "";
  }
  if (!(m.young_modulus > 0)) return "Young's modulus must be positive";
  if (!(m.poisson_ratio >= 0 && m.poisson_ratio < 1)) return "Poisson's ratio must be in [0, 1)";
  for (const ContactParameters* contact : {&m.particle_particle, &m.particle_wall}) {
    if (!(contact->restitution > 0 && contact->restitution <= 1)) {
      return "the restitution must be in (0, 1]";
    }
  }
  return "";
}

std::string ExplainDomain(const Program& program) {
  const Vector3 lengths = program.domain.Lengths();
  const double diameter = Summarise(program.particles).largest_diameter;
  static constexpr const char* kAxes[] = {"x", "y", "z"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(lengths[axis] > 0)) return fmt::format("the domain has no extent along {}", kAxes[axis]);
    if (program.domain.boundaries[axis] != Boundary::periodic) continue;
    if (lengths[axis] < 2.2 * diameter) {
      return fmt::format(
          "the domain is periodic along {} and {:.4g} m wide there: a particle of {:.4g} m would "
          "meet the same neighbour on two sides; at least 2.2 diameters are needed",
          kAxes[axis], lengths[axis], diameter);
    }
  }
  return "";
}

std::string ExplainSlab(const Program& program) {
  if (!program.stress_slab) return "";
  if (FullyPeriodic(program.domain)) {
    return "a cell that is periodic in x, y and z has no stress slab: its own stress is recorded";
  }
  if (program.domain.boundaries[2] == Boundary::periodic) {
    return "a stress slab needs a domain that is not periodic along z";
  }
  const auto [bottom, top] = *program.stress_slab;
  if (!(bottom < top) || !std::isfinite(bottom) || !std::isfinite(top)) {
    return fmt::format("the stress slab from {:.4g} to {:.4g} m has no height", bottom, top);
  }
  return "";
}

std::string ExplainBodies(const Program& program) {
  std::string twice;
  BodyNames(program, &twice);
  if (!twice.empty()) return fmt::format("two bodies are called '{}'", twice);
  for (const PlaneWall& wall : program.walls) {
    if (wall.axis < 0 || wall.axis > 2) return "a plane's axis must be 0, 1 or 2";
    if (program.domain.boundaries[static_cast<std::size_t>(wall.axis)] == Boundary::periodic) {
      return fmt::format("plane '{}' stands across a periodic axis", wall.name);
    }
  }
  if (!program.particles.packing) {
    if (!program.groups.empty()) return "glued groups need an explicit packing";
    if (!program.particles.contacts.empty()) return "contact histories need an explicit packing";
    return "";
  }
  std::set<std::int64_t> ids;
  for (const Sphere& sphere : *program.particles.packing) ids.insert(sphere.id);
  std::set<std::int64_t> glued;
  for (const GluedGroup& group : program.groups) {
    for (const std::int64_t id : group.ids) {
      if (!ids.contains(id)) {
        return fmt::format("group '{}' names particle {}, which does not exist", group.name, id);
      }
      if (!glued.insert(id).second) return fmt::format("particle {} is glued twice", id);
    }
  }
  return "";
}

class StageCheck {
 public:
  explicit StageCheck(const Program& program)
      : program_(program), names_(BodyNames(program, &unused_)) {}

  std::string Check() {
    for (std::size_t n = 0; n < program_.stages.size(); ++n) {
      if (n > 0 && std::holds_alternative<Insert>(program_.stages[n])) {
        return "particles can be inserted at the beginning only";
      }
      std::string problem =
          std::visit([this](const auto& stage) { return Check(stage); }, program_.stages[n]);
      if (!problem.empty()) return problem;
    }
    return "";
  }

 private:
  std::string Check(const Insert&) { return ""; }
  std::string Check(const Settle& settle) {
    return settle.check_interval > 0 ? "" : "settle: the check interval must be positive";
  }
  std::string Check(const Servo& servo) {
    if (!servo_wall_.empty() && servo.wall != servo_wall_) {
      return fmt::format("servo: '{}' has the program's servo, '{}' cannot have another",
                         servo_wall_, servo.wall);
    }
    if (const std::string problem = ExplainAbsent("servo", servo.wall); !problem.empty()) {
      return problem;
    }
    if (!(servo.stress > 0)) return "servo: the stress must be positive";
    if (!(servo.max_velocity > 0)) return "servo: the largest velocity must be positive";
    for (const PlaneWall& wall : program_.walls) {
      if (wall.name == servo.wall && (wall.axis != 2 || wall.facing_positive)) {
        return fmt::format("servo: plane '{}' does not face down", wall.name);
      }
    }
    servo_wall_ = servo.wall;
    state_.servo = true;
    return "";
  }
  std::string Check(const Hold& hold) {
    if (!state_.servo) return "hold: no servo stands before it";
    return hold.window > 0 ? "" : "hold: the window must be positive";
  }
  std::string Check(const Advance& advance) {
    for (const Motion& motion : advance.motions) {
      if (const std::string problem = ExplainAbsent(advance.name, motion.body); !problem.empty()) {
        return problem;
      }
      const bool turns = motion.spin != Vector3{};
      const bool mesh = std::any_of(program_.meshes.begin(), program_.meshes.end(),
                                    [&](const Mesh& m) { return m.name == motion.body; });
      if (turns && (!mesh || motion.body == servo_wall_)) {
        return fmt::format("{}: '{}' cannot turn, only a mesh without a servo can", advance.name,
                           motion.body);
      }
    }
    return "";
  }
  std::string Check(const Deform& deform) {
    if (!FullyPeriodic(program_.domain)) {
      return fmt::format("{}: only a cell that is periodic in x, y and z can be deformed",
                         deform.name);
    }
    if (!names_.empty()) return fmt::format("{}: the cell holds walls", deform.name);
    if (program_.gravity != Vector3{}) return fmt::format("{}: the cell has gravity", deform.name);
    for (const EdgeControl& edge : deform.edges) {
      if (edge.kind != EdgeControl::Kind::stress) continue;
      if (!(edge.value > 0)) return fmt::format("{}: stresses must be positive", deform.name);
      if (deform.shear_rate == 0 && !(deform.relaxation_rate > 0)) {
        return fmt::format("{}: stress control without shear needs a relaxation rate", deform.name);
      }
    }
    return "";
  }
  std::string Check(const Save& save) {
    if (saved_.emplace(save.name, state_).second) return "";
    return fmt::format("save: there are two states called '{}'", save.name);
  }
  std::string Check(const Restore& restore) {
    const auto saved = saved_.find(restore.name);
    if (saved == saved_.end()) {
      return fmt::format("restore: no state called '{}' was saved before", restore.name);
    }
    state_ = saved->second;
    return "";
  }
  std::string Check(const Remove& remove) {
    if (std::string problem = ExplainAbsent("remove", remove.body); !problem.empty()) {
      return problem;
    }
    if (remove.body == servo_wall_) {
      return fmt::format("remove: '{}' has a servo", remove.body);
    }
    const bool glued = std::any_of(program_.groups.begin(), program_.groups.end(),
                                   [&](const GluedGroup& g) { return g.name == remove.body; });
    if (glued) return fmt::format("remove: '{}' is a glued group", remove.body);
    state_.removed.insert(remove.body);
    return "";
  }

  std::string ExplainAbsent(const std::string& stage, const std::string& body) const {
    if (!names_.contains(body)) {
      return fmt::format("{}: there is no plane, mesh or glued group called '{}'", stage, body);
    }
    if (state_.removed.contains(body)) {
      return fmt::format("{}: '{}' was removed before", stage, body);
    }
    return "";
  }

  // What Restore brings back.
  struct State {
    bool servo = false;  // at work
    std::set<std::string> removed;
  };

  const Program& program_;
  std::string unused_;
  std::set<std::string> names_;
  std::string servo_wall_;
  State state_;
  std::map<std::string, State> saved_;
};

}  // namespace

std::string ExplainUnsupported(const Program& program) {
  for (const auto& explain : {ExplainNumbers, ExplainDomain, ExplainSlab, ExplainBodies}) {
    if (std::string problem = explain(program); !problem.empty()) return problem;
  }
  return StageCheck(program).Check();
}

}  // namespace powdercal::embedded

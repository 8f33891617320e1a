#include "backends/yade/unsupported.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "backends/particle_summary.h"
#include "backends/stage_bodies.h"

namespace powdercal::yade {
namespace {

constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};

bool IsFullyPeriodic(const Domain& domain) {
  return std::all_of(domain.boundaries.begin(), domain.boundaries.end(),
                     [](Boundary b) { return b == Boundary::periodic; });
}

bool HasSurfaces(const Program& program) {
  return !program.walls.empty() || !program.meshes.empty();
}

// --- The contact law ----------------------------------------------------------------------------

// The materials of contacts that can come about.
std::vector<const ContactParameters*> ContactsOf(const Program& program) {
  std::vector<const ContactParameters*> contacts = {&program.materials.particle_particle};
  if (HasSurfaces(program)) contacts.push_back(&program.materials.particle_wall);
  return contacts;
}

template <typename Is>
bool Any(const Program& program, const Is& is) {
  const std::vector<const ContactParameters*> contacts = ContactsOf(program);
  return std::any_of(contacts.begin(), contacts.end(),
                     [&](const ContactParameters* contact) { return is(*contact); });
}

bool IsDamped(const Program& program) {
  if (program.law.normal == ContactLaw::Normal::linear) {
    return program.materials.linear.normal_damping != 0;
  }
  return Any(program, [](const ContactParameters& c) { return c.restitution < 1; });
}

bool Sticks(const Program& program) {
  return program.law.cohesion == ContactLaw::Cohesion::dmt &&
         Any(program, [](const ContactParameters& c) { return c.surface_energy != 0; });
}

bool Rolls(const Program& program) {
  return program.law.rolling != ContactLaw::Rolling::none &&
         Any(program, [](const ContactParameters& c) { return c.rolling_friction != 0; });
}

std::string ExplainTangential(const Program& program) {
  const ContactLaw& law = program.law;
  if (!Any(program, [](const ContactParameters& c) { return c.friction != 0; })) return "";
  if (law.tangential == ContactLaw::Tangential::no_history) {
    return "YADE has no law without tangential history; use tangential: history";
  }
  if (law.normal == ContactLaw::Normal::hertz &&
      law.shear_update == ContactLaw::ShearUpdate::displacement) {
    return "YADE sums up the tangential force, not the displacement; use shear_update: incremental";
  }
  return "";
}

std::string ExplainDmt(const Program& program) {
  if (program.law.cohesion != ContactLaw::Cohesion::dmt || !Sticks(program)) return "";
  if (program.law.normal == ContactLaw::Normal::linear) {
    return "YADE has adhesion with the Hertz law only; use normal: hertz, or cohesion: none";
  }
  if (program.law.tangential_reduce) {
    return "YADE does not reduce friction by adhesion; use tangential_reduce: false";
  }
  const Materials& m = program.materials;
  if (!HasSurfaces(program)) return "";
  const bool smooth = std::any_of(program.walls.begin(), program.walls.end(),
                                  [](const PlaneWall& wall) { return wall.frictionless; });
  if (smooth) {
    return "YADE's DMT adhesion holds at every contact, at frictionless walls too; use walls with "
           "friction, a periodic cell, or cohesion: none";
  }
  if (m.particle_wall.surface_energy != m.particle_particle.surface_energy) {
    return fmt::format(
        "YADE has one surface energy for all contacts, not {} J/m2 between particles and {} J/m2 "
        "at walls",
        m.particle_particle.surface_energy, m.particle_wall.surface_energy);
  }
  return "";
}

std::string ExplainCohesion(const Program& program) {
  const bool sjkr2 = program.law.cohesion == ContactLaw::Cohesion::sjkr2;
  if (sjkr2 &&
      Any(program, [](const ContactParameters& c) { return c.cohesion_energy_density != 0; })) {
    return "YADE has no SJKR2 cohesion; use cohesion: dmt with a surface energy, or none; embedded "
           "and liggghts have SJKR2";
  }
  return ExplainDmt(program);
}

std::string ExplainRolling(const Program& program) {
  const ContactLaw& law = program.law;
  if (!Rolls(program)) return "";
  if (law.rolling == ContactLaw::Rolling::cdt) {
    return "YADE has no CDT rolling friction; use rolling: epsd2 or none";
  }
  if (law.normal == ContactLaw::Normal::linear) {
    return "YADE has rolling friction with the Hertz law only; use rolling: none";
  }
  if (law.torsion) {
    return "YADE's resistance to torsion has no limit; use torsion: false";
  }
  if (Sticks(program)) {
    return "YADE limits rolling friction by the force with adhesion in it, not by the elastic "
           "force; use rolling: none with DMT adhesion";
  }
  if (HasSurfaces(program)) {
    return "YADE's limit of rolling friction is wrong at planes and meshes, whose radius it takes "
           "for 1e8 of the particle's; use rolling: none, or a periodic cell";
  }
  const auto particles = SummariseIfValid(program.particles);
  if (particles && !particles->OneSize()) {
    return "YADE limits rolling friction by the mean of two radii, which is 2 R* for particles of "
           "one size only; use one size, or rolling: none";
  }
  return "";
}

std::string ExplainNormal(const Program& program) {
  const ContactLaw& law = program.law;
  if (!law.limit_force && IsDamped(program)) {
    return "YADE never lets the dashpot pull; use limit_force: true";
  }
  if (law.normal == ContactLaw::Normal::hertz) return "";
  const bool deforms =
      std::any_of(program.stages.begin(), program.stages.end(),
                  [](const Stage& s) { return std::holds_alternative<Deform>(s); });
  if (!deforms) return "";
  return "YADE's linear law takes the velocity of periodic images with the wrong sign where the "
         "cell deforms; use normal: hertz";
}

// First what takes another law, then what takes another option.
std::string ExplainLaw(const Program& program) {
  for (const auto& explain : {ExplainCohesion, ExplainRolling, ExplainTangential, ExplainNormal}) {
    if (std::string reason = explain(program); !reason.empty()) return reason;
  }
  return "";
}

// --- Numbers, domain, bodies --------------------------------------------------------------------

std::string ExplainNumbers(const Program& program) {
  const Materials& m = program.materials;
  if (!(program.time_step > 0)) return "the time step must be positive";
  if (!(m.density > 0)) return "the density must be positive";
  if (program.law.normal == ContactLaw::Normal::linear) {
    return m.linear.normal > 0 ? "" : "the linear normal law needs a positive stiffness";
  }
  if (!(m.young_modulus > 0)) return "Young's modulus must be positive";
  if (!(m.poisson_ratio >= 0 && m.poisson_ratio < 1)) return "Poisson's ratio must be in [0, 1)";
  if (Any(program,
          [](const ContactParameters& c) { return !(c.restitution > 0 && c.restitution <= 1); })) {
    return "the restitution must be in (0, 1]";
  }
  return "";
}

std::string ExplainDomain(const Program& program) {
  const Domain& domain = program.domain;
  const Vector3 lengths = domain.Lengths();
  const bool cell = IsFullyPeriodic(domain);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(lengths[axis] > 0)) return fmt::format("the domain has no extent along {}", kAxes[axis]);
    if (domain.boundaries[axis] == Boundary::periodic && !cell) {
      return fmt::format(
          "the domain is periodic along {} but not along all axes: in YADE planes and meshes do "
          "not work in a periodic domain. Consolidation and spreading have `sides: walls` for it, "
          "shear `cell: periodic`",
          kAxes[axis]);
    }
  }
  const auto particles = SummariseIfValid(program.particles);
  if (!cell || !particles) return "";
  if (HasSurfaces(program)) return "in YADE planes and meshes do not work in a periodic domain";
  const double smallest = 2.2 * particles->largest_diameter;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (lengths[axis] >= smallest) continue;
    return fmt::format("the domain is periodic along {} and less than 2.2 particles wide there",
                       kAxes[axis]);
  }
  return "";
}

std::string ExplainGroups(const Program& program) {
  if (program.particles.packing && program.groups.size() > 16) {
    return "more than 16 glued groups are not offered through YADE";
  }
  return ExplainGluedGroups(program);
}

std::string ExplainBodies(const Program& program) {
  std::set<std::string> names;
  const auto twice = [&](const auto& bodies) -> std::string {
    for (const auto& body : bodies) {
      if (!names.insert(body.name).second) {
        return fmt::format("two bodies are called '{}'", body.name);
      }
    }
    return "";
  };
  if (std::string reason = twice(program.walls); !reason.empty()) return reason;
  if (std::string reason = twice(program.meshes); !reason.empty()) return reason;
  if (std::string reason = twice(program.groups); !reason.empty()) return reason;
  for (const PlaneWall& wall : program.walls) {
    if (wall.axis < 0 || wall.axis > 2) return "a plane's axis must be 0, 1 or 2";
  }
  for (const Mesh& mesh : program.meshes) {
    if (mesh.triangles.empty()) return fmt::format("mesh '{}' has no triangles", mesh.name);
  }
  if (program.stress_slab) return "the stress in a slab of the bed is not recorded through YADE";
  if (!program.particles.contacts.empty()) {
    return "YADE cannot be handed a contact history: its contacts begin without one";
  }
  return ExplainGroups(program);
}

// --- Stages -------------------------------------------------------------------------------------

// Goes through a program's stages and finds what cannot be done.
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
    return "";
  }

 private:
  static std::string Check(const Insert&) { return "particles are inserted at the beginning only"; }
  static std::string Check(const Settle& settle) {
    return settle.check_interval > 0 ? "" : "the check interval must be positive";
  }
  std::string Check(const Servo& servo) {
    if (!servo_wall_.empty() && servo.wall != servo_wall_) {
      return fmt::format("only one servo, and '{}' has it", servo_wall_);
    }
    if (std::string reason = bodies_.ExplainAbsent(servo.wall); !reason.empty()) return reason;
    if (bodies_.Group(servo.wall)) {
      return fmt::format(
          "'{}' is a glued group: through YADE the stress of planes and meshes only is controlled",
          servo.wall);
    }
    if (!(servo.stress > 0)) return "the stress must be positive";
    if (!(servo.max_velocity > 0)) return "the largest velocity must be positive";
    if (std::string reason = bodies_.ExplainFacing(servo); !reason.empty()) return reason;
    servo_wall_ = servo.wall;
    bodies_.BeginServo();
    return "";
  }
  std::string Check(const Hold& hold) const {
    if (!bodies_.servo()) return "no servo before it";
    return hold.window > 0 ? "" : "the window must be positive";
  }
  std::string Check(const Advance& advance) const {
    for (const Motion& motion : advance.motions) {
      if (std::string reason = bodies_.ExplainAbsent(motion.body); !reason.empty()) return reason;
      if (motion.spin != Vector3{}) {
        return fmt::format("'{}' turns, which is not offered through YADE", motion.body);
      }
    }
    return "";
  }
  std::string Check(const Deform& deform) const {
    if (!IsFullyPeriodic(program_.domain)) {
      return "only a cell that is periodic in x, y and z can be deformed";
    }
    if (!program_.groups.empty()) return "the cell holds glued particles";
    if (program_.gravity != Vector3{}) return "the cell has gravity";
    for (const EdgeControl& edge : deform.edges) {
      if (edge.kind != EdgeControl::Kind::stress) continue;
      if (!(edge.value > 0)) return "stresses must be positive";
      if (deform.shear_rate == 0 && !(deform.relaxation_rate > 0)) {
        return "stress control without shear needs a relaxation rate";
      }
    }
    return "";
  }
  std::string Check(const Save& save) { return bodies_.Pass(save); }
  std::string Check(const Restore& restore) { return bodies_.Pass(restore); }
  std::string Check(const Remove& remove) { return bodies_.Pass(remove, servo_wall_); }

  const Program& program_;
  std::string servo_wall_;
  StageBodies bodies_;
};

}  // namespace

std::string ExplainUnsupported(const Program& program) {
  for (const auto& explain : {ExplainNumbers, ExplainLaw, ExplainDomain, ExplainBodies}) {
    if (std::string reason = explain(program); !reason.empty()) return reason;
  }
  return StageCheck(program).Explain();
}

std::string DescribeLaw(const Program& program) {
  if (program.law.normal == ContactLaw::Normal::linear) {
    return "ViscElMat with kn, ks, cn, cs; Law2_ScGeom_ViscElPhys_Basic";
  }
  std::string law = "Law2_ScGeom_MindlinPhys_Mindlin with betan = betas";
  if (Sticks(program)) {
    law +=
        ", includeAdhesion (friction at most mu (F_DMT + |F_n|), dashpot at most F_DMT where the "
        "net force pulls)";
  }
  if (Rolls(program)) law += ", includeMoment (constant krot; eta R_mean = mu_r R*)";
  return law;
}

}  // namespace powdercal::yade

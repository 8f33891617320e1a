#include "backends/stage_bodies.h"

#include <fmt/format.h>

#include <algorithm>

namespace powdercal {
namespace {

template <typename Body>
bool Names(const std::vector<Body>& bodies, const std::string& name) {
  return std::any_of(bodies.begin(), bodies.end(),
                     [&](const Body& body) { return body.name == name; });
}

}  // namespace

bool StageBodies::Plane(const std::string& body) const { return Names(program_.walls, body); }
bool StageBodies::Group(const std::string& body) const { return Names(program_.groups, body); }

std::string StageBodies::ExplainAbsent(const std::string& body) const {
  if (!Plane(body) && !Names(program_.meshes, body) && !Group(body)) {
    return fmt::format("no wall, mesh or group '{}'", body);
  }
  return state_.removed.contains(body) ? fmt::format("'{}' was removed before", body) : "";
}

std::string StageBodies::ExplainFacing(const Servo& servo) const {
  for (const PlaneWall& wall : program_.walls) {
    if (wall.name == servo.wall && (wall.axis != 2 || wall.facing_positive)) {
      return fmt::format("the servo's wall '{}' has to face down", servo.wall);
    }
  }
  return "";
}

std::string StageBodies::Pass(const Save& save) {
  if (saved_.emplace(save.name, state_).second) return "";
  return fmt::format("there are two states '{}'", save.name);
}

std::string StageBodies::Pass(const Restore& restore) {
  const auto saved = saved_.find(restore.name);
  if (saved == saved_.end()) return fmt::format("no state '{}' was saved", restore.name);
  state_ = saved->second;
  return "";
}

std::string StageBodies::Pass(const Remove& remove, const std::string& servo_wall) {
  const std::string& body = remove.body;
  if (std::string reason = ExplainAbsent(body); !reason.empty()) return reason;
  if (Group(body)) return fmt::format("'{}' is a glued group", body);
  if (body == servo_wall) return fmt::format("'{}' has a servo", body);
  state_.removed.insert(body);
  return "";
}

std::string ExplainGluedGroups(const Program& program) {
  if (program.groups.empty()) return "";
  if (!program.particles.packing) return "glued groups need an explicit packing";
  std::set<std::int64_t> free;
  for (const Sphere& sphere : *program.particles.packing) free.insert(sphere.id);
  for (const GluedGroup& group : program.groups) {
    for (const std::int64_t id : group.ids) {
      if (free.erase(id) == 0) {
        return fmt::format("glued group '{}': there is no particle {} that is not glued already",
                           group.name, id);
      }
    }
  }
  return free.empty() ? "all particles are glued" : "";
}

}  // namespace powdercal

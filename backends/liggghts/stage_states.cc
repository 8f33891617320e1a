#include "backends/liggghts/stage_states.h"

#include <algorithm>
#include <cmath>

namespace powdercal::liggghts {
namespace {

double Lowest(const Mesh& mesh) {
  double lowest = HUGE_VAL;
  for (const Vector3& vertex : mesh.vertices) lowest = std::min(lowest, vertex[2]);
  return lowest;
}

std::map<std::string, BodyState> FirstBodies(const Program& program) {
  std::map<std::string, BodyState> bodies;
  for (const PlaneWall& wall : program.walls) bodies[wall.name].height = wall.position;
  for (const Mesh& mesh : program.meshes) bodies[mesh.name].height = Lowest(mesh);
  for (const GluedGroup& group : program.groups) bodies[group.name] = {};
  if (const Servo* servo = FirstServo(program)) bodies.erase(servo->wall);
  return bodies;
}

// Bodies at the end of a stage, at rest.
void MoveOn(StageState& state, double duration) {
  for (auto& [name, body] : state.bodies) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      body.displacement[axis] += body.velocity[axis] * duration;
    }
    body.height += body.velocity[2] * duration;
    body.velocity = {};
  }
}

}  // namespace

const Servo* FirstServo(const Program& program) {
  for (const Stage& stage : program.stages) {
    if (const auto* servo = std::get_if<Servo>(&stage)) return servo;
  }
  return nullptr;
}

bool LeavesMoment(const Stage& stage) {
  return !std::holds_alternative<Insert>(stage) && !std::holds_alternative<Save>(stage) &&
         !std::holds_alternative<Restore>(stage) && !std::holds_alternative<Remove>(stage);
}

std::optional<std::size_t> LastMoment(const Program& program) {
  for (std::size_t i = program.stages.size(); i-- > 0;) {
    if (LeavesMoment(program.stages[i])) return i;
  }
  return std::nullopt;
}

bool HasOutflow(const Program& program) {
  const auto& boundaries = program.domain.boundaries;
  return std::find(boundaries.begin(), boundaries.end(), Boundary::outflow) != boundaries.end();
}

std::vector<StageState> StatesOf(const Program& program, const std::vector<double>& ends) {
  std::vector<StageState> states;
  std::map<std::string, StageState> saved;
  StageState now{.bodies = FirstBodies(program)};
  for (std::size_t i = 0; i < program.stages.size(); ++i) {
    const Stage& stage = program.stages[i];
    if (const auto* servo = std::get_if<Servo>(&stage)) now.servo = servo;
    if (const auto* restore = std::get_if<Restore>(&stage)) {
      const double begin = now.begin;
      now = saved.at(restore->name);
      now.begin = begin;
    }
    if (const auto* remove = std::get_if<Remove>(&stage)) now.bodies.erase(remove->body);
    if (const auto* advance = std::get_if<Advance>(&stage)) {
      for (const Motion& motion : advance->motions) {
        now.bodies.at(motion.body).velocity = motion.velocity;
      }
    }
    states.push_back(now);
    MoveOn(now, (ends[i] - now.begin) * program.time_step);
    now.begin = ends[i];
    if (const auto* save = std::get_if<Save>(&stage)) saved[save->name] = now;
  }
  return states;
}

}  // namespace powdercal::liggghts

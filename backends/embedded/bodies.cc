#include "backends/embedded/bodies.h"

#include <algorithm>
#include <cmath>

#include "backends/embedded/vector_math.h"

namespace powdercal::embedded {

double ServoControl::Next(double force, double time_step) {
  const double error = 1 - force / target;
  if (integral_time > 0 && (std::abs(error) < 0.5 || error * integral < 0)) {
    integral += speed * error * time_step / integral_time;
    integral = std::clamp(integral, -speed, speed);
  }
  return -std::clamp(speed * error + integral, -max_velocity, max_velocity);
}

PlaneState PlaneBody::State() const {
  PlaneState state;
  const auto axis = static_cast<std::size_t>(wall.axis);
  const double sign = wall.facing_positive ? 1 : -1;
  state.normal[axis] = sign;
  state.offset = sign * wall.position;
  for (std::size_t a = 0; a < 3; ++a) state.velocity[a] = velocity[a];
  return state;
}

void MeshBody::Start(const Motion& prescribed) {
  motion = prescribed;
  moving = true;
  motion_time = 0;
  motion_start = surface.pose();
  reach = 0;
  for (std::uint32_t v = 0; v < surface.vertex_count(); ++v) {
    reach = std::max(reach, Length(surface.Vertex(v) - motion.centre));
  }
  velocity = prescribed.velocity;
  surface.SetVelocity(motion.velocity, motion.spin, motion.centre);
}

void MeshBody::Stop() {
  moving = false;
  velocity = {};
  surface.SetVelocity({}, {}, {});
}

void MeshBody::Advance(double time_step) {
  if (servo) {  // velocity[2] is the servo's
    displacement = displacement + time_step * velocity;
    Pose pose = surface.pose();
    pose.translation = pose.translation + time_step * velocity;
    surface.Place(pose);
    surface.SetVelocity(velocity, {}, {});
    return;
  }
  if (!moving) return;
  motion_time += time_step;
  displacement = displacement + time_step * motion.velocity;
  surface.Place(Moved(motion_start, motion, motion_time));
  surface.SetVelocity(motion.velocity, motion.spin, motion.centre + motion_time * motion.velocity);
}

double MeshBody::Fastest() const {
  return Length(velocity) + (moving ? Length(motion.spin) * reach : 0);
}

}  // namespace powdercal::embedded

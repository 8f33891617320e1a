#include "backends/servo_gain.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "backends/particle_summary.h"
#include "scaling/groups.h"

namespace powdercal {
namespace {

bool IsFrictionless(const Program& program, const std::string& wall) {
  return std::any_of(program.walls.begin(), program.walls.end(), [&](const PlaneWall& plane) {
    return plane.name == wall && plane.frictionless;
  });
}

// gamma_n of the Hertz law at a wall for a sphere of diameter d that bears the force.
double HertzDamping(const Program& program, const Servo& servo, double d, double force) {
  const Materials& m = program.materials;
  const ContactParameters& wall = m.particle_wall;
  if (wall.restitution >= 1) return 0;
  const bool sticks = !IsFrictionless(program, servo.wall);
  const double radius = d / 2;
  // Effective modulus of two like bodies, as the canonical law takes it for walls.
  const double modulus = EffectiveModulus(m.young_modulus, m.poisson_ratio);
  const double mass = m.density * std::numbers::pi / 6 * d * d * d;
  const double sjkr2 = sticks && program.law.cohesion == ContactLaw::Cohesion::sjkr2
                           ? 2 * std::numbers::pi * wall.cohesion_energy_density * radius
                           : 0;
  const double dmt = sticks && program.law.cohesion == ContactLaw::Cohesion::dmt
                         ? PullOffForceDmt(wall.surface_energy, radius)
                         : 0;
  // Overlap under the load: (4/3) E* √R δ^1.5 − cohesion(δ) = F, by bisection.
  const auto excess = [&](double delta) {
    return 4.0 / 3.0 * modulus * std::sqrt(radius) * std::pow(delta, 1.5) - sjkr2 * delta - dmt -
           force;
  };
  double low = 0;
  double high = radius;
  while (excess(high) < 0) high *= 2;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(middle) < 0 ? low : high) = middle;
  }
  const double log_e = std::log(wall.restitution);
  const double beta = -log_e / std::hypot(log_e, std::numbers::pi);
  const double stiffness = 2 * modulus * std::sqrt(radius * high);
  return 2 * std::sqrt(5.0 / 6.0) * beta * std::sqrt(stiffness * mass);
}

double Damping(const Program& program, const Servo& servo, double d, double force) {
  return program.law.normal == ContactLaw::Normal::linear ? program.materials.linear.normal_damping
                                                          : HertzDamping(program, servo, d, force);
}

}  // namespace

double ServoSpeed(const Program& program, const Servo& servo) {
  const double d = Summarise(program.particles).mean_diameter;
  const double area = program.domain.BaseArea();
  const double contacts = 0.5 * area / (d * d);
  const double force = servo.stress * area;
  const double damping = Damping(program, servo, d, force / contacts);
  if (damping == 0) return servo.max_velocity;
  return std::min(servo.max_velocity, 0.3 * force / (contacts * damping));
}

double ServoGain(const Program& program, const Servo& servo) {
  const double d = Summarise(program.particles).mean_diameter;
  const double area = program.domain.BaseArea();
  const double contacts = 0.5 * area / (d * d);
  const double force = servo.stress * area;
  return ServoSpeed(program, servo) * contacts * Damping(program, servo, d, force / contacts) /
         force;
}

}  // namespace powdercal

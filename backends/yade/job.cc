#include "backends/yade/job.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "backends/particle_summary.h"
#include "backends/servo_gain.h"
#include "scaling/groups.h"

namespace powdercal::yade {
namespace {

using nlohmann::json;

constexpr double kOverlapWithoutStress = 1e-3;  // [R*]

// The first stress of the program [Pa], 0 if there is none.
double FirstStress(const Program& program) {
  for (const Stage& stage : program.stages) {
    if (const auto* servo = std::get_if<Servo>(&stage)) return servo->stress;
    const auto* deform = std::get_if<Deform>(&stage);
    if (deform == nullptr) continue;
    for (const EdgeControl& edge : deform->edges) {
      if (edge.kind == EdgeControl::Kind::stress) return edge.value;
    }
  }
  return 0;
}

json Gains(const Program& program, const Stage& stage) {
  const auto* servo = std::get_if<Servo>(&stage);
  if (servo == nullptr) return nullptr;
  const Materials& m = program.materials;
  const bool hertz = program.law.normal == ContactLaw::Normal::hertz;
  const double d = Summarise(program.particles).mean_diameter;
  // For the linear law what kappa stands for, diameter over overlap.
  const double kappa = hertz ? StiffnessNumber(m.young_modulus, m.poisson_ratio, servo->stress)
                             : m.linear.normal / (servo->stress * d);
  return {{"speed", ServoSpeed(program, *servo)}, {"kappa", kappa}};
}

}  // namespace

double RollingStiffness(const Program& program) {
  const Materials& m = program.materials;
  if (program.law.normal != ContactLaw::Normal::hertz) return 0;
  const double d = Summarise(program.particles).mean_diameter;
  const double radius = d / 4;  // R*
  const double young = EffectiveModulus(m.young_modulus, m.poisson_ratio);
  const double shear = m.young_modulus / (4 * (2 - m.poisson_ratio) * (1 + m.poisson_ratio));
  const double force = FirstStress(program) * d * d;
  const double overlap = force > 0 ? std::pow(0.75 * force / (young * std::sqrt(radius)), 2.0 / 3.0)
                                   : kOverlapWithoutStress * radius;
  return 8 * shear * std::sqrt(radius * overlap) * radius * radius;
}

std::string MakeJob(const Program& program, const Packing& start) {
  Program rest = program;
  rest.particles.packing.reset();
  json job = {{"program", rest.ToJson()},
              {"start", json::array()},
              {"servo_wall", nullptr},
              {"servos", json::array()},
              {"rolling_stiffness", RollingStiffness(program)}};
  for (const Sphere& s : start) {
    job["start"].push_back({s.id, s.radius, s.position[0], s.position[1], s.position[2],
                            s.velocity[0], s.velocity[1], s.velocity[2], s.spin[0], s.spin[1],
                            s.spin[2]});
  }
  for (const Stage& stage : program.stages) {
    job["servos"].push_back(Gains(program, stage));
    const auto* servo = std::get_if<Servo>(&stage);
    if (servo != nullptr && job["servo_wall"].is_null()) job["servo_wall"] = servo->wall;
  }
  return job.dump();
}

}  // namespace powdercal::yade

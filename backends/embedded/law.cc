#include "backends/embedded/law.h"

#include <cmath>
#include <numbers>

#include "scaling/groups.h"

namespace powdercal::embedded {
namespace {

constexpr double kPi = std::numbers::pi;

LawConstants Make(const Program& program, const ContactParameters& contact, double cohesion_area) {
  const Materials& m = program.materials;
  const ContactLaw& law = program.law;
  LawConstants constants;
  if (law.normal == ContactLaw::Normal::hertz) {
    const double young = EffectiveModulus(m.young_modulus, m.poisson_ratio);
    const double shear = m.young_modulus / (4 * (2 - m.poisson_ratio) * (1 + m.poisson_ratio));
    const double log_e = std::log(contact.restitution);
    const double beta = -log_e / std::sqrt(log_e * log_e + kPi * kPi);
    const double damping = 2 * std::sqrt(5.0 / 6.0) * beta;
    constants.normal = 4.0 / 3.0 * young;
    constants.tangential = 8 * shear;
    constants.normal_damping = damping * std::sqrt(2 * young);
    constants.tangential_damping = damping * std::sqrt(8 * shear);
  } else {
    constants.normal = m.linear.normal;
    constants.tangential = m.linear.tangential;
    constants.normal_damping = m.linear.normal_damping;
    constants.tangential_damping = m.linear.tangential_damping;
  }
  if (law.limit_force) constants.least_normal = 0;
  constants.time_step = program.time_step;
  constants.without_torsion = law.torsion ? 0 : 1;
  constants.friction = contact.friction;
  constants.rolling = contact.rolling_friction;
  if (law.cohesion == ContactLaw::Cohesion::sjkr2) {
    constants.cohesion_slope = cohesion_area * contact.cohesion_energy_density;
  }
  if (law.cohesion == ContactLaw::Cohesion::dmt) {
    constants.cohesion_constant = 4 * kPi * contact.surface_energy;
  }
  constants.tangential_reduce = law.tangential_reduce;
  return constants;
}

}  // namespace

LawConstants SphereLaw(const Program& program) {
  return Make(program, program.materials.particle_particle, 4 * kPi);
}

LawConstants WallLaw(const Program& program, bool frictionless) {
  ContactParameters contact = program.materials.particle_wall;
  if (frictionless) contact = {.restitution = contact.restitution};
  return Make(program, contact, 2 * kPi);
}

}  // namespace powdercal::embedded

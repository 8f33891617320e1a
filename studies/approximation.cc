#include "studies/approximation.h"

#include <fmt/format.h>

#include <numbers>

#include "core/quantity.h"
#include "scaling/groups.h"

namespace powdercal {

std::span<const std::string> CohesionApproximationNames() {
  static const std::vector<std::string> names = {"none", "dmt_pull_off"};
  return names;
}

double PullOffSurfaceEnergy(double cohesion_energy_density, double effective_radius,
                            double effective_modulus) {
  return PullOffForceSjkr2(cohesion_energy_density, effective_radius, effective_modulus) /
         (4 * std::numbers::pi * effective_radius);
}

double PullOffSurfaceEnergyAtWall(double cohesion_energy_density, double radius,
                                  double effective_modulus) {
  return PullOffSurfaceEnergy(cohesion_energy_density / 2, radius, effective_modulus);
}

std::string Approximations::ToString() const {
  if (!any()) return "";
  return "cohesion: " + CohesionApproximationNames()[static_cast<std::size_t>(cohesion)];
}

void Approximations::Serialize(Archive& archive, const ContactLaw& law) {
  archive.Enumeration("cohesion", cohesion, "approximation of the cohesion law",
                      CohesionApproximationNames());
  if (cohesion == Cohesion::dmt_pull_off && law.cohesion != ContactLaw::Cohesion::sjkr2) {
    throw archive.ErrorAt(
        "cohesion", fmt::format("dmt_pull_off replaces SJKR2, and contact_law has cohesion: {}",
                                CohesionNames()[static_cast<std::size_t>(law.cohesion)]));
  }
}

void Approximations::Apply(SimulatedPowder& powder) const {
  if (cohesion != Cohesion::dmt_pull_off) return;
  Materials& materials = powder.materials;
  const double modulus = EffectiveModulus(materials.young_modulus, materials.poisson_ratio);
  const double diameter = powder.sizes.Moment(1);
  ContactParameters& particles = materials.particle_particle;
  ContactParameters& walls = materials.particle_wall;
  particles.surface_energy =
      PullOffSurfaceEnergy(particles.cohesion_energy_density, diameter / 4, modulus);
  walls.surface_energy =
      PullOffSurfaceEnergyAtWall(walls.cohesion_energy_density, diameter / 2, modulus);
  particles.cohesion_energy_density = walls.cohesion_energy_density = 0;
  powder.law.cohesion = ContactLaw::Cohesion::dmt;
}

std::vector<ApproximationStatement> Approximations::Describe(const SizeDistribution& sizes) const {
  if (cohesion != Cohesion::dmt_pull_off) return {};
  const double diameter = sizes.Moment(1);
  std::string text = fmt::format(
      "SJKR2 cohesion is approximated by DMT adhesion with the same pull-off force between two "
      "particles of the mean diameter ({}; R* = {}) and between one of them and a wall. Under load "
      "DMT does not grow with the overlap as SJKR2 does, and parting two particles takes a quarter "
      "of its energy.",
      HumanQuantity(diameter, "m"), HumanQuantity(diameter / 4, "m"));
  if (sizes.kind != SizeDistribution::Kind::monodisperse) {
    text += fmt::format(
        " At other sizes the pull-off force is off as well, since it grows with R*, and that of "
        "SJKR2 with its square: {:.2g} times that of SJKR2 between two of the smallest particles, "
        "{:.2g} times between two of the largest.",
        diameter / sizes.Quantile(0), diameter / sizes.Quantile(1));
  }
  return {{.part = "cohesion", .name = "dmt_pull_off", .text = std::move(text)}};
}

}  // namespace powdercal

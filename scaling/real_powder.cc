#include "scaling/real_powder.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "core/quantity.h"
#include "scaling/groups.h"

namespace powdercal {

std::optional<PowderCohesion> ReadBack(const std::string& experiment, const Conditions& laboratory,
                                       const Conditions& simulation) {
  // Either group is F_c over a load; the diameter is the same on both sides.
  const auto load_over_weight = EvaluateGroup("sigma/(rho_b g h)", simulation);
  const bool weight_rules = load_over_weight && *load_over_weight < 1;
  const std::string kept =
      simulation.stress && laboratory.stress && !weight_rules ? "F_c/(sigma d^2)" : "Bo";
  const auto simulated = EvaluateGroup(kept, simulation);
  if (!simulated || !simulation.young_modulus || !laboratory.diameter) return std::nullopt;
  // Both groups are proportional to the surface energy of DMT.
  Conditions unit = laboratory;
  unit.cohesion_energy_density.reset();
  unit.surface_energy = 1;
  const auto of_one = EvaluateGroup(kept, unit);
  if (!of_one) return std::nullopt;
  return PowderCohesion{.experiment = experiment,
                        .surface_energy = *simulated / *of_one,
                        .kept = kept,
                        .young_modulus = *simulation.young_modulus,
                        .cohesion_energy_density = simulation.cohesion_energy_density,
                        .stated = laboratory.surface_energy};
}

std::vector<std::string> Describe(const std::vector<PowderCohesion>& readings) {
  std::vector<std::string> sentences;
  for (const PowderCohesion& reading : readings) {
    const std::string cohesion =
        reading.cohesion_energy_density
            ? fmt::format("k = {} at E = {}",
                          HumanQuantity(*reading.cohesion_energy_density, "J/m3", 3),
                          HumanQuantity(reading.young_modulus, "Pa", 3))
            : std::string("its surface energy");
    std::string text = fmt::format(
        "in {}, {} stands for a powder with a surface energy of {:.2g} mJ/m2 (equal {})",
        reading.experiment, cohesion, 1e3 * reading.surface_energy, reading.kept);
    if (reading.stated) {
      text += fmt::format("; the study states {:.2g} mJ/m2", 1e3 * *reading.stated);
    }
    sentences.push_back(std::move(text));
  }
  const auto by_energy = [](const PowderCohesion& a, const PowderCohesion& b) {
    return a.surface_energy < b.surface_energy;
  };
  const auto [least, most] = std::minmax_element(readings.begin(), readings.end(), by_energy);
  if (!readings.empty() && most->surface_energy > least->surface_energy * kMatchFactor) {
    sentences.push_back(fmt::format(
        "one cohesion, different powders: {} and {} differ {:.3g} times in the surface energy they "
        "stand for, since their conditions are not scaled alike",
        least->experiment, most->experiment, most->surface_energy / least->surface_energy));
  }
  return sentences;
}

}  // namespace powdercal

#include "experiments/experiment.h"

#include <array>

#include "core/errors.h"
#include "experiments/angle_of_repose.h"
#include "experiments/consolidation.h"
#include "experiments/shear.h"
#include "experiments/spreading.h"

namespace powdercal {

void Numerics::Serialize(Archive& archive) {
  archive.Quantity("rayleigh_fraction", rayleigh_fraction, "1",
                   {.lower = 0, .upper = 1, .lower_open = true});
  archive.Quantity("time_step", time_step, "s", kPositive);
}

double Numerics::TimeStep(const SimulatedPowder& powder) const {
  if (time_step) return *time_step;
  const Materials& m = powder.materials;
  return rayleigh_fraction *
         RayleighTime(powder.sizes.Quantile(0) / 2, m.density, m.young_modulus, m.poisson_ratio);
}

std::span<const std::string> ExperimentNames() {
  static const std::vector<std::string> names = {"angle_of_repose", "consolidation", "shear",
                                                 "spreading"};
  return names;
}

std::unique_ptr<Experiment> MakeExperiment(const std::string& name) {
  if (name == "angle_of_repose") return std::make_unique<AngleOfRepose>();
  if (name == "consolidation") return std::make_unique<Consolidation>();
  if (name == "shear") return std::make_unique<Shear>();
  if (name == "spreading") return std::make_unique<Spreading>();
  throw UnknownName("experiment", name, ExperimentNames());
}

}  // namespace powdercal

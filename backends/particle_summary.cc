#include "backends/particle_summary.h"

#include <algorithm>
#include <cassert>
#include <numbers>

namespace powdercal {

double ParticleSummary::Mass(double density) const {
  return count * density * std::numbers::pi / 6 * mean_cube;
}

ParticleSummary Summarise(const Particles& particles) {
  if (!particles.packing) {
    const SizeDistribution& sizes = particles.sizes;
    return {particles.count, sizes.Quantile(0), sizes.Quantile(1), sizes.Moment(1),
            sizes.Moment(3)};
  }
  const Packing& packing = *particles.packing;
  assert(!packing.empty());
  const auto [smallest, largest] =
      std::minmax_element(packing.begin(), packing.end(),
                          [](const Sphere& a, const Sphere& b) { return a.radius < b.radius; });
  ParticleSummary summary{.count = static_cast<int>(packing.size()),
                          .smallest_diameter = 2 * smallest->radius,
                          .largest_diameter = 2 * largest->radius};
  const auto count = static_cast<double>(packing.size());
  for (const Sphere& sphere : packing) {
    const double d = 2 * sphere.radius;
    summary.mean_diameter += d / count;
    summary.mean_cube += d * d * d / count;
  }
  return summary;
}

std::optional<ParticleSummary> SummariseIfValid(const Particles& particles) {
  const bool valid =
      particles.packing ? !particles.packing->empty() : particles.sizes.ExplainInvalid().empty();
  return valid ? std::optional(Summarise(particles)) : std::nullopt;
}

}  // namespace powdercal

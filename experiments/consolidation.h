#pragma once

#include <string>

#include "experiments/experiment.h"
#include "experiments/pouring.h"

namespace powdercal {

/// Uniaxial consolidation: loose powder, settled under gravity, is loaded by a flat lid to a normal
/// stress and held until it is at rest. Periodic in x and y, so without the friction of a vessel;
/// or, with `sides: walls`, in a box of four frictionless planes, for simulators that cannot have
/// planes in a periodic domain. Powder is looser along a wall: void ratios in the box are higher,
/// and to be compared with others from such a box only.
///
/// Protocol. Spheres are placed at random at `initial_solid_fraction` in a square cell and move
/// down together at `initial_velocity`. This preparation is a part of the test: unlike the rate of
/// loading, it shifts the void ratio (docs/validation/consolidation.md). The lid is lowered once
/// the bed is at rest, at a speed that keeps its controller stable, and the run ends as soon as,
/// over one window of 6 t_i (t_i = d √(rho/sigma)), stress and height no longer change and the
/// kinetic energy is below a thousandth of the elastic one.
///
/// Fidelities: quick 1000 particles in a cell 10 d wide, standard 3000 in 14.4 d, paper 500 000 in
/// 2 mm × 2 mm, as in the seed paper.
///
/// Responses: void_ratio [1]: void over solid volume between 20 % and 80 % of the height, spheres
/// counted whole (overlaps twice); void_ratio_wall_to_wall [1]; bulk_density [kg/m3]: density of
/// the solid over 1 + void_ratio.
///
/// Diagnostics: void_ratio_overlap_corrected, void_ratio_rigid (both [1], see packing_measures.h),
/// coordination_number, mechanical_coordination_number, rattler_fraction, stress [Pa], stress_ratio
/// (reached over target), kappa, inertial_number (last window), inertial_number_loading (largest
/// while loading), max_overlap (delta/R*), mean_relative_overlap (delta/d), bed_height [m],
/// simulated_time [s].
class Consolidation final : public Experiment {
 public:
  const std::string& name() const override;
  std::span<const ResponseDescription> responses() const override;
  void Serialize(Archive& archive) override;
  void DescribeConditions(Fidelity fidelity, Conditions& conditions) const override;
  Program Plan(const SimulatedPowder& powder, const Conditions& conditions,
               const Numerics& numerics, Fidelity fidelity, std::uint64_t seed) const override;
  double ExpectedDuration(const Program& program) const override;
  Measurement Measure(const Program& program, const Trace& trace, Outcome* outcome) const override;

 private:
  double stress_ = 0;  // [Pa] in the laboratory
  Sides sides_ = Sides::periodic;
  double initial_solid_fraction_ = 0.30;  // [-]
  double initial_velocity_ = 0.1;         // [m/s] downwards
  double max_load_time_ = 100;  // [t_i · bed height/d], then the load counts as unreachable
  int max_hold_windows_ = 40;
};

}  // namespace powdercal

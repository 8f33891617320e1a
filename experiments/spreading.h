#pragma once

#include <optional>
#include <string>

#include "experiments/experiment.h"
#include "experiments/pouring.h"

namespace powdercal {

/// Spreading of a layer by a blade: powder in a heap before the blade is drawn over a plate and
/// passes through the gap beneath. x is the direction of the sweep; periodic in y or, with `sides:
/// walls`, between frictionless planes (as in consolidation.h, for some simulators). The blade's
/// front face starts at x = 0 and z = 0 is the level that the gap is measured from.
///
/// Protocol. Spheres are placed at random before the blade, at a solid fraction of 0.30 and all of
/// them above the plate, fall and collapse to a heap as far as their cohesion lets them. Once the
/// heap is at rest the blade moves by the length of the sweep at constant speed; then it stands
/// still while the layer comes to rest. The heap holds `powder_surplus` times what a layer of the
/// gap's height with a solid fraction of 0.5 takes over the whole sweep. The plate is `smooth`, a
/// plane with the parameters of walls; or `rough`, a layer of fixed equal spheres with the
/// powder's parameters, packed as closely as the period along y allows, with their tops at z = 0.
/// Particles that pass the ends of the plate are gone and counted.
///
/// The window in which the layer is measured lies behind the blade: from `start_margin` gaps before
/// its first position to `end_margin` gaps behind its back edge; over the whole period in y.
///
/// Fidelities: quick sweeps 36 d of a plate 6 d wide, standard 80 d of 10 d; paper 7 mm of 48 d
/// with 50 000 particles, whatever the surplus, at 25 mm/s as in the seed paper (which does not
/// state the plate's width). The speed is never changed to save time.
///
/// Responses: coverage [1]: share of the window beneath the spheres; layer_thickness [m]: mean
/// height of the surface, bare plate counted as 0; mass_per_area [kg/m2]; packing_density [1]:
/// solid volume between plate and gap over that volume; packing_density_sd [1]: its standard
/// deviation over cells of `density_cell` diameters; roughness_sa, roughness_sq [m] of the surface
/// (layer_measures.h); swept_share [1]: share of the powder's mass that the sweep did not lay down:
/// it stands before the blade's front face at the end, or has left the plate.
///
/// Diagnostics: window_x0, window_x1, window_y0, window_y1, gap [m]; coverage_pixel [m],
/// coverage_change (of the last refinements), coverage_converged (1: below 0.001); density_cell_x,
/// density_cell_y [m], density_cells; surface_pixel [m], surface_maximum [m]; leavers (particles
/// gone); airborne (particles that jammed under the blade, were shot up and are not down yet; they
/// count in no response as laid down); heap_share (of the mass, before the blade at the end);
/// layer_kinetic_energy_ratio (in the window, over m g d); particles (free ones at the start);
/// simulated_time [s].
class Spreading final : public Experiment {
 public:
  const std::string& name() const override;
  std::span<const ResponseDescription> responses() const override;
  void Serialize(Archive& archive) override;
  void DescribeConditions(Fidelity fidelity, Conditions& conditions) const override;
  /// A gap below the largest particle: it would be crushed or stop the blade.
  std::string ExplainUnsupported(const SimulatedPowder& powder) const override;
  /// Throws InputError for what ExplainUnsupported() gives a reason, and for a sweep that leaves no
  /// window or a plate too narrow for the particles.
  Program Plan(const SimulatedPowder& powder, const Conditions& conditions,
               const Numerics& numerics, Fidelity fidelity, std::uint64_t seed) const override;
  double ExpectedDuration(const Program& program) const override;
  Measurement Measure(const Program& program, const Trace& trace, Outcome* outcome) const override;

 private:
  enum class Plate { rough, smooth };

  void CheckLengths(const SimulatedPowder& powder, double sweep, double width) const;
  double WindowEnd(double sweep) const;  // [m]

  double blade_speed_ = 0.025;             // [m/s] in the laboratory
  double gap_ = 80e-6;                     // [m]
  std::optional<double> blade_thickness_;  // [m] the gap
  Plate plate_ = Plate::rough;
  Sides sides_ = Sides::periodic;
  std::optional<double> plate_particle_diameter_;  // [m] the powder's mean
  std::optional<double> sweep_;                    // [m] by fidelity
  std::optional<double> width_;                    // [m] by fidelity
  double powder_surplus_ = 1.1;                    // [-]
  double rest_time_ = 2e-3;                        // [s]
  double start_margin_ = 3;                        // [gap]
  double end_margin_ = 1;                          // [gap]
  double density_cell_ = 3;                        // [d]
};

}  // namespace powdercal

#pragma once

#include <optional>
#include <string>

#include "experiments/experiment.h"
#include "experiments/heap_measures.h"
#include "experiments/pouring.h"

namespace powdercal {

/// Angle of repose, by one of two methods.
///
/// `draw_down`: a bed settles between a back wall at x = 0 and a gate, on a smooth floor, periodic
/// in y or, with `sides: walls`, between frictionless planes (as in consolidation.h). The gate is
/// taken away; what flows beyond the floor's end, half a mean diameter outside the gate, is gone.
/// The face that stays is read when everything is at rest, or at `flow_time` after the gate was
/// opened.
///
/// `funnel`: powder settles in a funnel whose outlet is closed: a cone with walls at 30° from the
/// vertical, and a cylinder above. The plug is taken away, and the powder pours on a round plate
/// below with a rim one diameter high, over which the excess falls. What of the heap stands above
/// the rim is read in the same way.
///
/// Before either, spheres are placed at random at a solid fraction of 0.30 and fall at 0.1 m/s. All
/// surfaces have the parameters of walls. Friction without history is refused: no heap would stay.
///
/// Fidelities: draw_down quick 14 d from back wall to gate and 5 d wide (about 750 particles),
/// standard 20 d and 6 d (1850), paper 43 d and 13 d (18 000); beds of `bed_aspect` times that
/// length in height. funnel quick a plate of 7 d radius and 450 particles, standard 11 d and 1750,
/// paper 24 d and 15 000. The seed paper has no such test.
///
/// Responses: angle [rad] of the face with the horizontal, by a straight line through the profile
/// between 20 % and 80 % of its height (heap_measures.h); retained_mass [1]: share of the powder's
/// mass that stays on the floor, or on the plate; of draw_down, poured_void_ratio [1] of the
/// settled bed, in its middle; of funnel, discharged_share [1]: share of the mass that has left the
/// funnel.
///
/// A cohesive face is a cliff, and has no angle of repose. Its inclination is the response all the
/// same, with `cliff` = 1: an optimizer that looks for 32° learns that it is far off, where a
/// failed evaluation would tell it nothing. Where the cliff crosses the fitted range within fewer
/// than four bins of half a diameter, the angle is the lower bound that follows from their width
/// (`angle_is_bound` = 1). Only where no face of at least two diameters is left is there no angle
/// (`no_face` = 1); the other responses are always there.
///
/// Diagnostics: cliff, angle_is_bound, no_face, at_rest (0 or 1); angle_degrees [deg];
/// face_start, face_end, face_lower, face_upper [m] of the range of the fit; face_bins, r_squared;
/// bed_height [m], bed_length [m] (draw_down), plate_radius, outlet_diameter [m] (funnel);
/// kinetic_energy_ratio (over m g d); leavers, particles; flow_time, simulated_time [s].
class AngleOfRepose final : public Experiment {
 public:
  const std::string& name() const override;
  std::span<const ResponseDescription> responses() const override;
  void Serialize(Archive& archive) override;
  void DescribeConditions(Fidelity fidelity, Conditions& conditions) const override;
  /// Friction without history; an outlet that the largest particle cannot pass.
  std::string ExplainUnsupported(const SimulatedPowder& powder) const override;
  /// Throws InputError for what ExplainUnsupported() gives a reason, and without gravity.
  Program Plan(const SimulatedPowder& powder, const Conditions& conditions,
               const Numerics& numerics, Fidelity fidelity, std::uint64_t seed) const override;
  double ExpectedDuration(const Program& program) const override;
  Measurement Measure(const Program& program, const Trace& trace, Outcome* outcome) const override;

 private:
  enum class Method { draw_down, funnel };

  void PlanDrawDown(Fidelity fidelity, double speed_ratio, Program* program) const;
  void PlanFunnel(Fidelity fidelity, double speed_ratio, Program* program) const;
  double FlowTime(double by_default, double speed_ratio) const;  // [s] at most
  FlankFit MeasureDrawDown(const Program& program, const Moment& settled, const Moment& end,
                           Measurement* measurement) const;
  FlankFit MeasureFunnel(const Program& program, const Moment& end, Measurement* measurement) const;

  Method method_ = Method::draw_down;
  Sides sides_ = Sides::periodic;    // draw_down
  double bed_aspect_ = 0.8;          // [-] draw_down: height of the bed over its length
  double outlet_diameters_ = 8;      // [d] funnel
  std::optional<double> flow_time_;  // [s] at most, after the opening
};

}  // namespace powdercal

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/experiment.h"
#include "experiments/shear_cells.h"

namespace powdercal {

/// The shear test of a rotational or ring shear tester (ASTM D7891, D6773): the powder is sheared
/// to steady state under a normal stress (preshear), then made to yield under smaller ones, each
/// time from the same presheared state.
///
/// Protocol. Loose powder is consolidated and sheared in one of two cells (shear_cells.h) until
/// `preshear_strain`. The second half of it holds `repeats` states at even strains; from each of
/// them the normal stress is reduced to each of `normal_stresses` and the powder sheared on by
/// `yield_strain`. One state alone would hand its momentary fluctuation (7 % of the shear stress
/// with 1000 particles) on to the whole locus. What of it is left is removed as in the laboratory,
/// by prorating (ASTM D6128; Schulze 2008, Powders and Bulk Solids, §4): a yield point's shear
/// stress is multiplied by the steady state's tau/sigma over that of the state it came from.
///
/// Steady state is detected (steady_state.h) in shear stress and void ratio; the definition of the
/// yield point: FindYieldPoint() in shear_series.h. The locus is a straight line, fitted to the
/// means over the states with sds proportional to the shear stress; the variances of its figures
/// follow from the scatter of the states' own lines, or, with one state, from the scatter about the
/// line.
///
/// Stresses. The simulation's preshear is Conditions::stress; the yield stresses are in proportion.
/// Responses with a unit of stress are the laboratory's: multiplied by `preshear` over the
/// simulation's preshear. That presumes that cohesion is scaled along with the load
/// (F_c/(sigma d²) kept).
///
/// Fidelities: quick 1000 particles in a cell 10 d wide at I = 0.004, preshear strain 2.4;
/// standard 3000 in 14.4 d at 0.002, 3; paper 10 000 in 21.5 d at 0.001, 3 (no size is published).
///
/// Outcome not_quasi_static: no steady state; a mean normal stress off by more than 5 %; a stress
/// tensor that is not symmetric within 5 %; between platens, normal or shear stresses at the top,
/// at the bottom and in the powder that differ by more than 5 % of the normal stress; a yield
/// stress that is never reached.
///
/// Responses: preshear_shear_stress [Pa] at exactly `preshear`; shear_stress_1, _2, … [Pa] at
/// exactly the normal stresses, moved there from the measured ones along the locus; cohesion [Pa]
/// (may be negative by noise), tan_phi [1] and phi [rad] of the locus; unconfined_yield_strength,
/// major_principal_stress [Pa], inverse_ffc [1] (finite for every powder, unlike the flow function
/// coefficient, which is infinite without cohesion), effective_friction_angle [rad];
/// steady_state_friction [1], tau/sigma of the preshear, and its angle, steady_state_angle [rad];
/// steady_state_void_ratio [1] and steady_state_bulk_density [kg/m3], spheres counted whole.
///
/// Diagnostics: steady_state_strain (at which it begins), shear_drift, void_ratio_drift (see
/// Drift::value), memory_strain (of the shear stress: that much strain counts as one
/// independent sample), stress_ratio (reached over target), asymmetry (of the stress tensor's shear
/// stresses, over the shear stress); between platens, in the simulation's Pa: normal_stress_top,
/// _bottom, _bulk, shear_stress_top, _bottom, _bulk; yield_normal_stress_1, … [simulation's Pa],
/// prorated_scatter and plain_scatter (relative sd of yield points among the states, with and
/// without prorating), ffc where finite, locus_residual (rms over the mean shear stress),
/// inertial_number, kappa, chi (with cdt, see Warnings()), simulated_time [s]; and
/// warning_NAME = 1 for each ShearWarning of the locus.
class Shear final : public Experiment {
 public:
  Shear();

  const std::string& name() const override;
  std::span<const ResponseDescription> responses() const override { return responses_; }
  /// yield_locus: a CSV file as ReadYieldLocus() takes it, every point with a sd of its shear
  /// stress. Gives the shear stresses, and where there are preshear rows preshear_shear_stress.
  /// Where the study has no normal_stresses, the file's are taken; else both must agree within 1 %.
  std::span<const std::string> observed_files() const override;
  std::vector<ObservedValue> ReadObserved(const std::string& key, const std::string& path) override;
  void Serialize(Archive& archive) override;
  /// The laboratory's shear rate stays unknown: the test does not depend on it. Gravity has no part
  /// in the test.
  void DescribeConditions(Fidelity fidelity, Conditions& conditions) const override;
  void DescribeSimulation(const SimulatedPowder& powder, Fidelity fidelity,
                          Conditions& simulation) const override;
  /// Refuses a tangential law without history: it has no static friction.
  std::string ExplainUnsupported(const SimulatedPowder& powder) const override;
  /// With `cdt` rolling friction, chi = mu_r (dt/t_i)/I above 0.05, t_i = d √(rho/sigma): the
  /// rolling torque then dithers, and the result depends on time step and rate (docs/physics.md).
  std::vector<std::string> Warnings(const Program& program) const override;
  Program Plan(const SimulatedPowder& powder, const Conditions& conditions,
               const Numerics& numerics, Fidelity fidelity, std::uint64_t seed) const override;
  double ExpectedDuration(const Program& program) const override;
  Measurement Measure(const Program& program, const Trace& trace, Outcome* outcome) const override;

 private:
  void SetNormalStresses(std::vector<double> stresses);
  double InertialNumber(Fidelity fidelity) const;
  double Chi(const Program& program) const;

  ShearCell cell_ = ShearCell::periodic;
  double preshear_ = 0;                    // [Pa] in the laboratory
  std::vector<double> normal_stresses_;    // [Pa] in the laboratory; 3/9, 5/9, 7/9 of the preshear
  bool normal_stresses_given_ = false;     // by the study
  std::optional<double> inertial_number_;  // [-] the fidelity's
  std::optional<double> preshear_strain_;  // [-] the fidelity's
  double yield_strain_ = 0.05;             // [-] at each normal stress
  int repeats_ = 5;
  std::vector<ResponseDescription> responses_;
};

}  // namespace powdercal

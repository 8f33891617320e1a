#pragma once

#include <optional>

namespace powdercal {

/// The dimensional variables of a powder test, of the laboratory or of a
/// simulation of it. SI units. Empty: not known, or without meaning for the
/// test at hand.
struct Conditions {
  enum class Cohesion { none, sjkr2, dmt };

  std::optional<double> stress;                   ///< [Pa] normal stress applied
  std::optional<double> study_stress;             ///< [Pa] largest applied in a test of the study
  std::optional<double> young_modulus;            ///< [Pa] of the particles
  std::optional<double> poisson_ratio;            ///< [-]
  std::optional<double> density;                  ///< [kg/m3] of the solid
  std::optional<double> diameter;                 ///< [m] number mean
  std::optional<double> gravity;                  ///< [m/s2]
  std::optional<double> cohesion_energy_density;  ///< [J/m3] k of SJKR2
  std::optional<double> surface_energy;           ///< [J/m2] of the real powder, or of DMT
  std::optional<double> bulk_solid_fraction;      ///< [-] for the bulk density in
                                                  ///< the weight of the bed
  std::optional<double> bed_height;               ///< [m]
  std::optional<double> width;                    ///< [m] of the cell
  std::optional<double> velocity;                 ///< [m/s] of the wall or the blade
  std::optional<double> shear_rate;               ///< [1/s]
  std::optional<double> gap;                      ///< [m] under the blade
  std::optional<double> restitution;              ///< [-]
  std::optional<double> friction;                 ///< [-] between particles
  std::optional<double> wall_friction;            ///< [-]
  std::optional<double> rolling_friction;         ///< [-]

  // Of the simulation alone.
  Cohesion law_of_cohesion = Cohesion::none;
  /// [-] Speeds that belong to the protocol itself (of the fall, of the lid)
  /// over those in the laboratory; durations of the protocol go by the inverse.
  double speed_ratio = 1;
  std::optional<double> time_step;      ///< [s]
  std::optional<double> rayleigh_time;  ///< [s] of the smallest particle
  std::optional<double> servo_gain;     ///< [-] P N gamma_n/F of a servo-controlled wall
  bool directional_torque = false;      ///< rolling friction is `cdt`, which may chatter
};

}  // namespace powdercal

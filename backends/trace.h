#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "backends/program.h"

namespace powdercal {

/// How a simulation ended.
enum class Reason {
  ok,
  invalid_input,     ///< the simulator refused what it was given
  unsupported,       ///< this backend cannot run this program
  lost_particles,    ///< fewer particles at the end than at the start
  unstable,          ///< blown up: overlaps or velocities beyond all bounds
  not_quasi_static,  ///< the target stress or a state of rest was not reached
  timeout,           ///< the wall-clock limit of the run
  crashed,           ///< the simulator died, or left no result
  cancelled,         ///< stopped on request; not a result
};
std::span<const std::string> ReasonNames();
const std::string& ToString(Reason reason);

struct Outcome {
  Reason reason = Reason::ok;
  std::string message;  ///< for people: what was seen, with figures; "" when ok

  bool ok() const { return reason == Reason::ok; }
};

/// State of a plane, a mesh or a glued group. Forces are those that the particles exert on it.
struct WallState {
  double height = 0;       ///< [m] of a plane: its position along its axis
  Vector3 displacement{};  ///< [m] from where the program put it; of a servo's body, from where the
                           ///< servo put it
  Vector3 force{};         ///< [N] mean over the last window
  double velocity = 0;     ///< [m/s] along z, mean over the last window
};

/// State of a fully periodic cell.
struct CellState {
  Vector3 lower{};          ///< [m]
  Vector3 upper{};          ///< [m]
  double shear_offset = 0;  ///< [m] by which the image above (+z) is displaced along +x
  double shear_rate = 0;    ///< [1/s] dv_x/dz
  /// [Pa] compressive positive, rows x, y, z: of the contacts (sum of branch vector times force
  /// over volume) and of the motion (sum of m v' v', v' without the affine part).
  std::array<Vector3, 3> stress{};
};

/// The bed at a named moment: the end of a stage ("settle", "servo", "hold").
struct Moment {
  std::string name;
  double time = 0;  ///< [s] simulated
  Packing packing;
  std::map<std::string, WallState> walls;  ///< planes, meshes and glued groups, by name
  std::optional<CellState> cell;           ///< where x, y and z are periodic
  std::vector<ContactHistory> contacts;  ///< where the backend knows them; see Particles::contacts
};

/// History of a servo's wall from its servo on, or of a mesh or a glued group from the beginning
/// until it is removed; one entry per window of averaging (100 steps). The servo's wall comes
/// first. Windows begin anew with each Servo, Deform, Save and Restore: none mixes what is before
/// it with what is after, and a window cut short is left out.
struct WallSeries {
  std::string wall;
  std::vector<double> time;          ///< [s]
  std::vector<double> height;        ///< [m] as in WallState
  std::vector<double> normal_force;  ///< [N] along z; on a servo's wall compressive, positive
  std::vector<Vector3> force;        ///< [N] of the particles on the body, mean over the window
};

/// A periodic cell's history, one entry per window of averaging, as in WallSeries.
struct CellSeries {
  std::vector<double> time;  ///< [s]
  /// [-] shear strain since the beginning of the program; Restore takes it back to that of the
  /// state, so that branches from one state can be laid over each other.
  std::vector<double> strain;
  std::vector<Vector3> lengths;                ///< [m] of the edges
  std::vector<std::array<Vector3, 3>> stress;  ///< [Pa] as in CellState, mean over the window
};

/// History of Program::stress_slab, one entry per window of averaging, as in WallSeries.
struct SlabSeries {
  std::vector<double> time;  ///< [s]
  /// [-] volume of the free spheres centred in it over its own (base of the domain by its height)
  std::vector<double> solid_fraction;
  /// [Pa] compressive positive, rows x, y, z. Each contact counts with the part of its branch that
  /// lies in the slab: from centre to centre, or from the centre to the point of contact with a
  /// plane or a mesh (Irving & Kirkwood 1950, averaged over planes). At rest column z is then what
  /// the walls above and below bear, whatever the slab; a sum over whole particles would differ by
  /// some per cent, from where their edges happen to be. Motion: of the particles centred in the
  /// slab, relative to their mean.
  std::vector<std::array<Vector3, 3>> stress;
};

struct Diagnostics {
  std::int64_t steps = 0;
  double time_step = 0;     ///< [s]
  double wall_seconds = 0;  ///< of the simulator
  int lost_particles = 0;
  int leavers = 0;                  ///< particles that left through an outflow side
  double kinetic_energy = 0;        ///< [J] at the end
  double kinetic_energy_ratio = 0;  ///< [-] kinetic to elastic contact energy at the end
  double max_overlap = 0;           ///< [-] largest delta/R at the end
  std::string law;                  ///< the contact law as it was run, in the backend's own terms
  std::map<std::string, double> figures;  ///< SI, what only this backend knows, by its own names
};

/// {"reason": …, "message": …}; every member of the diagnostics by name.
nlohmann::json ToJson(const Outcome& outcome);
nlohmann::json ToJson(const Diagnostics& diagnostics);

/// A response that a backend knows without a simulation (the table backend).
struct ReportedResponse {
  double value = 0;     ///< SI
  double variance = 0;  ///< SI²
};

/// What a simulation gave.
struct Trace {
  Outcome outcome;
  std::vector<Moment> moments;
  std::vector<WallSeries> series;
  CellSeries cell;
  SlabSeries slab;
  Diagnostics diagnostics;
  std::map<std::string, ReportedResponse> reported;  ///< by response name; empty for simulators

  /// The last moment of that name, or null.
  const Moment* Find(const std::string& name) const;
  /// The series of that body, or null.
  const WallSeries* FindSeries(const std::string& wall) const;
};

}  // namespace powdercal

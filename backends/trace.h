#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
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

/// State of a flat wall. Forces are those that the particles exert on the wall.
struct WallState {
  double height = 0;    ///< [m] z
  Vector3 force{};      ///< [N] mean over the last window
  double velocity = 0;  ///< [m/s] along z, mean over the last window
};

/// The bed at a named moment: the end of a stage ("settle", "servo", "hold").
struct Moment {
  std::string name;
  double time = 0;  ///< [s] simulated
  Packing packing;
  std::map<std::string, WallState> walls;
};

/// A wall's history, one entry per window of averaging.
struct WallSeries {
  std::string wall;
  std::vector<double> time;          ///< [s]
  std::vector<double> height;        ///< [m]
  std::vector<double> normal_force;  ///< [N] compressive, positive
};

struct Diagnostics {
  std::int64_t steps = 0;
  double time_step = 0;     ///< [s]
  double wall_seconds = 0;  ///< of the simulator
  int lost_particles = 0;
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
  Diagnostics diagnostics;
  std::map<std::string, ReportedResponse> reported;  ///< by response name; empty for simulators

  /// The last moment of that name, or null.
  const Moment* Find(const std::string& name) const;
};

}  // namespace powdercal

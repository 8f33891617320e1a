#include "backends/trace.h"

#include <nlohmann/json.hpp>

namespace powdercal {

std::span<const std::string> ReasonNames() {
  static const std::vector<std::string> names = {
      "ok",      "invalid_input", "unsupported", "lost_particles", "unstable", "not_quasi_static",
      "timeout", "crashed",       "cancelled"};
  return names;
}

const std::string& ToString(Reason reason) {
  return ReasonNames()[static_cast<std::size_t>(reason)];
}

const Moment* Trace::Find(const std::string& name) const {
  for (auto moment = moments.rbegin(); moment != moments.rend(); ++moment) {
    if (moment->name == name) return &*moment;
  }
  return nullptr;
}

const WallSeries* Trace::FindSeries(const std::string& wall) const {
  for (const WallSeries& entry : series) {
    if (entry.wall == wall) return &entry;
  }
  return nullptr;
}

nlohmann::json ToJson(const Outcome& outcome) {
  return {{"reason", ToString(outcome.reason)}, {"message", outcome.message}};
}

nlohmann::json ToJson(const Diagnostics& diagnostics) {
  nlohmann::json json = {{"steps", diagnostics.steps},
                         {"time_step", diagnostics.time_step},
                         {"wall_seconds", diagnostics.wall_seconds},
                         {"lost_particles", diagnostics.lost_particles},
                         {"leavers", diagnostics.leavers},
                         {"kinetic_energy", diagnostics.kinetic_energy},
                         {"kinetic_energy_ratio", diagnostics.kinetic_energy_ratio},
                         {"max_overlap", diagnostics.max_overlap},
                         {"law", diagnostics.law}};
  json["figures"] = diagnostics.figures;
  return json;
}

}  // namespace powdercal

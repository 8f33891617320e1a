// A simulation as bytes, to go on in another process.

#include <fmt/format.h>

#include "backends/embedded/simulation.h"
#include "backends/embedded/state_stream.h"
#include "core/errors.h"
#include "core/hash.h"

namespace powdercal::embedded {
namespace {

// Raise the number when what is written changes.
constexpr std::string_view kMagic = "powdercal embedded state 1\n";
constexpr std::size_t kDigits = 64;  // of a SHA-256

}  // namespace

// Numbers one by one where a structure has gaps: equal states have equal bytes.
template <typename Self, typename Stream>
void Simulation::Transfer(Self& self, Stream& stream) {
  stream(self.particles_, self.neighbours_, self.box_.lower, self.box_.upper, self.box_.periodic,
         self.images_, self.drive_, self.cell_drive_, self.filtered_stress_, self.filtered_at_,
         self.shear_offset_, self.shear_strain_);
  // As many as the program has.
  for (auto& body : self.planes_) stream(body);
  for (auto& body : self.groups_) stream(body);
  for (auto& body : self.meshes_) stream(body);
  for (auto& contacts : self.mesh_contacts_) stream(contacts);
  stream(self.plane_states_);
  stream(self.steps_, self.undone_steps_, self.started_, self.lists_stale_, self.travelled_,
         self.travelled_outer_, self.steps_since_prune_, self.inner_skin_, self.outer_skin_,
         self.pace_, self.mean_diameter_, self.largest_diameter_);
  stream(self.leavers_, self.stress_, self.counters_);
}

// The hash of the program comes first, then that of the bytes, then the bytes.
std::string Simulation::SaveState() const {
  StateWriter writer;
  Transfer(*this, writer);
  const std::string bytes = writer.Take();
  return fmt::format("{}{}{}", kMagic, program_.Hash(), Sha256(bytes)) + bytes;
}

void Simulation::LoadState(std::string_view bytes) {
  if (!bytes.starts_with(kMagic)) {
    throw InputError("not the state of a simulation, or one of another version");
  }
  bytes.remove_prefix(kMagic.size());
  if (bytes.substr(0, kDigits) != program_.Hash()) {
    throw InputError("the saved state belongs to another program");
  }
  bytes.remove_prefix(kDigits);
  const std::string_view sum = bytes.substr(0, kDigits);
  bytes.remove_prefix(sum.size());
  if (sum != Sha256(bytes)) throw InputError("the saved state is damaged");
  StateReader reader(bytes);
  Transfer(*this, reader);
  if (!reader.at_end()) throw InputError("the saved state is longer than it says");
  neighbours_.Resume(particles_.count(), *team_);
  sums_.assign(neighbours_.slabs().size(), {0, std::vector<Vector3>(BodyCount())});
  failure_.reset();
}

}  // namespace powdercal::embedded

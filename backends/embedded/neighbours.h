#pragma once

#include <cstdint>
#include <vector>

#include "backends/embedded/contact_lists.h"
#include "backends/embedded/kernels.h"
#include "backends/embedded/particle_store.h"
#include "backends/embedded/schedule.h"
#include "backends/embedded/team.h"

namespace powdercal::embedded {

// Who may touch whom. The outer list holds the pairs closer than an outer skin and is built from
// cells, with the particles sorted into their order. The inner list, pruned from it, holds those
// closer than a thin skin: nearly all of them are in contact, so that the kernels waste few lanes.
//
// Particles are divided into slabs along one axis. A slab's pairs reach into itself and the next
// slab only. Slabs of odd number wait for both of their neighbours, so that every particle gets its
// forces in the same order whatever the threads, and no two threads write to one particle.

/// The box in which particles are sorted into cells.
struct Box {
  Vector3 lower{};  ///< [m]
  Vector3 upper{};  ///< [m]
  std::array<bool, 3> periodic{};
};

struct Slab {
  std::int32_t begin = 0;  ///< particles
  std::int32_t end = 0;

  std::vector<std::int32_t> start;  ///< of each particle's entries in the outer list; one more
  AlignedVector<Offset> outer_i;
  AlignedVector<Offset> outer_j;
  /// Where the history of an outer entry stands before a prune, or kNone.
  std::vector<std::int32_t> source;

  ContactList pairs;
  std::vector<std::int32_t> slots;  ///< outer entry of each pair
  std::vector<ContactList> planes;  ///< contacts with each plane

  // Room for the next prune.
  ContactList next_pairs;
  std::vector<std::int32_t> next_slots;
  std::vector<std::uint8_t> accept;
  std::vector<std::int32_t> accepted;

  /// See state_stream.h; between two prunes, when no entry has a source.
  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream) {
    stream(self.begin, self.end, self.start, self.outer_i, self.outer_j, self.pairs, self.slots,
           self.planes);
  }
};

class Neighbours {
 public:
  static constexpr std::int32_t kNone = -1;

  Neighbours(HistoryKinds kinds, int planes) : kinds_(kinds), plane_count_(planes) {}

  /// Wraps, sorts and reorders the particles, leaves out those marked in `removed` (may be empty),
  /// and builds the outer list: pairs with surfaces closer than `skin` [m] that are not of one
  /// glued group. Histories are kept. Prune() must follow. Periodic edges must be at least twice
  /// the largest diameter plus skin.
  void Rebuild(ParticleStore& particles, const Box& box, const Images& images, double skin,
               const std::vector<std::uint8_t>& removed, Team& team);

  /// Makes the inner lists: pairs with surfaces closer than `gap` [m], and particles within `gap`
  /// of each plane.
  void Prune(ParticleStore& particles, const Kernels& kernels, const Images& images,
             const std::vector<PlaneState>& planes, double gap, Team& team);

  std::vector<Slab>& slabs() { return slabs_; }
  const std::vector<Slab>& slabs() const { return slabs_; }
  /// Slabs [first, last) of a thread.
  std::pair<std::size_t, std::size_t> SlabsOf(int thread) const {
    const auto t = static_cast<std::size_t>(thread);
    return {share_[t], share_[t + 1]};
  }
  const Schedule& schedule() const { return schedule_; }
  std::int64_t pair_count() const;
  std::int64_t outer_count() const;

  /// Gives a pair its history before the first Prune(): indices in the present order; true if the
  /// outer list has the pair.
  bool SetHistory(std::int32_t i, std::int32_t j, const Vector3& shear, const Vector3& rolling);
  void SetPlaneHistory(int plane, std::int32_t i, const Vector3& shear, const Vector3& rolling);

  /// See state_stream.h. Not between Rebuild() and its Prune(); Resume() must follow reading.
  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream) {
    stream(self.slabs_, self.wrap_);
  }
  /// Makes what follows from the slabs of `particles` particles that were read.
  void Resume(std::int32_t particles, const Team& team);

 private:
  // Histories on their way from the old order of particles to the new one.
  struct Carried {
    std::vector<std::int32_t> i;
    std::vector<std::int32_t> j;
    HistoryColumns history;
  };

  void AssignHistories();
  void CarryHistories(const std::vector<std::int32_t>& place);
  void DivideWork(int threads);
  void PruneSlab(std::size_t slab, ParticleStore& particles, const Kernels& kernels,
                 const Images& images, double gap);
  void PrunePlane(std::size_t slab, int plane, ParticleStore& particles, const PlaneState& state,
                  double gap);
  std::int32_t FindEntry(std::int32_t i, std::int32_t j, std::size_t* slab, bool* swapped) const;
  std::size_t SlabOf(std::int32_t particle) const;

  HistoryKinds kinds_;
  int plane_count_ = 0;
  std::vector<Slab> slabs_;
  bool wrap_ = false;  // the last slab meets the first
  std::vector<std::size_t> share_;
  Schedule schedule_;
  bool carrying_ = false;  // sources point to carried_, not to the slab's own pairs
  Carried carried_;
  std::vector<Carried> carried_planes_;                  // by plane; j unused
  std::vector<std::vector<std::int32_t>> plane_source_;  // by plane and particle
};

}  // namespace powdercal::embedded

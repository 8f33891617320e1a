#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace powdercal::embedded {

/// A piece of a step's work: the forces of a slab's pairs, or what remains to be done for its
/// particles once all their pairs have been.
struct SlabTask {
  bool finish = false;
  std::uint32_t slab = 0;
};

/// What each thread does in a step. All threads have to end a phase before the next begins. Within
/// a phase a slab is finished as soon as it can be, while its particles are in the cache.
using Schedule = std::vector<std::vector<std::vector<SlabTask>>>;  // by phase and thread

/// `first` holds the first slab of each thread, and the end.
Schedule MakeSchedule(std::span<const std::size_t> first, bool wrap);

}  // namespace powdercal::embedded

#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "backends/program.h"
#include "backends/trace.h"
#include "core/process.h"

namespace powdercal::liggghts {

/// What the deck prints, see deck.h.
struct Record {
  std::string kind;
  std::map<std::string, double> values;
};
std::vector<Record> ReadRecords(const std::string& screen);

/// One packing of a dump, with positions as LIGGGHTS has them: beyond periodic sides by as much as
/// a particle moves between two sortings.
struct Frame {
  std::int64_t step = 0;
  std::size_t particle_count = 0;
  Packing packing;  ///< sorted by id
};
/// The packings of a dump that the deck wrote, in the order of time. Throws std::runtime_error when
/// the file is missing or damaged.
std::vector<Frame> ReadDump(const std::filesystem::path& file);

/// Reads what a run left in its work folder. `particle_count` is what went in. Packings come sorted
/// by id, wrapped into the domain along its periodic axes; those on the way through an Advance know
/// of planes that rest, but not of the servo's wall. Every way to fail that LIGGGHTS has ends in a
/// reason code here:
///  - stopped on request, or by the limit: cancelled, timeout;
///  - "Lost atoms" (its only sign of a blow-up, too): unstable if the time step exceeds 0.4
///  Rayleigh
///    times (Hertz) or particles were faster than 1 m/s at the last check, else lost_particles;
///  - other ERROR lines, exit status ≠ 0, a signal, no record of the last stage's end: crashed, or
///    invalid_input when the input was refused before the first step;
///  - fewer particles in the result than went in: lost_particles;
///  - mean stress off by more than 5 % at the end of a Hold, or still moving: not_quasi_static.
Trace ReadTrace(const Program& program, int particle_count, const std::filesystem::path& folder,
                const ProcessResult& process);

}  // namespace powdercal::liggghts

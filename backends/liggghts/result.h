#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "backends/program.h"
#include "backends/trace.h"
#include "core/process.h"

namespace powdercal::liggghts {

/// What the deck prints: lines "PC KIND key=value …".
struct Record {
  std::string kind;
  std::map<std::string, double> values;
};
std::vector<Record> ReadRecords(const std::string& screen);

/// Packing from a dump written by the deck, with x and y wrapped into the domain. Throws
/// std::runtime_error when the file is missing or damaged.
Packing ReadDump(const std::filesystem::path& file);

/// Reads what a run left in its work folder. `particle_count` is what went in. Every way to fail
/// that LIGGGHTS has ends in a reason code here:
///  - stopped on request, or by the limit: cancelled, timeout;
///  - "Lost atoms" (its only sign of a blow-up, too): unstable if the time step exceeds 0.4
///  Rayleigh
///    times or particles were faster than 1 m/s at the last check, else lost_particles;
///  - other ERROR lines, exit status ≠ 0, a signal, no result record: crashed, or invalid_input
///  when
///    the input was refused before the first step;
///  - fewer particles in the result than went in: lost_particles;
///  - mean stress off by more than 5 %, or still moving: not_quasi_static.
Trace ReadTrace(const Program& program, int particle_count, const std::filesystem::path& folder,
                const ProcessResult& process);

}  // namespace powdercal::liggghts

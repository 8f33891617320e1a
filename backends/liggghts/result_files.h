#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "backends/program.h"
#include "backends/trace.h"

// What the files in a run's work folder hold.

namespace powdercal::liggghts {

/// What the deck prints, see deck.h.
struct Record {
  std::string kind;
  std::map<std::string, double> values;
};
std::vector<Record> ReadRecords(const std::string& screen);
/// Throws std::runtime_error where the record lacks the key.
double Value(const Record& record, const std::string& key);
/// The record END of a stage, which those that leave a moment and `Save` write; null if the run did
/// not come that far.
const Record* EndOf(const std::vector<Record>& records, std::size_t stage);

/// What to add to the steps in the files of each segment, to have them count from the beginning of
/// the program; segments that were not reached are missing.
std::vector<double> ShiftsOf(const std::vector<Record>& records);

/// One packing of a dump, with positions as LIGGGHTS has them: beyond periodic sides by as much as
/// a particle moves between two sortings.
struct Frame {
  std::int64_t step = 0;  ///< as LIGGGHTS counts, back with each Restore
  std::size_t particle_count = 0;
  Packing packing;  ///< sorted by id
};
/// The packings of a dump that the deck wrote, in the order of time. Throws std::runtime_error when
/// the file is missing or damaged.
std::vector<Frame> ReadDump(const std::filesystem::path& file);

/// Forces on the servo's wall, then on meshes and glued groups, in the order of the program;
/// through all segments. Heights are filled in of the servo's wall only.
std::vector<WallSeries> ReadForces(const Program& program, const std::filesystem::path& folder,
                                   const std::vector<double>& shifts);
/// Program::stress_slab, through all segments; empty without one.
SlabSeries ReadSlab(const Program& program, const std::filesystem::path& folder,
                    const std::vector<double>& shifts);

}  // namespace powdercal::liggghts

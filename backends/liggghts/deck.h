#pragma once

#include <map>
#include <string>

#include "backends/program.h"

namespace powdercal::liggghts {

/// Names of the files in a run's work folder.
inline constexpr const char* kDeckFile = "in.deck";
inline constexpr const char* kDataFile = "packing.data";
inline constexpr const char* kLidFile = "lid.stl";  ///< what the servo moves
inline constexpr const char* kScreenFile = "screen.txt";
/// What a dump of a packing holds, and how it is written: in full precision.
inline constexpr const char* kDumpColumns = "id type x y z radius vx vy vz omegax omegay omegaz";
inline constexpr const char* kDumpFormat =
    "sort id format \"%d %d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\"";
/// Packing at the end of a stage of Program::stages: "1-settle.dump".
std::string DumpFile(const Program& program, std::size_t stage);
/// Packings on the way through an Advance: "2-advance-frames.dump".
std::string FramesFile(const Program& program, std::size_t stage);
/// Surface of Program::meshes[mesh] at the beginning: "mesh-0.stl".
std::string MeshFile(std::size_t mesh);
/// Means over windows: "series-0-lid.txt". A segment ends with each Restore; tags are "lid",
/// "mesh_0", "group_0", "slab".
std::string SeriesFile(int segment, const std::string& tag);

/// Window of averaging of all series, and how often the slab is looked at within one [steps].
inline constexpr int kSeriesSteps = 100;
inline constexpr int kSlabSteps = 20;

// What the deck prints, one a line: "PC KIND key=value …". Steps count from the beginning of the
// program, through Restores.
//   START n               particles, before the first step
//   CHECK stage step ke   after each run
//   RESTORE segment shift what to add to the steps in the files that follow
//   END stage step n ke z, from the servo on h, rise; of Hold also p, velocity, change, quiet, rest
// `ke` kinetic energy of the free particles [J], `z` their coordination number, `h` the servo's
// lowest point [m] and `rise` its way from where it was put, `p` its mean stress over the last
// window [Pa, tensile], `velocity` [m/s] its mean over the same, `change` that of its mean height
// above the floor relative to the window before, `quiet` kinetic to elastic energy, `rest` 1 where
// the criteria of Hold are met.

/// Everything LIGGGHTS reads, as text.
struct Input {
  std::string deck;
  std::map<std::string, std::string> files;  ///< packing and surfaces, by name
  int particle_count = 0;
};

/// "" if LIGGGHTS can run the program, else the reason.
std::string ExplainUnsupported(const Program& program);

/// Writes the input for a supported program. Throws InputError when the particles cannot be placed.
Input WriteInput(const Program& program);

}  // namespace powdercal::liggghts

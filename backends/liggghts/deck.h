#pragma once

#include <string>

#include "backends/program.h"

namespace powdercal::liggghts {

/// Names of the files in a run's work folder.
inline constexpr const char* kDeckFile = "in.deck";
inline constexpr const char* kDataFile = "packing.data";
inline constexpr const char* kMeshFile = "wall.stl";
inline constexpr const char* kScreenFile = "screen.txt";
inline constexpr const char* kSeriesFile = "series.txt";
/// Packing at the end of a stage of Program::stages: "1-settle.dump".
std::string DumpFile(const Program& program, std::size_t stage);
/// Packings on the way through an Advance: "2-advance-frames.dump".
std::string FramesFile(const Program& program, std::size_t stage);

// What the deck prints, one a line: "PC KIND key=value …". Steps count from the beginning of the
// program.
//   START n               particles, before the first step
//   CHECK stage step ke   in the loops of Settle, Servo and Hold
//   END stage step n ke z, from the servo on h, rise; of Hold also p, velocity, change, quiet, rest
// `ke` kinetic energy [J], `z` coordination number, `h` the servo's height [m] and `rise` its way
// from where it was put, `p` its mean stress over the last window [Pa, tensile], `velocity` [m/s]
// its mean over the same, `change` that of its mean height above the floor relative to the window
// before, `quiet` kinetic to elastic energy, `rest` 1 where the criteria of Hold are met.

/// Everything LIGGGHTS reads, as text.
struct Input {
  std::string deck;
  std::string data;
  std::string mesh;  ///< "" where the program has no servo
  int particle_count = 0;
};

/// "" if LIGGGHTS can run the program, else the reason.
std::string ExplainUnsupported(const Program& program);

/// Writes the input for a supported program. Throws InputError when the particles cannot be placed.
Input WriteInput(const Program& program);

}  // namespace powdercal::liggghts

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
/// Packing at the end of a stage: "settle.dump", "hold.dump".
std::string DumpFile(const std::string& moment);

/// The contact law in LIGGGHTS' own words: "gran model hertz tangential history …".
std::string PairStyle(const ContactLaw& law);

/// Everything LIGGGHTS reads, as text.
struct Input {
  std::string deck;
  std::string data;
  std::string mesh;
  int particle_count = 0;
};

/// "" if LIGGGHTS can run the program, else the reason.
std::string ExplainUnsupported(const Program& program);

/// Writes the input for a supported program. Throws InputError when the particles cannot be placed.
Input WriteInput(const Program& program);

}  // namespace powdercal::liggghts

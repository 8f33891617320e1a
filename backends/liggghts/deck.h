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

/// Speed at which the servo wall moves per unit of relative error of its force [m/s], the product
/// vel_max · kp of LIGGGHTS. The wall moves with v = P (1 − F/F_target); each step changes the
/// force by about P · N · gamma_n, so that P N gamma_n/F_target must stay well below 1 (measured:
/// stable up to about 0.8, period-two oscillation at 1.4), with N = A/(2 d²) contacts at the wall,
/// an upper bound of what was measured, and gamma_n = 2 √(5/6) beta √(S_n m) of the mean sphere
/// under its share of the load. Chosen: 0.3 F_target/(N gamma_n), at most the program's own limit.
double ServoSpeed(const Program& program, const Servo& servo);

}  // namespace powdercal::liggghts

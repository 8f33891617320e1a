#pragma once

#include <map>
#include <string>

#include "backends/program.h"

namespace powdercal::liggghts {

/// The packing for `read_data`. Glued particles rest.
std::string WriteData(const Program& program, const Packing& packing);

/// Every mesh of the program as STL, by file name; that of the servo is kLidFile. A servo's plane
/// becomes a rectangle over the domain's base at z = 0.
std::map<std::string, std::string> WriteMeshes(const Program& program);

}  // namespace powdercal::liggghts

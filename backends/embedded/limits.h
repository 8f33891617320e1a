#pragma once

#include <string>

#include "backends/program.h"

namespace powdercal::embedded {

/// "" if the engine can run the program, else the reason why not.
std::string ExplainUnsupported(const Program& program);

}  // namespace powdercal::embedded

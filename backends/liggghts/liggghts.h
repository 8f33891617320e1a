#pragma once

#include <memory>

#include "backends/backend.h"

namespace powdercal {

/// LIGGGHTS-PUBLIC 3.8.0, run as a program of its own, one process and one core for each run.
std::unique_ptr<Backend> MakeLiggghtsBackend();

}  // namespace powdercal

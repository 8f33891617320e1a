#pragma once

#include <memory>

#include "backends/backend.h"

namespace powdercal {

/// powdercal's own DEM engine, in this process: no start-up, no files, the whole contact law. Runs
/// of one program are identical to the last bit, whatever the number of threads and the processor.
std::unique_ptr<Backend> MakeEmbeddedBackend();

}  // namespace powdercal

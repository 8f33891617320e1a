#pragma once

#include <filesystem>

#include "backends/program.h"
#include "backends/trace.h"
#include "core/process.h"

namespace powdercal::yade {

/// Reads what a run left. The driver names how the simulation ended in its last record; without one
/// the run was stopped (cancelled, timeout), the driver refused something that only YADE knows of
/// before the first step (invalid_input), or the process died (crashed). Moments and series are
/// there as far as the run came.
Trace ReadTrace(const Program& program, const std::filesystem::path& result,
                const ProcessResult& process);

}  // namespace powdercal::yade

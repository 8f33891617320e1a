#pragma once

#include <filesystem>

#include "backends/program.h"
#include "backends/trace.h"
#include "core/process.h"

namespace powdercal::liggghts {

/// Reads what a run left in its work folder. `particle_count` is what went in. Every way to fail
/// that LIGGGHTS has ends in a reason code here:
///  - stopped on request, or by the limit: cancelled, timeout;
///  - "Lost atoms", or a box grown beyond bounds (its only signs of a blow-up, too): unstable if
///  the
///    time step exceeds 0.4 Rayleigh times (Hertz) or particles were faster than 1 m/s at the last
///    check, else lost_particles;
///  - other ERROR lines, exit status ≠ 0, a signal, no record of the last stage's end: crashed, or
///    invalid_input when the input was refused before the first step;
///  - fewer particles in the result than went in: lost_particles; with outflow sides, those that
///  are
///    gone have left (Diagnostics::leavers), and lost are those that a packing of the trace shows
///    beyond an open side. A particle that passes an open side and, between two packings, an
///    outflow side as well counts as a leaver;
///  - mean stress off by more than 5 % at the end of a Hold, or still moving: not_quasi_static.
Trace ReadTrace(const Program& program, int particle_count, const std::filesystem::path& folder,
                const ProcessResult& process);

}  // namespace powdercal::liggghts

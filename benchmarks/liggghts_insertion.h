#pragma once

#include "backends/program.h"

namespace powdercal::benchmarks {

/// The packing that LIGGGHTS' own insertion (fix insert/pack) makes of a program whose first stage
/// inserts: equal spheres, or eight sizes with equal numbers in place of a distribution. Overlaps,
/// density, velocity and slab are the program's; the seed picks LIGGGHTS' one, a prime. Asked
/// again it remembers; not for several threads. Throws std::runtime_error where LIGGGHTS fails or
/// cannot place all.
Packing InsertByLiggghts(const Program& program);

}  // namespace powdercal::benchmarks

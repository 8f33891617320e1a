#pragma once

#include <string>

#include "backends/program.h"

namespace powdercal::yade {

inline constexpr const char* kJobFile = "job.json";
inline constexpr const char* kResultFile = "result.jsonl";

/// What the driver reads (driver/main.py): {"program": Program::ToJson() without its packing,
/// "start": the placed spheres, "servo_wall": name or null, "servos": for each stage null or the
/// gains of its servo, "rolling_stiffness" [N m]}.
std::string MakeJob(const Program& program, const Packing& start);

/// Stiffness of YADE's rolling springs [N m], which is constant where the canonical law has k_t R*²
/// with k_t growing with the overlap: that of a contact which bears its share of the program's
/// first stress, or has an overlap of R*/1000 where there is none.
double RollingStiffness(const Program& program);

}  // namespace powdercal::yade

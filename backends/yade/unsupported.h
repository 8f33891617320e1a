#pragma once

#include <string>

#include "backends/program.h"

namespace powdercal::yade {

/// "" if YADE can run the program as it stands, else why not and what could be used instead.
std::string ExplainUnsupported(const Program& program);

/// The contact law as YADE runs it, in its own terms.
std::string DescribeLaw(const Program& program);

}  // namespace powdercal::yade

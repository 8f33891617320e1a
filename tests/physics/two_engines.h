#pragma once

#include <gtest/gtest.h>

#include "backends/registry.h"
#include "tests/physics/programs.h"
#include "tests/support/program.h"

// The same program in the embedded engine and in the real LIGGGHTS.

namespace powdercal::physics {

struct TwoTraces {
  Trace embedded;
  Trace liggghts;
};

inline Trace RunLiggghts(const Program& program) {
  const TemporaryFolder folder;
  return MakeBackend("liggghts")->Run(program, {.work_folder = folder / "run"});
}

inline TwoTraces RunBoth(const Program& program) {
  return {RunProgram(program), RunLiggghts(program)};
}

}  // namespace powdercal::physics

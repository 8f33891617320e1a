#pragma once

#include <fmt/format.h>

#include "core/errors.h"

namespace powdercal::benchmarks {

/// The main function of a benchmark: the program's exit status, or 2 for input that it refuses.
inline int Main(int (*program)(int, char**), int argc, char** argv) {
  try {
    return program(argc, argv);
  } catch (const InputError& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 2;
  }
}

}  // namespace powdercal::benchmarks

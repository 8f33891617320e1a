#pragma once

#include <filesystem>
#include <memory>

#include "backends/backend.h"

namespace powdercal {

/// Where YADE is. Debian builds it for its own Python, so that another `python3` that stands first
/// on PATH is of no use, and is never asked.
struct YadeInstallation {
  std::filesystem::path python = "/usr/bin/python3";
  /// The folder of the Python package `yade`; empty: lib/ARCHITECTURE/yade-double/py below /usr.
  std::filesystem::path modules;
};

/// YADE 2023.02a, used as a Python library: one process and one core for each run, without its
/// servers, its display and its threads.
std::unique_ptr<Backend> MakeYadeBackend();
std::unique_ptr<Backend> MakeYadeBackend(const YadeInstallation& installation);

}  // namespace powdercal

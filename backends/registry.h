#pragma once

#include <memory>
#include <span>
#include <string>

#include "backends/backend.h"

namespace powdercal {

/// Names of all backends, sorted, whether they can run on this machine or not.
std::span<const std::string> BackendNames();

/// A new backend, with default options and not yet prepared. Throws InputError for an unknown name.
std::unique_ptr<Backend> MakeBackend(const std::string& name);

}  // namespace powdercal

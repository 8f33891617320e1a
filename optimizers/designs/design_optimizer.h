#pragma once

#include <memory>
#include <string>

#include "optimizers/optimizer.h"

namespace powdercal {

/// A design as an optimizer: it asks for its points in order and is finished. `name`: see
/// DesignNames().
std::unique_ptr<OptimizerFactory> MakeDesignFactory(const std::string& name);

}  // namespace powdercal

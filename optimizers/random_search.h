#pragma once

#include <memory>

#include "optimizers/optimizer.h"

namespace powdercal {

/// `random`: independent points, uniform in the unit box, without end. The baseline that every
/// other optimizer is to beat.
std::unique_ptr<OptimizerFactory> MakeRandomSearchFactory();

}  // namespace powdercal

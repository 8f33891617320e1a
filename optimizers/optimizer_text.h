#pragma once

#include <memory>
#include <string>

#include "optimizers/designs/design.h"
#include "optimizers/optimizer.h"

namespace powdercal {

/// An optimizer as a command line names it: "bayesian", or with options of its section in a study,
/// "bayesian:acquisition=ei,initial_design.points=8". It begins with `initial_design` unless that is null, the
/// optimizer has none, or the text names another. Throws InputError for an unknown optimizer or
/// option, a bad value, or a text without that form.
std::unique_ptr<OptimizerFactory> ParseOptimizer(const std::string& text, const SearchSpace& space,
                                                 const DesignOptions* initial_design);

}  // namespace powdercal

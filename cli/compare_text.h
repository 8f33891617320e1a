#pragma once

#include <string>

#include "studies/comparison/comparison.h"

namespace powdercal::cli {

/// A comparison for people.
std::string ComparisonText(const comparison::Comparison& comparison);

}  // namespace powdercal::cli

#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace powdercal {

/// JSON knows no NaN and no infinity: null stands for them, and for a number that is not there.
inline nlohmann::json JsonNumber(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}
inline nlohmann::json JsonNumber(const std::optional<double>& value) {
  return value ? JsonNumber(*value) : nlohmann::json(nullptr);
}

}  // namespace powdercal

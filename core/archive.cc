#include "core/archive.h"

#include <algorithm>
#include <cmath>

namespace powdercal {

void AddOverrides(std::span<const std::string> texts, Overrides* overrides) {
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw InputError("expected --set KEY=VALUE", {.location = {"command line"}, .value = text});
    }
    if (!overrides->emplace(text.substr(0, equals), text.substr(equals + 1)).second) {
      throw InputError("given twice",
                       {.location = {"command line"}, .key = text.substr(0, equals)});
    }
  }
}

bool Range::Contains(double value) const {
  if (std::isnan(value)) return false;
  if (lower_open ? value <= lower : value < lower) return false;
  return upper_open ? value < upper : value <= upper;
}

void Archive::Integer(std::string_view key, int& value, Range range) {
  std::int64_t wide = value;
  range.lower = std::max<double>(range.lower, std::numeric_limits<int>::min());
  range.upper = std::min<double>(range.upper, std::numeric_limits<int>::max());
  Integer(key, wide, range);
  value = static_cast<int>(wide);
}

}  // namespace powdercal

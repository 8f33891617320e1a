#include "core/archive.h"

#include <algorithm>
#include <cmath>

namespace powdercal {

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

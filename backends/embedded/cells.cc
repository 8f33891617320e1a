#include "backends/embedded/cells.h"

#include <algorithm>
#include <cmath>

namespace powdercal::embedded {

Cells::Cells(const double* positions, std::int32_t count, const Box& box, const Images& images,
             double cell_size)
    : box_(box), shear_offset_(images.shear_offset) {
  std::array<double, 3> upper{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lower_[axis] = box.lower[axis];
    upper[axis] = box.upper[axis];
    if (box.periodic[axis] || count == 0) continue;
    double low = positions[axis];
    double high = low;
    for (std::int32_t p = 1; p < count; ++p) {
      const double x = positions[static_cast<std::size_t>(p) * kRow + axis];
      low = std::min(low, x);
      high = std::max(high, x);
    }
    lower_[axis] = low;
    upper[axis] = high;
  }
  // A nearly empty box shall not cost more cells than it has particles.
  const double limit = 4.0 * count + 64;
  for (double size = cell_size;; size *= 1.26) {
    double product = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double extent = upper[axis] - lower_[axis];
      const double cells = std::max(1.0, std::floor(extent / size));
      product *= cells;
      counts_[axis] = static_cast<std::int32_t>(std::min(cells, 1e6));
      size_[axis] = std::max(extent / counts_[axis], size * 1e-9);
    }
    if (product <= limit) break;
  }
  order_ = {0, 1, 2};
  std::stable_sort(order_.begin(), order_.end(), [&](int a, int b) {
    return counts_[static_cast<std::size_t>(a)] > counts_[static_cast<std::size_t>(b)];
  });
  // Shear displaces x along z: pairs across the top would join layers of x far apart.
  const bool sheared = images.shear_offset != 0 || images.shear_speed != 0;
  if (sheared && order_[0] == 0) std::swap(order_[0], order_[1]);
}

std::array<std::int32_t, 3> Cells::Coordinates(std::int32_t cell) const {
  std::array<std::int32_t, 3> at{};
  for (int rank = 2; rank >= 0; --rank) {
    const auto axis = static_cast<std::size_t>(order_[static_cast<std::size_t>(rank)]);
    at[axis] = cell % counts_[axis];
    cell /= counts_[axis];
  }
  return at;
}

std::int32_t Cells::Index(const std::array<std::int32_t, 3>& at) const {
  const auto a = static_cast<std::size_t>(order_[0]);
  const auto b = static_cast<std::size_t>(order_[1]);
  const auto c = static_cast<std::size_t>(order_[2]);
  return (at[a] * counts_[b] + at[b]) * counts_[c] + at[c];
}

std::int32_t Cells::CellOf(const double* position) const {
  std::array<std::int32_t, 3> at{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double place = (position[axis] - lower_[axis]) / size_[axis];
    at[axis] = static_cast<std::int32_t>(std::clamp(place, 0.0, counts_[axis] - 1.0));
  }
  return Index(at);
}

void Cells::Neighbourhood(std::int32_t cell, std::vector<std::int32_t>* cells) const {
  cells->clear();
  const std::array<std::int32_t, 3> at = Coordinates(cell);
  const auto wrapped = [&](std::size_t axis, std::int32_t c, std::int32_t* result) {
    if (c < 0 || c >= counts_[axis]) {
      if (!box_.periodic[axis]) return false;
      c = (c % counts_[axis] + counts_[axis]) % counts_[axis];
    }
    *result = c;
    return true;
  };
  for (std::int32_t dz = -1; dz <= 1; ++dz) {
    std::array<std::int32_t, 3> to{};
    if (!wrapped(2, at[2] + dz, &to[2])) continue;
    // Across the top the neighbours' images stand displaced by the shear.
    std::int32_t first = at[0] - 1;
    std::int32_t last = at[0] + 1;
    if (shear_offset_ != 0 && at[2] + dz != to[2]) {
      const double shift = (dz > 0 ? -shear_offset_ : shear_offset_) / size_[0];
      first += static_cast<std::int32_t>(std::floor(shift));
      last += static_cast<std::int32_t>(std::ceil(shift));
    }
    for (std::int32_t dy = -1; dy <= 1; ++dy) {
      if (!wrapped(1, at[1] + dy, &to[1])) continue;
      for (std::int32_t x = first; x <= last; ++x) {
        if (wrapped(0, x, &to[0])) cells->push_back(Index(to));
      }
    }
  }
  std::sort(cells->begin(), cells->end());
  cells->erase(std::unique(cells->begin(), cells->end()), cells->end());
}

}  // namespace powdercal::embedded

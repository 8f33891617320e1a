#include "backends/cell_grid.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace powdercal {

CellGrid::CellGrid(const Vector3& lower, const Vector3& upper, const std::array<bool, 3>& periodic,
                   double cell_size, std::size_t max_cells)
    : lower_(lower), periodic_(periodic) {
  assert(cell_size > 0 && max_cells >= 1);
  for (int axis = 0; axis < 3; ++axis) length_[axis] = upper[axis] - lower[axis];
  constexpr double kMaxPerAxis = 1 << 20;
  for (double size = cell_size;; size *= 1.25) {
    for (int axis = 0; axis < 3; ++axis) {
      counts_[axis] =
          static_cast<int>(std::clamp(std::floor(length_[axis] / size), 1.0, kMaxPerAxis));
    }
    if (CellGrid::size() <= max_cells) return;
  }
}

std::size_t CellGrid::size() const {
  return static_cast<std::size_t>(counts_[0]) * counts_[1] * counts_[2];
}

CellGrid::Cell CellGrid::CellOf(const Vector3& point) const {
  Cell cell;
  for (int axis = 0; axis < 3; ++axis) {
    const double fraction = (point[axis] - lower_[axis]) / length_[axis];
    const double last = counts_[axis] - 1;
    cell[axis] = static_cast<int>(std::clamp(fraction * counts_[axis], 0.0, last));
  }
  return cell;
}

std::size_t CellGrid::Index(const Cell& cell) const {
  return (static_cast<std::size_t>(cell[2]) * counts_[1] + cell[1]) * counts_[0] + cell[0];
}

Vector3 CellGrid::Wrap(Vector3 point) const {
  for (int axis = 0; axis < 3; ++axis) {
    if (!periodic_[axis]) continue;
    const double turns = std::floor((point[axis] - lower_[axis]) / length_[axis]);
    point[axis] -= turns * length_[axis];
  }
  return point;
}

}  // namespace powdercal

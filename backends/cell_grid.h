#pragma once

#include <array>
#include <cstddef>

#include "backends/program.h"

namespace powdercal {

/// A box divided into equal cells no smaller than `cell_size`, for finding what lies within that
/// distance of a point. Periodic images are handled by shifts, so that boxes only one or two cells
/// wide are right as well.
class CellGrid {
 public:
  /// Cells grow beyond cell_size where there would otherwise be more than max_cells of them.
  CellGrid(const Vector3& lower, const Vector3& upper, const std::array<bool, 3>& periodic,
           double cell_size, std::size_t max_cells);

  using Cell = std::array<int, 3>;

  std::size_t size() const;
  /// Points outside the box belong to the nearest cell.
  Cell CellOf(const Vector3& point) const;
  std::size_t Index(const Cell& cell) const;

  /// The point moved into the box along the periodic axes.
  Vector3 Wrap(Vector3 point) const;

  /// Calls visit(index, shift) for the cell itself, then for its up to 26 neighbours, until a call
  /// returns true; returns whether one did. `shift` is to be added to the positions in that cell.
  template <typename Visit>
  bool AnyNeighbour(const Cell& cell, Visit&& visit) const;

 private:
  Vector3 lower_;
  Vector3 length_;
  std::array<bool, 3> periodic_;
  std::array<int, 3> counts_{1, 1, 1};
};

template <typename Visit>
bool CellGrid::AnyNeighbour(const Cell& cell, Visit&& visit) const {
  if (visit(Index(cell), Vector3{})) return true;
  static constexpr std::array<int, 3> kSteps = {0, -1, 1};
  // Per axis: the neighbouring cells that exist, with their shifts.
  std::array<std::array<int, 3>, 3> cells;
  std::array<std::array<double, 3>, 3> shifts;
  std::array<int, 3> found{};
  for (int axis = 0; axis < 3; ++axis) {
    for (const int step : kSteps) {
      int c = cell[axis] + step;
      double shift = 0;
      if (c < 0 || c >= counts_[axis]) {
        if (!periodic_[axis]) continue;
        shift = c < 0 ? -length_[axis] : length_[axis];
        c += c < 0 ? counts_[axis] : -counts_[axis];
      }
      cells[axis][found[axis]] = c;
      shifts[axis][found[axis]] = shift;
      ++found[axis];
    }
  }
  for (int iz = 0; iz < found[2]; ++iz) {
    for (int iy = 0; iy < found[1]; ++iy) {
      for (int ix = (iy == 0 && iz == 0) ? 1 : 0; ix < found[0]; ++ix) {
        const std::size_t index = Index({cells[0][ix], cells[1][iy], cells[2][iz]});
        if (visit(index, Vector3{shifts[0][ix], shifts[1][iy], shifts[2][iz]})) return true;
      }
    }
  }
  return false;
}

}  // namespace powdercal

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "backends/embedded/kernels.h"
#include "backends/embedded/neighbours.h"

namespace powdercal::embedded {

/// Cells no smaller than a cut-off, layered along the axis with the most of them; the order of
/// cells is that in which particles are sorted: layer by layer, the shortest axis fastest.
class Cells {
 public:
  /// `positions` are rows of particles, inside the box along its periodic axes. Along the others
  /// the cells span what the particles span.
  Cells(const double* positions, std::int32_t count, const Box& box, const Images& images,
        double cell_size);

  std::int32_t size() const { return counts_[0] * counts_[1] * counts_[2]; }
  std::int32_t layers() const { return counts_[order_[0]]; }
  std::int32_t per_layer() const { return counts_[order_[1]] * counts_[order_[2]]; }
  /// Whether the last layer touches the first one.
  bool layers_wrap() const { return box_.periodic[static_cast<std::size_t>(order_[0])]; }

  std::int32_t CellOf(const double* position) const;
  /// Indices of all cells that may hold something within a cell's size of something in this one,
  /// itself included, ascending, without repetition.
  void Neighbourhood(std::int32_t cell, std::vector<std::int32_t>* cells) const;

 private:
  std::array<std::int32_t, 3> Coordinates(std::int32_t cell) const;
  std::int32_t Index(const std::array<std::int32_t, 3>& at) const;

  Box box_;
  double shear_offset_ = 0;
  std::array<int, 3> order_{};  // axes, slowest first
  std::array<std::int32_t, 3> counts_{1, 1, 1};
  std::array<double, 3> lower_{};
  std::array<double, 3> size_{};  // of a cell
};

/// The displacement d, moved to the nearest image, as the kernels do it.
inline void NearestImage(const Images& images, double (&d)[3]) {
  const auto round = [](double x) {
    constexpr double kMagic = 6755399441055744.0;  // 1.5 · 2^52: adding it leaves no fraction
    return (x + kMagic) - kMagic;
  };
  const double up = round(d[2] * images.inverse[2]);
  d[2] -= up * images.length[2];
  d[0] -= up * images.shear_offset;
  d[0] -= round(d[0] * images.inverse[0]) * images.length[0];
  d[1] -= round(d[1] * images.inverse[1]) * images.length[1];
}

}  // namespace powdercal::embedded

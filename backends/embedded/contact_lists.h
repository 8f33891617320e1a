#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "backends/embedded/aligned.h"
#include "backends/embedded/kernels.h"

namespace powdercal::embedded {

/// Which histories a contact law keeps.
struct HistoryKinds {
  bool shear = false;
  bool rolling = false;
};

/// What contacts remember, in columns.
struct HistoryColumns {
  std::array<AlignedVector<double>, 3> shear;
  std::array<AlignedVector<double>, 3> rolling;

  void Resize(std::size_t size, HistoryKinds kinds);
  /// Entry n becomes sign times entry m of `from`.
  void Copy(std::size_t n, const HistoryColumns& from, std::size_t m, double sign,
            HistoryKinds kinds);

  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream) {
    stream(self.shear, self.rolling);
  }
};

/// A list of contacts that the kernels read; owns its columns.
struct ContactList {
  std::int32_t size = 0;  ///< without padding
  AlignedVector<Offset> i;
  AlignedVector<Offset> j;  ///< empty at walls
  AlignedVector<double> radius_sum;
  AlignedVector<double> effective_radius;
  AlignedVector<double> effective_mass;
  HistoryColumns history;
  std::array<AlignedVector<double>, 3> force;  ///< [N] on i; of the last step that recorded them

  /// Room for `contacts` and their padding; the padding points to `padding_row` and is inert.
  void Resize(std::int32_t contacts, bool pairs, HistoryKinds kinds, std::int32_t padding_row);
  /// For the kernels, which write `force` if asked to.
  ContactColumns Columns(bool record_forces);

  /// See state_stream.h.
  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream) {
    stream(self.size, self.i, self.j, self.radius_sum, self.effective_radius, self.effective_mass,
           self.history, self.force);
  }
};

}  // namespace powdercal::embedded

#include "backends/embedded/contact_lists.h"

namespace powdercal::embedded {

void HistoryColumns::Resize(std::size_t size, HistoryKinds kinds) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (kinds.shear) shear[axis].assign(size, 0.0);
    if (kinds.rolling) rolling[axis].assign(size, 0.0);
  }
}

void HistoryColumns::Copy(std::size_t n, const HistoryColumns& from, std::size_t m, double sign,
                          HistoryKinds kinds) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (kinds.shear) shear[axis][n] = sign * from.shear[axis][m];
    if (kinds.rolling) rolling[axis][n] = sign * from.rolling[axis][m];
  }
}

void ContactList::Resize(std::int32_t contacts, bool pairs, HistoryKinds kinds,
                         std::int32_t padding_row) {
  size = contacts;
  const auto real = static_cast<std::size_t>(contacts);
  const std::size_t padded = (real + kPadding - 1) / kPadding * kPadding;
  i.resize(padded);
  if (pairs) j.resize(padded);
  radius_sum.resize(padded);
  effective_radius.resize(padded);
  effective_mass.resize(padded);
  history.Resize(padded, kinds);
  for (std::size_t n = real; n < padded; ++n) {
    i[n] = OffsetOf(padding_row);
    if (pairs) j[n] = OffsetOf(padding_row);
    radius_sum[n] = -1;
    effective_radius[n] = 0;
    effective_mass[n] = 0;
  }
}

ContactColumns ContactList::Columns(bool record_forces) {
  ContactColumns columns;
  columns.size = static_cast<std::int32_t>(i.size());
  columns.i = i.data();
  columns.j = j.data();
  columns.radius_sum = radius_sum.data();
  columns.effective_radius = effective_radius.data();
  columns.effective_mass = effective_mass.data();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    columns.shear[axis] = history.shear[axis].data();
    columns.rolling[axis] = history.rolling[axis].data();
    if (!record_forces) continue;
    force[axis].resize(i.size());
    columns.force[axis] = force[axis].data();
  }
  return columns;
}

}  // namespace powdercal::embedded

#include "backends/embedded/particle_store.h"

#include <algorithm>
#include <numbers>

namespace powdercal::embedded {
namespace {

// values[n] = old values[order[n]], `width` numbers at a time.
template <typename Vector>
void Permute(Vector& values, const std::vector<std::int32_t>& order, std::size_t width) {
  Vector sorted(order.size() * width);
  for (std::size_t n = 0; n < order.size(); ++n) {
    const auto from = static_cast<std::size_t>(order[n]) * width;
    for (std::size_t k = 0; k < width; ++k) sorted[n * width + k] = values[from + k];
  }
  values.swap(sorted);
}

}  // namespace

ParticleStore::ParticleStore(const Packing& packing, double density)
    : count_(static_cast<std::int32_t>(packing.size())), density_(density) {
  const std::size_t n = packing.size();
  rows_.resize(n * kRow);
  inverse_mass.resize(n);
  inverse_inertia.resize(n);
  ids.resize(n);
  group.assign(n, -1);
  for (std::size_t p = 0; p < n; ++p) {
    const Sphere& s = packing[p];
    double* row = &rows_[p * kRow];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      row[axis] = s.position[axis];
      row[kVelocity + axis] = s.velocity[axis];
      row[kSpin + axis] = s.spin[axis];
    }
    row[3] = s.radius;
    const double mass = Mass(static_cast<std::int32_t>(p));
    inverse_mass[p] = 1 / mass;
    inverse_inertia[p] = 1 / (0.4 * mass * s.radius * s.radius);
    ids[p] = s.id;
  }
}

double ParticleStore::Mass(std::int32_t p) const {
  const double r = Radius(p);
  return density_ * (4.0 / 3.0 * std::numbers::pi) * r * r * r;
}

Sphere ParticleStore::ToSphere(std::int32_t p) const {
  const double* x = Position(p);
  const double* w = Spin(p);
  return {.id = ids[static_cast<std::size_t>(p)],
          .radius = x[3],
          .position = {x[0], x[1], x[2]},
          .velocity = {x[4], x[5], x[6]},
          .spin = {w[0], w[1], w[2]}};
}

void ParticleStore::ResizePadding(int slabs) {
  rows_.resize(static_cast<std::size_t>(count_ + slabs) * kRow);
}

void ParticleStore::ClearLoads() {
  for (std::size_t row = 0; row < rows_.size(); row += kRow) {
    std::fill_n(&rows_[row + kForce], kRow - kForce, 0.0);
  }
}

void ParticleStore::Reorder(const std::vector<std::int32_t>& order) {
  Permute(rows_, order, kRow);
  Permute(inverse_mass, order, 1);
  Permute(inverse_inertia, order, 1);
  Permute(ids, order, 1);
  Permute(group, order, 1);
  count_ = static_cast<std::int32_t>(order.size());
}

}  // namespace powdercal::embedded

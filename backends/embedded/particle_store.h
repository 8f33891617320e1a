#pragma once

#include <cstdint>
#include <vector>

#include "backends/embedded/aligned.h"
#include "backends/embedded/kernels.h"
#include "backends/program.h"

namespace powdercal::embedded {

/// The particles in rows, kept in spatial order. Behind the `count` real ones stands a row of zeros
/// for each slab, to which the inert entries of its contact lists point.
class ParticleStore {
 public:
  /// Requires density > 0.
  ParticleStore(const Packing& packing, double density);

  std::int32_t count() const { return count_; }
  double* rows() { return rows_.data(); }
  const double* rows() const { return rows_.data(); }

  double Radius(std::int32_t p) const { return rows_[Row(p) + 3]; }
  double Mass(std::int32_t p) const;
  const double* Position(std::int32_t p) const { return &rows_[Row(p)]; }
  double* Position(std::int32_t p) { return &rows_[Row(p)]; }
  const double* Velocity(std::int32_t p) const { return Position(p) + kVelocity; }
  double* Velocity(std::int32_t p) { return Position(p) + kVelocity; }
  const double* Spin(std::int32_t p) const { return Position(p) + kSpin; }
  const double* Force(std::int32_t p) const { return Position(p) + kForce; }
  /// Sets all forces and torques to zero.
  void ClearLoads();
  Sphere ToSphere(std::int32_t p) const;

  /// Makes room for a row of zeros for each slab.
  void ResizePadding(int slabs);
  std::int32_t PaddingRow(int slab) const { return count_ + slab; }
  /// Moves particle order[n] to place n, dropping those that `order` does not name.
  void Reorder(const std::vector<std::int32_t>& order);

  AlignedVector<double> inverse_mass;
  AlignedVector<double> inverse_inertia;
  std::vector<std::int64_t> ids;
  std::vector<std::int32_t> group;  ///< index of the glued group, or −1

  double density() const { return density_; }

  /// See state_stream.h.
  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream) {
    stream(self.rows_, self.count_, self.inverse_mass, self.inverse_inertia, self.ids, self.group);
  }

 private:
  static std::size_t Row(std::int32_t p) { return static_cast<std::size_t>(p) * kRow; }

  AlignedVector<double> rows_;
  std::int32_t count_ = 0;
  double density_ = 0;
};

}  // namespace powdercal::embedded

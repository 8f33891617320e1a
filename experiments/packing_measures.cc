#include "experiments/packing_measures.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <tuple>

#include "backends/cell_grid.h"
#include "scaling/groups.h"

namespace powdercal {
namespace {

using std::numbers::pi;

double Cube(double x) { return x * x * x; }

double SphereVolume(double radius) { return 4.0 / 3.0 * pi * Cube(radius); }

double Dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

double EffectiveRadius(const Packing& packing, const PairContact& contact) {
  const double ri = packing[contact.i].radius;
  const double rj = packing[contact.j].radius;
  return ri * rj / (ri + rj);
}

// Spheres sorted by cell, so that a search reads memory in order.
class SortedSpheres {
 public:
  struct Entry {
    Vector3 position;  // wrapped into the box
    double radius;
    std::uint32_t index;
  };

  SortedSpheres(const Packing& packing, const CellGrid& grid)
      : grid_(grid), first_(grid.size() + 1, 0), entries_(packing.size()) {
    std::vector<std::size_t> cell(packing.size());
    for (std::size_t i = 0; i < packing.size(); ++i) {
      cell[i] = grid.Index(grid.CellOf(grid.Wrap(packing[i].position)));
      ++first_[cell[i] + 1];
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < packing.size(); ++i) {
      entries_[next[cell[i]]++] = {grid.Wrap(packing[i].position), packing[i].radius,
                                   static_cast<std::uint32_t>(i)};
    }
  }

  std::span<const Entry> all() const { return entries_; }
  std::span<const Entry> InCell(std::size_t cell) const {
    return std::span(entries_).subspan(first_[cell], first_[cell + 1] - first_[cell]);
  }

  // Appends the contacts of one sphere with those of larger index.
  void FindPartners(const Entry& self, std::vector<PairContact>* pairs) const {
    grid_.AnyNeighbour(grid_.CellOf(self.position), [&](std::size_t cell, const Vector3& shift) {
      for (const Entry& other : InCell(cell)) {
        if (other.index <= self.index) continue;
        const Vector3 d = {other.position[0] + shift[0] - self.position[0],
                           other.position[1] + shift[1] - self.position[1],
                           other.position[2] + shift[2] - self.position[2]};
        const double squared = Dot(d, d);
        const double reach = self.radius + other.radius;
        if (squared > reach * reach || squared == 0) continue;
        const double distance = std::sqrt(squared);
        // The lens's plane is this far from the first centre.
        const double arm =
            (squared + self.radius * self.radius - other.radius * other.radius) / (2 * distance);
        pairs->push_back({self.index, other.index, distance, std::max(0.0, reach - distance),
                          self.position[2] + d[2] * arm / distance});
      }
      return false;
    });
  }

 private:
  const CellGrid& grid_;
  std::vector<std::size_t> first_;  // of each cell in entries_
  std::vector<Entry> entries_;
};

// A box that holds the packing, with the domain's own sides where it is periodic.
CellGrid MakeGrid(const Packing& packing, const Domain& domain) {
  Vector3 lower = domain.lower;
  Vector3 upper = domain.upper;
  std::array<bool, 3> periodic;
  double largest = 0;
  for (const Sphere& sphere : packing) largest = std::max(largest, 2 * sphere.radius);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    periodic[axis] = domain.boundaries[axis] == Boundary::periodic;
    if (periodic[axis]) {
      assert(upper[axis] - lower[axis] >= largest);
      continue;
    }
    lower[axis] = std::numeric_limits<double>::max();
    upper[axis] = std::numeric_limits<double>::lowest();
    for (const Sphere& sphere : packing) {
      lower[axis] = std::min(lower[axis], sphere.position[axis]);
      upper[axis] = std::max(upper[axis], sphere.position[axis]);
    }
    if (!(upper[axis] - lower[axis] > largest)) upper[axis] = lower[axis] + largest;
  }
  // A little larger than the diameter, so that spheres that just touch are found despite rounding.
  return CellGrid(lower, upper, periodic, largest * (1 + 1e-9), 4 * packing.size() + 64);
}

VoidRatio Compose(const Domain& domain, double bottom, double top, double sphere_volume,
                  double overlap_volume) {
  const double total = domain.BaseArea() * (top - bottom);
  const double solid = sphere_volume - overlap_volume;
  const auto ratio = [total](double volume) {
    return volume > 0 ? (total - volume) / volume : std::numeric_limits<double>::infinity();
  };
  return {bottom, top, sphere_volume, overlap_volume, ratio(sphere_volume), ratio(solid)};
}

double LensVolumeBetween(const Packing& packing, const Contacts& contacts, double bottom,
                         double top) {
  double volume = 0;
  for (const PairContact& contact : contacts.pairs) {
    if (contact.contact_height < bottom || contact.contact_height >= top) continue;
    volume += LensVolume(packing[contact.i].radius, packing[contact.j].radius, contact.distance);
  }
  return volume;
}

}  // namespace

double SolidVolume(const Packing& packing) {
  double volume = 0;
  for (const Sphere& sphere : packing) volume += SphereVolume(sphere.radius);
  return volume;
}

double SphereVolumeBelow(double radius, double height) {
  const double t = std::clamp(height, -radius, radius);
  return pi / 3 * (radius + t) * (radius + t) * (2 * radius - t);
}

double SphereSlabVolume(const Sphere& sphere, double bottom, double top) {
  const double z = sphere.position[2];
  return SphereVolumeBelow(sphere.radius, top - z) - SphereVolumeBelow(sphere.radius, bottom - z);
}

double LensVolume(double radius1, double radius2, double distance) {
  const double sum = radius1 + radius2;
  const double difference = radius1 - radius2;
  if (distance >= sum) return 0;
  if (distance <= std::abs(difference)) return SphereVolume(std::min(radius1, radius2));
  return pi * (sum - distance) * (sum - distance) *
         (distance * distance + 2 * distance * sum - 3 * difference * difference) / (12 * distance);
}

Contacts FindContacts(const Packing& packing, const Domain& domain,
                      std::span<const WallPlane> walls) {
  assert(packing.size() < std::numeric_limits<std::uint32_t>::max());
  Contacts contacts;
  if (packing.empty()) return contacts;
  const CellGrid grid = MakeGrid(packing, domain);
  const SortedSpheres spheres(packing, grid);
  contacts.pairs.reserve(4 * packing.size());
  for (const SortedSpheres::Entry& entry : spheres.all()) {
    spheres.FindPartners(entry, &contacts.pairs);
  }
  std::sort(contacts.pairs.begin(), contacts.pairs.end(),
            [](const PairContact& a, const PairContact& b) {
              return std::tie(a.i, a.j, a.contact_height) < std::tie(b.i, b.j, b.contact_height);
            });
  for (std::size_t w = 0; w < walls.size(); ++w) {
    for (std::size_t i = 0; i < packing.size(); ++i) {
      const double z = packing[i].position[2];
      const double gap = walls[w].facing_up ? z - walls[w].height : walls[w].height - z;
      if (gap > packing[i].radius) continue;
      contacts.walls.push_back(
          {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(w), packing[i].radius - gap});
    }
  }
  return contacts;
}

VoidRatio MeasureVoidRatio(const Packing& packing, const Contacts& contacts, const Domain& domain,
                           double bottom, double top) {
  assert(bottom < top);
  double spheres = 0;
  for (const Sphere& sphere : packing) spheres += SphereSlabVolume(sphere, bottom, top);
  return Compose(domain, bottom, top, spheres, LensVolumeBetween(packing, contacts, bottom, top));
}

VoidRatio CentralVoidRatio(const Packing& packing, const Contacts& contacts, const Domain& domain,
                           double floor, double wall) {
  const double height = wall - floor;
  return MeasureVoidRatio(packing, contacts, domain, floor + 0.2 * height, floor + 0.8 * height);
}

VoidRatio WallToWallVoidRatio(const Packing& packing, const Contacts& contacts,
                              const Domain& domain, double floor, double wall) {
  assert(floor < wall);
  double whole = 0;
  double inside = 0;
  for (const Sphere& sphere : packing) {
    if (sphere.position[2] < floor || sphere.position[2] > wall) continue;
    whole += SphereVolume(sphere.radius);
    inside += SphereSlabVolume(sphere, floor, wall);
  }
  const double lenses = LensVolumeBetween(packing, contacts, floor, wall);
  return Compose(domain, floor, wall, whole, whole - inside + lenses);
}

double StiffnessShift(double void_ratio, double mean_relative_overlap) {
  return 3 * (1 + void_ratio) * mean_relative_overlap;
}

ContactStatistics MeasureContacts(const Packing& packing, const Contacts& contacts) {
  ContactStatistics statistics;
  if (packing.empty()) return statistics;
  std::vector<int> count(packing.size(), 0);
  double relative = 0;
  for (const PairContact& contact : contacts.pairs) {
    ++count[contact.i];
    ++count[contact.j];
    relative += contact.overlap / (packing[contact.i].radius + packing[contact.j].radius);
    statistics.max_overlap =
        std::max(statistics.max_overlap, contact.overlap / EffectiveRadius(packing, contact));
  }
  for (const WallContact& contact : contacts.walls) {
    ++count[contact.i];
    statistics.max_overlap =
        std::max(statistics.max_overlap, contact.overlap / packing[contact.i].radius);
  }
  double all = 0;
  double mechanical = 0;
  double bearing = 0;
  for (const int n : count) {
    all += n;
    if (n < 2) continue;
    mechanical += n;
    bearing += 1;
  }
  const auto particles = static_cast<double>(packing.size());
  statistics.coordination_number = all / particles;
  statistics.mechanical_coordination_number = bearing > 0 ? mechanical / bearing : 0;
  statistics.rattler_fraction = 1 - bearing / particles;
  if (!contacts.pairs.empty()) {
    statistics.mean_relative_overlap = relative / static_cast<double>(contacts.pairs.size());
  }
  return statistics;
}

double HertzEnergy(const Packing& packing, const Contacts& contacts, double young_modulus,
                   double poisson_ratio) {
  double sum = 0;  // of sqrt(R*) delta^(5/2)
  for (const PairContact& contact : contacts.pairs) {
    sum += contact.overlap * contact.overlap *
           std::sqrt(EffectiveRadius(packing, contact) * contact.overlap);
  }
  for (const WallContact& contact : contacts.walls) {
    sum +=
        contact.overlap * contact.overlap * std::sqrt(packing[contact.i].radius * contact.overlap);
  }
  const double effective_modulus = EffectiveModulus(young_modulus, poisson_ratio);
  return 8.0 / 15.0 * effective_modulus * sum;
}

double KineticEnergy(const Packing& packing, double density) {
  double energy = 0;
  for (const Sphere& sphere : packing) {
    const double mass = density * SphereVolume(sphere.radius);
    energy += 0.5 * mass * Dot(sphere.velocity, sphere.velocity) +
              0.2 * mass * sphere.radius * sphere.radius * Dot(sphere.spin, sphere.spin);
  }
  return energy;
}

}  // namespace powdercal

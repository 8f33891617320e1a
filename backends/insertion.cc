#include "backends/insertion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <unordered_set>

#include "backends/cell_grid.h"
#include "core/errors.h"
#include "core/quantity.h"
#include "core/random.h"

namespace powdercal {
namespace {

bool Finite(const Vector3& v) {
  return std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
}

void CheckExplicitPacking(const Packing& packing, const Domain& domain) {
  if (packing.empty()) throw InputError("the explicit packing holds no particles");
  std::unordered_set<std::int64_t> ids;
  for (const Sphere& sphere : packing) {
    const auto fail = [&](const std::string& problem) {
      throw InputError(fmt::format("particle {} of the explicit packing: {}", sphere.id, problem));
    };
    if (sphere.id < 1) fail("ids count from 1");
    if (!ids.insert(sphere.id).second) fail("its id appears twice");
    if (!std::isfinite(sphere.radius) || sphere.radius <= 0) {
      fail(fmt::format("radius {} m is not positive", sphere.radius));
    }
    if (!Finite(sphere.position) || !Finite(sphere.velocity) || !Finite(sphere.spin)) {
      fail("position, velocity or spin is not finite");
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (domain.boundaries[axis] == Boundary::periodic) continue;
      const double x = sphere.position[axis];
      if (x < domain.lower[axis] || x > domain.upper[axis]) {
        fail(fmt::format("{} = {} m lies outside the domain ({} m to {} m)", "xyz"[axis], x,
                         domain.lower[axis], domain.upper[axis]));
      }
    }
  }
}

// Where centres may lie, and what has been placed so far.
class Slab {
 public:
  Slab(const Domain& domain, const Insert& insert, double largest_diameter, std::size_t count)
      : lower_{domain.lower[0], domain.lower[1], insert.bottom},
        upper_{domain.upper[0], domain.upper[1], insert.top},
        periodic_{domain.boundaries[0] == Boundary::periodic,
                  domain.boundaries[1] == Boundary::periodic, false},
        grid_(lower_, upper_, periodic_, largest_diameter, 4 * count + 64),
        first_(grid_.size(), -1) {
    placed_.reserve(count);
  }

  // A uniform point among those where a sphere is wholly inside.
  Vector3 Draw(RandomStream& random, double radius) const {
    Vector3 point;
    for (int axis = 0; axis < 3; ++axis) {
      const double margin = periodic_[axis] ? 0 : radius;
      const double low = lower_[axis] + margin;
      const double high = upper_[axis] - margin;
      point[axis] = low < high ? random.Uniform(low, high) : 0.5 * (low + high);
    }
    return point;
  }

  bool Place(const Vector3& point, double radius) {
    const CellGrid::Cell cell = grid_.CellOf(point);
    const bool blocked = grid_.AnyNeighbour(cell, [&](std::size_t index, const Vector3& shift) {
      for (int other = first_[index]; other >= 0; other = placed_[other].next) {
        const Placed& p = placed_[other];
        const double dx = p.position[0] + shift[0] - point[0];
        const double dy = p.position[1] + shift[1] - point[1];
        const double dz = p.position[2] + shift[2] - point[2];
        const double reach = p.radius + radius;
        if (dx * dx + dy * dy + dz * dz < reach * reach) return true;
      }
      return false;
    });
    if (blocked) return false;
    int& first = first_[grid_.Index(cell)];
    placed_.push_back({point, radius, first});
    first = static_cast<int>(placed_.size()) - 1;
    return true;
  }

 private:
  struct Placed {
    Vector3 position;
    double radius;
    int next;  // in the same cell; -1 at the end
  };

  Vector3 lower_;
  Vector3 upper_;
  std::array<bool, 3> periodic_;
  CellGrid grid_;
  std::vector<int> first_;
  std::vector<Placed> placed_;
};

// Solid fraction of the slab if all were placed.
double SolidFraction(const std::vector<double>& diameters, const Domain& domain,
                     const Insert& insert) {
  double cubes = 0;
  for (const double d : diameters) cubes += d * d * d;
  return std::numbers::pi / 6 * cubes / (domain.BaseArea() * (insert.top - insert.bottom));
}

void CheckSlab(const Domain& domain, const Insert& insert, double largest) {
  const auto fail = [&](const std::string& what, double size) {
    throw InputError(fmt::format("{} ({}) is too small for the largest particle ({})", what,
                                 HumanQuantity(size, "m"), HumanQuantity(largest, "m")));
  };
  for (int axis = 0; axis < 2; ++axis) {
    const double width = domain.Lengths()[axis];
    if (!(width >= largest)) fail(fmt::format("the domain's width in {}", "xy"[axis]), width);
  }
  const double height = insert.top - insert.bottom;
  if (!(height >= largest)) fail("the height of the insertion slab", height);
  if (insert.bottom < domain.lower[2] || insert.top > domain.upper[2]) {
    throw InputError(
        fmt::format("the insertion slab ({} to {} m) reaches beyond the domain ({} to {} m)",
                    insert.bottom, insert.top, domain.lower[2], domain.upper[2]));
  }
}

InputError TooFull(double fraction, std::size_t placed, std::size_t count) {
  return InputError(fmt::format(
      "cannot place {} particles without overlap: {} found room; the insertion slab would be "
      "filled "
      "to a solid fraction of {:.3f}, random insertion manages about 0.33; make it higher",
      count, placed, fraction));
}

}  // namespace

std::vector<double> DrawDiameters(const SizeDistribution& sizes, int count, std::uint64_t seed) {
  if (count < 1) throw InputError(fmt::format("{} particles asked for; at least 1 needed", count));
  const std::string problem = sizes.ExplainInvalid();
  if (!problem.empty()) throw InputError("size distribution: " + problem);
  RandomStream random = RandomStream(seed).Split("diameters");
  std::vector<double> diameters(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    diameters[static_cast<std::size_t>(i)] = sizes.Quantile((i + random.Uniform()) / count);
  }
  random.Shuffle(std::span(diameters));
  return diameters;
}

Packing PlaceParticles(const Particles& particles, const Domain& domain, const Insert& insert,
                       const std::stop_token& stop) {
  if (particles.packing) {
    CheckExplicitPacking(*particles.packing, domain);
    return *particles.packing;
  }
  const std::vector<double> diameters =
      DrawDiameters(particles.sizes, particles.count, particles.seed);
  const double largest = *std::max_element(diameters.begin(), diameters.end());
  CheckSlab(domain, insert, largest);

  // Near jamming at 0.38 the attempts for the next particle grow as (0.38 - fraction)^-4 (Swendsen
  // 1981): the budget reaches 0.33 and is soon spent beyond. Nothing placed by chance exceeds 0.5.
  const std::size_t count = diameters.size();
  const double fraction = SolidFraction(diameters, domain, insert);
  std::int64_t attempts_left = 150 * static_cast<std::int64_t>(count) + 10'000'000;
  if (fraction > 0.5) throw TooFull(fraction, 0, count);

  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return diameters[a] > diameters[b]; });
  RandomStream random = RandomStream(particles.seed).Split("positions");
  Slab slab(domain, insert, largest, count);
  Packing packing(count);
  for (std::size_t placed = 0; placed < count; ++placed) {
    const std::size_t i = order[placed];
    Sphere& sphere = packing[i];
    sphere.id = static_cast<std::int64_t>(i) + 1;
    sphere.radius = 0.5 * diameters[i];
    sphere.velocity = insert.velocity;
    do {
      if (attempts_left-- == 0) throw TooFull(fraction, placed, count);
      if (attempts_left % 1024 == 0 && stop.stop_requested()) return {};
      sphere.position = slab.Draw(random, sphere.radius);
    } while (!slab.Place(sphere.position, sphere.radius));
  }
  return packing;
}

}  // namespace powdercal

// What a simulation tells of its present state.

#include <algorithm>
#include <cmath>

#include "backends/embedded/cells.h"
#include "backends/embedded/simulation.h"
#include "backends/embedded/vector_math.h"

namespace powdercal::embedded {
namespace {

Vector3 VectorAt(const std::array<AlignedVector<double>, 3>& columns, std::size_t n) {
  if (columns[0].empty()) return {};
  return {columns[0][n], columns[1][n], columns[2][n]};
}

// From j to the nearest image of i.
Vector3 Branch(const ParticleStore& particles, const Images& images, std::int32_t i,
               std::int32_t j) {
  const double* a = particles.Position(i);
  const double* b = particles.Position(j);
  double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  NearestImage(images, d);
  return {d[0], d[1], d[2]};
}

// How much of the way from a to b lies in the range.
double ShareInside(double a, double b, const std::array<double, 2>& range) {
  if (a == b) return a >= range[0] && a < range[1] ? 1 : 0;
  const auto [low, high] = std::minmax(a, b);
  return std::max(0.0, std::min(high, range[1]) - std::max(low, range[0])) / (high - low);
}

// Energy in a normal spring compressed by `overlap`.
double SpringEnergy(const ContactLaw& law, const LawConstants& constants, double overlap,
                    double effective_radius) {
  if (law.normal == ContactLaw::Normal::linear) return 0.5 * constants.normal * overlap * overlap;
  return 0.4 * constants.normal * std::sqrt(effective_radius * overlap) * overlap * overlap;
}

}  // namespace

Packing Simulation::CurrentPacking() const {
  Packing packing;
  packing.reserve(static_cast<std::size_t>(particles_.count()));
  for (std::int32_t p = 0; p < particles_.count(); ++p) {
    Sphere sphere = particles_.ToSphere(p);
    // Into the box; velocities are those of the image that is inside.
    const auto wrap = [&](std::size_t axis) {
      if (!box_.periodic[axis]) return;
      const double n =
          std::floor((sphere.position[axis] - box_.lower[axis]) * images_.inverse[axis]);
      if (n == 0) return;
      sphere.position[axis] -= n * images_.length[axis];
      sphere.velocity[axis] -= n * images_.speed[axis];
      if (axis != 2) return;
      sphere.position[0] -= n * images_.shear_offset;
      sphere.velocity[0] -= n * images_.shear_speed;
    };
    for (const std::size_t axis : {std::size_t{2}, std::size_t{1}, std::size_t{0}}) wrap(axis);
    packing.push_back(sphere);
  }
  std::sort(packing.begin(), packing.end(),
            [](const Sphere& a, const Sphere& b) { return a.id < b.id; });
  return packing;
}

std::vector<ContactHistory> Simulation::CurrentContacts() const {
  std::vector<ContactHistory> contacts;
  const auto zero = [](const Vector3& v) { return v[0] == 0 && v[1] == 0 && v[2] == 0; };
  const auto add = [&](std::int64_t i, std::int64_t j, const ContactList& list, std::size_t n) {
    const Vector3 shear = VectorAt(list.history.shear, n);
    const Vector3 rolling = VectorAt(list.history.rolling, n);
    if (!zero(shear) || !zero(rolling)) contacts.push_back({i, j, shear, rolling});
  };
  const auto id = [&](std::int32_t p) { return particles_.ids[static_cast<std::size_t>(p)]; };
  for (const Slab& slab : neighbours_.slabs()) {
    for (std::size_t n = 0; n < static_cast<std::size_t>(slab.pairs.size); ++n) {
      add(id(ParticleOf(slab.pairs.i[n])), id(ParticleOf(slab.pairs.j[n])), slab.pairs, n);
    }
    for (std::size_t plane = 0; plane < slab.planes.size(); ++plane) {
      const ContactList& list = slab.planes[plane];
      for (std::size_t n = 0; n < static_cast<std::size_t>(list.size); ++n) {
        add(id(ParticleOf(list.i[n])), -1 - static_cast<std::int64_t>(plane), list, n);
      }
    }
  }
  std::sort(contacts.begin(), contacts.end(), [](const ContactHistory& a, const ContactHistory& b) {
    return a.i != b.i ? a.i < b.i : a.j < b.j;
  });
  return contacts;
}

Survey Simulation::MakeSurvey() const {
  Survey survey;
  survey.top = -HUGE_VAL;
  for (std::int32_t p = 0; p < particles_.count(); ++p) {
    const double* x = particles_.Position(p);
    survey.top = std::max(survey.top, x[2] + x[3]);
    const auto n = static_cast<std::size_t>(p);
    if (particles_.group[n] >= 0) continue;  // glued: moved, not moving
    const double* v = particles_.Velocity(p);
    const double* w = particles_.Spin(p);
    const double mass = particles_.Mass(p);
    Vector3 own = {v[0], v[1], v[2]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      own[axis] -= drive_.rate[axis] * (x[axis] - drive_.centre[axis]);
    }
    own[0] -= drive_.shear_rate * (x[2] - drive_.centre[2]);
    survey.kinetic_energy += 0.5 * mass * Dot(own, own) +
                             0.2 * mass * x[3] * x[3] * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  }
  const auto touch = [&](const LawConstants& law, double overlap, double radius) {
    if (!(overlap > 0)) return;
    ++survey.contacts;
    survey.max_overlap = std::max(survey.max_overlap, overlap / radius);
    survey.elastic_energy += SpringEnergy(program_.law, law, overlap, radius);
  };
  for (const Slab& slab : neighbours_.slabs()) {
    for (std::size_t n = 0; n < static_cast<std::size_t>(slab.pairs.size); ++n) {
      const double distance = Length(
          Branch(particles_, images_, ParticleOf(slab.pairs.i[n]), ParticleOf(slab.pairs.j[n])));
      touch(sphere_law_, slab.pairs.radius_sum[n] - distance, slab.pairs.effective_radius[n]);
    }
    for (std::size_t plane = 0; plane < slab.planes.size(); ++plane) {
      const PlaneState state = planes_[plane].State();
      const ContactList& list = slab.planes[plane];
      for (std::size_t n = 0; n < static_cast<std::size_t>(list.size); ++n) {
        const double* x = particles_.Position(ParticleOf(list.i[n]));
        const double distance =
            state.normal[0] * x[0] + state.normal[1] * x[1] + state.normal[2] * x[2] - state.offset;
        touch(planes_[plane].law, x[3] - distance, x[3]);
      }
    }
  }
  for (std::size_t mesh = 0; mesh < meshes_.size(); ++mesh) {
    mesh_contacts_[mesh].ForEachContact(
        [&](double overlap, double radius) { touch(meshes_[mesh].law, overlap, radius); });
  }
  return survey;
}

std::array<Vector3, 3> Simulation::MeasureStress() const {
  std::array<Vector3, 3> sum{};
  for (const Slab& slab : neighbours_.slabs()) {
    for (std::size_t n = 0; n < static_cast<std::size_t>(slab.pairs.size); ++n) {
      const Vector3 force = VectorAt(slab.pairs.force, n);
      if (force[0] == 0 && force[1] == 0 && force[2] == 0) continue;
      const Vector3 branch =
          Branch(particles_, images_, ParticleOf(slab.pairs.i[n]), ParticleOf(slab.pairs.j[n]));
      for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t b = 0; b < 3; ++b) sum[a][b] += force[a] * branch[b];
      }
    }
  }
  for (std::int32_t p = 0; p < particles_.count(); ++p) {
    const double* x = particles_.Position(p);
    const double* v = particles_.Velocity(p);
    Vector3 own = {v[0], v[1], v[2]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      own[axis] -= drive_.rate[axis] * (x[axis] - drive_.centre[axis]);
    }
    own[0] -= drive_.shear_rate * (x[2] - drive_.centre[2]);
    const double mass = particles_.Mass(p);
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) sum[a][b] += mass * own[a] * own[b];
    }
  }
  const double volume = images_.length[0] * images_.length[1] * images_.length[2];
  for (Vector3& row : sum) {
    for (double& component : row) component /= volume;
  }
  return sum;
}

SlabState Simulation::MeasureSlab() const {
  const std::array<double, 2>& range = *program_.stress_slab;
  std::array<Vector3, 3> sum{};
  const auto add = [&](double share, const Vector3& a, const Vector3& b) {
    for (std::size_t row = 0; row < 3; ++row) sum[row] = sum[row] + (share * a[row]) * b;
  };
  // `branch` leads to the centre of p, `force` acts on p.
  const auto touch = [&](std::int32_t p, const Vector3& branch, const Vector3& force) {
    const double z = particles_.Position(p)[2];
    const double share = ShareInside(z - branch[2], z, range);
    if (share > 0) add(share, force, branch);
  };
  for (const Slab& slab : neighbours_.slabs()) {
    for (std::size_t n = 0; n < static_cast<std::size_t>(slab.pairs.size); ++n) {
      const std::int32_t i = ParticleOf(slab.pairs.i[n]);
      const std::int32_t j = ParticleOf(slab.pairs.j[n]);
      touch(i, Branch(particles_, images_, i, j), VectorAt(slab.pairs.force, n));
    }
    for (std::size_t plane = 0; plane < slab.planes.size(); ++plane) {
      const PlaneState state = planes_[plane].State();
      const Vector3 normal = {state.normal[0], state.normal[1], state.normal[2]};
      const ContactList& list = slab.planes[plane];
      for (std::size_t n = 0; n < static_cast<std::size_t>(list.size); ++n) {
        const std::int32_t p = ParticleOf(list.i[n]);
        const double* x = particles_.Position(p);
        const double distance = Dot(normal, {x[0], x[1], x[2]}) - state.offset;
        touch(p, distance * normal, VectorAt(list.force, n));
      }
    }
  }
  for (const MeshContacts& contacts : mesh_contacts_) contacts.ForEachForce(touch);

  double mass = 0;
  Vector3 momentum{};
  for (std::int32_t p = 0; p < particles_.count(); ++p) {
    const double z = particles_.Position(p)[2];
    const bool glued = particles_.group[static_cast<std::size_t>(p)] >= 0;
    if (glued || z < range[0] || z >= range[1]) continue;
    const double* v = particles_.Velocity(p);
    const double m = particles_.Mass(p);
    mass += m;
    momentum = momentum + m * Vector3{v[0], v[1], v[2]};
    add(m, {v[0], v[1], v[2]}, {v[0], v[1], v[2]});
  }
  if (mass > 0) add(-1 / mass, momentum, momentum);
  const double volume = program_.domain.BaseArea() * (range[1] - range[0]);
  SlabState state{.solid_fraction = mass / particles_.density() / volume};
  for (std::size_t row = 0; row < 3; ++row) state.stress[row] = (1 / volume) * sum[row];
  return state;
}

CellState Simulation::Cell() const {
  return {.lower = box_.lower,
          .upper = box_.upper,
          .shear_offset = shear_offset_,
          .shear_rate = drive_.shear_rate,
          .stress = MeasureStress()};
}

}  // namespace powdercal::embedded

#include "backends/embedded/mesh_contacts.h"

#include <algorithm>
#include <cmath>

namespace powdercal::embedded {

void MeshContacts::Rebuild(const ParticleStore& particles, const TriangleMesh& surface,
                           const Box& box, const Images& images, const std::vector<Slab>& slabs,
                           double skin) {
  // Memory goes by id, since particles have changed places and slabs.
  std::vector<Remembered> memory;
  for (SlabContacts& slab : slabs_) {
    memory.insert(memory.end(), slab.memory.begin(), slab.memory.end());
  }
  std::stable_sort(memory.begin(), memory.end(),
                   [](const Remembered& a, const Remembered& b) { return a.id < b.id; });

  const std::array<Vector3, 2> bounds = surface.Bounds();
  struct Found {
    Near near;
    std::size_t order;
  };
  std::vector<Found> found;
  candidates_.clear();
  std::vector<Candidate> block;
  std::vector<Vector3> centres;
  std::vector<double> radii;
  std::vector<std::int32_t> indices;
  // Images of the particles that can be near the mesh, which may have travelled far.
  double largest = 0;
  for (std::int32_t p = 0; p < particles.count(); ++p) {
    largest = std::max(largest, particles.Radius(p) + skin);
  }
  std::array<int, 3> from{};
  std::array<int, 3> to{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!box.periodic[axis]) continue;
    const double length = images.length[axis];
    from[axis] =
        static_cast<int>(std::floor((bounds[0][axis] - largest - box.upper[axis]) / length));
    to[axis] = static_cast<int>(std::ceil((bounds[1][axis] + largest - box.lower[axis]) / length));
  }
  for (int nx = from[0]; nx <= to[0]; ++nx) {
    for (int ny = from[1]; ny <= to[1]; ++ny) {
      for (int nz = from[2]; nz <= to[2]; ++nz) {
        const Vector3 shift = {nx * images.length[0], ny * images.length[1], nz * images.length[2]};
        centres.clear();
        radii.clear();
        indices.clear();
        for (std::int32_t p = 0; p < particles.count(); ++p) {
          const double* x = particles.Position(p);
          const double reach = x[3] + skin;
          bool inside = true;
          Vector3 centre{};
          for (std::size_t axis = 0; axis < 3; ++axis) {
            centre[axis] = x[axis] + shift[axis];
            inside = inside && centre[axis] > bounds[0][axis] - reach &&
                     centre[axis] < bounds[1][axis] + reach;
          }
          if (!inside) continue;
          centres.push_back(centre);
          radii.push_back(x[3]);
          indices.push_back(p);
        }
        if (centres.empty()) continue;
        surface.FindCandidates(centres, radii, skin, block);
        for (std::size_t n = 0; n < block.size();) {
          std::size_t end = n;
          while (end < block.size() && block[end].first == block[n].first) ++end;
          const auto base = static_cast<std::uint32_t>(candidates_.size());
          candidates_.insert(candidates_.end(), block.begin() + static_cast<std::ptrdiff_t>(n),
                             block.begin() + static_cast<std::ptrdiff_t>(end));
          found.push_back(
              {{indices[block[n].first], shift, base, base + static_cast<std::uint32_t>(end - n)},
               found.size()});
          n = end;
        }
      }
    }
  }
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
    return a.near.particle != b.near.particle ? a.near.particle < b.near.particle
                                              : a.order < b.order;
  });
  slabs_.resize(slabs.size());
  std::size_t next = 0;
  for (std::size_t s = 0; s < slabs.size(); ++s) {
    SlabContacts& slab = slabs_[s];
    slab.near.clear();
    slab.memory.clear();
    for (; next < found.size() && found[next].near.particle < slabs[s].end; ++next) {
      const Near& near = found[next].near;
      const std::int64_t id = particles.ids[static_cast<std::size_t>(near.particle)];
      const bool again = !slab.near.empty() && slab.near.back().particle == near.particle;
      slab.near.push_back(near);
      if (again) continue;
      auto known =
          std::lower_bound(memory.begin(), memory.end(), id,
                           [](const Remembered& m, std::int64_t key) { return m.id < key; });
      for (; known != memory.end() && known->id == id; ++known) {
        slab.memory.push_back(*known);
        slab.memory.back().particle = near.particle;
      }
    }
  }
}

void MeshContacts::FindContacts(SlabContacts& slab, const ParticleStore& particles,
                                const MeshBody& body) {
  slab.particle.clear();
  slab.contacts.clear();
  for (std::size_t n = 0; n < slab.near.size();) {
    const std::int32_t particle = slab.near[n].particle;
    const double* x = particles.Position(particle);
    std::vector<MeshContact>& all = slab.of_particle;
    all.clear();
    std::size_t next = n;
    for (; next < slab.near.size() && slab.near[next].particle == particle; ++next) {
      const Near& near = slab.near[next];
      const Vector3 centre = {x[0] + near.shift[0], x[1] + near.shift[1], x[2] + near.shift[2]};
      body.surface.Contacts(
          centre, x[3],
          std::span<const Candidate>(candidates_).subspan(near.begin, near.end - near.begin),
          slab.found);
      all.insert(all.end(), slab.found.begin(), slab.found.end());
    }
    if (next - n > 1) body.surface.KeepDistinct(x[3], all);
    n = next;
    for (const MeshContact& contact : all) {
      slab.particle.push_back(particle);
      slab.contacts.push_back(contact);
    }
  }
}

// Fills the histories of the new contacts from those of the step before.
void MeshContacts::Recall(SlabContacts& slab) {
  std::size_t first = 0;
  for (std::size_t n = 0; n < slab.contacts.size(); ++n) {
    // Both are in the order of the particles.
    const std::int32_t particle = slab.particle[n];
    while (first < slab.memory.size() && slab.memory[first].particle < particle) ++first;
    Remembered* best = nullptr;
    double nearest = 0.7;  // within 45°
    for (std::size_t m = first; m < slab.memory.size() && slab.memory[m].particle == particle;
         ++m) {
      Remembered& candidate = slab.memory[m];
      const double cosine = Dot(candidate.normal, slab.contacts[n].normal);
      if (candidate.taken || cosine <= nearest) continue;
      nearest = cosine;
      best = &candidate;
    }
    if (best == nullptr) continue;
    best->taken = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (kinds_.shear) slab.list.history.shear[axis][n] = best->shear[axis];
      if (kinds_.rolling) slab.list.history.rolling[axis][n] = best->rolling[axis];
    }
  }
}

void MeshContacts::Remember(SlabContacts& slab, const ParticleStore& particles) {
  slab.memory.clear();
  for (std::size_t n = 0; n < slab.contacts.size(); ++n) {
    Remembered memory{.particle = slab.particle[n],
                      .id = particles.ids[static_cast<std::size_t>(slab.particle[n])],
                      .normal = slab.contacts[n].normal,
                      .overlap = particles.Radius(slab.particle[n]) - slab.contacts[n].distance,
                      .radius = particles.Radius(slab.particle[n])};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (kinds_.shear) memory.shear[axis] = slab.list.history.shear[axis][n];
      if (kinds_.rolling) memory.rolling[axis] = slab.list.history.rolling[axis][n];
    }
    slab.memory.push_back(memory);
  }
}

void MeshContacts::AddForces(std::size_t s, std::int32_t padding_row, ParticleStore& particles,
                             const MeshBody& body, SurfaceKernel kernel, bool record,
                             Vector3* force) {
  SlabContacts& slab = slabs_[s];
  if (slab.near.empty()) return;
  FindContacts(slab, particles, body);
  ContactList& list = slab.list;
  list.Resize(static_cast<std::int32_t>(slab.contacts.size()), false, kinds_, padding_row);
  const std::size_t padded = list.i.size();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    slab.normal[axis].assign(padded, 0.0);
    slab.velocity[axis].assign(padded, 0.0);
  }
  slab.distance.assign(padded, 1.0);
  for (std::size_t n = 0; n < slab.contacts.size(); ++n) {
    const MeshContact& contact = slab.contacts[n];
    const std::int32_t p = slab.particle[n];
    list.i[n] = OffsetOf(p);
    list.radius_sum[n] = particles.Radius(p);
    list.effective_radius[n] = particles.Radius(p);
    list.effective_mass[n] = particles.Mass(p);
    const Vector3 velocity = body.surface.VelocityAt(contact.point);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      slab.normal[axis][n] = contact.normal[axis];
      slab.velocity[axis][n] = velocity[axis];
    }
    slab.distance[n] = contact.distance;
  }
  Recall(slab);
  SurfaceColumns surface;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    surface.normal[axis] = slab.normal[axis].data();
    surface.velocity[axis] = slab.velocity[axis].data();
  }
  surface.distance = slab.distance.data();
  kernel(body.law, surface, particles.rows(), list.Columns(record), force->data());
  Remember(slab, particles);
}

}  // namespace powdercal::embedded

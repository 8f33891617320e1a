#include "backends/embedded/neighbours.h"

#include <algorithm>
#include <cmath>

#include "backends/embedded/cells.h"

namespace powdercal::embedded {
namespace {

// Particles of a slab, at least: fewer would waste lanes on padding.
constexpr std::int32_t kSlabParticles = 200;
// Contacts of this many neighbouring particles are interleaved, so that consecutive ones add to
// different particles and need not wait for each other.
constexpr std::int32_t kInterleave = 16;

template <typename T>
T* At(std::vector<T>& v, std::int32_t n) {
  return &v[static_cast<std::size_t>(n)];
}
template <typename T>
const T* At(const std::vector<T>& v, std::int32_t n) {
  return &v[static_cast<std::size_t>(n)];
}

// Moves particles into the box; those that cross a moving image change their velocity.
void Wrap(ParticleStore& particles, const Box& box, const Images& images) {
  for (std::int32_t p = 0; p < particles.count(); ++p) {
    double* x = particles.Position(p);
    double* v = particles.Velocity(p);
    const auto cells = [&](std::size_t axis) {
      return std::floor((x[axis] - box.lower[axis]) * images.inverse[axis]);
    };
    if (box.periodic[2]) {
      const double n = cells(2);
      if (n != 0) {
        x[2] -= n * images.length[2];
        x[0] -= n * images.shear_offset;
        v[2] -= n * images.speed[2];
        v[0] -= n * images.shear_speed;
      }
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (!box.periodic[axis]) continue;
      const double n = cells(axis);
      if (n == 0) continue;
      x[axis] -= n * images.length[axis];
      v[axis] -= n * images.speed[axis];
    }
  }
}

// order[n]: the particle that goes to place n. Stable, so that it depends on nothing but positions.
std::vector<std::int32_t> SortIntoCells(const ParticleStore& particles, const Cells& cells,
                                        const std::vector<std::uint8_t>& removed,
                                        std::vector<std::int32_t>* cell_start) {
  const auto count = static_cast<std::size_t>(particles.count());
  std::vector<std::int32_t> cell(count);
  cell_start->assign(static_cast<std::size_t>(cells.size()) + 1, 0);
  std::size_t kept = 0;
  for (std::size_t p = 0; p < count; ++p) {
    if (!removed.empty() && removed[p] != 0) {
      cell[p] = -1;
      continue;
    }
    cell[p] = cells.CellOf(particles.Position(static_cast<std::int32_t>(p)));
    ++*At(*cell_start, cell[p] + 1);
    ++kept;
  }
  for (std::size_t c = 1; c < cell_start->size(); ++c) (*cell_start)[c] += (*cell_start)[c - 1];
  std::vector<std::int32_t> next(cell_start->begin(), cell_start->end() - 1);
  std::vector<std::int32_t> order(kept);
  for (std::size_t p = 0; p < count; ++p) {
    if (cell[p] >= 0) *At(order, (*At(next, cell[p]))++) = static_cast<std::int32_t>(p);
  }
  return order;
}

// First cell of each slab, and the end: whole layers, with about the same number of particles.
std::vector<std::int32_t> DivideIntoSlabs(const Cells& cells,
                                          const std::vector<std::int32_t>& cell_start) {
  const std::int32_t particles = cell_start.back();
  std::int32_t slabs = std::clamp(particles / kSlabParticles, 1, cells.layers());
  // Across a periodic end the last slab meets the first: their numbers must differ in parity.
  if (cells.layers_wrap() && slabs > 1) slabs -= slabs % 2;
  std::vector<std::int32_t> first = {0};
  std::int32_t layer = 0;
  for (std::int32_t s = 1; s < slabs; ++s) {
    const auto target = static_cast<std::int32_t>(static_cast<std::int64_t>(particles) * s / slabs);
    const std::int32_t last_start = cells.layers() - (slabs - s);
    ++layer;
    while (layer < last_start &&
           cell_start[static_cast<std::size_t>(layer * cells.per_layer())] < target) {
      ++layer;
    }
    first.push_back(layer * cells.per_layer());
  }
  first.push_back(cells.size());
  return first;
}

// Whether a pair of slabs a and b belongs to a's list.
bool Owns(std::size_t a, std::size_t b, std::size_t slabs, bool wrap) {
  if (a + 1 == b) return true;
  return wrap && a + 1 == slabs && b == 0 && slabs > 2;
}

// The particles, sorted into cells, and the cells, cut into slabs.
struct Division {
  const Cells& cells;
  const std::vector<std::int32_t>& cell_start;
  std::vector<std::int32_t> first_cell;

  std::size_t slabs() const { return first_cell.size() - 1; }

  // Pairs of the slab closer than `skin` that are not of one glued group.
  void FindPairs(std::size_t s, const ParticleStore& particles, const Images& images, double skin,
                 Slab* slab) const;

 private:
  using Range = std::pair<std::int32_t, std::int32_t>;

  std::size_t SlabOfCell(std::int32_t cell) const {
    const auto after = std::upper_bound(first_cell.begin(), first_cell.end(), cell);
    return static_cast<std::size_t>(after - first_cell.begin()) - 1;
  }
  // Particles of the cells around this one whose pairs with it are the slab's.
  void PartnersOf(std::int32_t cell, std::size_t s, std::vector<std::int32_t>* near,
                  std::vector<Range>* ranges) const;
};

void Division::PartnersOf(std::int32_t cell, std::size_t s, std::vector<std::int32_t>* near,
                          std::vector<Range>* ranges) const {
  cells.Neighbourhood(cell, near);
  ranges->clear();
  for (const std::int32_t other : *near) {
    const std::size_t t = SlabOfCell(other);
    if (t == s ? other <= cell : !Owns(s, t, slabs(), cells.layers_wrap())) continue;
    const Range range = {*At(cell_start, other), *At(cell_start, other + 1)};
    if (!ranges->empty() && ranges->back().second == range.first) {
      ranges->back().second = range.second;
    } else if (range.first != range.second) {
      ranges->push_back(range);
    }
  }
}

void Division::FindPairs(std::size_t s, const ParticleStore& particles, const Images& images,
                         double skin, Slab* slab) const {
  slab->begin = *At(cell_start, first_cell[s]);
  slab->end = *At(cell_start, first_cell[s + 1]);
  slab->start.assign(1, 0);
  slab->outer_i.clear();
  slab->outer_j.clear();
  std::vector<std::int32_t> near;
  std::vector<Range> ranges;
  const double* rows = particles.rows();
  for (std::int32_t cell = first_cell[s]; cell < first_cell[s + 1]; ++cell) {
    const Range own = {*At(cell_start, cell), *At(cell_start, cell + 1)};
    if (own.first == own.second) continue;
    PartnersOf(cell, s, &near, &ranges);
    for (std::int32_t i = own.first; i < own.second; ++i) {
      const double* a = rows + OffsetOf(i);
      const std::int32_t group = *At(particles.group, i);
      const auto test = [&](std::int32_t j) {
        const double* b = rows + OffsetOf(j);
        double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
        NearestImage(images, d);
        const double reach = a[3] + b[3] + skin;
        if (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] >= reach * reach) return;
        if (group >= 0 && group == *At(particles.group, j)) return;
        slab->outer_i.push_back(OffsetOf(i));
        slab->outer_j.push_back(OffsetOf(j));
      };
      for (std::int32_t j = i + 1; j < own.second; ++j) test(j);
      for (const auto& [from, to] : ranges) {
        for (std::int32_t j = from; j < to; ++j) test(j);
      }
      slab->start.push_back(static_cast<std::int32_t>(slab->outer_i.size()));
    }
  }
}

}  // namespace

void Neighbours::Rebuild(ParticleStore& particles, const Box& box, const Images& images,
                         double skin, const std::vector<std::uint8_t>& removed, Team& team) {
  Wrap(particles, box, images);
  double largest = 0;
  for (std::int32_t p = 0; p < particles.count(); ++p) {
    largest = std::max(largest, particles.Radius(p));
  }
  const Cells cells(particles.rows(), particles.count(), box, images, 2 * largest + skin);
  std::vector<std::int32_t> cell_start;
  const std::vector<std::int32_t> order = SortIntoCells(particles, cells, removed, &cell_start);
  std::vector<std::int32_t> place(static_cast<std::size_t>(particles.count()), kNone);
  for (std::size_t n = 0; n < order.size(); ++n)
    *At(place, order[n]) = static_cast<std::int32_t>(n);
  CarryHistories(place);
  particles.Reorder(order);

  const Division division = {cells, cell_start, DivideIntoSlabs(cells, cell_start)};
  slabs_.resize(division.slabs());
  particles.ResizePadding(static_cast<int>(slabs_.size()));
  team.Run([&](int thread) {
    for (auto s = static_cast<std::size_t>(thread); s < slabs_.size();
         s += static_cast<std::size_t>(team.size())) {
      division.FindPairs(s, particles, images, skin, &slabs_[s]);
      Slab& slab = slabs_[s];
      slab.source.assign(slab.outer_i.size(), kNone);
      while (slab.outer_i.size() % kPadding != 0) {
        slab.outer_i.push_back(OffsetOf(particles.PaddingRow(static_cast<int>(s))));
        slab.outer_j.push_back(OffsetOf(particles.PaddingRow(static_cast<int>(s))));
      }
    }
  });
  AssignHistories();
  wrap_ = cells.layers_wrap();
  DivideWork(team.size());
}

void Neighbours::Resume(std::int32_t particles, const Team& team) {
  if (slabs_.empty()) return;  // no list was built yet
  for (Slab& slab : slabs_) {
    slab.source.assign(static_cast<std::size_t>(slab.start.back()), kNone);
  }
  plane_source_.assign(static_cast<std::size_t>(plane_count_),
                       std::vector<std::int32_t>(static_cast<std::size_t>(particles), kNone));
  carrying_ = false;
  DivideWork(team.size());
}

// Tells the entries of the outer list which of the carried histories are theirs.
void Neighbours::AssignHistories() {
  for (std::size_t n = 0; n < carried_.i.size(); ++n) {
    std::size_t s = 0;
    bool swapped = false;
    const std::int32_t entry = FindEntry(carried_.i[n], carried_.j[n], &s, &swapped);
    if (entry == kNone) continue;
    if (swapped) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (kinds_.shear) carried_.history.shear[axis][n] *= -1;
        if (kinds_.rolling) carried_.history.rolling[axis][n] *= -1;
      }
    }
    *At(slabs_[s].source, entry) = static_cast<std::int32_t>(n);
  }
}

// Takes the histories of all contacts that have one out of the lists. `place` maps old indices to
// new ones.
void Neighbours::CarryHistories(const std::vector<std::int32_t>& place) {
  const auto carry = [&](Carried& carried, const std::vector<ContactList*>& lists, bool pairs) {
    carried.i.clear();
    carried.j.clear();
    std::vector<std::pair<const ContactList*, std::int32_t>> from;
    for (ContactList* list : lists) {
      for (std::int32_t n = 0; n < list->size; ++n) {
        const auto k = static_cast<std::size_t>(n);
        const auto any = [&](const std::array<AlignedVector<double>, 3>& c) {
          return !c[0].empty() && (c[0][k] != 0 || c[1][k] != 0 || c[2][k] != 0);
        };
        if (!any(list->history.shear) && !any(list->history.rolling)) continue;
        const std::int32_t i = place[static_cast<std::size_t>(ParticleOf(list->i[k]))];
        const std::int32_t j = pairs ? place[static_cast<std::size_t>(ParticleOf(list->j[k]))] : 0;
        if (i < 0 || j < 0) continue;
        carried.i.push_back(i);
        carried.j.push_back(j);
        from.emplace_back(list, n);
      }
    }
    carried.history.Resize(from.size(), kinds_);
    for (std::size_t n = 0; n < from.size(); ++n) {
      carried.history.Copy(n, from[n].first->history, static_cast<std::size_t>(from[n].second), 1,
                           kinds_);
    }
  };
  if (!carrying_) {  // else they have been carried, and wait for their prune
    std::vector<ContactList*> lists;
    for (Slab& slab : slabs_) lists.push_back(&slab.pairs);
    carry(carried_, lists, true);
    carried_planes_.resize(static_cast<std::size_t>(plane_count_));
    for (std::size_t plane = 0; plane < carried_planes_.size(); ++plane) {
      lists.clear();
      for (Slab& slab : slabs_) {
        if (!slab.planes.empty()) lists.push_back(&slab.planes[plane]);
      }
      carry(carried_planes_[plane], lists, false);
    }
  }
  carrying_ = true;
  std::size_t kept = 0;
  for (const std::int32_t p : place) kept += p >= 0 ? 1 : 0;
  plane_source_.assign(static_cast<std::size_t>(plane_count_),
                       std::vector<std::int32_t>(kept, kNone));
  for (std::size_t plane = 0; plane < carried_planes_.size(); ++plane) {
    const std::vector<std::int32_t>& particles = carried_planes_[plane].i;
    for (std::size_t n = 0; n < particles.size(); ++n) {
      *At(plane_source_[plane], particles[n]) = static_cast<std::int32_t>(n);
    }
  }
}

std::size_t Neighbours::SlabOf(std::int32_t particle) const {
  const auto after =
      std::upper_bound(slabs_.begin(), slabs_.end(), particle,
                       [](std::int32_t p, const Slab& slab) { return p < slab.end; });
  return static_cast<std::size_t>(after - slabs_.begin());
}

std::int32_t Neighbours::FindEntry(std::int32_t i, std::int32_t j, std::size_t* slab,
                                   bool* swapped) const {
  for (const bool swap : {false, true}) {
    const std::int32_t a = swap ? j : i;
    const std::int32_t b = swap ? i : j;
    const std::size_t s = SlabOf(a);
    const Slab& candidate = slabs_[s];
    const auto local = static_cast<std::size_t>(a - candidate.begin);
    for (std::int32_t n = candidate.start[local]; n < candidate.start[local + 1]; ++n) {
      if (candidate.outer_j[static_cast<std::size_t>(n)] != OffsetOf(b)) continue;
      *slab = s;
      *swapped = swap;
      return n;
    }
  }
  return kNone;
}

bool Neighbours::SetHistory(std::int32_t i, std::int32_t j, const Vector3& shear,
                            const Vector3& rolling) {
  std::size_t s = 0;
  bool swapped = false;
  const std::int32_t entry = FindEntry(i, j, &s, &swapped);
  if (entry == kNone) return false;
  *At(slabs_[s].source, entry) = static_cast<std::int32_t>(carried_.i.size());
  carried_.i.push_back(i);
  carried_.j.push_back(j);
  const double sign = swapped ? -1 : 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (kinds_.shear) carried_.history.shear[axis].push_back(sign * shear[axis]);
    if (kinds_.rolling) carried_.history.rolling[axis].push_back(sign * rolling[axis]);
  }
  return true;
}

void Neighbours::SetPlaneHistory(int plane, std::int32_t i, const Vector3& shear,
                                 const Vector3& rolling) {
  Carried& carried = carried_planes_[static_cast<std::size_t>(plane)];
  *At(plane_source_[static_cast<std::size_t>(plane)], i) =
      static_cast<std::int32_t>(carried.i.size());
  carried.i.push_back(i);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (kinds_.shear) carried.history.shear[axis].push_back(shear[axis]);
    if (kinds_.rolling) carried.history.rolling[axis].push_back(rolling[axis]);
  }
}

// Consecutive slabs for each thread, with about the same number of pairs.
void Neighbours::DivideWork(int threads) {
  std::vector<std::int64_t> work = {0};
  for (const Slab& slab : slabs_) {
    work.push_back(work.back() + static_cast<std::int64_t>(slab.outer_i.size()) + slab.end -
                   slab.begin);
  }
  share_.assign(1, 0);
  for (int t = 1; t < threads; ++t) {
    const std::int64_t target = work.back() * t / threads;
    // Half a slab more or less.
    std::size_t s = share_.back();
    while (s < slabs_.size() && (work[s] + work[s + 1]) / 2 < target) ++s;
    share_.push_back(s);
  }
  share_.push_back(slabs_.size());
  schedule_ = MakeSchedule(share_, wrap_);
}

void Neighbours::Prune(ParticleStore& particles, const Kernels& kernels, const Images& images,
                       const std::vector<PlaneState>& planes, double gap, Team& team) {
  if (!carrying_) {
    for (std::size_t plane = 0; plane < plane_source_.size(); ++plane) {
      std::vector<std::int32_t>& source = plane_source_[plane];
      std::fill(source.begin(), source.end(), kNone);
    }
  }
  team.Run([&](int thread) {
    const auto [first, last] = SlabsOf(thread);
    for (std::size_t s = first; s < last; ++s) {
      PruneSlab(s, particles, kernels, images, gap);
      for (int plane = 0; plane < plane_count_; ++plane) {
        PrunePlane(s, plane, particles, planes[static_cast<std::size_t>(plane)], gap);
      }
    }
  });
  carrying_ = false;
}

void Neighbours::PruneSlab(std::size_t s, ParticleStore& particles, const Kernels& kernels,
                           const Images& images, double gap) {
  Slab& slab = slabs_[s];
  if (!carrying_) {
    for (std::size_t n = 0; n < slab.slots.size(); ++n) {
      *At(slab.source, slab.slots[n]) = static_cast<std::int32_t>(n);
    }
  }
  slab.accept.resize(slab.outer_i.size());
  kernels.prune(images, particles.rows(), slab.outer_i.data(), slab.outer_j.data(),
                static_cast<std::int32_t>(slab.outer_i.size()), gap, slab.accept.data());

  std::vector<std::int32_t>& slots = slab.next_slots;
  slots.clear();
  std::array<std::int32_t, kInterleave> next;
  for (std::int32_t block = slab.begin; block < slab.end; block += kInterleave) {
    const std::int32_t size = std::min(kInterleave, slab.end - block);
    const auto local = static_cast<std::size_t>(block - slab.begin);
    for (std::int32_t p = 0; p < size; ++p) {
      next[static_cast<std::size_t>(p)] = slab.start[local + static_cast<std::size_t>(p)];
    }
    bool more = true;
    while (more) {
      more = false;
      for (std::size_t p = 0; p < static_cast<std::size_t>(size); ++p) {
        const std::int32_t end = slab.start[local + p + 1];
        std::int32_t n = next[p];
        while (n < end && slab.accept[static_cast<std::size_t>(n)] == 0) ++n;
        next[p] = n + 1;
        if (n >= end) continue;
        slots.push_back(n);
        more = true;
      }
    }
  }

  ContactList& pairs = slab.next_pairs;
  pairs.Resize(static_cast<std::int32_t>(slots.size()), true, kinds_,
               particles.PaddingRow(static_cast<int>(s)));
  const HistoryColumns& old = carrying_ ? carried_.history : slab.pairs.history;
  for (std::size_t n = 0; n < slots.size(); ++n) {
    const auto slot = static_cast<std::size_t>(slots[n]);
    const std::int32_t i = ParticleOf(slab.outer_i[slot]);
    const std::int32_t j = ParticleOf(slab.outer_j[slot]);
    const double ri = particles.Radius(i);
    const double rj = particles.Radius(j);
    const double mi = particles.Mass(i);
    const double mj = particles.Mass(j);
    pairs.i[n] = slab.outer_i[slot];
    pairs.j[n] = slab.outer_j[slot];
    pairs.radius_sum[n] = ri + rj;
    pairs.effective_radius[n] = ri * rj / (ri + rj);
    pairs.effective_mass[n] = mi * mj / (mi + mj);
    if (slab.source[slot] != kNone) {
      pairs.history.Copy(n, old, static_cast<std::size_t>(slab.source[slot]), 1, kinds_);
    }
  }
  if (carrying_) {
    std::fill(slab.source.begin(), slab.source.end(), kNone);
  } else {
    for (const std::int32_t slot : slab.slots) *At(slab.source, slot) = kNone;
  }
  std::swap(slab.pairs, slab.next_pairs);
  slab.slots.swap(slab.next_slots);
}

void Neighbours::PrunePlane(std::size_t s, int plane, ParticleStore& particles,
                            const PlaneState& state, double gap) {
  Slab& slab = slabs_[s];
  slab.planes.resize(static_cast<std::size_t>(plane_count_));
  ContactList& list = slab.planes[static_cast<std::size_t>(plane)];
  std::vector<std::int32_t>& source = plane_source_[static_cast<std::size_t>(plane)];
  if (!carrying_) {
    for (std::int32_t n = 0; n < list.size; ++n) {
      *At(source, ParticleOf(list.i[static_cast<std::size_t>(n)])) = n;
    }
  }
  std::vector<std::int32_t>& near = slab.accepted;
  near.clear();
  for (std::int32_t p = slab.begin; p < slab.end; ++p) {
    const double* x = particles.Position(p);
    const double distance =
        state.normal[0] * x[0] + state.normal[1] * x[1] + state.normal[2] * x[2] - state.offset;
    if (distance < x[3] + gap) near.push_back(p);
  }
  ContactList fresh;
  fresh.Resize(static_cast<std::int32_t>(near.size()), false, kinds_,
               particles.PaddingRow(static_cast<int>(s)));
  const HistoryColumns& old =
      carrying_ ? carried_planes_[static_cast<std::size_t>(plane)].history : list.history;
  for (std::size_t n = 0; n < near.size(); ++n) {
    const std::int32_t p = near[n];
    fresh.i[n] = OffsetOf(p);
    fresh.radius_sum[n] = particles.Radius(p);
    fresh.effective_radius[n] = particles.Radius(p);
    fresh.effective_mass[n] = particles.Mass(p);
    if (*At(source, p) != kNone) {
      fresh.history.Copy(n, old, static_cast<std::size_t>(*At(source, p)), 1, kinds_);
    }
  }
  std::swap(list, fresh);
}

std::int64_t Neighbours::pair_count() const {
  std::int64_t count = 0;
  for (const Slab& slab : slabs_) count += slab.pairs.size;
  return count;
}

std::int64_t Neighbours::outer_count() const {
  std::int64_t count = 0;
  for (const Slab& slab : slabs_) count += static_cast<std::int64_t>(slab.source.size());
  return count;
}

}  // namespace powdercal::embedded

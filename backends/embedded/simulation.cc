#include "backends/embedded/simulation.h"

#include <algorithm>
#include <cmath>

#include "backends/embedded/cells.h"
#include "backends/embedded/law.h"
#include "backends/embedded/vector_math.h"

namespace powdercal::embedded {
namespace {

// Skins in mean diameters. A skin is worth its extra pairs while rebuilding is what costs: both
// optima go with the square root of how far particles move in a step (docs/validation/embedded.md).
constexpr double kLeastInnerSkin = 0.016;
constexpr double kMostInnerSkin = 0.15;
constexpr double kInnerSkinFactor = 1.2;
constexpr double kLeastOuterSkin = 0.12;
constexpr double kMostOuterSkin = 0.60;
constexpr double kOuterSkinFactor = 10.0;
constexpr int kStressEvery = 20;
constexpr double kStressWeight = 0.3;
constexpr double kMostPace = 6;

// Takes away what all particles of a deforming cell have in common beyond the affine velocity:
// under shear a common v_z makes their v_x grow without end.
void StopDrift(ParticleStore& particles, const Drive& drive) {
  double mass = 0;
  Vector3 momentum{};
  for (std::int32_t p = 0; p < particles.count(); ++p) {
    const double* x = particles.Position(p);
    const double* v = particles.Velocity(p);
    const double m = particles.Mass(p);
    mass += m;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      momentum[axis] += m * (v[axis] - drive.rate[axis] * (x[axis] - drive.centre[axis]));
    }
    momentum[0] -= m * drive.shear_rate * (x[2] - drive.centre[2]);
  }
  if (mass == 0) return;
  const Vector3 drift = (1 / mass) * momentum;
  for (std::int32_t p = 0; p < particles.count(); ++p) {
    for (std::size_t axis = 0; axis < 3; ++axis) particles.Velocity(p)[axis] -= drift[axis];
  }
}

}  // namespace

Simulation::Simulation(const Program& program, const Packing& packing, const Settings& settings)
    : program_(program),
      settings_(settings),
      kernels_(KernelsFor(settings.isa, program.law)),
      sphere_law_(SphereLaw(program)),
      particles_(packing, program.materials.density),
      neighbours_({program.law.tangential == ContactLaw::Tangential::history,
                   program.law.rolling == ContactLaw::Rolling::epsd2},
                  static_cast<int>(program.walls.size())),
      team_(std::make_shared<Team>(settings.threads)) {
  program_.particles.packing.reset();
  box_.lower = program.domain.lower;
  box_.upper = program.domain.upper;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box_.periodic[axis] = program.domain.boundaries[axis] == Boundary::periodic;
    drive_.gravity[axis] = program.gravity[axis];
  }
  drive_.time_step = program.time_step;
  double sum = 0;
  for (const Sphere& sphere : packing) {
    sum += 2 * sphere.radius;
    largest_diameter_ = std::max(largest_diameter_, 2 * sphere.radius);
  }
  mean_diameter_ = packing.empty() ? 1 : sum / static_cast<double>(packing.size());
  AddBodies();
  UpdateImages();
}

void Simulation::AddBodies() {
  for (const PlaneWall& wall : program_.walls) {
    PlaneBody body;
    body.name = wall.name;
    body.wall = wall;
    body.law = WallLaw(program_, wall.frictionless);
    planes_.push_back(std::move(body));
  }
  for (const GluedGroup& group : program_.groups) {
    std::vector<std::int64_t> ids = group.ids;
    std::sort(ids.begin(), ids.end());
    for (std::int32_t p = 0; p < particles_.count(); ++p) {
      const auto n = static_cast<std::size_t>(p);
      if (!std::binary_search(ids.begin(), ids.end(), particles_.ids[n])) continue;
      particles_.group[n] = static_cast<std::int32_t>(groups_.size());
      particles_.inverse_mass[n] = 0;
      particles_.inverse_inertia[n] = 0;
      std::fill_n(particles_.Velocity(p), 3, 0.0);
      std::fill_n(particles_.Position(p) + kSpin, 3, 0.0);
    }
    GroupBody body;
    body.name = group.name;
    groups_.push_back(std::move(body));
  }
  const HistoryKinds kinds = {program_.law.tangential == ContactLaw::Tangential::history,
                              program_.law.rolling == ContactLaw::Rolling::epsd2};
  for (const Mesh& mesh : program_.meshes) {
    Vector3 periods{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (box_.periodic[axis]) periods[axis] = box_.upper[axis] - box_.lower[axis];
    }
    meshes_.emplace_back(mesh, periods);
    meshes_.back().law = WallLaw(program_, false);
    mesh_contacts_.emplace_back(kinds);
  }
}

Body* Simulation::FindBody(const std::string& name) {
  for (PlaneBody& body : planes_) {
    if (body.name == name) return &body;
  }
  for (GroupBody& body : groups_) {
    if (body.name == name) return &body;
  }
  for (MeshBody& body : meshes_) {
    if (body.name == name) return &body;
  }
  return nullptr;
}

void Simulation::UpdateImages() {
  const Vector3 rate = {drive_.rate[0], drive_.rate[1], drive_.rate[2]};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double length = box_.upper[axis] - box_.lower[axis];
    images_.length[axis] = length;
    images_.inverse[axis] = box_.periodic[axis] ? 1 / length : 0;
    images_.speed[axis] = rate[axis] * length;
    drive_.centre[axis] = 0.5 * (box_.lower[axis] + box_.upper[axis]);
  }
  images_.shear_offset = shear_offset_;
  images_.shear_speed = drive_.shear_rate * images_.length[2] + rate[0] * shear_offset_;
}

bool Simulation::CellTooSmall(double skin) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!box_.periodic[axis] || images_.length[axis] >= 2 * (largest_diameter_ + skin)) continue;
    failure_ = Outcome{Reason::unstable, "the periodic cell has shrunk below four particle radii"};
    return true;
  }
  return false;
}

// --- Lists --------------------------------------------------------------------------------------

void Simulation::ChooseSkins() {
  if (steps_since_prune_ > 0) pace_ = travelled_ / static_cast<double>(steps_since_prune_);
  const double d = mean_diameter_;
  const double pace = pace_ / d;
  inner_skin_ = d * std::clamp(kInnerSkinFactor * std::sqrt(pace), kLeastInnerSkin, kMostInnerSkin);
}

void Simulation::Rebuild() {
  double room = kMostOuterSkin * mean_diameter_;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (box_.periodic[axis]) {
      room = std::min(room, 0.5 * images_.length[axis] - largest_diameter_);
    }
  }
  const double d = mean_diameter_;
  const double wish =
      d * std::clamp(kOuterSkinFactor * std::sqrt(pace_ / d), kLeastOuterSkin, kMostOuterSkin);
  outer_skin_ = std::min(wish, room);
  if (CellTooSmall(0)) return;
  inner_skin_ = std::min(inner_skin_, 0.5 * outer_skin_);
  const std::vector<std::uint8_t> removed = FindLeavers();
  for (const std::uint8_t leaves : removed) leavers_ += leaves;
  neighbours_.Rebuild(particles_, box_, images_, outer_skin_, removed, *team_);
  std::vector<Slab>& slabs = neighbours_.slabs();
  for (std::size_t m = 0; m < meshes_.size(); ++m) {
    if (meshes_[m].removed) {
      mesh_contacts_[m].Clear(slabs.size());
      continue;
    }
    mesh_contacts_[m].Rebuild(particles_, meshes_[m].surface, box_, images_, slabs, outer_skin_);
  }
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    groups_[g].members.assign(slabs.size(), {});
    for (std::size_t s = 0; s < slabs.size(); ++s) {
      for (std::int32_t p = slabs[s].begin; p < slabs[s].end; ++p) {
        if (particles_.group[static_cast<std::size_t>(p)] == static_cast<std::int32_t>(g)) {
          groups_[g].members[s].push_back(p);
        }
      }
    }
  }
  sums_.assign(slabs.size(), {0, std::vector<Vector3>(BodyCount())});
  travelled_outer_ = 0;
  ++counters_.rebuilds;
  counters_.outer = neighbours_.outer_count();
}

// The lists hold while no two particles have come closer by more than the skin.
void Simulation::RefreshLists() {
  if (!lists_stale_ && 2 * travelled_ <= inner_skin_) return;
  ChooseSkins();
  if (lists_stale_ || 2 * travelled_outer_ > outer_skin_ - inner_skin_) {
    Rebuild();
    if (failure_) return;
    if (!started_) RestoreContacts();
  }
  plane_states_.clear();
  for (const PlaneBody& plane : planes_) plane_states_.push_back(plane.State());
  neighbours_.Prune(particles_, kernels_, images_, plane_states_, inner_skin_, *team_);
  lists_stale_ = false;
  travelled_ = 0;
  steps_since_prune_ = 0;
  ++counters_.prunes;
}

std::vector<std::uint8_t> Simulation::FindLeavers() const {
  std::vector<std::uint8_t> removed;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (program_.domain.boundaries[axis] != Boundary::outflow) continue;
    removed.resize(static_cast<std::size_t>(particles_.count()));
    for (std::int32_t p = 0; p < particles_.count(); ++p) {
      const double x = particles_.Position(p)[axis];
      if (x < box_.lower[axis] || x > box_.upper[axis]) removed[static_cast<std::size_t>(p)] = 1;
    }
  }
  return removed;
}

int Simulation::CountLost() const {
  int lost = 0;
  for (std::int32_t p = 0; p < particles_.count(); ++p) {
    const double* x = particles_.Position(p);
    bool here = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      here = here && std::isfinite(x[axis]);
      if (program_.domain.boundaries[axis] != Boundary::open) continue;
      here = here && x[axis] >= box_.lower[axis] && x[axis] <= box_.upper[axis];
    }
    lost += here ? 0 : 1;
  }
  return lost;
}

void Simulation::RestoreContacts() {
  if (program_.particles.contacts.empty()) return;
  std::vector<std::pair<std::int64_t, std::int32_t>> places;
  for (std::int32_t p = 0; p < particles_.count(); ++p) {
    places.emplace_back(particles_.ids[static_cast<std::size_t>(p)], p);
  }
  std::sort(places.begin(), places.end());
  const auto place = [&](std::int64_t id) {
    const auto found = std::lower_bound(places.begin(), places.end(), std::pair(id, 0));
    return found != places.end() && found->first == id ? found->second : -1;
  };
  for (const ContactHistory& contact : program_.particles.contacts) {
    const std::int32_t i = place(contact.i);
    if (i < 0) continue;
    if (contact.j < 0) {
      const auto plane = static_cast<int>(-1 - contact.j);
      if (plane < static_cast<int>(planes_.size())) {
        neighbours_.SetPlaneHistory(plane, i, contact.shear, contact.rolling);
      }
    } else if (const std::int32_t j = place(contact.j); j >= 0) {
      neighbours_.SetHistory(i, j, contact.shear, contact.rolling);
    }
  }
}

// --- One step -----------------------------------------------------------------------------------

// Forces on all particles where they are, and what the flags of Integration say. While a slab's
// particles are in the cache everything is done with them.
void Simulation::Pass(bool forces, bool finish, bool begin, bool record) {
  std::vector<Slab>& slabs = neighbours_.slabs();
  for (const auto& phase : neighbours_.schedule()) {
    team_->Run([&](int thread) {
      for (const SlabTask& task : phase[static_cast<std::size_t>(thread)]) {
        if (task.finish) {
          if (forces) FinishForces(task.slab, record);
          if (finish || begin) Integrate(task.slab, finish, begin);
        } else if (forces) {
          kernels_.pairs(sphere_law_, images_, particles_.rows(),
                         slabs[task.slab].pairs.Columns(record));
        }
      }
    });
  }
}

// Walls, and what glued groups have to bear.
void Simulation::FinishForces(std::size_t s, bool record) {
  Slab& slab = neighbours_.slabs()[s];
  std::vector<Vector3>& force = sums_[s].body_force;
  std::fill(force.begin(), force.end(), Vector3{});
  std::size_t body = 0;
  for (std::size_t n = 0; n < planes_.size(); ++n, ++body) {
    if (slab.planes[n].size == 0) continue;
    kernels_.plane(planes_[n].law, plane_states_[n], particles_.rows(),
                   slab.planes[n].Columns(record), force[body].data());
  }
  for (std::size_t n = 0; n < meshes_.size(); ++n, ++body) {
    mesh_contacts_[n].AddForces(s, particles_.PaddingRow(static_cast<int>(s)), particles_,
                                meshes_[n], kernels_.surface, record, &force[body]);
  }
  for (const GroupBody& group : groups_) {
    for (const std::int32_t p : group.members[s]) {
      const double* load = particles_.Force(p);
      for (std::size_t axis = 0; axis < 3; ++axis) force[body][axis] += load[axis];
    }
    ++body;
  }
}

void Simulation::Integrate(std::size_t s, bool finish, bool begin) {
  const Integration integration = {particles_.inverse_mass.data(),
                                   particles_.inverse_inertia.data(), finish, begin};
  const Slab& slab = neighbours_.slabs()[s];
  sums_[s].fastest =
      kernels_.integrate(drive_, particles_.rows(), integration, slab.begin, slab.end);
}

// Once the forces of a step are complete: sums over the bodies, and what follows from them.
void Simulation::AfterForces() {
  std::size_t index = 0;
  const auto finish = [&](Body& body) {
    body.force = {};
    for (const SlabSums& sums : sums_) body.force = body.force + sums.body_force[index];
    ++index;
    if (body.servo) body.velocity[2] = body.servo->Next(body.force[2], program_.time_step);
  };
  for (PlaneBody& body : planes_) finish(body);
  for (MeshBody& body : meshes_) finish(body);
  for (GroupBody& body : groups_) finish(body);
  if (measured_cell()) {
    stress_ = MeasureStress();
    ControlCell();
  }
  if (after_step) after_step();
}

bool Simulation::Measures() const { return steps_ % kStressEvery == 0; }

// Bodies and cell, from one step to the next.
void Simulation::Move() {
  const double dt = program_.time_step;
  for (PlaneBody& body : planes_) {
    body.displacement = body.displacement + dt * body.velocity;
    body.wall.position += dt * body.velocity[static_cast<std::size_t>(body.wall.axis)];
  }
  for (MeshBody& body : meshes_) body.Advance(dt);
  for (GroupBody& body : groups_) body.displacement = body.displacement + dt * body.velocity;
  MoveGroups();
  for (std::size_t n = 0; n < planes_.size(); ++n) plane_states_[n] = planes_[n].State();
  if (cell_drive_) DeformCell();
  ++steps_;
}

// Glued particles drift with their rows' velocity: that of the group for the next step.
void Simulation::MoveGroups() {
  for (const GroupBody& body : groups_) {
    for (const std::vector<std::int32_t>& members : body.members) {
      for (const std::int32_t p : members) {
        std::copy_n(body.velocity.data(), 3, particles_.Velocity(p));
      }
    }
  }
}

double Simulation::FastestParticle() const {
  double fastest = 0;
  for (const SlabSums& sums : sums_) {
    // Not std::max, which would pass over what is not a number.
    if (!(sums.fastest <= fastest)) fastest = sums.fastest;
  }
  return std::sqrt(fastest);
}

double Simulation::FastestBody() const {
  double fastest = 0;
  for (const PlaneBody& body : planes_) {
    fastest = std::max(fastest, std::abs(body.velocity[static_cast<std::size_t>(body.wall.axis)]));
  }
  for (const MeshBody& body : meshes_) fastest = std::max(fastest, body.Fastest());
  for (const GroupBody& body : groups_) fastest = std::max(fastest, Length(body.velocity));
  return fastest;
}

void Simulation::Start() {
  RefreshLists();
  if (failure_) return;
  particles_.ClearLoads();
  // A first look at the forces must not let the springs of contacts grow.
  LawConstants law = sphere_law_;
  sphere_law_.time_step = 0;
  for (PlaneBody& plane : planes_) plane.law.time_step = 0;
  for (MeshBody& mesh : meshes_) mesh.law.time_step = 0;
  Pass(true, false, false, true);
  sphere_law_ = law;
  for (PlaneBody& plane : planes_) plane.law.time_step = law.time_step;
  for (MeshBody& mesh : meshes_) mesh.law.time_step = law.time_step;
  started_ = true;
}

bool Simulation::Run(std::int64_t count, const std::function<bool()>& interrupted) {
  if (failure_) return false;
  if (!started_) Start();
  MoveGroups();  // their velocity may have been set since the last step
  const double dt = program_.time_step;
  // About a millisecond's work.
  const std::int64_t check_every =
      std::clamp<std::int64_t>(20'000 / std::max(1, particles_.count()), 1, 1000);
  bool go_on = !failure_;
  std::int64_t step = 0;
  for (; step < count && go_on; ++step) {
    // The forces that the last Run() ended with begin the first step.
    Pass(step > 0, step > 0, true, measured_cell() || measured_slab());
    if (step > 0) AfterForces();
    Move();
    const double cell_rate =
        std::max({std::abs(drive_.rate[0]), std::abs(drive_.rate[1]), std::abs(drive_.rate[2])}) +
        std::abs(drive_.shear_rate);
    const double way =
        dt * (FastestParticle() + FastestBody() + 0.5 * cell_rate * largest_diameter_);
    travelled_ += way;
    travelled_outer_ += way;
    ++steps_since_prune_;
    if (!std::isfinite(way) || way > largest_diameter_) {
      failure_ = Outcome{Reason::unstable, "particles move by more than a diameter in a step"};
    } else {
      RefreshLists();
    }
    if (failure_) return false;
    if (step % check_every == 0 && interrupted && interrupted()) go_on = false;
  }
  if (step > 0) {
    Pass(true, true, false, true);  // for whoever asks about the stress of this moment
    AfterForces();
  }
  return go_on;
}

void Simulation::GoBackTo(const Simulation& saved) {
  const std::int64_t steps_done = steps();
  const Counters counters = counters_;
  *this = saved;
  undone_steps_ = steps_done - steps_;
  counters_ = counters;
}

void Simulation::Remove(Body& body) {
  body.removed = true;
  body.velocity = {};
  for (PlaneBody& plane : planes_) {
    if (&plane == &body) plane.wall.position = plane.wall.facing_positive ? -HUGE_VAL : HUGE_VAL;
  }
  for (std::size_t m = 0; m < meshes_.size(); ++m) {
    if (&meshes_[m] == &body) mesh_contacts_[m].Clear(neighbours_.slabs().size());
  }
  BodiesMoved();
}

Simulation::Counters Simulation::counters() const {
  Counters counters = counters_;
  counters.pairs = neighbours_.pair_count();
  counters.inner_skin = inner_skin_;
  counters.outer_skin = outer_skin_;
  return counters;
}

// --- The periodic cell --------------------------------------------------------------------------

void Simulation::SetCellDrive(const std::optional<CellDrive>& drive) {
  cell_drive_ = drive;
  if (!drive) {
    SetRates({}, 0);
    filtered_at_ = steps_;
    return;
  }
  if (filtered_at_ != steps_) {
    if (!started_) Start();
    stress_ = MeasureStress();
    for (std::size_t axis = 0; axis < 3; ++axis) filtered_stress_[axis] = stress_[axis][axis];
  }
  SetRates(ControlledRates(), drive->shear_rate);
}

void Simulation::DeformCell() {
  const double dt = program_.time_step;
  shear_offset_ += dt * images_.shear_speed;
  shear_strain_ += dt * drive_.shear_rate;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double growth = 0.5 * dt * images_.speed[axis];
    box_.lower[axis] -= growth;
    box_.upper[axis] += growth;
  }
  const double length = box_.upper[0] - box_.lower[0];
  shear_offset_ -= length * std::round(shear_offset_ / length);
  UpdateImages();
}

// A rate in proportion to the error of the filtered stress, bounded: see Deform.
Vector3 Simulation::ControlledRates() const {
  const CellDrive& drive = *cell_drive_;
  Vector3 rate{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const EdgeControl& edge = drive.edges[axis];
    rate[axis] = edge.value;
    if (edge.kind == EdgeControl::Kind::strain_rate) continue;
    const double error = (filtered_stress_[axis] - edge.value) / edge.value;
    rate[axis] = drive.pace * std::clamp(drive.gain * error, -kMostPace, kMostPace);
  }
  return rate;
}

void Simulation::ControlCell() {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    filtered_stress_[axis] += kStressWeight * (stress_[axis][axis] - filtered_stress_[axis]);
  }
  SetRates(ControlledRates(), cell_drive_->shear_rate);
  StopDrift(particles_, drive_);
}

// Particles take the change of the affine velocity, so that no boundary has to drive them.
void Simulation::SetRates(const Vector3& rate, double shear_rate) {
  Vector3 change{};
  bool any = shear_rate != drive_.shear_rate;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    change[axis] = rate[axis] - drive_.rate[axis];
    any = any || change[axis] != 0;
    drive_.rate[axis] = rate[axis];
  }
  if (!any) return;
  const double shear_change = shear_rate - drive_.shear_rate;
  drive_.shear_rate = shear_rate;
  for (std::int32_t p = 0; p < particles_.count(); ++p) {
    const double* x = particles_.Position(p);
    double* v = particles_.Velocity(p);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      v[axis] += change[axis] * (x[axis] - drive_.centre[axis]);
    }
    v[0] += shear_change * (x[2] - drive_.centre[2]);
  }
  UpdateImages();
}

}  // namespace powdercal::embedded

#include "backends/embedded/stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "backends/embedded/vector_math.h"
#include "backends/insertion.h"
#include "backends/particle_summary.h"
#include "backends/servo_gain.h"
#include "scaling/groups.h"

namespace powdercal::embedded {
namespace {

constexpr std::int64_t kSeriesSteps = 100;
constexpr std::int64_t kStressSamples = 5;  // in as many steps
constexpr std::int64_t kHealthSteps = 500;
constexpr double kWorstOverlap = 1.0;  // δ/R*: beyond it contact laws mean nothing
constexpr double kEnergyFactor = 100;
constexpr double kStressTolerance = 0.05;

double SumOfMasses(const Packing& packing, double density) {
  double volume = 0;
  for (const Sphere& s : packing) volume += s.radius * s.radius * s.radius;
  return density * 4.1887902047863905 * volume;
}

double MeanDiameter(const Packing& packing) {
  double sum = 0;
  for (const Sphere& s : packing) sum += 2 * s.radius;
  return packing.empty() ? 0 : sum / static_cast<double>(packing.size());
}

const Servo* FirstServo(const Program& program) {
  for (const Stage& stage : program.stages) {
    if (const Servo* servo = std::get_if<Servo>(&stage)) return servo;
  }
  return nullptr;
}

}  // namespace

ServoControl ControlOf(const Program& program, const Servo& servo, double height) {
  ServoControl control{.target = servo.stress * program.domain.BaseArea(),
                       .speed = ServoSpeed(program, servo),
                       .max_velocity = servo.max_velocity};
  // Ten times what the bed takes to answer: its stress grows by about 1.5 kappa sigma per strain.
  const double kappa = StiffnessNumber(program.materials.young_modulus,
                                       program.materials.poisson_ratio, servo.stress);
  const double bed =
      std::max(height - program.domain.lower[2], Summarise(program.particles).mean_diameter);
  control.integral_time = 10 * bed / (1.5 * kappa * control.speed);
  return control;
}

// Planes, meshes, groups: visit(body, height as in WallState).
template <typename Visit>
void StageRunner::ForEachBody(const Visit& visit) const {
  for (const PlaneBody& body : simulation_->planes()) visit(body, body.wall.position);
  for (const MeshBody& body : simulation_->meshes()) visit(body, body.surface.Bounds()[0][2]);
  for (const GroupBody& body : simulation_->groups()) visit(body, body.displacement[2]);
}

StageRunner::StageRunner(const Program& program, const RunContext& context,
                         const Settings& settings)
    : program_(program),
      context_(context),
      settings_(settings),
      start_(std::chrono::steady_clock::now()),
      first_servo_(FirstServo(program)) {}

Trace StageRunner::Run() {
  if (context_.snapshot_interval > 0) {
    snapshots_.emplace(context_.work_folder / kSnapshotFolder);
    snapshot_every_ = StepsOf(context_.snapshot_interval);
  }
  bool go_on = true;
  if (program_.stages.empty() || !std::holds_alternative<Insert>(program_.stages.front())) {
    go_on = Do(Insert{});
  }
  for (const Stage& stage : program_.stages) {
    held_ = {};
    go_on = go_on && std::visit([this](const auto& s) { return Do(s); }, stage);
  }
  Finish();
  return std::move(trace_);
}

std::int64_t StageRunner::StepsOf(double duration) const {
  return std::max<std::int64_t>(1, std::llround(std::min(duration / program_.time_step, 1e15)));
}

bool StageRunner::Do(const Insert& insert) {
  packing_ = PlaceParticles(program_.particles, program_.domain, insert, context_.stop);
  if (Interrupted()) return FailInterrupted();
  total_mass_ = SumOfMasses(packing_, program_.materials.density);
  simulation_.emplace(program_, packing_, settings_);
  for (PlaneBody& plane : simulation_->planes()) {
    // A servo's plane comes into play with its stage.
    if (first_servo_ != nullptr && plane.name == first_servo_->wall) plane.wall.position = HUGE_VAL;
  }
  PrepareSeries();
  simulation_->after_step = [this] { Record(); };
  const Survey survey = simulation_->MakeSurvey();
  first_energy_ = survey.kinetic_energy;
  first_elastic_ = survey.elastic_energy;
  if (snapshots_) WriteSnapshot();
  return true;
}

bool StageRunner::Do(const Settle& settle) {
  const std::int64_t interval = StepsOf(settle.check_interval);
  const double gravity = Length(program_.gravity);
  const double weight = total_mass_ * gravity * MeanDiameter(packing_);
  const double begin = simulation_->time();
  while (simulation_->time() - begin < settle.max_duration) {
    if (!RunSteps(interval)) return false;
    const Survey survey = simulation_->MakeSurvey();
    if (simulation_->time() - begin >= settle.min_duration &&
        survey.kinetic_energy < settle.kinetic_energy_ratio * weight) {
      break;
    }
  }
  AddMoment("settle");
  return true;
}

bool StageRunner::Do(const Servo& servo) {
  const bool first = servo_ == nullptr;
  servo_ = &servo;
  servo_body_ = simulation_->FindBody(servo.wall);
  const double top = simulation_->MakeSurvey().top;
  const double above = top + 0.03 * MeanDiameter(packing_);
  if (first) PlaceServo(above);
  ServoControl control = ControlOf(program_, servo, above);
  const double integral = servo_body_->servo ? servo_body_->servo->integral : 0;
  control.integral = std::clamp(integral, -control.speed, control.speed);
  servo_body_->servo = control;
  drive_speed_ = std::max(drive_speed_, servo.max_velocity);
  RestartWindows();

  const WallSeries& series = *trace_.FindSeries(servo.wall);
  const std::int64_t loops = StepsOf(servo.max_duration) / kSeriesSteps + 1;
  for (std::int64_t n = 0; n < loops; ++n) {
    if (!RunSteps(kSeriesSteps)) return false;
    const double load = series.normal_force.back() / control.target;
    if (load > 0.9 && (first || load < 1.1)) break;
  }
  AddMoment("servo");
  return true;
}

// Its lowest point, or of a group nothing, since a group stands in the packing.
void StageRunner::PlaceServo(double height) {
  for (PlaneBody& plane : simulation_->planes()) {
    if (&plane == servo_body_) plane.wall.position = height;
  }
  for (MeshBody& mesh : simulation_->meshes()) {
    if (&mesh != servo_body_) continue;
    Pose pose = mesh.surface.pose();
    pose.translation[2] += height - mesh.surface.Bounds()[0][2];
    mesh.surface.Place(pose);
  }
  servo_body_->displacement = {};
  simulation_->BodiesMoved();
}

bool StageRunner::Do(const Hold& hold) {
  const std::int64_t steps = StepsOf(hold.window);
  const double window = static_cast<double>(steps) * program_.time_step;
  const std::int64_t loops = StepsOf(hold.max_duration) / steps + 1;
  const double area = program_.domain.BaseArea();
  double before = 0;
  for (std::int64_t n = 0; n < loops; ++n) {
    hold_window_ = {};
    if (!RunSteps(steps)) return false;
    const double stress = hold_window_.force[2] / static_cast<double>(steps) / area;
    const double height = hold_window_.height / static_cast<double>(steps);
    const Survey survey = simulation_->MakeSurvey();
    const double change = before == 0 ? 1 : std::abs(height / before - 1);
    const double error = std::abs(stress / servo_->stress - 1);
    const double quiet = survey.kinetic_energy / std::max(survey.elastic_energy, 1e-300);
    held_ = {.force = stress * area,
             .velocity = before == 0 ? 0 : (height - before) / window,
             .valid = true};
    before = height;
    trace_.diagnostics.kinetic_energy_ratio = quiet;
    if (change < hold.strain_rate * window && error < hold.stress_tolerance &&
        quiet < hold.kinetic_energy_ratio) {
      AddMoment("hold");
      return true;
    }
    if (n + 1 < loops) continue;
    AddMoment("hold");
    if (error > kStressTolerance) {
      return Fail(
          Reason::not_quasi_static,
          fmt::format("the wall bears {:.4g} Pa instead of {:.4g} Pa", stress, servo_->stress));
    }
    return Fail(Reason::not_quasi_static,
                fmt::format("the bed still moves after {:.3g} s under load: stress {:.4g} Pa, "
                            "relative change of height {:.2g} in {:.2g} s, kinetic to elastic "
                            "energy {:.2g}",
                            hold.max_duration, stress, change, window, quiet));
  }
  return true;
}

bool StageRunner::Do(const Advance& advance) {
  StartMotions(advance);
  std::int64_t left = StepsOf(advance.duration);
  const std::int64_t every = advance.packing_every > 0 ? advance.packing_every : left;
  while (left > 0) {
    const std::int64_t count = std::min(left, every);
    if (!RunSteps(count)) return false;
    left -= count;
    AddMoment(advance.name);
  }
  for (const Motion& motion : advance.motions) SetVelocity(motion.body, {});
  for (MeshBody& mesh : simulation_->meshes()) {
    if (mesh.moving) mesh.Stop();
  }
  return true;
}

void StageRunner::StartMotions(const Advance& advance) {
  for (const Motion& motion : advance.motions) {
    drive_speed_ = std::max(drive_speed_, Length(motion.velocity));
    SetVelocity(motion.body, motion.velocity);
    for (MeshBody& mesh : simulation_->meshes()) {
      if (mesh.name != motion.body) continue;
      mesh.Start(motion);
      drive_speed_ = std::max(drive_speed_, mesh.Fastest());
    }
  }
}

// A servo keeps its velocity along z.
void StageRunner::SetVelocity(const std::string& name, const Vector3& velocity) {
  Body& body = *simulation_->FindBody(name);
  const double servo_velocity = body.velocity[2];
  body.velocity = velocity;
  if (body.servo) body.velocity[2] = servo_velocity;
}

bool StageRunner::Do(const Deform& deform) {
  CellDrive drive{.edges = deform.edges, .shear_rate = deform.shear_rate, .gain = deform.gain};
  drive.pace = deform.shear_rate != 0 ? std::abs(deform.shear_rate) : deform.relaxation_rate;
  const Vector3 lengths = program_.domain.Lengths();
  drive_speed_ = std::max(drive_speed_, (std::abs(deform.shear_rate) + 6 * drive.pace) *
                                            *std::max_element(lengths.begin(), lengths.end()));
  simulation_->SetCellDrive(drive);
  RestartWindows();
  const bool go_on = RunSteps(StepsOf(deform.duration));
  if (go_on) AddMoment(deform.name);
  simulation_->SetCellDrive(std::nullopt);
  return go_on;
}

// Windows begin anew, so that what follows a restoration is recorded as what follows here.
bool StageRunner::Do(const Save& save) {
  saved_.insert_or_assign(save.name, Saved{*simulation_, servo_});
  RestartWindows();
  return true;
}

bool StageRunner::Do(const Restore& restore) {
  const Saved& saved = saved_.at(restore.name);
  simulation_->GoBackTo(saved.simulation);
  servo_ = saved.servo;
  servo_body_ = servo_ != nullptr ? simulation_->FindBody(servo_->wall) : nullptr;
  RestartWindows();
  return true;
}

bool StageRunner::Do(const Remove& remove) {
  simulation_->Remove(*simulation_->FindBody(remove.body));
  return true;
}

// --- What happens along the way -----------------------------------------------------------------

// The servo's wall comes first, then meshes and groups.
void StageRunner::PrepareSeries() {
  if (first_servo_ != nullptr) trace_.series.push_back({.wall = first_servo_->wall});
  ForEachBody([&](const Body& body, double) {
    body_series_.emplace_back();
    if (first_servo_ != nullptr && body.name == first_servo_->wall) {
      body_series_.back() = 0;
    } else if (body_series_.size() > program_.walls.size()) {  // not a plane
      body_series_.back() = trace_.series.size();
      trace_.series.push_back({.wall = body.name});
    }
  });
  RestartWindows();
}

void StageRunner::RestartWindows() {
  body_windows_.assign(body_series_.size(), {});
  window_steps_ = 0;
  cell_window_ = {};
  slab_window_ = {};
}

void StageRunner::Record() {
  RecordBodies();
  if (simulation_->measured_cell()) RecordCell();
  if (simulation_->measured_slab()) RecordSlab();
}

void StageRunner::RecordBodies() {
  body_force_.resize(body_series_.size());
  ++body_steps_;
  ++window_steps_;
  std::size_t index = 0;
  ForEachBody([&](const Body& body, double height) {
    const auto add = [&](Window& window) {
      window.force = window.force + body.force;
      window.height += height;
    };
    body_force_[index] = body_force_[index] + body.force;
    add(body_windows_[index]);
    if (&body == servo_body_) add(hold_window_);
    ++index;
  });
  if (window_steps_ < kSeriesSteps) return;
  const double n = static_cast<double>(kSeriesSteps);
  index = 0;
  ForEachBody([&](const Body& body, double) {
    const Window& window = body_windows_[index];
    const std::optional<std::size_t> place = body_series_[index++];
    if (!place || body.removed) return;
    if (servo_ == nullptr && first_servo_ != nullptr && body.name == first_servo_->wall) return;
    WallSeries& series = trace_.series[*place];
    series.time.push_back(simulation_->time());
    series.height.push_back(window.height / n);
    series.normal_force.push_back(window.force[2] / n);
    series.force.push_back((1 / n) * window.force);
  });
  body_windows_.assign(body_series_.size(), {});
  window_steps_ = 0;
}

void StageRunner::RecordCell() {
  ++cell_window_.samples;
  for (std::size_t a = 0; a < 3; ++a) {
    cell_window_.stress[a] = cell_window_.stress[a] + simulation_->stress()[a];
  }
  if (cell_window_.samples < kStressSamples) return;
  const double n = static_cast<double>(cell_window_.samples);
  CellSeries& series = trace_.cell;
  series.time.push_back(simulation_->time());
  series.strain.push_back(simulation_->shear_strain());
  series.lengths.push_back(simulation_->box().upper - simulation_->box().lower);
  series.stress.push_back({(1 / n) * cell_window_.stress[0], (1 / n) * cell_window_.stress[1],
                           (1 / n) * cell_window_.stress[2]});
  cell_window_ = {};
}

void StageRunner::RecordSlab() {
  const SlabState state = simulation_->MeasureSlab();
  SlabWindow& window = slab_window_;
  ++window.samples;
  window.solid_fraction += state.solid_fraction;
  for (std::size_t a = 0; a < 3; ++a) window.stress[a] = window.stress[a] + state.stress[a];
  if (window.samples < kStressSamples) return;
  const double n = static_cast<double>(window.samples);
  SlabSeries& series = trace_.slab;
  series.time.push_back(simulation_->time());
  series.solid_fraction.push_back(window.solid_fraction / n);
  series.stress.push_back(
      {(1 / n) * window.stress[0], (1 / n) * window.stress[1], (1 / n) * window.stress[2]});
  window = {};
}

bool StageRunner::RunSteps(std::int64_t count) {
  body_force_.clear();
  body_steps_ = 0;
  while (count > 0) {
    std::int64_t piece = std::min(count, kHealthSteps);
    if (snapshot_every_ > 0) {
      piece = std::min(piece, snapshot_every_ - simulation_->steps() % snapshot_every_);
    }
    if (!RunPiece(piece)) return false;
    count -= piece;
    if (snapshot_every_ > 0 && simulation_->steps() % snapshot_every_ == 0) WriteSnapshot();
  }
  return true;
}

bool StageRunner::RunPiece(std::int64_t count) {
  if (simulation_->Run(count, [this] { return Interrupted(); })) return Healthy();
  if (simulation_->failure()) {
    return Fail(simulation_->failure()->reason, simulation_->failure()->message);
  }
  return FailInterrupted();
}

bool StageRunner::FailInterrupted() {
  const std::int64_t steps = simulation_ ? simulation_->steps() : 0;
  if (!timed_out_) return Fail(Reason::cancelled, "stopped on request");
  return Fail(Reason::timeout, fmt::format("stopped after {:.4g} s, at step {}",
                                           context_.time_limit->count(), steps));
}

bool StageRunner::Interrupted() {
  timed_out_ =
      context_.time_limit && std::chrono::steady_clock::now() - start_ > *context_.time_limit;
  return timed_out_ || context_.stop.stop_requested();
}

bool StageRunner::Healthy() {
  const int lost = simulation_->CountLost();
  if (lost > 0) {
    trace_.diagnostics.lost_particles = lost;
    return Fail(Reason::lost_particles,
                fmt::format("{} of {} particles are outside the domain at step {}", lost,
                            packing_.size(), simulation_->steps()));
  }
  const Survey survey = simulation_->MakeSurvey();
  trace_.diagnostics.max_overlap = survey.max_overlap;
  if (!(survey.max_overlap <= kWorstOverlap)) {
    return Fail(Reason::unstable,
                fmt::format("particles overlap by {:.2f} R* at step {}: too soft for the load, or "
                            "the time step is too long",
                            survey.max_overlap, simulation_->steps()));
  }
  if (!(survey.kinetic_energy <= EnergyBudget())) {
    return Fail(Reason::unstable,
                fmt::format("the kinetic energy of {:.3g} J at step {} is far more than gravity, "
                            "walls and cohesion can have put in",
                            survey.kinetic_energy, simulation_->steps()));
  }
  return true;
}

// Far above anything that happens in a sane simulation.
double StageRunner::EnergyBudget() const {
  const Vector3 lengths = program_.domain.Lengths();
  const double largest = *std::max_element(lengths.begin(), lengths.end());
  double energy = first_energy_ + total_mass_ * Length(program_.gravity) * largest +
                  0.5 * total_mass_ * drive_speed_ * drive_speed_;
  if (servo_ != nullptr) energy += servo_->stress * program_.domain.BaseArea() * largest;
  energy += first_elastic_;
  // Bonds that form and snap: a quarter of E R*³ per particle is more than any holds.
  const double d = MeanDiameter(packing_);
  const double stiffness = program_.law.normal == ContactLaw::Normal::hertz
                               ? program_.materials.young_modulus * d
                               : program_.materials.linear.normal;
  energy += 1e-6 * stiffness * d * d * static_cast<double>(packing_.size());
  return kEnergyFactor * energy;
}

bool StageRunner::Fail(Reason reason, std::string message) {
  trace_.outcome = {reason, std::move(message)};
  return false;
}

void StageRunner::AddMoment(const std::string& name) {
  Moment moment{.name = name,
                .time = simulation_->time(),
                .packing = simulation_->CurrentPacking(),
                .contacts = simulation_->CurrentContacts()};
  const double steps = static_cast<double>(std::max<std::int64_t>(1, body_steps_));
  std::size_t index = 0;
  ForEachBody([&](const Body& body, double height) {
    WallState state{
        .height = height, .displacement = body.displacement, .velocity = body.velocity[2]};
    if (index < body_force_.size()) state.force = (1 / steps) * body_force_[index];
    ++index;
    if (body.removed || !std::isfinite(height)) return;  // gone, or not in play yet
    if (&body == servo_body_ && held_.valid) state.velocity = held_.velocity;
    moment.walls[body.name] = state;
  });
  const auto& b = program_.domain.boundaries;
  if (b[0] == Boundary::periodic && b[1] == Boundary::periodic && b[2] == Boundary::periodic) {
    moment.cell = simulation_->Cell();
  }
  trace_.moments.push_back(std::move(moment));
}

void StageRunner::WriteSnapshot() {
  std::vector<SnapshotSurface> surfaces;
  // Surfaces keep their order; those of removed bodies are empty.
  for (const PlaneBody& body : simulation_->planes()) {
    if (body.removed) {
      surfaces.push_back({.name = body.name});
      continue;
    }
    PlaneWall wall = body.wall;
    if (!std::isfinite(wall.position)) {  // not in play yet
      const auto axis = static_cast<std::size_t>(wall.axis);
      wall.position = program_.domain.upper[axis];
    }
    surfaces.push_back(PlaneSurface(wall, program_.domain));
    surfaces.back().force = body.force;
  }
  for (const MeshBody& body : simulation_->meshes()) {
    if (body.removed) {
      surfaces.push_back({.name = body.name});
      continue;
    }
    SnapshotSurface surface{.name = body.name, .force = body.force};
    for (std::uint32_t v = 0; v < body.surface.vertex_count(); ++v) {
      surface.vertices.push_back(body.surface.Vertex(v));
    }
    for (std::uint32_t t = 0; t < body.surface.triangle_count(); ++t) {
      const std::array<std::uint32_t, 3>& v = body.surface.VerticesOf(t);
      surface.triangles.push_back(
          {static_cast<int>(v[0]), static_cast<int>(v[1]), static_cast<int>(v[2])});
    }
    surfaces.push_back(std::move(surface));
  }
  snapshots_->Write(simulation_->time(), simulation_->CurrentPacking(), surfaces);
}

void StageRunner::Finish() {
  Diagnostics& d = trace_.diagnostics;
  d.time_step = program_.time_step;
  d.law = program_.law.ToString();
  d.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  if (!simulation_) return;
  const bool failed = !trace_.outcome.ok() && trace_.outcome.reason != Reason::cancelled;
  if (failed && !context_.work_folder.empty()) {
    if (!snapshots_) snapshots_.emplace(context_.work_folder / kSnapshotFolder);
    WriteSnapshot();
  }
  const Survey survey = simulation_->MakeSurvey();
  d.steps = simulation_->steps();
  d.leavers = simulation_->leavers();
  d.kinetic_energy = survey.kinetic_energy;
  if (survey.elastic_energy > 0) {
    d.kinetic_energy_ratio = survey.kinetic_energy / survey.elastic_energy;
  }
  d.max_overlap = survey.max_overlap;
  const Simulation::Counters counters = simulation_->counters();
  d.figures["elastic_energy"] = survey.elastic_energy;
  d.figures["contacts"] = static_cast<double>(survey.contacts);
  d.figures["threads"] = settings_.threads;
  d.figures["list_rebuilds"] = static_cast<double>(counters.rebuilds);
  d.figures["list_prunes"] = static_cast<double>(counters.prunes);
  const double particle_steps = static_cast<double>(d.steps) * static_cast<double>(packing_.size());
  if (d.wall_seconds > 0) d.figures["particle_steps_per_second"] = particle_steps / d.wall_seconds;
}

}  // namespace powdercal::embedded

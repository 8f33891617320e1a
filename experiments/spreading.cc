#include "experiments/spreading.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/errors.h"
#include "core/quantity.h"
#include "experiments/layer_measures.h"
#include "experiments/packing_measures.h"
#include "experiments/pouring.h"

namespace powdercal {
namespace {

constexpr const char* kPlate = "plate";
constexpr const char* kBlade = "blade";
constexpr const char* kPlateParticles = "plate_particles";
constexpr double kLooseFraction = 0.30;  // as placed
constexpr double kDenseFraction = 0.50;  // of the layer that the heap is made for
constexpr double kHeapFraction = 0.55;   // of the heap at rest, for its size only
constexpr double kFallSpeed = 0.1;       // [m/s]
constexpr double kSlabAspect = 1.5;      // length over height of the slab in which powder is placed
constexpr double kSurfacePixels = 8;     // per mean diameter
constexpr int kPaperCount = 50'000;
constexpr const char* kCeiling = "ceiling";

const std::vector<std::string>& PlateNames() {
  static const std::vector<std::string> kNames = {"rough", "smooth"};
  return kNames;
}

struct SweepSize {
  double sweep = 0;  // [m]
  double width = 0;  // [m]
};

SweepSize SizeOf(Fidelity fidelity, double diameter) {
  switch (fidelity) {
    case Fidelity::quick:
      return {36 * diameter, 6 * diameter};
    case Fidelity::standard:
      return {80 * diameter, 10 * diameter};
    case Fidelity::paper:
      break;
  }
  return {7e-3, 48 * diameter};
}

// For particles that jam under the rigid blade and are shot up when they come free: as high as
// twenty times its speed takes them. The stiffest are faster, and meet a ceiling.
double Headroom(double speed, double gravity) {
  constexpr double kEjection = 20;
  return kEjection * speed * kEjection * speed / (2 * gravity);
}

// Front and bottom face; the rest of a blade meets no powder.
Mesh BladeMesh(double width, double gap, double thickness, double height) {
  Mesh mesh{.name = kBlade};
  mesh.vertices = {{0, 0, gap},    {0, width, gap},      {0, width, height},
                   {0, 0, height}, {-thickness, 0, gap}, {-thickness, width, gap}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 4, 5}, {0, 5, 1}};
  return mesh;
}

// Rows of equal spheres along y, hexagonal, over the domain's base, with their tops at z = 0.
// Between walls every second row has one less, so that none reaches into a wall.
Packing PlateLayer(const Domain& domain, double diameter, std::int64_t first_id) {
  const Vector3 lengths = domain.Lengths();
  const auto columns = static_cast<int>(std::floor(lengths[1] / diameter * (1 + 1e-12)));
  const double spacing = lengths[1] / columns;
  const double pitch = std::sqrt(diameter * diameter - spacing * spacing / 4);
  const auto rows = static_cast<int>(std::floor((lengths[0] - diameter) / pitch)) + 1;
  const bool periodic = domain.boundaries[1] == Boundary::periodic;
  Packing layer;
  for (int row = 0; row < rows; ++row) {
    const bool even = row % 2 == 0;
    const double shift = (even ? 0.25 : 0.75) + (periodic ? 0 : 0.25);
    const int in_row = periodic || even ? columns : columns - 1;
    for (int column = 0; column < in_row; ++column) {
      layer.push_back({.id = first_id + static_cast<std::int64_t>(layer.size()),
                       .radius = diameter / 2,
                       .position = {domain.lower[0] + diameter / 2 + row * pitch,
                                    domain.lower[1] + (column + shift) * spacing, -diameter / 2}});
    }
  }
  return layer;
}

// How far the blade has moved at the end.
double SweepOf(const Program& program) {
  for (const Stage& stage : program.stages) {
    if (const auto* advance = std::get_if<Advance>(&stage); advance && !advance->motions.empty()) {
      return advance->motions[0].velocity[0] * advance->duration;
    }
  }
  return 0;
}

}  // namespace

const std::string& Spreading::name() const {
  static const std::string kName = "spreading";
  return kName;
}

std::span<const ResponseDescription> Spreading::responses() const {
  static const std::vector<ResponseDescription> kResponses = {
      {"coverage", "1", "share of the plate beneath the particles"},
      {"layer_thickness", "m", "mean height of the layer's surface, bare plate counted as zero"},
      {"mass_per_area", "kg/m2", "mass of the layer over the plate's area"},
      {"packing_density", "1", "solid volume of the layer over that of the gap"},
      {"packing_density_sd", "1", "standard deviation of the same over cells of the plate"},
      {"roughness_sa", "m", "arithmetical mean deviation of the layer's surface"},
      {"roughness_sq", "m", "root mean square deviation of the layer's surface"},
      {"swept_share", "1", "share of the powder that the sweep did not lay down"},
  };
  return kResponses;
}

void Spreading::Serialize(Archive& archive) {
  archive.Quantity("blade_speed", blade_speed_, "m/s", kPositive);
  archive.Quantity("gap", gap_, "m", kPositive);
  archive.Quantity("blade_thickness", blade_thickness_, "m", kPositive);
  archive.Enumeration("plate", plate_, "plate", PlateNames());
  archive.Enumeration("sides", sides_, "sides", SidesNames());
  archive.Quantity("plate_particle_diameter", plate_particle_diameter_, "m", kPositive);
  if (archive.reading() && plate_particle_diameter_ && plate_ != Plate::rough) {
    throw archive.ErrorAt("plate_particle_diameter", "a smooth plate has no particles");
  }
  archive.Quantity("sweep", sweep_, "m", kPositive);
  archive.Quantity("width", width_, "m", kPositive);
  archive.Quantity("powder_surplus", powder_surplus_, "1", {.lower = 0.1, .upper = 10});
  archive.Quantity("rest_time", rest_time_, "s", kPositive);
  archive.Quantity("start_margin", start_margin_, "1", kNonNegative);
  archive.Quantity("end_margin", end_margin_, "1", kNonNegative);
  archive.Quantity("density_cell", density_cell_, "1", {.lower = 1, .upper = 1000});
}

void Spreading::DescribeConditions(Fidelity fidelity, Conditions& conditions) const {
  conditions.velocity = blade_speed_;
  conditions.gap = gap_;
  conditions.width = width_.value_or(SizeOf(fidelity, conditions.diameter.value()).width);
}

std::string Spreading::ExplainUnsupported(const SimulatedPowder& powder) const {
  const double largest = powder.sizes.Quantile(1);
  if (gap_ > largest) return "";
  return fmt::format("the gap of {} lets the largest particles of {} not pass",
                     HumanQuantity(gap_, "m"), HumanQuantity(largest, "m"));
}

Program Spreading::Plan(const SimulatedPowder& powder, const Conditions& conditions,
                        const Numerics& numerics, Fidelity fidelity, std::uint64_t seed) const {
  if (const std::string why = ExplainUnsupported(powder); !why.empty()) throw InputError(why);
  const double d = powder.sizes.Moment(1);
  const double gravity = conditions.gravity.value();
  const double fall_speed = kFallSpeed * conditions.speed_ratio;
  const double speed = conditions.velocity.value();
  const double width = conditions.width.value();
  const double sweep = sweep_.value_or(SizeOf(fidelity, d).sweep);
  const double thickness = blade_thickness_.value_or(gap_);
  const double plate_diameter = plate_particle_diameter_.value_or(d);
  CheckLengths(powder, sweep, width);

  const double sphere = MeanSphereVolume(powder.sizes);
  const double layer = kDenseFraction * gap_ * width * sweep;
  const int count = fidelity == Fidelity::paper
                        ? kPaperCount
                        : static_cast<int>(std::ceil(powder_surplus_ * layer / sphere));
  const double loose_area = count * sphere / (kLooseFraction * width);
  const double heap_area = loose_area * kLooseFraction / kHeapFraction;
  const double slab_height =
      std::max(std::sqrt(loose_area / kSlabAspect), powder.sizes.Quantile(1) * 2);
  const double slab_length = loose_area / slab_height;
  const double heap_length = std::max(slab_length, 2 * std::sqrt(heap_area));

  Program program{.experiment = name(), .fidelity = fidelity};
  program.particles = {.sizes = powder.sizes, .count = count, .seed = seed};
  program.particles.packing =
      PourLoose(program.particles, {.lower = {0, 0, 0},
                                    .upper = {slab_length, width, slab_height},
                                    .periodic_y = sides_ == Sides::periodic,
                                    .fall_speed = fall_speed});
  program.materials = powder.materials;
  program.law = powder.law;
  const bool rough = plate_ == Plate::rough;
  const double floor = rough ? -plate_diameter : 0;
  const double ceiling = 3 * slab_height + Headroom(speed, gravity);
  program.domain = {{-(thickness + 3 * gap_), 0, floor - d},
                    {sweep + 0.6 * heap_length, width, ceiling + d},
                    {Boundary::outflow, Boundary::periodic, Boundary::open}};
  program.walls = {{.name = kPlate, .position = floor}};
  if (sides_ == Sides::walls) EncloseBetweenWalls(1, &program);
  program.walls.push_back({.name = kCeiling, .position = ceiling, .facing_positive = false});
  program.meshes = {BladeMesh(width, gap_, thickness, gap_ + 2 * slab_height)};
  if (rough) {
    GluedGroup group{.name = kPlateParticles};
    for (const Sphere& fixed : PlateLayer(program.domain, plate_diameter, count + 1)) {
      group.ids.push_back(fixed.id);
      program.particles.packing->push_back(fixed);
    }
    program.groups = {std::move(group)};
  }
  program.gravity = {0, 0, -gravity};
  program.time_step = numerics.TimeStep(powder);
  program.stages = {SettleAfterFall(slab_height, fall_speed, gravity, d),
                    Advance{.name = "sweep",
                            .duration = sweep / speed,
                            .motions = {{.body = kBlade, .velocity = {speed, 0, 0}}}},
                    Advance{.name = "rest", .duration = rest_time_ / conditions.speed_ratio}};
  return program;
}

void Spreading::CheckLengths(const SimulatedPowder& powder, double sweep, double width) const {
  const double window = WindowEnd(sweep) - start_margin_ * gap_;
  if (window < powder.sizes.Moment(1)) {
    throw InputError(fmt::format(
        "a sweep of {} leaves no window to measure the layer in: the margins and the blade take {}",
        HumanQuantity(sweep, "m"), HumanQuantity(sweep - window, "m")));
  }
  double largest = powder.sizes.Quantile(1);
  if (plate_ == Plate::rough) largest = std::max(largest, plate_particle_diameter_.value_or(0));
  if (width < 3 * largest) {
    throw InputError(
        fmt::format("a plate {} wide is too narrow for particles of {}; at least three "
                    "of them must fit side by side",
                    HumanQuantity(width, "m"), HumanQuantity(largest, "m")));
  }
}

double Spreading::WindowEnd(double sweep) const {
  return sweep - blade_thickness_.value_or(gap_) - end_margin_ * gap_;
}

// The heap is at rest soon after its fall.
double Spreading::ExpectedDuration(const Program& program) const {
  double duration = 0;
  for (const Stage& stage : program.stages) {
    if (const auto* settle = std::get_if<Settle>(&stage)) duration += 1.5 * settle->min_duration;
    if (const auto* advance = std::get_if<Advance>(&stage)) duration += advance->duration;
  }
  return duration;
}

Measurement Spreading::Measure(const Program& program, const Trace& trace, Outcome* outcome) const {
  Measurement measurement;
  auto& responses = measurement.responses;
  for (const auto& [response, reported] : trace.reported) {
    responses[response] = {reported.value, reported.variance};
  }
  if (!trace.reported.empty()) return measurement;
  const Moment* rest = trace.Find("rest");
  if (rest == nullptr) {
    *outcome = {Reason::crashed, "the trace has no packing after the sweep"};
    return measurement;
  }
  const Packing poured = FreeSpheres(*program.particles.packing, program.particles.count);
  Packing packing = FreeSpheres(rest->packing, program.particles.count);
  const double d = program.particles.sizes.Moment(1);
  const double front = SweepOf(program);
  // What the blade has passed over and is higher than it, is on its way down.
  const auto airborne = std::erase_if(packing, [&](const Sphere& sphere) {
    return sphere.position[0] < front && sphere.position[2] - sphere.radius > gap_;
  });
  const double width = program.domain.Lengths()[1];
  const PlateWindow window{.x0 = start_margin_ * gap_,
                           .x1 = WindowEnd(front),
                           .y0 = 0,
                           .y1 = width,
                           .plate = 0,
                           .period_y = sides_ == Sides::periodic ? width : 0};
  const Coverage coverage = MeasureCoverage(packing, window);
  const PackingDensity density = MeasurePackingDensity(packing, window, gap_, d, density_cell_);
  const double pixel = d / kSurfacePixels;
  const SurfaceTexture surface = MeasureSurface(MeasureHeightField(packing, window, pixel));
  const double on_plate = SolidVolume(packing);
  Packing before;
  Packing layer;
  for (const Sphere& sphere : packing) {
    const double x = sphere.position[0];
    if (x > front) before.push_back(sphere);
    if (x > window.x0 && x < window.x1) layer.push_back(sphere);
  }
  const double heap = SolidVolume(before);
  const double all = SolidVolume(poured);

  responses["coverage"].value = coverage.fraction;
  responses["layer_thickness"].value = surface.thickness;
  responses["mass_per_area"].value = MassPerArea(packing, window, program.materials.density);
  responses["packing_density"].value = density.mean;
  responses["packing_density_sd"].value = density.standard_deviation;
  responses["roughness_sa"].value = surface.sa;
  responses["roughness_sq"].value = surface.sq;
  responses["swept_share"].value = 1 - (on_plate - heap) / all;
  measurement.diagnostics = {
      {"window_x0", window.x0},
      {"window_x1", window.x1},
      {"window_y0", window.y0},
      {"window_y1", window.y1},
      {"gap", gap_},
      {"coverage_pixel", coverage.pixel},
      {"coverage_change", coverage.change},
      {"coverage_converged", coverage.converged ? 1 : 0},
      {"density_cell_x", density.cell_x},
      {"density_cell_y", density.cell_y},
      {"density_cells", static_cast<double>(density.count)},
      {"surface_pixel", pixel},
      {"surface_maximum", surface.maximum},
      {"leavers", static_cast<double>(trace.diagnostics.leavers)},
      {"heap_share", heap / all},
      {"airborne", static_cast<double>(airborne)},
      {"layer_kinetic_energy_ratio", KineticEnergyRatio(layer, std::abs(program.gravity[2]))},
      {"particles", static_cast<double>(program.particles.count)},
      {"simulated_time", rest->time}};
  return measurement;
}

}  // namespace powdercal

#include "experiments/angle_of_repose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/errors.h"
#include "core/quantity.h"
#include "experiments/layer_measures.h"
#include "experiments/packing_measures.h"
#include "experiments/pouring.h"

namespace powdercal {
namespace {

using std::numbers::pi;
constexpr const char* kBackWall = "back_wall";
constexpr const char* kGate = "gate";
constexpr const char* kPlate = "plate";
constexpr const char* kFunnel = "funnel";
constexpr const char* kPlug = "plug";
constexpr double kLooseFraction = 0.30;    // as placed
constexpr double kSettledFraction = 0.55;  // for sizes only
constexpr double kFallSpeed = 0.1;         // [m/s]
constexpr double kConeAngle = pi / 6;      // from the vertical
constexpr int kSides = 24;                 // of round surfaces
constexpr double kRestRatio = 1e-3;        // kinetic energy over m g d
constexpr double kSurfacePixels = 4;       // per mean diameter
constexpr std::size_t kFewestBins = 4;     // for a fit

const std::vector<std::string>& MethodNames() {
  static const std::vector<std::string> kNames = {"draw_down", "funnel"};
  return kNames;
}

struct BedSize {
  double length = 0;  // [m] from back wall to gate
  double width = 0;   // [m]
};

BedSize BedSizeOf(Fidelity fidelity, double d) {
  switch (fidelity) {
    case Fidelity::quick:
      return {14 * d, 5 * d};
    case Fidelity::standard:
      return {20 * d, 6 * d};
    case Fidelity::paper:
      break;
  }
  return {43 * d, 13 * d};
}

struct FunnelSize {
  double radius = 0;  // [m] of the plate and of the cylinder
  int count = 0;
};

FunnelSize FunnelSizeOf(Fidelity fidelity, double d) {
  switch (fidelity) {
    case Fidelity::quick:
      return {7 * d, 450};
    case Fidelity::standard:
      return {11 * d, 1750};
    case Fidelity::paper:
      break;
  }
  return {24 * d, 15'000};
}

// Keeps the lowest layer on the plate, as the lip of a laboratory's does.
double RimHeight(double d) { return d; }

// Just above the largest heap.
double OutletHeight(double plate_radius, double d) {
  return RimHeight(d) + 0.75 * plate_radius + d;
}

double BinWidth(double d) { return d / 2; }

double Gravity(const Program& program) { return std::abs(program.gravity[2]); }

// Until rest, or for `longest`, after something was opened.
Settle Flow(double longest, double shortest, double gravity, double d) {
  return {.kinetic_energy_ratio = kRestRatio,
          .check_interval = 0.16 * std::sqrt(d / gravity),
          .min_duration = std::min(shortest, longest),
          .max_duration = longest};
}

const Settle* LastSettle(const Program& program) {
  const auto stage = std::find_if(program.stages.rbegin(), program.stages.rend(),
                                  [](const Stage& s) { return std::holds_alternative<Settle>(s); });
  return stage == program.stages.rend() ? nullptr : &std::get<Settle>(*stage);
}

// A ring of vertices at a height, first of kSides.
void AddRing(double radius, double height, Mesh* mesh) {
  for (int side = 0; side < kSides; ++side) {
    const double angle = 2 * pi * side / kSides;
    mesh->vertices.push_back({radius * std::cos(angle), radius * std::sin(angle), height});
  }
}

Mesh DiscMesh(const std::string& name, double radius, double height) {
  Mesh mesh{.name = name};
  AddRing(radius, height, &mesh);
  mesh.vertices.push_back({0, 0, height});
  for (int side = 0; side < kSides; ++side) {
    mesh.triangles.push_back({kSides, side, (side + 1) % kSides});
  }
  return mesh;
}

// Quadrilaterals between two rings, by their first vertices.
void JoinRings(int lower, int upper, Mesh* mesh) {
  for (int side = 0; side < kSides; ++side) {
    const int next = (side + 1) % kSides;
    mesh->triangles.push_back({lower + side, lower + next, upper + next});
    mesh->triangles.push_back({lower + side, upper + next, upper + side});
  }
}

Mesh PlateWithRim(double radius, double rim) {
  Mesh mesh = DiscMesh(kPlate, radius, 0);
  AddRing(radius, rim, &mesh);
  JoinRings(0, kSides + 1, &mesh);
  return mesh;
}

// Surface of revolution through (radius, height) pairs.
Mesh Round(const std::string& name, const std::vector<std::array<double, 2>>& line) {
  Mesh mesh{.name = name};
  for (const auto& [radius, height] : line) AddRing(radius, height, &mesh);
  for (int ring = 0; ring + 1 < static_cast<int>(line.size()); ++ring) {
    JoinRings(ring * kSides, (ring + 1) * kSides, &mesh);
  }
  return mesh;
}

// Mean height of a surface over a coordinate, in bins of about `bin_width` from 0 to `end`.
HeightProfile ProfileOf(const HeightField& field, double end, double bin_width,
                        const std::function<double(std::size_t, std::size_t)>& coordinate) {
  HeightProfile profile;
  const std::size_t bins = CountThatFit(end, bin_width);
  profile.bin_width = end / static_cast<double>(bins);
  profile.heights.assign(bins, 0);
  std::vector<double> counts(bins, 0);
  for (std::size_t iy = 0; iy < field.ny; ++iy) {
    for (std::size_t ix = 0; ix < field.nx; ++ix) {
      const auto bin = static_cast<std::size_t>(coordinate(ix, iy) / profile.bin_width);
      if (bin >= bins) continue;
      profile.heights[bin] += field.At(ix, iy);
      counts[bin] += 1;
    }
  }
  for (std::size_t bin = 0; bin < bins; ++bin) {
    profile.heights[bin] /= std::max(1.0, counts[bin]);
  }
  return profile;
}

FlankFit FitFace(const HeightProfile& profile, double d) {
  return FitFlank(profile, {.min_drop = 2 * d, .min_bins = kFewestBins});
}

// What the profile says of the face's inclination [rad], and whether that is a lower bound only.
struct Inclination {
  double angle = 0;
  double error = 0;
  bool is_bound = false;
};

Inclination InclinationOf(const FlankFit& fit, double bin_width) {
  if (fit.bins >= kFewestBins) return {fit.angle, fit.angle_error, false};
  const double widest = static_cast<double>(fit.bins + 1) * bin_width;
  return {std::atan((fit.upper - fit.lower) / widest), 0, true};
}

void ReportFace(const FlankFit& fit, double bin_width, Measurement* measurement) {
  auto& notes = measurement->diagnostics;
  const bool no_face = fit.state == FlankFit::State::no_flank;
  notes["no_face"] = no_face ? 1 : 0;
  notes["cliff"] = fit.state == FlankFit::State::cliff ? 1 : 0;
  notes["angle_is_bound"] = 0;
  if (no_face) return;
  const Inclination face = InclinationOf(fit, bin_width);
  measurement->responses["angle"] = {face.angle, face.error * face.error};
  notes["angle_is_bound"] = face.is_bound ? 1 : 0;
  notes["angle_degrees"] = face.angle * 180 / pi;
  notes["face_start"] = fit.start;
  notes["face_end"] = fit.end;
  notes["face_lower"] = fit.lower;
  notes["face_upper"] = fit.upper;
  notes["face_bins"] = static_cast<double>(fit.bins);
  notes["r_squared"] = fit.r_squared;
}

}  // namespace

const std::string& AngleOfRepose::name() const {
  static const std::string kName = "angle_of_repose";
  return kName;
}

std::span<const ResponseDescription> AngleOfRepose::responses() const {
  static const ResponseDescription kAngle = {
      "angle", "rad", "inclination of the face that stays; beyond 75 deg it is a cliff"};
  static const std::vector<ResponseDescription> kDrawDown = {
      kAngle,
      {"poured_void_ratio", "1", "void over solid volume of the bed before the gate is opened"},
      {"retained_mass", "1", "share of the powder's mass that stays on the floor"}};
  static const std::vector<ResponseDescription> kFromFunnel = {
      kAngle,
      {"discharged_share", "1", "share of the powder's mass that has left the funnel"},
      {"retained_mass", "1", "share of the powder's mass that stays on the plate"}};
  return method_ == Method::draw_down ? kDrawDown : kFromFunnel;
}

void AngleOfRepose::Serialize(Archive& archive) {
  archive.Enumeration("method", method_, "method", MethodNames());
  if (method_ == Method::draw_down) {
    archive.Quantity("bed_aspect", bed_aspect_, "1", {.lower = 0.1, .upper = 2});
    archive.Enumeration("sides", sides_, "sides", SidesNames());
  } else {
    archive.Quantity("outlet", outlet_diameters_, "1", {.lower = 2, .upper = 12});
  }
  archive.Quantity("flow_time", flow_time_, "s", kPositive);
}

void AngleOfRepose::DescribeConditions(Fidelity fidelity, Conditions& conditions) const {
  const double d = conditions.diameter.value();
  conditions.bulk_solid_fraction = kSettledFraction;
  if (method_ == Method::draw_down) {
    const BedSize bed = BedSizeOf(fidelity, d);
    conditions.width = bed.width;
    conditions.bed_height = bed_aspect_ * bed.length;
  } else {
    conditions.width = 2 * FunnelSizeOf(fidelity, d).radius;
  }
}

std::string AngleOfRepose::ExplainUnsupported(const SimulatedPowder& powder) const {
  if (powder.law.tangential == ContactLaw::Tangential::no_history) {
    return "friction without history lets every heap creep until it is flat: "
           "contact_law.tangential "
           "must be history";
  }
  const double outlet = outlet_diameters_ * powder.sizes.Moment(1);
  if (method_ == Method::funnel && outlet < 2 * powder.sizes.Quantile(1)) {
    return fmt::format("an outlet of {} is too narrow for particles of {}",
                       HumanQuantity(outlet, "m"), HumanQuantity(powder.sizes.Quantile(1), "m"));
  }
  return "";
}

Program AngleOfRepose::Plan(const SimulatedPowder& powder, const Conditions& conditions,
                            const Numerics& numerics, Fidelity fidelity, std::uint64_t seed) const {
  if (const std::string why = ExplainUnsupported(powder); !why.empty()) throw InputError(why);
  const double gravity = conditions.gravity.value();
  if (!(gravity > 0)) throw InputError("an angle of repose needs gravity");
  Program program{.experiment = name(), .fidelity = fidelity};
  program.particles = {.sizes = powder.sizes, .seed = seed};
  program.materials = powder.materials;
  program.law = powder.law;
  program.gravity = {0, 0, -gravity};
  program.time_step = numerics.TimeStep(powder);
  if (method_ == Method::draw_down) {
    PlanDrawDown(fidelity, conditions.speed_ratio, &program);
  } else {
    PlanFunnel(fidelity, conditions.speed_ratio, &program);
  }
  return program;
}

double AngleOfRepose::FlowTime(double by_default, double speed_ratio) const {
  return flow_time_ ? *flow_time_ / speed_ratio : by_default;
}

void AngleOfRepose::PlanDrawDown(Fidelity fidelity, double speed_ratio, Program* program) const {
  Particles& particles = program->particles;
  const double d = particles.sizes.Moment(1);
  const double gravity = Gravity(*program);
  const BedSize bed = BedSizeOf(fidelity, d);
  const double height = bed_aspect_ * bed.length;
  const double volume = bed.length * bed.width * height;
  particles.count =
      static_cast<int>(std::lround(kSettledFraction * volume / MeanSphereVolume(particles.sizes)));
  const double top = height * kSettledFraction / kLooseFraction;
  particles.packing = PourLoose(particles, {.lower = {0, 0, 0},
                                            .upper = {bed.length, bed.width, top},
                                            .periodic_y = sides_ == Sides::periodic,
                                            .fall_speed = kFallSpeed * speed_ratio});
  program->domain = {{-d, 0, -d},
                     {bed.length + d / 2, bed.width, top + 2 * d},
                     {Boundary::outflow, Boundary::periodic, Boundary::open}};
  program->walls = {{.name = "floor", .position = 0},
                    {.name = kBackWall, .axis = 0, .position = 0},
                    {.name = kGate, .axis = 0, .position = bed.length, .facing_positive = false}};
  if (sides_ == Sides::walls) EncloseBetweenWalls(1, program);
  const double longest = FlowTime(10 * std::sqrt(bed.length / gravity), speed_ratio);
  program->stages = {SettleAfterFall(top - height, kFallSpeed * speed_ratio, gravity, d),
                     Remove{kGate}, Flow(longest, 2 * std::sqrt(2 * height / gravity), gravity, d)};
}

void AngleOfRepose::PlanFunnel(Fidelity fidelity, double speed_ratio, Program* program) const {
  Particles& particles = program->particles;
  const double d = particles.sizes.Moment(1);
  const double gravity = Gravity(*program);
  const auto [radius, count] = FunnelSizeOf(fidelity, d);
  particles.count = count;
  const double outlet = outlet_diameters_ * d / 2;
  const double bottom = OutletHeight(radius, d);
  const double cone_top = bottom + (radius - outlet) / std::tan(kConeAngle);
  const double half = 0.98 * radius * std::cos(pi / kSides) / std::numbers::sqrt2;
  const double top =
      cone_top + count * MeanSphereVolume(particles.sizes) / (kLooseFraction * 4 * half * half);
  particles.packing = PourLoose(particles, {.lower = {-half, -half, cone_top},
                                            .upper = {half, half, top},
                                            .periodic_y = false,
                                            .fall_speed = kFallSpeed * speed_ratio});
  const double side = radius + 3 * d;
  program->domain = {{-side, -side, -3 * d},
                     {side, side, top + 3 * d},
                     {Boundary::outflow, Boundary::outflow, Boundary::outflow}};
  program->meshes = {PlateWithRim(radius, RimHeight(d)),
                     Round(kFunnel, {{outlet, bottom}, {radius, cone_top}, {radius, top + 2 * d}}),
                     DiscMesh(kPlug, outlet, bottom)};
  const double longest = FlowTime(20 * std::sqrt(radius / gravity), speed_ratio);
  program->stages = {SettleAfterFall(top - bottom, kFallSpeed * speed_ratio, gravity, d),
                     Remove{kPlug}, Flow(longest, 3 * std::sqrt(2 * bottom / gravity), gravity, d)};
}

// As measured at quick: settling takes its shortest time, the flow about half of its limit.
double AngleOfRepose::ExpectedDuration(const Program& program) const {
  const Settle& settle = std::get<Settle>(program.stages.front());
  const Settle& flow = std::get<Settle>(program.stages.back());
  return 1.2 * settle.min_duration + 0.5 * flow.max_duration;
}

Measurement AngleOfRepose::Measure(const Program& program, const Trace& trace,
                                   Outcome* outcome) const {
  Measurement measurement;
  for (const auto& [response, reported] : trace.reported) {
    measurement.responses[response] = {reported.value, reported.variance};
  }
  if (!trace.reported.empty()) return measurement;
  // Both stages that wait for rest leave a moment of the same name.
  std::vector<const Moment*> moments;
  for (const Moment& moment : trace.moments) {
    if (moment.name == "settle") moments.push_back(&moment);
  }
  const Settle* flow = LastSettle(program);
  if (moments.size() < 2 || flow == nullptr) {
    *outcome = {Reason::crashed, "the trace has no packing before or after the opening"};
    return measurement;
  }
  const Moment& settled = *moments.front();
  const Moment& end = *moments.back();
  const double d = program.particles.sizes.Moment(1);
  const FlankFit fit = method_ == Method::draw_down
                           ? MeasureDrawDown(program, settled, end, &measurement)
                           : MeasureFunnel(program, end, &measurement);
  ReportFace(fit, BinWidth(d), &measurement);
  const double motion = KineticEnergyRatio(end.packing, Gravity(program));
  auto& notes = measurement.diagnostics;
  notes["kinetic_energy_ratio"] = motion;
  notes["at_rest"] = motion < flow->kinetic_energy_ratio ? 1 : 0;
  notes["leavers"] = static_cast<double>(trace.diagnostics.leavers);
  notes["particles"] = static_cast<double>(program.particles.count);
  notes["flow_time"] = end.time - settled.time;
  notes["simulated_time"] = end.time;
  return measurement;
}

FlankFit AngleOfRepose::MeasureDrawDown(const Program& program, const Moment& settled,
                                        const Moment& end, Measurement* measurement) const {
  const double d = program.particles.sizes.Moment(1);
  const BedSize bed = BedSizeOf(program.fidelity, d);
  const bool periodic = sides_ == Sides::periodic;
  PlateWindow window{.x0 = 0,
                     .x1 = bed.length,
                     .y0 = 0,
                     .y1 = bed.width,
                     .plate = 0,
                     .period_y = periodic ? bed.width : 0};
  const double pixel = d / kSurfacePixels;
  const double height =
      MeasureSurface(MeasureHeightField(settled.packing, window, pixel)).thickness;
  measurement->diagnostics["bed_height"] = height;
  measurement->diagnostics["bed_length"] = bed.length;
  const std::optional<BoxRegion> middle =
      CentralRegion({{0, 0, 0}, {bed.length, bed.width, height}}, 3 * d, 0);
  if (middle) {
    const std::vector<WallPlane> walls = {{.height = 0, .facing_up = true}};
    const Contacts contacts = FindContacts(settled.packing, program.domain, walls);
    measurement->responses["poured_void_ratio"].value =
        RegionVoidRatio(settled.packing, contacts, program.domain, *middle).value;
  }
  measurement->responses["retained_mass"].value =
      SolidVolume(end.packing) / SolidVolume(*program.particles.packing);
  // Beyond the floor's end as well, so that a face that stands there is seen to fall.
  window.x1 += 2 * d;
  const HeightField field = MeasureHeightField(end.packing, window, pixel);
  return FitFace(ProfileOf(field, window.x1, BinWidth(d),
                           [&field](std::size_t ix, std::size_t) {
                             return (static_cast<double>(ix) + 0.5) * field.pixel_x;
                           }),
                 d);
}

FlankFit AngleOfRepose::MeasureFunnel(const Program& program, const Moment& end,
                                      Measurement* measurement) const {
  const double d = program.particles.sizes.Moment(1);
  const double radius = FunnelSizeOf(program.fidelity, d).radius;
  const double bottom = OutletHeight(radius, d);
  Packing heap;
  Packing in_funnel;
  for (const Sphere& sphere : end.packing) {
    const auto& [x, y, z] = sphere.position;
    if (z >= bottom) in_funnel.push_back(sphere);
    if (z < bottom && z > 0 && std::hypot(x, y) < radius) heap.push_back(sphere);
  }
  const double all = SolidVolume(*program.particles.packing);
  measurement->responses["retained_mass"].value = SolidVolume(heap) / all;
  measurement->responses["discharged_share"].value = 1 - SolidVolume(in_funnel) / all;
  measurement->diagnostics["plate_radius"] = radius;
  measurement->diagnostics["outlet_diameter"] = outlet_diameters_ * d;
  const double side = radius + 2 * d;
  const PlateWindow window{.x0 = -side, .x1 = side, .y0 = -side, .y1 = side};
  const HeightField field = MeasureHeightField(heap, window, d / kSurfacePixels);
  HeightProfile profile = ProfileOf(field, side, BinWidth(d), [&](std::size_t ix, std::size_t iy) {
    return std::hypot((static_cast<double>(ix) + 0.5) * field.pixel_x - side,
                      (static_cast<double>(iy) + 0.5) * field.pixel_y - side);
  });
  for (double& height : profile.heights) height = std::max(0.0, height - RimHeight(d));
  return FitFace(profile, d);
}

}  // namespace powdercal

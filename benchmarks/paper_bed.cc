#include "benchmarks/paper_bed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/table.h"
#include "experiments/packing_measures.h"

namespace powdercal::benchmarks {
namespace {

constexpr const char* kFloor = "floor";
constexpr const char* kLid = "lid";
constexpr double kDensity = 8220;          // [kg/m3]
constexpr double kPoissonRatio = 0.3;      // [-]
constexpr double kTypicalFraction = 0.55;  // of a settled bed, for estimates of time

SizeDistribution SizesOf(const BedSetup& setup) {
  const double d = setup.diameter;
  switch (setup.sizes) {
    case BedSetup::Sizes::equal:
      break;
    case BedSetup::Sizes::narrow:
      return {SizeDistribution::Kind::normal, d, 2e-6, d - 6e-6, d + 6e-6};
    case BedSetup::Sizes::wide:
      return {SizeDistribution::Kind::normal, d, 6e-6, 12.5e-6, 37.5e-6};
  }
  return {.kind = SizeDistribution::Kind::monodisperse, .mean = d};
}

Materials MaterialsOf(const BedSetup& setup, double cohesion, double rolling) {
  const ContactParameters contact = {.restitution = setup.restitution,
                                     .friction = setup.friction,
                                     .rolling_friction = setup.no_rolling ? 0 : rolling,
                                     .cohesion_energy_density = setup.cohesion_factor * cohesion};
  Materials materials{.density = kDensity,
                      .young_modulus = setup.young_modulus,
                      .poisson_ratio = kPoissonRatio,
                      .particle_particle = contact,
                      .particle_wall = contact};
  if (!setup.sticky_walls) {
    materials.particle_wall.cohesion_energy_density = 0;
    materials.particle_wall.rolling_friction = 0;
  }
  return materials;
}

// Time of a fall over a distance from an initial speed [s].
double TimeOfFall(double distance, double speed, double gravity) {
  if (gravity <= 0) return speed > 0 ? distance / speed : 0;
  return (std::sqrt(speed * speed + 2 * gravity * distance) - speed) / gravity;
}

Settle SettleOf(const BedSetup& setup, double top) {
  const double sink =
      setup.drop + (top - setup.drop) * (1 - setup.solid_fraction / kTypicalFraction);
  const double fall = TimeOfFall(sink, setup.velocity, setup.gravity);
  const double own_time = std::sqrt(setup.diameter / setup.gravity);
  if (setup.settle_time > 0) {
    return {.kinetic_energy_ratio = 0,
            .check_interval = 0.16 * own_time,
            .min_duration = setup.settle_time,
            .max_duration = setup.settle_time};
  }
  return {.kinetic_energy_ratio = 0.18,
          .check_interval = 0.16 * own_time,
          .min_duration = 1.2 * fall,
          .max_duration = 4 * fall + 0.02};
}

double Fraction(double void_ratio) { return 1 / (1 + void_ratio); }

}  // namespace

const std::vector<TableRow>& Table3() {
  static const std::vector<TableRow> kRows = [] {
    const Table table =
        Table::ReadCsv(POWDERCAL_SOURCE_DIR "/studies/library/hastelloy_x_table3.csv");
    const std::vector<double>& k = table.Get("cohesion_energy_density", "J/m3").values;
    const std::vector<double>& mu_r = table.Get("rolling_friction", "1").values;
    const std::vector<double>& e = table.Get("consolidation.void_ratio", "1").values;
    std::vector<TableRow> rows;
    for (std::size_t n = 0; n < table.row_count(); ++n) {
      const std::size_t initial = 5;
      std::string name =
          n < initial ? fmt::format("0-{}", n + 1) : fmt::format("{}", n - initial + 1);
      if (n + 1 == table.row_count()) name = "best";
      rows.push_back({std::move(name), k[n], mu_r[n], e[n]});
    }
    return rows;
  }();
  return kRows;
}

Program MakeBed(const BedSetup& setup, double cohesion, double rolling, std::uint64_t seed) {
  Program program{.experiment = "paper_consolidation"};
  program.parameters = {{"cohesion_energy_density", cohesion}, {"rolling_friction", rolling}};
  program.particles = {.sizes = SizesOf(setup), .count = setup.particles, .seed = seed};
  program.materials = MaterialsOf(setup, cohesion, rolling);
  program.law = setup.law;
  const double d = setup.diameter;
  const double width = setup.Width();
  const double solid = setup.particles * std::numbers::pi / 6 * program.particles.sizes.Moment(3);
  const double top = setup.drop + solid / (width * width * setup.solid_fraction);
  program.domain.lower = {0, 0, -0.5 * d};
  program.domain.upper = {width, width, top + 2 * d};
  program.walls = {{.name = kFloor, .position = 0, .facing_positive = true},
                   {.name = kLid, .position = top + d, .facing_positive = false}};
  program.gravity = {0, 0, -setup.gravity};
  program.time_step = setup.time_step;
  program.stages = {Insert{.bottom = setup.drop, .top = top, .velocity = {0, 0, -setup.velocity}},
                    SettleOf(setup, top)};
  if (setup.stress > 0) {
    const double bed = solid / (width * width * kTypicalFraction);
    program.stages.push_back(Servo{.wall = kLid,
                                   .stress = setup.stress,
                                   .max_velocity = setup.lid_speed,
                                   .max_duration = 0.01 + bed / (0.1 * setup.lid_speed)});
  }
  const int steps = static_cast<int>(std::lround(setup.hold / setup.time_step));
  program.stages.push_back(Advance{.name = "hold",
                                   .duration = setup.hold,
                                   .packing_every = std::max(1, steps / BedSetup::kReadings)});
  return program;
}

Reading Read(const Program& program, const Packing& packing, std::optional<double> lid_height,
             double stress) {
  const double d = program.particles.sizes.Moment(1);
  std::vector<double> heights;
  for (const Sphere& sphere : packing) heights.push_back(sphere.position[2]);
  const auto nth =
      heights.begin() +
      static_cast<std::ptrdiff_t>(std::llround(0.99 * static_cast<double>(heights.size() - 1)));
  std::nth_element(heights.begin(), nth, heights.end());
  const double bed_top = *nth + d / 2;
  // A lid that is not in play yet stands where it was put.
  const bool lid = lid_height.has_value() && stress > 0;
  const double top = lid ? *lid_height : bed_top;
  const double far = program.domain.upper[2] + d;
  const std::array<WallPlane, 2> planes = {WallPlane{0, true}, WallPlane{lid ? top : far, false}};
  const Contacts contacts = FindContacts(packing, program.domain, planes);
  const VoidRatio central = CentralVoidRatio(packing, contacts, program.domain, 0, top);
  Reading reading{.height = top, .stress = lid ? stress : 0};
  reading.central = central.value;
  reading.less_overlaps = central.overlap_corrected;
  if (lid) {
    reading.wall_to_wall = WallToWallVoidRatio(packing, contacts, program.domain, 0, top).value;
  } else {
    reading.wall_to_wall = MeasureVoidRatio(packing, contacts, program.domain, 0, top).value;
  }
  const SizeDistribution& sizes = program.particles.sizes;
  const double share = d * d * d / sizes.Moment(3);
  reading.mean_diameter = 1 / (Fraction(reading.wall_to_wall) * share) - 1;
  reading.coordination = MeasureContacts(packing, contacts).coordination_number;
  const double mass = kDensity * std::numbers::pi / 6 * sizes.Moment(3);
  const double unit = mass * -program.gravity[2] * d * static_cast<double>(packing.size());
  reading.kinetic = KineticEnergy(packing, kDensity) / unit;
  return reading;
}

std::vector<Reading> ReadAll(const Program& program, const Trace& trace) {
  std::vector<Reading> readings;
  double settled = 0;
  for (const Moment& moment : trace.moments) {
    std::optional<double> height;
    double stress = 0;
    if (const auto lid = moment.walls.find(kLid);
        lid != moment.walls.end() && moment.name != "settle") {
      height = lid->second.height;
      stress = lid->second.force[2] / program.domain.BaseArea();
    }
    if (moment.name == "settle") settled = moment.time;
    Reading reading = Read(program, moment.packing, height, stress);
    reading.moment = moment.name;
    reading.time = moment.time - settled;
    readings.push_back(std::move(reading));
  }
  return readings;
}

nlohmann::json ToJson(const Reading& r) {
  return {{"moment", r.moment},
          {"time", r.time},
          {"height", r.height},
          {"stress", r.stress},
          {"central", r.central},
          {"wall_to_wall", r.wall_to_wall},
          {"less_overlaps", r.less_overlaps},
          {"mean_diameter", r.mean_diameter},
          {"coordination", r.coordination},
          {"kinetic", r.kinetic}};
}

Reading ReadingFromJson(const nlohmann::json& json) {
  return {.moment = json.at("moment"),
          .time = json.at("time"),
          .height = json.at("height"),
          .stress = json.at("stress"),
          .central = json.at("central"),
          .wall_to_wall = json.at("wall_to_wall"),
          .less_overlaps = json.at("less_overlaps"),
          .mean_diameter = json.at("mean_diameter"),
          .coordination = json.at("coordination"),
          .kinetic = json.at("kinetic")};
}

}  // namespace powdercal::benchmarks

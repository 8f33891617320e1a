#include "experiments/consolidation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "experiments/packing_measures.h"
#include "experiments/pouring.h"
#include "scaling/groups.h"

namespace powdercal {
namespace {

constexpr const char* kFloor = "floor";
constexpr const char* kLid = "lid";
constexpr double kTypicalSolidFraction = 0.55;
// Beyond an overlap of R* (a whole radius of equal spheres: half of it each) contact laws mean
// nothing.
constexpr double kMaxOverlap = 1.0;

struct Cell {
  int count = 0;
  double width = 0;  // [m]
};

Cell CellOf(Fidelity fidelity, double diameter) {
  switch (fidelity) {
    case Fidelity::quick:
      return {1000, 10 * diameter};
    case Fidelity::standard:
      return {3000, 14.4 * diameter};
    case Fidelity::paper:
      break;
  }
  return {500'000, 2e-3};
}

// Height [m] of a bed of `count` spheres at a solid fraction.
double BedHeight(const Cell& cell, double third_moment, double solid_fraction) {
  return cell.count * std::numbers::pi / 6 * third_moment /
         (cell.width * cell.width * solid_fraction);
}

// Largest I while the lid moves down, from its height at even intervals.
double LoadingInertialNumber(const WallSeries& series, double inertial_time) {
  double largest = 0;
  for (std::size_t i = 1; i < series.time.size(); ++i) {
    const double rate = (series.height[i - 1] - series.height[i]) /
                        (series.time[i] - series.time[i - 1]) / series.height[i];
    if (series.normal_force[i] > 0) largest = std::max(largest, rate * inertial_time);
  }
  return largest;
}

}  // namespace

const std::string& Consolidation::name() const {
  static const std::string kName = "consolidation";
  return kName;
}

std::span<const ResponseDescription> Consolidation::responses() const {
  static const std::vector<ResponseDescription> kResponses = {
      {"bulk_density", "kg/m3", "mass over volume of the loaded bed, away from the walls"},
      {"void_ratio", "1", "void over solid volume of the loaded bed, away from the walls"},
      {"void_ratio_wall_to_wall", "1", "the same over the whole height of the cell"},
  };
  return kResponses;
}

void Consolidation::Serialize(Archive& archive) {
  archive.Require("stress");
  archive.Quantity("stress", stress_, "Pa", kPositive);
  archive.Enumeration("sides", sides_, "sides", SidesNames());
  archive.Quantity("initial_solid_fraction", initial_solid_fraction_, "1",
                   {.lower = 0.05, .upper = 0.36});
  archive.Quantity("initial_velocity", initial_velocity_, "m/s", kNonNegative);
  archive.Quantity("max_load_time", max_load_time_, "1", kPositive);
  archive.Integer("max_hold_windows", max_hold_windows_, {.lower = 1, .upper = 1e6});
}

void Consolidation::DescribeConditions(Fidelity fidelity, Conditions& conditions) const {
  const double d = conditions.diameter.value();
  const Cell cell = CellOf(fidelity, d);
  conditions.stress = stress_;
  conditions.bulk_solid_fraction = kTypicalSolidFraction;
  conditions.width = cell.width;
  conditions.bed_height = BedHeight(cell, d * d * d, kTypicalSolidFraction);
}

Program Consolidation::Plan(const SimulatedPowder& powder, const Conditions& conditions,
                            const Numerics& numerics, Fidelity fidelity, std::uint64_t seed) const {
  const double d = powder.sizes.Moment(1);
  const double gravity = conditions.gravity.value();
  const double stress = conditions.stress.value();
  const Cell cell = CellOf(fidelity, d);
  const double top = BedHeight(cell, powder.sizes.Moment(3), initial_solid_fraction_);
  const double inertial_time = d * std::sqrt(powder.materials.density / stress);

  Program program{.experiment = name(), .fidelity = fidelity};
  program.particles = {.sizes = powder.sizes, .count = cell.count, .seed = seed};
  program.materials = powder.materials;
  program.law = powder.law;
  program.domain.lower = {0, 0, -0.5 * d};
  program.domain.upper = {cell.width, cell.width, top + 2 * d};
  program.walls = {{.name = kFloor, .position = 0, .facing_positive = true},
                   {.name = kLid, .position = top, .facing_positive = false}};
  if (sides_ == Sides::walls) {
    EncloseBetweenWalls(0, &program);
    EncloseBetweenWalls(1, &program);
  }
  program.gravity = {0, 0, -gravity};
  program.time_step = numerics.TimeStep(powder);
  const double velocity = initial_velocity_ * conditions.speed_ratio;
  program.stages.push_back(Insert{.bottom = 0, .top = top, .velocity = {0, 0, -velocity}});

  // The bed sinks by about (1 − phi0/phi) of its height; from rest, the first check would otherwise
  // find it "at rest" before it has begun to fall.
  const double sink = top * (1 - initial_solid_fraction_ / kTypicalSolidFraction);
  const double fall = FallTime(std::max(sink, d), velocity, gravity);
  const double gravity_time = gravity > 0 ? std::sqrt(d / gravity) : fall;
  program.stages.push_back(Settle{.kinetic_energy_ratio = 0.18,
                                  .check_interval = 0.16 * gravity_time,
                                  .min_duration = 0.5 * fall,
                                  .max_duration = 20 * fall});
  const double bed = BedHeight(cell, powder.sizes.Moment(3), kTypicalSolidFraction);
  program.stages.push_back(Servo{.wall = kLid,
                                 .stress = stress,
                                 .max_velocity = 0.1 * conditions.speed_ratio,
                                 .max_duration = max_load_time_ * inertial_time * bed / d});
  const double window = 6 * inertial_time * std::max(1.0, bed / (12 * d));
  program.stages.push_back(
      Hold{.stress_tolerance = 0.02,
           .strain_rate = std::min(0.1 * conditions.speed_ratio, 1e-5 / inertial_time),
           .kinetic_energy_ratio = 1e-3,
           .window = window,
           .max_duration = max_hold_windows_ * window});
  return program;
}

// As measured at quick: settling takes about the time of the fall, loading about as long as five
// windows of the hold, and the hold itself three to ten.
double Consolidation::ExpectedDuration(const Program& program) const {
  const Settle& settle = std::get<Settle>(program.stages[1]);
  const Hold& hold = std::get<Hold>(program.stages[3]);
  return settle.max_duration / 20 + 10 * hold.window;
}

Measurement Consolidation::Measure(const Program& program, const Trace& trace,
                                   Outcome* outcome) const {
  Measurement measurement;
  if (!trace.reported.empty()) {  // a backend that knows responses without a simulation
    for (const auto& [response, reported] : trace.reported) {
      measurement.responses[response] = {reported.value, reported.variance};
    }
    return measurement;
  }
  const Moment* end = trace.Find("hold");
  if (end == nullptr || !end->walls.contains(kLid)) {
    *outcome = {Reason::crashed, "the trace has no packing under load"};
    return measurement;
  }
  const WallState& lid = end->walls.at(kLid);
  const double floor = program.walls[0].position;
  const std::array<WallPlane, 2> planes = {WallPlane{floor, true}, WallPlane{lid.height, false}};
  const Contacts contacts = FindContacts(end->packing, program.domain, planes);
  const ContactStatistics statistics = MeasureContacts(end->packing, contacts);
  const VoidRatio central =
      CentralVoidRatio(end->packing, contacts, program.domain, floor, lid.height);
  const VoidRatio whole =
      WallToWallVoidRatio(end->packing, contacts, program.domain, floor, lid.height);

  const Materials& m = program.materials;
  const double target = std::get<Servo>(program.stages[2]).stress;
  const double stress = std::abs(lid.force[2]) / program.domain.BaseArea();
  const double inertial_time = program.particles.sizes.Moment(1) * std::sqrt(m.density / target);

  measurement.responses["void_ratio"].value = central.value;
  measurement.responses["void_ratio_wall_to_wall"].value = whole.value;
  measurement.responses["bulk_density"].value = m.density / (1 + central.value);
  auto& notes = measurement.diagnostics;
  notes["void_ratio_overlap_corrected"] = central.overlap_corrected;
  notes["void_ratio_rigid"] =
      central.value + StiffnessShift(central.value, statistics.mean_relative_overlap);
  notes["coordination_number"] = statistics.coordination_number;
  notes["mechanical_coordination_number"] = statistics.mechanical_coordination_number;
  notes["rattler_fraction"] = statistics.rattler_fraction;
  notes["max_overlap"] = statistics.max_overlap;
  notes["mean_relative_overlap"] = statistics.mean_relative_overlap;
  notes["stress"] = stress;
  notes["stress_ratio"] = stress / target;
  notes["kappa"] = StiffnessNumber(m.young_modulus, m.poisson_ratio, target);
  notes["inertial_number"] = std::abs(lid.velocity) / lid.height * inertial_time;
  if (const WallSeries* loading = trace.FindSeries(kLid)) {
    notes["inertial_number_loading"] = LoadingInertialNumber(*loading, inertial_time);
  }
  notes["bed_height"] = lid.height - floor;
  notes["simulated_time"] = end->time;
  if (statistics.max_overlap > kMaxOverlap) {
    *outcome = {
        Reason::unstable,
        fmt::format("overlaps of up to {:.2f} R*: the particles are too soft for {:.4g} Pa, or "
                    "the run has blown up",
                    statistics.max_overlap, target)};
  }
  return measurement;
}

}  // namespace powdercal

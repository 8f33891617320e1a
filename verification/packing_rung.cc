#include "verification/packing_rung.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "backends/insertion.h"
#include "experiments/packing_measures.h"

namespace powdercal::verification {
namespace {

constexpr int kCount = 1000;
constexpr double kWidth = 10;            // of the box, in mean diameters
constexpr double kSolidFraction = 0.30;  // of the packing at the start
constexpr double kLoading = 30;          // length of a load, in d √(rho/stress)
constexpr double kFirstLoading = 60;  // the lid has to come down first, and its servo to calm down
constexpr std::array<double, 3> kStresses = {0.5, 1, 2};  // over the subject's
constexpr std::size_t kWindows = 20;                      // over which the stress is averaged
constexpr const char* kLid = "lid";

struct Margin {
  std::string name;
  double value;
  const char* reason;
};

const std::vector<Margin>& Margins() {
  static const std::vector<Margin> kMargins = {
      {"coordination", 0.1, "2 % of a dense bed's"},
      {"stress_ratio", 0.02, "what the consolidation experiment tolerates"},
      {"void_ratio", 0.02,
       "two standard deviations of a measured void ratio, as the shipped "
       "studies assume them"},
  };
  return kMargins;
}

std::string LoadName(double stress) { return fmt::format("{:.4g} Pa", stress); }

double Solid(const Subject& subject) {
  return kCount * std::numbers::pi / 6 * subject.sizes.Moment(3);
}

}  // namespace

Program PackingProgram(const Subject& subject, std::uint64_t seed) {
  const double d = subject.sizes.Moment(1);
  const double width = kWidth * d;
  const double top = Solid(subject) / (width * width * kSolidFraction);
  const double speed =
      3.5e-3 * std::sqrt(subject.materials.young_modulus / subject.materials.density);
  Program program{.experiment = "packing"};
  program.materials = subject.materials;
  program.law = subject.law;
  program.time_step = subject.time_step;
  program.domain.lower = {0, 0, -0.5 * d};
  program.domain.upper = {width, width, top + 2 * d};
  program.domain.boundaries = {Boundary::open, Boundary::open, Boundary::open};
  program.walls = {{.name = "floor", .axis = 2, .position = 0},
                   {.name = kLid, .axis = 2, .position = top, .facing_positive = false}};
  for (const int axis : {0, 1}) {
    const char letter = "xy"[axis];
    program.walls.push_back(
        {.name = fmt::format("low_{}", letter), .axis = axis, .frictionless = true});
    program.walls.push_back({.name = fmt::format("high_{}", letter),
                             .axis = axis,
                             .position = width,
                             .facing_positive = false,
                             .frictionless = true});
  }
  program.particles = {.sizes = subject.sizes, .count = kCount, .seed = seed};
  program.particles.packing =
      PlaceParticles(program.particles, program.domain, {.top = top, .velocity = {0, 0, -speed}});
  program.stages = {Advance{.name = "settle", .duration = 0.5 * top / speed}};
  double loading = kFirstLoading;
  for (const double factor : kStresses) {
    const double stress = factor * subject.stress;
    const double duration = loading * d * std::sqrt(subject.materials.density / stress);
    program.stages.push_back(
        Servo{.wall = kLid, .stress = stress, .max_velocity = speed, .max_duration = duration});
    program.stages.push_back(Advance{.name = LoadName(stress), .duration = duration});
    loading = kLoading;
  }
  return program;
}

Measurement MeasurePacking(const Program& program, const Trace& trace, Outcome* outcome) {
  Measurement measurement;
  const WallSeries* series = trace.FindSeries(kLid);
  double stress = 0;
  for (const Stage& stage : program.stages) {
    if (const auto* servo = std::get_if<Servo>(&stage)) stress = servo->stress;
    const auto* load = std::get_if<Advance>(&stage);
    if (load == nullptr || stress <= 0) continue;
    const Moment* end = trace.Find(load->name);
    if (end == nullptr || !end->walls.contains(kLid) || series == nullptr) {
      *outcome = {Reason::crashed, fmt::format("the trace has no bed at {}", load->name)};
      return measurement;
    }
    const double lid = end->walls.at(kLid).height;
    const std::array<WallPlane, 2> planes = {WallPlane{0, true}, WallPlane{lid, false}};
    const Contacts contacts = FindContacts(end->packing, program.domain, planes);
    double force = 0;
    std::size_t windows = 0;
    const double beyond = end->time + 0.5 * program.time_step;
    for (std::size_t n = series->time.size(); n-- > 0 && windows < kWindows;) {
      if (series->time[n] > beyond) continue;
      force += series->normal_force[n];
      ++windows;
    }
    if (windows == 0) {
      *outcome = {Reason::crashed,
                  fmt::format("the trace has no force on the lid at {}", load->name)};
      return measurement;
    }
    const auto set = [&](const char* name, double value) {
      measurement.responses[fmt::format("{} at {}", name, load->name)].value = value;
    };
    set("void_ratio", CentralVoidRatio(end->packing, contacts, program.domain, 0, lid).value);
    set("coordination", MeasureContacts(end->packing, contacts).coordination_number);
    set("stress_ratio",
        std::abs(force) / static_cast<double>(windows) / program.domain.BaseArea() / stress);
  }
  return measurement;
}

std::span<const std::string> PackingQuantities() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names;
    for (const Margin& margin : Margins()) names.push_back(margin.name);
    return names;
  }();
  return kNames;
}

SeedCase PackingCase(const Subject& subject, int seeds,
                     const std::map<std::string, double>& margins) {
  SeedCase entry{.name = "bed", .measure = MeasurePacking};
  for (int seed = 1; seed <= seeds; ++seed) {
    entry.seeds.push_back(static_cast<std::uint64_t>(seed));
    entry.programs.push_back(PackingProgram(subject, entry.seeds.back()));
  }
  for (const double factor : kStresses) {
    for (const Margin& margin : Margins()) {
      const auto given = margins.find(margin.name);
      const bool own = given != margins.end();
      entry.comparisons.push_back(
          {.name = fmt::format("{} at {}", margin.name, LoadName(factor * subject.stress)),
           .unit = "1",
           .margin = own ? given->second : margin.value,
           .margin_reason = own ? "as given" : margin.reason});
    }
  }
  return entry;
}

}  // namespace powdercal::verification

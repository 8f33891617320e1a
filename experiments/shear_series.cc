#include "experiments/shear_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

#include "experiments/packing_measures.h"
#include "experiments/shear_cells.h"

namespace powdercal {
namespace {

// A stage that shears, with the times between which it ran.
struct ShearStage {
  std::string name;
  double begin = 0;  // [s]
  double end = 0;    // [s]
  double speed = 0;  // [1/s] shear rate, or [m/s] of the bottom platen
};

bool LeavesMoment(const Stage& stage) {
  return !std::holds_alternative<Insert>(stage) && !std::holds_alternative<Save>(stage) &&
         !std::holds_alternative<Restore>(stage) && !std::holds_alternative<Remove>(stage);
}

std::optional<double> SpeedOf(const Stage& stage) {
  if (const Deform* deform = std::get_if<Deform>(&stage)) return deform->shear_rate;
  if (const Advance* advance = std::get_if<Advance>(&stage)) {
    return -advance->motions.front().velocity[0];
  }
  return {};
}

std::vector<ShearStage> ShearStages(const Program& program, const Trace& trace) {
  std::vector<ShearStage> stages;
  std::size_t next = 0;
  double begin = 0;
  for (const Stage& stage : program.stages) {
    if (!LeavesMoment(stage)) continue;
    if (next == trace.moments.size()) return {};
    const Moment& moment = trace.moments[next++];
    if (moment.name != MomentName(stage)) return {};
    if (const std::optional<double> speed = SpeedOf(stage)) {
      stages.push_back({moment.name, begin, moment.time, *speed});
    }
    begin = moment.time;
  }
  return stages;
}

// Indices of the times in (begin, end].
std::pair<std::size_t, std::size_t> Between(const std::vector<double>& times, double begin,
                                            double end) {
  // A time at a border, but for rounding, belongs to the stage before.
  const double rounding = 1e-9 * end;
  const auto index = [&](double time) {
    return static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time + rounding) -
                                    times.begin());
  };
  return {index(begin), index(end)};
}

ShearSeries ReadCell(const CellSeries& cell, const ShearStage& stage, double solid_volume) {
  ShearSeries series;
  const auto [first, last] = Between(cell.time, stage.begin, stage.end);
  for (std::size_t i = first; i < last; ++i) {
    const Vector3& edges = cell.lengths[i];
    const StressPair stress = {cell.stress[i][2][2], -cell.stress[i][0][2]};
    series.push_back({.strain = stage.speed * (cell.time[i] - stage.begin),
                      .stress = stress,
                      .bulk = stress,
                      .bottom = stress,
                      .complementary = -cell.stress[i][2][0],
                      .void_ratio = edges[0] * edges[1] * edges[2] / solid_volume - 1});
  }
  return series;
}

// The three series of platens have windows of their own; each sample of the top is joined to those
// of the others that end next to it.
ShearSeries ReadPlatens(const Program& program, const Trace& trace, const ShearStage& stage) {
  ShearSeries series;
  const WallSeries& top = *trace.FindSeries(kTopPlaten);
  const WallSeries& bottom = *trace.FindSeries(kBottomPlaten);
  const SlabSeries& slab = trace.slab;
  const double area = program.domain.BaseArea();
  const PlatenLevels levels = LevelsOf(program.particles.sizes);
  const double gap = 0.5 * levels.ridge_depth - levels.bottom;
  const auto at = [&](const std::vector<double>& times, double time) {
    const auto [first, last] = Between(times, stage.begin, stage.end);
    const auto found = std::lower_bound(times.begin() + static_cast<std::ptrdiff_t>(first),
                                        times.begin() + static_cast<std::ptrdiff_t>(last), time);
    const auto index = static_cast<std::size_t>(found - times.begin());
    return index < last || first == last ? index : last - 1;
  };
  const auto [first, last] = Between(top.time, stage.begin, stage.end);
  double strain = 0;
  double before = stage.begin;
  for (std::size_t i = first; i < last; ++i) {
    const double time = top.time[i];
    const std::size_t b = at(bottom.time, time);
    const std::size_t s = at(slab.time, time);
    if (b >= bottom.time.size() || s >= slab.time.size()) break;
    strain += stage.speed * (time - before) / (top.height[i] + gap);
    before = time;
    series.push_back({.strain = strain,
                      .stress = {top.force[i][2] / area, -top.force[i][0] / area},
                      .bulk = {slab.stress[s][2][2], -slab.stress[s][0][2]},
                      .bottom = {-bottom.force[b][2] / area, bottom.force[b][0] / area},
                      .complementary = -slab.stress[s][2][0],
                      .void_ratio = 1 / std::max(1e-3, slab.solid_fraction[s]) - 1});
  }
  return series;
}

}  // namespace

std::string ReadShearRecord(const Program& program, const Trace& trace, ShearRecord* record) {
  *record = {};
  const std::vector<ShearStage> stages = ShearStages(program, trace);
  if (stages.empty()) return "the trace lacks moments of the program's stages";
  const bool platens = !program.meshes.empty();
  if (platens && (trace.FindSeries(kTopPlaten) == nullptr ||
                  trace.FindSeries(kBottomPlaten) == nullptr || trace.slab.time.empty())) {
    return "the trace lacks the stresses at the platens or in the slab between them";
  }
  const double solid_volume = SolidVolume(trace.moments.front().packing);
  for (const ShearStage& stage : stages) {
    const ShearSeries series =
        platens ? ReadPlatens(program, trace, stage) : ReadCell(trace.cell, stage, solid_volume);
    if (series.empty()) return fmt::format("nothing was recorded during {}", stage.name);
    if (stage.name.starts_with(kYieldPrefix)) {
      record->yields.back().push_back(series);
      continue;
    }
    const double strain = record->preshear.empty() ? 0 : record->preshear.back().strain;
    for (ShearSample sample : series) {
      sample.strain += strain;
      record->preshear.push_back(sample);
    }
    record->states.push_back(record->preshear.size());
    record->yields.emplace_back();
  }
  return "";
}

ShearSample MeanSample(std::span<const ShearSample> samples) {
  assert(!samples.empty());
  ShearSample mean{.strain = samples.back().strain};
  const double weight = 1 / static_cast<double>(samples.size());
  for (const ShearSample& sample : samples) {
    for (StressPair ShearSample::*pair :
         {&ShearSample::stress, &ShearSample::bulk, &ShearSample::bottom}) {
      (mean.*pair).normal += weight * (sample.*pair).normal;
      (mean.*pair).shear += weight * (sample.*pair).shear;
    }
    mean.complementary += weight * sample.complementary;
    mean.void_ratio += weight * sample.void_ratio;
  }
  return mean;
}

YieldPoint FindYieldPoint(std::span<const ShearSample> samples, double normal, double friction) {
  YieldPoint point;
  double most = 0;
  std::size_t first = 0;
  for (std::size_t last = 0; last < samples.size(); ++last) {
    while (samples[last].strain - samples[first].strain >= kYieldWindow) ++first;
    const double before = first > 0 ? samples[first - 1].strain : 0;
    if (samples[last].strain - before < 0.9 * kYieldWindow) continue;
    const ShearSample mean = MeanSample(samples.subspan(first, last + 1 - first));
    if (std::abs(mean.stress.normal / normal - 1) > kNormalStressTolerance) continue;
    const double strength = mean.stress.shear - friction * (mean.stress.normal - normal);
    if (point.reached && strength <= most) continue;
    most = strength;
    point = {.reached = true, .stress = mean.stress, .strain = mean.strain};
  }
  return point;
}

}  // namespace powdercal

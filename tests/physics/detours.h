#pragma once

#include "backends/insertion.h"
#include "tests/physics/determinism.h"

// Programs that save their state, do something else, and come back.

namespace powdercal::physics {

// The program with a save and a detour from which it comes back, before its last stage.
inline Program WithDetour(Program program, const std::vector<Stage>& detour) {
  const auto last = program.stages.end() - 1;
  std::vector<Stage> stages = {Save{"before"}};
  stages.insert(stages.end(), detour.begin(), detour.end());
  stages.push_back(Restore{"before"});
  program.stages.insert(last, stages.begin(), stages.end());
  return program;
}

inline Program WithSave(Program program) {
  program.stages.insert(program.stages.end() - 1, Save{"before"});
  return program;
}

inline Trace RunOn(const Program& program, const Way& way) {
  const RunContext context;
  Trace trace =
      embedded::StageRunner(program, context, {.isa = way.isa, .threads = way.threads}).Run();
  EXPECT_TRUE(trace.outcome.ok()) << trace.outcome.message;
  return trace;
}

template <typename T>
std::vector<T> LastOf(const std::vector<T>& values, std::size_t count) {
  EXPECT_GE(values.size(), count);
  return {values.end() - static_cast<std::ptrdiff_t>(count), values.end()};
}

// The last moment and the last windows of all series.
inline void ExpectSameEnd(const Trace& direct, const Trace& detour, double last_stage) {
  Trace end;
  end.moments = {direct.moments.back()};
  Trace other;
  other.moments = {detour.moments.back()};
  ExpectIdentical(end, other);
  EXPECT_GT(other.moments[0].time, end.moments[0].time) << "the clock goes on";
  const auto windows =
      static_cast<std::size_t>(last_stage / (100 * direct.diagnostics.time_step) + 0.5);
  ASSERT_EQ(direct.series.size(), detour.series.size());
  for (std::size_t n = 0; n < direct.series.size(); ++n) {
    SCOPED_TRACE(direct.series[n].wall);
    EXPECT_EQ(LastOf(direct.series[n].force, windows), LastOf(detour.series[n].force, windows));
    EXPECT_EQ(LastOf(direct.series[n].height, windows), LastOf(detour.series[n].height, windows));
  }
  if (direct.cell.time.empty()) return;
  EXPECT_EQ(LastOf(direct.cell.stress, windows), LastOf(detour.cell.stress, windows));
  EXPECT_EQ(LastOf(direct.cell.strain, windows), LastOf(detour.cell.strain, windows));
}

// 1000 spheres, pressed and sheared.
inline Program ShearedCell() {
  Program program = Cell(ContactLaw::Rolling::epsd2, 1e-3);
  const auto shear = std::get<Deform>(program.stages.back());
  Deform more = shear;
  more.name = "more";
  more.duration = 5e-4;
  more.edges[2].value = 400;
  program.stages.push_back(more);
  return program;
}

inline std::vector<Stage> CellDetour() {
  Deform detour{.name = "detour", .duration = 137 * 5e-7, .shear_rate = -400};
  detour.edges[1] = {EdgeControl::Kind::stress, 2000};
  return {detour, Advance{.name = "rest", .duration = 7 * 5e-7}};
}

// Spheres between a rough floor of glued ones and a ridged lid with a servo, behind a gate.
inline Program LoadedBed() {
  Program program = Grains(300, ContactLaw::Rolling::epsd2);
  const double width = 12 * kRadius;
  program.domain = {{-0.5 * width, -0.5 * width, -3 * kRadius},
                    {0.5 * width, 0.5 * width, 120 * kRadius},
                    {Boundary::open, Boundary::periodic, Boundary::open}};
  program.gravity = {0, 0, -kGravity};
  Packing packing = PlaceParticles(program.particles, program.domain,
                                   {kRadius, 100 * kRadius, {0.05, 0.02, -1}}, {});
  GluedGroup rough{.name = "rough"};
  for (int k = 0; k < 36; ++k) {
    const auto id = static_cast<std::int64_t>(packing.size()) + 1;
    packing.push_back(
        Ball(id, kRadius, {kRadius * (2 * (k % 6) - 5), kRadius * (2 * (k / 6) - 5), 0}));
    rough.ids.push_back(id);
  }
  program.particles.packing = packing;
  program.groups = {rough};
  program.walls = {{.name = "left", .axis = 0, .position = -0.5 * width},
                   {.name = "right", .axis = 0, .position = 0.5 * width, .facing_positive = false},
                   {.name = "floor", .position = -kRadius}};
  program.meshes = {embedded::MakeRidgedPlate("lid", {-0.5 * width, -0.5 * width, 115 * kRadius},
                                              width, width, width / 3, -kRadius, 3)};
  program.stages = {
      Advance{.name = "fall", .duration = 1.5e-3}, Servo{"lid", 900, 0.5, 1.5e-3},
      Advance{.name = "shear", .duration = 2e-4, .motions = {{"rough", {0, 0.05, 0}, {}, {}}}},
      Advance{.name = "more", .duration = 5e-4, .motions = {{"rough", {0, 0.05, 0}, {}, {}}}}};
  return program;
}

inline std::vector<Stage> BedDetour() {
  return {Servo{"lid", 300, 0.5, 133 * 5e-7}, Remove{"right"},
          Advance{.name = "detour",
                  .duration = 91 * 5e-7,
                  .motions = {{"rough", {0, -0.1, 0.02}, {}, {}}}}};
}

/// A run with and one without the detour; the last stage must last 5e-4 s. Gives the former.
inline Trace ExpectSameAfterDetour(const Program& program, const std::vector<Stage>& detour,
                                   const Way& way) {
  const Trace direct = RunOn(WithSave(program), way);
  Trace trace = RunOn(WithDetour(program, detour), way);
  ExpectSameEnd(direct, trace, 5e-4);
  return trace;
}

}  // namespace powdercal::physics

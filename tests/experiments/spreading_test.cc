#include "experiments/spreading.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "backends/registry.h"
#include "experiments/pouring.h"
#include "tests/experiments/powder_samples.h"

namespace powdercal {
namespace {

constexpr double kGap = 80e-6;

Spreading With(const std::string& options) { return WithOptions<Spreading>(options); }

const Advance& Sweep(const Program& program) { return std::get<Advance>(program.stages[1]); }

TEST(Spreading, PowderStandsBeforeTheBladeAndAboveThePlate) {
  for (const char* plate : {"rough", "smooth"}) {
    const Program program = PlanOf(With(std::string("plate: ") + plate), MetalPowder());
    const double width = program.domain.upper[1];
    EXPECT_LT(LargestOverlap(*program.particles.packing, width), 1e-15) << plate;
    const Packing free = FreeSpheres(*program.particles.packing, program.particles.count);
    ASSERT_EQ(free.size(), static_cast<std::size_t>(program.particles.count));
    for (const Sphere& sphere : free) {
      EXPECT_GE(sphere.position[0], sphere.radius);
      EXPECT_GE(sphere.position[2], sphere.radius);
      EXPECT_LT(sphere.position[2], program.meshes[0].vertices[2][2]) << "above the blade";
    }
  }
}

TEST(Spreading, HeapHoldsTheStatedSurplus) {
  const Program program = PlanOf(With("powder_surplus: 1.5"), MetalPowder());
  const double sweep = Sweep(program).duration * Sweep(program).motions[0].velocity[0];
  const double layer = 0.5 * kGap * program.domain.upper[1] * sweep;
  EXPECT_NEAR(program.particles.count * MeanSphereVolume(program.particles.sizes) / layer, 1.5,
              0.01);
}

TEST(Spreading, PaperSweepsSevenMillimetresOfFiftyThousandParticles) {
  const Program program = PlanOf(With("plate: smooth"), MetalPowder(), Fidelity::paper);
  EXPECT_EQ(program.particles.packing->size(), 50'000U);
  EXPECT_NEAR(Sweep(program).duration, 7e-3 / 0.025, 1e-12);
}

TEST(Spreading, BladeMovesAtTheSimulatedSpeedThroughTheGap) {
  const SimulatedPowder powder = MetalPowder();
  const Spreading spreading = With("{blade_speed: 25 mm/s, sweep: 1.5 mm, gap: 60 um}");
  Conditions conditions{.diameter = powder.sizes.Moment(1), .gravity = 9.81};
  spreading.DescribeConditions(Fidelity::quick, conditions);
  EXPECT_EQ(conditions.velocity, 0.025);
  conditions.velocity = 0.1;
  const Program program = spreading.Plan(powder, conditions, {}, Fidelity::quick, 1);
  EXPECT_EQ(Sweep(program).motions[0].velocity, (Vector3{0.1, 0, 0}));
  EXPECT_NEAR(Sweep(program).duration, 15e-3, 1e-12);
  double lowest = 1;
  for (const Vector3& vertex : program.meshes[0].vertices) lowest = std::min(lowest, vertex[2]);
  EXPECT_NEAR(lowest, 60e-6, 1e-15);
}

TEST(Spreading, RoughPlateIsALayerThatNothingFallsThrough) {
  const Program program = PlanOf(With("plate: rough"), MetalPowder());
  ASSERT_EQ(program.groups.size(), 1U);
  const std::vector<std::int64_t>& ids = program.groups[0].ids;
  EXPECT_EQ(ids.front(), program.particles.count + 1);
  Packing layer(program.particles.packing->begin() + program.particles.count,
                program.particles.packing->end());
  ASSERT_EQ(layer.size(), ids.size());
  const double d = program.particles.sizes.Moment(1);
  for (const Sphere& fixed : layer) EXPECT_NEAR(fixed.position[2] + fixed.radius, 0, 1e-18);
  EXPECT_GT(LargestOverlap(layer, program.domain.upper[1]), -0.01 * d) << "they touch";
  const Vector3 lengths = program.domain.Lengths();
  const double discs = static_cast<double>(ids.size()) * std::numbers::pi / 4 * d * d;
  EXPECT_GT(discs / (lengths[0] * lengths[1]), 0.88) << "hexagonal: 0.907 without the ends";
}

TEST(Spreading, StandsBetweenWallsWhereWanted) {
  const Program program = PlanOf(With("sides: walls"), MetalPowder());
  EXPECT_EQ(program.domain.boundaries[1], Boundary::open);
  ASSERT_EQ(program.walls.size(), 4U);
  for (const std::size_t side : {1U, 2U}) {
    EXPECT_EQ(program.walls[side].axis, 1);
    EXPECT_TRUE(program.walls[side].frictionless);
  }
  const double width = program.domain.upper[1];
  EXPECT_EQ(program.walls[2].position, width);
  for (const Sphere& sphere : *program.particles.packing) {
    EXPECT_GE(sphere.position[1], sphere.radius * (1 - 1e-12)) << "none reaches into a wall";
    EXPECT_LE(sphere.position[1], width - sphere.radius * (1 - 1e-12));
  }
  EXPECT_LT(LargestOverlap(*program.particles.packing, 0), 1e-15);
}

TEST(Spreading, EqualArgumentsEqualPrograms) {
  const Spreading spreading = With("{}");
  EXPECT_EQ(PlanOf(spreading, MetalPowder()).Hash(), PlanOf(spreading, MetalPowder()).Hash());
  EXPECT_NE(PlanOf(spreading, MetalPowder()).Hash(),
            PlanOf(spreading, MetalPowder(), Fidelity::quick, 2).Hash());
}

TEST(Spreading, RefusesBadOptions) {
  EXPECT_THROW(With("blade_speed: 0 m/s"), InputError);
  EXPECT_THROW(With("gap: 80"), InputError);
  EXPECT_THROW(With("plate: glass"), InputError);
  EXPECT_THROW(With("{plate: smooth, plate_particle_diameter: 29 um}"), InputError);
}

TEST(Spreading, RefusesAGapThatTheLargestParticleDoesNotPass) {
  const Spreading spreading = With("gap: 37 um");
  EXPECT_THAT(spreading.ExplainUnsupported(MetalPowder()), testing::HasSubstr("37.5 um"));
  EXPECT_THROW(PlanOf(spreading, MetalPowder()), InputError);
  EXPECT_EQ(With("gap: 38 um").ExplainUnsupported(MetalPowder()), "");
}

TEST(Spreading, RefusesASweepWithoutAWindowAndANarrowPlate) {
  EXPECT_THROW(PlanOf(With("sweep: 0.4 mm"), MetalPowder()), InputError);
  EXPECT_THROW(PlanOf(With("width: 100 um"), MetalPowder()), InputError);
  EXPECT_THROW(PlanOf(With("plate_particle_diameter: 80 um"), MetalPowder()), InputError);
}

// Equal spheres on a square lattice of two diameters, up to the blade; `heap` more before it.
Trace SquareLayer(const Program& program, int heap) {
  const double r = 14.5e-6;
  const double width = program.domain.upper[1];
  const double front = Sweep(program).duration * Sweep(program).motions[0].velocity[0];
  const auto columns = static_cast<int>(std::lround(width / (4 * r)));
  Moment rest{.name = "rest", .time = 0.05};
  const auto add = [&](double x, double y, double z) {
    rest.packing.push_back({.id = static_cast<std::int64_t>(rest.packing.size()) + 1,
                            .radius = r,
                            .position = {x, y, z}});
  };
  for (int row = 0; (row + 0.5) * 4 * r < front; ++row) {
    for (int column = 0; column < columns; ++column) {
      add((row + 0.5) * 4 * r, (column + 0.5) * 4 * r, r);
    }
  }
  for (int n = 0; n < heap; ++n) add(front + 20e-6, (2 * n + 1) * r, r);
  Trace trace;
  trace.moments.push_back(std::move(rest));
  trace.diagnostics.leavers = 3;
  return trace;
}

TEST(Spreading, MeasuresAKnownLayer) {
  // The window of 232 by 174 um holds whole cells of the lattice.
  const Spreading spreading =
      With("{sweep: 0.624 mm, width: 0.174 mm, plate: smooth, start_margin: 2.9}");
  const Program program = PlanOf(spreading, EqualSpheres());
  const Trace trace = SquareLayer(program, 3);
  Outcome outcome;
  const Measurement measured = spreading.Measure(program, trace, &outcome);
  ASSERT_TRUE(outcome.ok()) << outcome.message;
  EXPECT_NEAR(measured.diagnostics.at("window_x0"), 0.232e-3, 1e-9);
  EXPECT_NEAR(measured.diagnostics.at("window_x1"), 0.464e-3, 1e-9);
  EXPECT_NEAR(measured.responses.at("coverage").value, std::numbers::pi / 16, 2e-3);
  const double d = 29e-6;
  EXPECT_NEAR(measured.responses.at("packing_density").value, std::numbers::pi / 24 * d / kGap,
              1e-6);
  EXPECT_NEAR(measured.responses.at("mass_per_area").value, 8220 * std::numbers::pi / 24 * d, 1e-6);
  const double laid = static_cast<double>(trace.moments[0].packing.size()) - 3;
  EXPECT_NEAR(measured.responses.at("swept_share").value, 1 - laid / program.particles.count,
              1e-12);
  EXPECT_NEAR(measured.diagnostics.at("heap_share"), 3.0 / program.particles.count, 1e-12);
  EXPECT_EQ(measured.diagnostics.at("leavers"), 3);
}

TEST(Spreading, WhatIsInTheAirWasNotLaidDown) {
  const Spreading spreading =
      With("{sweep: 0.624 mm, width: 0.174 mm, plate: smooth, start_margin: 2.9}");
  const Program program = PlanOf(spreading, EqualSpheres());
  Trace trace = SquareLayer(program, 3);
  Outcome outcome;
  const Measurement still = spreading.Measure(program, trace, &outcome);
  // Two of the layer leap: one above the window, and one that is no higher than the heap may be.
  trace.moments[0].packing[25].position[2] = 3e-3;
  trace.moments[0].packing[26].position[2] = kGap + 15e-6;
  const Measurement measured = spreading.Measure(program, trace, &outcome);
  ASSERT_TRUE(outcome.ok()) << outcome.message;
  EXPECT_EQ(still.diagnostics.at("airborne"), 0);
  EXPECT_EQ(measured.diagnostics.at("airborne"), 2);
  EXPECT_NEAR(measured.responses.at("swept_share").value - still.responses.at("swept_share").value,
              2.0 / program.particles.count, 1e-12);
  EXPECT_LT(measured.diagnostics.at("surface_maximum"), kGap);
}

TEST(Spreading, HasACeilingForWhatTheBladeShootsUp) {
  const Program program = PlanOf(With("{}"), MetalPowder());
  const PlaneWall& ceiling = program.walls.back();
  EXPECT_FALSE(ceiling.facing_positive);
  EXPECT_LT(ceiling.position + MetalPowder().sizes.Moment(1) / 2, program.domain.upper[2]);
  // Ten times the blade's speed from the top of the heap, and more.
  double top = 0;
  for (const Sphere& sphere : *program.particles.packing) {
    top = std::max(top, sphere.position[2] + sphere.radius);
  }
  EXPECT_GT(ceiling.position, top + 0.25 * 0.25 / (2 * 9.81));
}

TEST(Spreading, BarePlateGivesZeros) {
  const Spreading spreading = With("{}");
  const Program program = PlanOf(spreading, MetalPowder());
  Trace trace;
  trace.moments.push_back({.name = "rest"});
  Outcome outcome;
  const Measurement measured = spreading.Measure(program, trace, &outcome);
  EXPECT_TRUE(outcome.ok());
  EXPECT_EQ(measured.responses.size(), spreading.responses().size());
  for (const auto& [name, response] : measured.responses) {
    EXPECT_EQ(response.value, name == "swept_share" ? 1 : 0) << name;
  }
}

TEST(Spreading, TraceWithoutALayerIsACrash) {
  const Spreading spreading = With("{}");
  Outcome outcome;
  spreading.Measure(PlanOf(spreading, MetalPowder()), Trace{}, &outcome);
  EXPECT_EQ(outcome.reason, Reason::crashed);
}

TEST(Spreading, BladeLaysALayerThatFitsTheGap) {
  const Spreading spreading =
      With("{sweep: 0.5 mm, width: 90 um, blade_speed: 50 mm/s, rest_time: 1 ms}");
  const Program program = PlanOf(spreading, EqualSpheres());
  const Trace trace = MakeBackend("embedded")->Run(program, {});
  ASSERT_TRUE(trace.outcome.ok()) << trace.outcome.message;
  Outcome outcome;
  const Measurement measured = spreading.Measure(program, trace, &outcome);
  ASSERT_TRUE(outcome.ok()) << outcome.message;
  const double coverage = measured.responses.at("coverage").value;
  EXPECT_GT(coverage, 0.6);
  EXPECT_LT(coverage, 1);
  EXPECT_GT(measured.responses.at("packing_density").value, 0.2);
  EXPECT_LT(measured.diagnostics.at("surface_maximum"), 1.02 * kGap);
  EXPECT_GT(measured.diagnostics.at("heap_share"), 0.02) << "the powder did not suffice";
}

}  // namespace
}  // namespace powdercal

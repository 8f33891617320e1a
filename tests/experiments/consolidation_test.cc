#include "experiments/consolidation.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace powdercal {
namespace {

SimulatedPowder Powder() {
  SimulatedPowder powder;
  powder.sizes = {SizeDistribution::Kind::normal, 29e-6, 6e-6, 12.5e-6, 37.5e-6};
  const ContactParameters contact{.restitution = 0.4, .friction = 0.3};
  powder.materials = {8220, 5e6, 0.3, contact, contact};
  return powder;
}

Consolidation At(const std::string& options) {
  Consolidation consolidation;
  ReadYaml(options, "x.yaml", [&](Archive& archive) { consolidation.Serialize(archive); });
  return consolidation;
}

Program Plan(Fidelity fidelity = Fidelity::quick) {
  Conditions conditions{.stress = 900, .gravity = 9.81};
  return At("stress: 9 kPa").Plan(Powder(), conditions, {}, fidelity, 7);
}

TEST(Consolidation, PlansTheStatedSizes) {
  EXPECT_EQ(Plan(Fidelity::quick).particles.count, 1000);
  EXPECT_EQ(Plan(Fidelity::standard).particles.count, 3000);
  const Program paper = Plan(Fidelity::paper);
  EXPECT_EQ(paper.particles.count, 500'000);
  EXPECT_EQ(paper.domain.upper[0], 2e-3);
}

TEST(Consolidation, StartsAtTheStatedSolidFraction) {
  const Program program = Plan();
  const Insert& insert = std::get<Insert>(program.stages[0]);
  const double volume = 1000 * std::numbers::pi / 6 * program.particles.sizes.Moment(3);
  const double slab =
      program.domain.upper[0] * program.domain.upper[1] * (insert.top - insert.bottom);
  EXPECT_NEAR(volume / slab, 0.30, 1e-12);
}

TEST(Consolidation, TimeStepIsAFifthOfTheRayleighTimeOfTheSmallest) {
  EXPECT_NEAR(Plan().time_step, 0.2 * RayleighTime(6.25e-6, 8220, 5e6, 0.3), 1e-15);
}

// The program of studies that do not speak of sides is what it was.
TEST(Consolidation, StandsBetweenWallsWhereWanted) {
  const Program periodic = Plan();
  EXPECT_EQ(periodic.walls.size(), 2u);
  EXPECT_EQ(periodic.domain.boundaries[1], Boundary::periodic);
  const Program walls =
      At("stress: 9 kPa\nsides: walls")
          .Plan(Powder(), {.stress = 900, .gravity = 9.81}, {}, Fidelity::quick, 7);
  ASSERT_EQ(walls.walls.size(), 6u);
  for (const int axis : {0, 1}) {
    EXPECT_EQ(walls.domain.boundaries[axis], Boundary::open);
    const PlaneWall& low = walls.walls[2 + 2 * axis];
    const PlaneWall& high = walls.walls[3 + 2 * axis];
    EXPECT_TRUE(low.frictionless && high.frictionless);
    EXPECT_TRUE(low.facing_positive && !high.facing_positive);
    EXPECT_EQ(low.axis, axis);
    EXPECT_EQ(low.position, 0);
    EXPECT_EQ(high.position, walls.domain.upper[axis]);
  }
  EXPECT_EQ(walls.domain.BaseArea(), periodic.domain.BaseArea());
}

TEST(Consolidation, RefusesBadOptions) {
  EXPECT_THROW(At("stress: 9 kPa\nsides: wall"), InputError);
  EXPECT_THROW(At("stress: 9"), InputError);
  EXPECT_THROW(At("initial_velocity: 1 m/s"), InputError) << "stress is required";
  EXPECT_THROW(At("stress: 9 kPa\ninitial_solid_fraction: 0.6"), InputError);
}

// A simple cubic lattice of equal spheres, ten layers between floor and lid.
Trace CubicLattice(const Program& program, double force) {
  const double r = 14.5e-6;
  Trace trace;
  Moment hold{.name = "hold", .time = 0.01};
  for (int x = 0; x < 10; ++x) {
    for (int y = 0; y < 10; ++y) {
      for (int z = 0; z < 10; ++z) {
        hold.packing.push_back({.id = 1 + x + 10 * (y + 10 * z),
                                .radius = r,
                                .position = {(2 * x + 1) * r, (2 * y + 1) * r, (2 * z + 1) * r}});
      }
    }
  }
  hold.walls["floor"].height = 0;
  hold.walls["lid"] = {.height = 20 * r, .force = {0, 0, force}, .velocity = 0};
  trace.moments.push_back(std::move(hold));
  trace.diagnostics.time_step = program.time_step;
  return trace;
}

TEST(Consolidation, MeasuresAKnownPacking) {
  SimulatedPowder powder = Powder();
  powder.sizes = {SizeDistribution::Kind::monodisperse, 29e-6, 0, 29e-6, 29e-6};
  const Conditions conditions{.stress = 900, .gravity = 9.81};
  const Consolidation consolidation = At("stress: 9 kPa");
  const Program program = consolidation.Plan(powder, conditions, {}, Fidelity::quick, 1);
  const double area = program.domain.upper[0] * program.domain.upper[1];
  Outcome outcome;
  const Measurement measured =
      consolidation.Measure(program, CubicLattice(program, 900 * area), &outcome);
  ASSERT_TRUE(outcome.ok()) << outcome.message;
  const double expected = 6 / std::numbers::pi - 1;
  EXPECT_NEAR(measured.responses.at("void_ratio").value, expected, 1e-9);
  EXPECT_NEAR(measured.responses.at("void_ratio_wall_to_wall").value, expected, 1e-9);
  EXPECT_NEAR(measured.responses.at("bulk_density").value, 8220 * std::numbers::pi / 6, 1e-5);
  EXPECT_NEAR(measured.diagnostics.at("stress_ratio"), 1, 1e-12);
  EXPECT_NEAR(measured.diagnostics.at("kappa"), 334, 1);
}

TEST(Consolidation, OverlapsBeyondTheContactLawAreUnstable) {
  SimulatedPowder powder = Powder();
  powder.sizes = {SizeDistribution::Kind::monodisperse, 29e-6, 0, 29e-6, 29e-6};
  const Conditions conditions{.stress = 900, .gravity = 9.81};
  const Consolidation consolidation = At("stress: 9 kPa");
  const Program program = consolidation.Plan(powder, conditions, {}, Fidelity::quick, 1);
  Trace trace = CubicLattice(program, 1e-4);
  trace.moments[0].packing[55].position = trace.moments[0].packing[56].position;
  trace.moments[0].packing[55].position[2] += 1e-6;
  Outcome outcome;
  consolidation.Measure(program, trace, &outcome);
  EXPECT_EQ(outcome.reason, Reason::unstable);
}

TEST(Consolidation, TraceWithoutALoadedBedIsACrash) {
  Outcome outcome;
  At("stress: 9 kPa").Measure(Plan(), Trace{}, &outcome);
  EXPECT_EQ(outcome.reason, Reason::crashed);
}

}  // namespace
}  // namespace powdercal

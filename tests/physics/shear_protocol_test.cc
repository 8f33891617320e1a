#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "backends/backend.h"
#include "backends/registry.h"
#include "experiments/shear.h"

// The whole shear test at `quick`, on the embedded engine. Bounds are four seed standard deviations
// or more (docs/physics.md has the figures).

namespace powdercal {
namespace {

struct Case {
  double cohesion = 0;  // [J/m3] k
  double friction = 0.3;
  double rolling = 0.2;
  const char* cell = "periodic";
  std::uint64_t seed = 1;
};

Measurement Sheared(const Case& test) {
  SimulatedPowder powder;
  powder.sizes = {SizeDistribution::Kind::normal, 29e-6, 6e-6, 12.5e-6, 37.5e-6};
  const ContactParameters contact{.restitution = 0.4,
                                  .friction = test.friction,
                                  .rolling_friction = test.rolling,
                                  .cohesion_energy_density = test.cohesion};
  powder.materials = {8220, 5e6, 0.3, contact, contact, {}};
  powder.law.cohesion = ContactLaw::Cohesion::sjkr2;
  powder.law.rolling = ContactLaw::Rolling::epsd2;
  Shear shear;
  ReadYaml(fmt::format("preshear: 9 kPa\ncell: {}", test.cell), "x.yaml",
           [&](Archive& archive) { shear.Serialize(archive); });
  const Program program = shear.Plan(powder, {.stress = 900}, {}, Fidelity::quick, test.seed);
  const Trace trace = MakeBackend("embedded")->Run(program, {});
  EXPECT_TRUE(trace.outcome.ok()) << trace.outcome.message;
  Outcome outcome;
  Measurement measured = shear.Measure(program, trace, &outcome);
  EXPECT_TRUE(outcome.ok()) << outcome.message;
  EXPECT_EQ(measured.responses.size(), shear.responses().size());
  for (const char* name :
       {"steady_state_friction", "tan_phi", "cohesion", "steady_state_void_ratio"}) {
    std::printf("  %s, k = %g, mu = %g, mu_r = %g: %s = %.4g\n", test.cell, test.cohesion,
                test.friction, test.rolling, name, measured.responses[name].value);
  }
  return measured;
}

TEST(ShearProtocol, CohesionlessPowderHasNoneAndItsFrictionGrowsWithMu) {
  const Measurement rough = Sheared({.friction = 0.3});
  EXPECT_NEAR(rough.responses.at("cohesion").value, 0, 150) << "[Pa] of 9 kPa";
  EXPECT_NEAR(rough.responses.at("tan_phi").value,
              rough.responses.at("steady_state_friction").value, 0.06)
      << "the locus of a powder without cohesion goes through its steady state";
  const Measurement smooth = Sheared({.friction = 0.1});
  EXPECT_GT(rough.responses.at("steady_state_friction").value,
            smooth.responses.at("steady_state_friction").value + 0.05);
}

TEST(ShearProtocol, EachParameterShowsInItsResponse) {
  const Measurement base = Sheared({.cohesion = 100, .rolling = 0.05});
  const Measurement rolling = Sheared({.cohesion = 100, .rolling = 0.7});
  const Measurement cohesive = Sheared({.cohesion = 15833, .rolling = 0.05});
  const auto rise = [&](const Measurement& other, const char* name) {
    return other.responses.at(name).value - base.responses.at(name).value;
  };
  EXPECT_GT(rise(rolling, "steady_state_friction"), 0.05);
  EXPECT_GT(rise(rolling, "steady_state_void_ratio"), 0.03);
  EXPECT_NEAR(rise(rolling, "cohesion"), 0, 200);
  EXPECT_GT(rise(cohesive, "cohesion"), 250);
  EXPECT_GT(rise(cohesive, "steady_state_void_ratio"), 0.03);
  EXPECT_GT(cohesive.responses.at("inverse_ffc").value, 0.04);
}

TEST(ShearProtocol, PlatensAndPeriodicCellAgree) {
  const Measurement periodic = Sheared({.cohesion = 15833});
  const Measurement platens = Sheared({.cohesion = 15833, .cell = "platens"});
  const auto& notes = platens.diagnostics;
  EXPECT_NEAR(notes.at("normal_stress_top"), notes.at("normal_stress_bottom"), 9);
  EXPECT_NEAR(notes.at("normal_stress_top"), notes.at("normal_stress_bulk"), 9);
  EXPECT_NEAR(notes.at("shear_stress_top"), notes.at("shear_stress_bottom"), 9);
  EXPECT_NEAR(notes.at("shear_stress_top"), notes.at("shear_stress_bulk"), 9);
  EXPECT_NEAR(platens.responses.at("steady_state_friction").value,
              periodic.responses.at("steady_state_friction").value, 0.08);
  EXPECT_NEAR(platens.responses.at("cohesion").value, periodic.responses.at("cohesion").value, 250);
}

}  // namespace
}  // namespace powdercal

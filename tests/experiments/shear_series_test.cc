#include "experiments/shear_series.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "backends/backend.h"
#include "backends/registry.h"
#include "experiments/shear_cells.h"

namespace powdercal {
namespace {

// 200 particles, in a fraction of a second: too few and too fast for figures, but every stage is a
// real one.
Trace RunSmall(ShearCell cell, Program* program) {
  SimulatedPowder powder;
  powder.sizes = {SizeDistribution::Kind::normal, 29e-6, 4e-6, 20e-6, 37.5e-6};
  const ContactParameters contact{.restitution = 0.4, .friction = 0.3, .rolling_friction = 0.2};
  powder.materials = {8220, 5e6, 0.3, contact, contact, {}};
  powder.law.rolling = ContactLaw::Rolling::epsd2;
  const ShearProtocol protocol{.cell = cell,
                               .count = 200,
                               .width = 6 * 29e-6,
                               .preshear = 900,
                               .normals = {400, 700},
                               .inertial_number = 0.02,
                               .preshear_strain = 2,
                               .yield_strain = 0.08,
                               .repeats = 2};
  *program = PlanShear(protocol, powder, 3);
  program->time_step = 4e-7;
  const std::unique_ptr<Backend> backend = MakeBackend("embedded");
  EXPECT_EQ(backend->ExplainUnsupported(*program), "");
  Trace trace = backend->Run(*program, {});
  EXPECT_TRUE(trace.outcome.ok()) << trace.outcome.message;
  return trace;
}

void ExpectWhole(const Program& program, const Trace& trace, ShearRecord* record) {
  ASSERT_EQ(ReadShearRecord(program, trace, record), "");
  ASSERT_EQ(record->states.size(), 2U);
  EXPECT_EQ(record->states.back(), record->preshear.size());
  ASSERT_EQ(record->yields.size(), 2U);
  for (std::size_t i = 1; i < record->preshear.size(); ++i) {
    EXPECT_GT(record->preshear[i].strain, record->preshear[i - 1].strain);
  }
  for (const std::vector<ShearSeries>& state : record->yields) {
    ASSERT_EQ(state.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_GT(state[i].front().strain, 0);
      const YieldPoint point = FindYieldPoint(state[i], i == 0 ? 400 : 700, 0.45);
      EXPECT_TRUE(point.reached) << i;
      EXPECT_NEAR(point.stress.shear / point.stress.normal, 0.6, 0.3) << i;
    }
  }
}

TEST(ShearSeries, OfARealPeriodicCell) {
  Program program;
  const Trace trace = RunSmall(ShearCell::periodic, &program);
  ShearRecord record;
  ExpectWhole(program, trace, &record);
  EXPECT_NEAR(record.preshear.back().strain, 2, 0.02);
  EXPECT_NEAR(record.preshear[record.states[0] - 1].strain, 1, 0.02);
  const ShearSample mean =
      MeanSample(std::span<const ShearSample>(record.preshear).subspan(record.states[0]));
  EXPECT_NEAR(mean.stress.normal / 900, 1, 0.05);
  EXPECT_NEAR(mean.complementary / mean.stress.shear, 1, 0.05);
  EXPECT_NEAR(mean.void_ratio, 0.7, 0.15);
}

// The difference between top and bottom that others found is not there: without gravity, and with
// no floor below the glued spheres, all that the one platen bears reaches the other.
TEST(ShearSeries, OfRealPlatensTopBottomAndBulkAgree) {
  Program program;
  const Trace trace = RunSmall(ShearCell::platens, &program);
  ShearRecord record;
  ExpectWhole(program, trace, &record);
  const ShearSample mean =
      MeanSample(std::span<const ShearSample>(record.preshear).subspan(record.states[0]));
  EXPECT_NEAR(mean.stress.normal / 900, 1, 0.05);
  EXPECT_NEAR(mean.stress.normal, mean.bottom.normal, 0.05 * 900);
  EXPECT_NEAR(mean.stress.normal, mean.bulk.normal, 0.05 * 900);
  EXPECT_NEAR(mean.stress.shear, mean.bottom.shear, 0.05 * 900);
  EXPECT_NEAR(mean.stress.shear, mean.bulk.shear, 0.05 * 900);
  EXPECT_GT(mean.stress.shear, 0.3 * 900);
  EXPECT_NEAR(mean.void_ratio, 0.7, 0.2);
}

// Samples every 0.001 of strain.
ShearSeries Series(double strain, const std::function<StressPair(double)>& law) {
  ShearSeries series;
  for (int i = 1; i <= std::lround(strain / 0.001); ++i) {
    series.push_back({.strain = 0.001 * i, .stress = law(0.001 * i)});
  }
  return series;
}

TEST(YieldPoint, IsThePeakOfTheSmoothedStrength) {
  const YieldPoint point =
      FindYieldPoint(Series(0.1,
                            [](double s) {
                              return StressPair{300, 150 - 2e4 * (s - 0.05) * (s - 0.05)};
                            }),
                     300, 0.5);
  ASSERT_TRUE(point.reached);
  EXPECT_NEAR(point.strain, 0.06, 0.002);
  EXPECT_NEAR(point.stress.shear, 150 - 2e4 * kYieldWindow * kYieldWindow / 12, 0.1);
}

TEST(YieldPoint, LoadIsNoStrength) {
  // Along the locus, more load gives more shear stress, and the same strength.
  const auto law = [](double s) {
    const double normal = s < 0.05 ? 325 : 300;
    return StressPair{normal, 10 + 0.4 * normal + (s > 0.05 ? 0.5 : 0)};
  };
  EXPECT_NEAR(FindYieldPoint(Series(0.1, law), 300, 0.5).stress.normal, 300, 1);
}

TEST(YieldPoint, WaitsForTheNormalStress) {
  const auto law = [](double s) { return s < 0.03 ? StressPair{500, 400} : StressPair{310, 150}; };
  const YieldPoint point = FindYieldPoint(Series(0.1, law), 300, 0.5);
  ASSERT_TRUE(point.reached);
  EXPECT_LE(point.stress.normal, 360);
  EXPECT_FALSE(FindYieldPoint(Series(0.03, law), 300, 0.5).reached);
}

}  // namespace
}  // namespace powdercal

#include "experiments/consolidation.h"
#include "experiments/shear_cells.h"
#include "experiments/spreading.h"
#include "tests/physics/programs.h"
#include "tests/support/program.h"

// Small beds of the three experiments in the embedded engine and in the real YADE: the same
// program, the same law. Trajectories part soon; what is compared are means.

namespace powdercal::physics {
namespace {

Trace RunYade(const Program& program) {
  const TemporaryFolder folder;
  return MakeBackend("yade")->Run(program, {.work_folder = folder / "run"});
}

SimulatedPowder Powder(double standard_deviation = 3e-6) {
  SimulatedPowder powder;
  powder.sizes = {SizeDistribution::Kind::normal, 29e-6, standard_deviation, 20e-6, 37.5e-6};
  const ContactParameters contact = {.restitution = 0.4, .friction = 0.3};
  powder.materials = {.density = kDensity,
                      .young_modulus = kYoung,
                      .poisson_ratio = kPoisson,
                      .particle_particle = contact,
                      .particle_wall = contact};
  powder.law = {.limit_force = true, .shear_update = ContactLaw::ShearUpdate::incremental};
  return powder;
}

template <typename E>
E ExperimentOf(const std::string& options) {
  E experiment;
  ReadYaml(options, "test.yaml", [&](Archive& archive) { experiment.Serialize(archive); });
  return experiment;
}

// Both engines' measurements of a program, by response.
template <typename E>
std::array<Measurement, 2> MeasureBoth(const E& experiment, const Program& program) {
  std::array<Measurement, 2> measurements;
  const std::array<Trace, 2> traces = {RunProgram(program), RunYade(program)};
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_TRUE(traces[n].outcome.ok()) << traces[n].outcome.message;
    if (!traces[n].outcome.ok()) continue;
    Outcome outcome;
    measurements[n] = experiment.Measure(program, traces[n], &outcome);
    EXPECT_TRUE(outcome.ok()) << outcome.message;
  }
  return measurements;
}

void ExpectAlike(const std::array<Measurement, 2>& both, const std::string& response,
                 double margin) {
  ASSERT_TRUE(both[0].responses.contains(response) && both[1].responses.contains(response));
  const double embedded = both[0].responses.at(response).value;
  const double yade = both[1].responses.at(response).value;
  std::printf("[ row ] | %s | %.4f | %.4f |\n", response.c_str(), embedded, yade);
  EXPECT_NEAR(yade, embedded, margin) << response;
}

TEST(BedsInYade, ConsolidateAlike) {
  const auto consolidation = ExperimentOf<Consolidation>("{stress: 900 Pa, sides: walls}");
  Program program =
      consolidation.Plan(Powder(), {.stress = 900, .gravity = kGravity}, {}, Fidelity::quick, 1);
  const auto both = MeasureBoth(consolidation, program);
  ExpectAlike(both, "void_ratio", 0.03);
  ExpectAlike(both, "void_ratio_wall_to_wall", 0.03);
  for (const Measurement& m : both) EXPECT_NEAR(m.diagnostics.at("stress_ratio"), 1, 0.02);
}

TEST(BedsInYade, SpreadAlike) {
  const auto spreading = ExperimentOf<Spreading>(
      "{blade_speed: 50 mm/s, gap: 80 um, sides: walls, sweep: 0.8 mm, width: 120 um}");
  Conditions conditions{.gravity = kGravity};
  conditions.diameter = 29e-6;
  spreading.DescribeConditions(Fidelity::quick, conditions);
  const Program program = spreading.Plan(Powder(), conditions, {}, Fidelity::quick, 1);
  const auto both = MeasureBoth(spreading, program);
  ExpectAlike(both, "coverage", 0.05);
  ExpectAlike(both, "packing_density", 0.04);
  ExpectAlike(both, "swept_share", 0.06);
}

struct Sheared {
  double friction = 0;
  double solid_fraction = 0;
};

Sheared SteadyState(const Trace& trace, const Program& program, double from, double to) {
  Sheared mean;
  double count = 0;
  const Vector3 width = program.domain.Lengths();
  const double solid = 300 * kPi / 6 * program.particles.sizes.Moment(3);
  for (std::size_t n = 0; n < trace.cell.time.size(); ++n) {
    if (trace.cell.strain[n] < from || trace.cell.strain[n] > to) continue;
    const auto& stress = trace.cell.stress[n];
    mean.friction += -0.5 * (stress[0][2] + stress[2][0]) / stress[2][2];
    mean.solid_fraction += solid / (width[0] * width[1] * trace.cell.lengths[n][2]);
    ++count;
  }
  EXPECT_GT(count, 100);
  return {mean.friction / count, mean.solid_fraction / count};
}

// Largest overlap of two spheres over their mean diameter, through all images.
double DeepestOverlap(const Moment& moment) {
  const CellState& cell = *moment.cell;
  const Vector3 length = cell.upper - cell.lower;
  double deepest = 0;
  for (const Sphere& a : moment.packing) {
    for (const Sphere& b : moment.packing) {
      if (a.id >= b.id) continue;
      Vector3 apart = a.position - b.position;
      const double turns = std::round(apart[2] / length[2]);
      apart[2] -= turns * length[2];
      apart[0] -= turns * cell.shear_offset;
      for (const std::size_t axis : {0U, 1U}) {
        apart[axis] -= length[axis] * std::round(apart[axis] / length[axis]);
      }
      deepest = std::max(deepest, 1 - Length(apart) / (a.radius + b.radius));
    }
  }
  return deepest;
}

// To a strain at which the cell has been exchanged for its mirror image several times, and once
// more from a saved state.
TEST(BedsInYade, ShearAlike) {
  const SimulatedPowder powder = Powder();
  const ShearProtocol protocol = {.count = 300,
                                  .width = 6.5 * 29e-6,
                                  .preshear = 900,
                                  .normals = {450},
                                  .inertial_number = 0.01,
                                  .preshear_strain = 2.2,
                                  .yield_strain = 0.2};
  Program program = PlanShear(protocol, powder, 1);
  program.time_step = 0.2 * RayleighTime(10e-6, kDensity, kYoung, kPoisson);
  const Trace embedded = RunProgram(program);
  const Trace yade = RunYade(program);
  ASSERT_TRUE(embedded.outcome.ok()) << embedded.outcome.message;
  ASSERT_TRUE(yade.outcome.ok()) << yade.outcome.message;
  EXPECT_GT(yade.diagnostics.figures.at("cell_flips"), 1);
  const Sheared a = SteadyState(embedded, program, 1, 2.2);
  const Sheared b = SteadyState(yade, program, 1, 2.2);
  std::printf("[ row ] | friction | %.4f | %.4f |\n", a.friction, b.friction);
  std::printf("[ row ] | solid fraction | %.4f | %.4f |\n", a.solid_fraction, b.solid_fraction);
  EXPECT_NEAR(b.friction, a.friction, 0.03);
  EXPECT_NEAR(b.solid_fraction, a.solid_fraction, 0.015);
  ASSERT_EQ(embedded.moments.size(), yade.moments.size());
  for (std::size_t n = 0; n < yade.moments.size(); ++n) {
    const CellState& cell = *yade.moments[n].cell;
    EXPECT_LT(DeepestOverlap(yade.moments[n]), 0.05) << "a contact was overlooked";
    EXPECT_EQ(yade.moments[n].name, embedded.moments[n].name);
    EXPECT_NEAR(yade.moments[n].time, embedded.moments[n].time, 1e-9);
    EXPECT_NEAR(cell.shear_rate, embedded.moments[n].cell->shear_rate, 1e-9 * cell.shear_rate);
    for (const Sphere& sphere : yade.moments[n].packing) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_GE(sphere.position[axis], cell.lower[axis]);
        EXPECT_LE(sphere.position[axis], cell.upper[axis]);
      }
    }
  }
  EXPECT_NEAR(yade.cell.strain.back(), 2.4, 0.01);
  EXPECT_NEAR(embedded.cell.strain.back(), 2.4, 0.01);
}

double Apart(const Packing& a, const Packing& b, const Vector3& period = {}) {
  double worst = a.size() == b.size() ? 0 : HUGE_VAL;
  for (std::size_t n = 0; n < std::min(a.size(), b.size()); ++n) {
    Vector3 apart = a[n].position - b[n].position;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (period[axis] > 0) apart[axis] -= period[axis] * std::round(apart[axis] / period[axis]);
    }
    worst =
        std::max({worst, Length(apart) / a[n].radius, Length(a[n].velocity - b[n].velocity) / 0.02,
                  a[n].radius * Length(a[n].spin - b[n].spin) / 0.02});
  }
  return worst;
}

TEST(CellsInYade, PairsAcrossSidesAndEdges) {
  const double half = 1e-4;
  const double v = 0.02;
  const double w = v / kRadius;
  const double r = kRadius;
  Program program =
      Vacuum({Ball(1, r, {half - 0.6 * r, 0, 0}, {v, 0, 0.4 * v}, {0, w, 0}),
              Ball(2, r, {-half + 1.41 * r, 0, 0}, {-v, 0, 0}, {0, w, 0}),
              Ball(3, r, {0, half - 0.7 * r, half - 0.7 * r}, {0, v, v}, {w, 0, 0}),
              Ball(4, r / 2, {0, -half + 0.37 * r, -half + 0.37 * r}, {0, -v, v}, {w, 0, 0})});
  program.domain = {{-half, -half, -half},
                    {half, half, half},
                    {Boundary::periodic, Boundary::periodic, Boundary::periodic}};
  program.law = Powder().law;
  SetContact(program, {.restitution = 0.6, .friction = 0.3});
  program.stages = {Advance{.duration = 2000 * program.time_step, .packing_every = 200}};
  const Trace embedded = RunOk(program);
  const Trace yade = RunYade(program);
  ASSERT_TRUE(yade.outcome.ok()) << yade.outcome.message;
  ASSERT_EQ(embedded.moments.size(), yade.moments.size());
  double worst = 0;
  for (std::size_t n = 0; n < yade.moments.size(); ++n) {
    worst = std::max(worst, Apart(embedded.moments[n].packing, yade.moments[n].packing,
                                  {2 * half, 2 * half, 2 * half}));
  }
  Measured("across periodic sides", worst);
  EXPECT_LT(worst, 1e-6);
  EXPECT_GT(Apart(*program.particles.packing, yade.moments.back().packing), 0.1);
}

// A bed under a servo, some of it sliding: what follows a restored state is what followed when it
// was saved, but for the order of sums.
TEST(StatesInYade, GoOnAsTheyHadGone) {
  SimulatedPowder powder = Powder();
  const auto consolidation = ExperimentOf<Consolidation>("{stress: 900 Pa, sides: walls}");
  Program program =
      consolidation.Plan(powder, {.stress = 900, .gravity = kGravity}, {}, Fidelity::quick, 1);
  program.particles.count = 100;
  program.domain.upper[0] = program.domain.upper[1] = 4 * 29e-6;
  for (PlaneWall& wall : program.walls) {
    if (wall.axis < 2 && !wall.facing_positive) wall.position = 4 * 29e-6;
  }
  const Servo servo = std::get<Servo>(program.stages[2]);
  const double dt = program.time_step;
  program.stages.resize(2);
  program.stages.insert(program.stages.end(),
                        {servo, Save{}, Advance{.name = "once", .duration = 300 * dt}, Restore{},
                         Advance{.name = "again", .duration = 300 * dt}, Restore{},
                         Advance{.name = "thrice", .duration = 300 * dt}});
  const Trace trace = RunYade(program);
  ASSERT_TRUE(trace.outcome.ok()) << trace.outcome.message;
  const Moment& once = *trace.Find("once");
  for (const char* name : {"again", "thrice"}) {
    const Moment& moment = *trace.Find(name);
    const double apart = Apart(once.packing, moment.packing);
    Measured(std::string("apart, ") + name, apart);
    EXPECT_LT(apart, 1e-9);
    EXPECT_GT(moment.time, once.time);
    EXPECT_NEAR(moment.walls.at("lid").height, once.walls.at("lid").height, 1e-15);
    EXPECT_NEAR(moment.walls.at("lid").force[2] / once.walls.at("lid").force[2], 1, 1e-6);
  }
}

}  // namespace
}  // namespace powdercal::physics

#include <functional>
#include <future>

#include "backends/embedded/stages.h"
#include "experiments/consolidation.h"
#include "experiments/packing_measures.h"
#include "studies/planner.h"
#include "tests/physics/two_engines.h"

// Beds of 1000 particles, consolidated from the same packings by both engines. Trajectories of beds
// part within some hundred steps: what is compared are means over particle seeds.

namespace powdercal::physics {
namespace {

constexpr int kSeeds = 6;      // 1, 2, … of the particles
constexpr double kErrors = 3;  // largest difference of two means, in its standard errors
constexpr double kVoidRatio = 0.02;
constexpr double kRelativeHeight = 0.005;  // of the settled bed's centre of mass
constexpr double kCoordination = 0.1;
constexpr double kStress = 0.05;      // what the lid's stress may be off by
constexpr double kMeanStress = 0.02;  // what the means of the two engines may differ by
constexpr double kAges = 0.05;        // by which the ages of two beds of one seed may differ
constexpr double kSettling = 3e-3;    // [s]
// From the loaded lid to the measurement, in units of d √(rho/stress).
constexpr double kLoading = 50;

struct Sample {
  std::vector<double> values;

  double Mean() const {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  }
  double Variance() const {
    double sum = 0;
    for (const double value : values) sum += (value - Mean()) * (value - Mean());
    return sum / static_cast<double>(values.size() - 1);
  }
};

// One figure in both engines, over the seeds.
struct Figure {
  std::string name;
  Sample liggghts;
  Sample embedded;

  double Difference() const { return embedded.Mean() - liggghts.Mean(); }
  double StandardError() const {
    return std::sqrt((liggghts.Variance() + embedded.Variance()) /
                     static_cast<double>(liggghts.values.size()));
  }
  bool Agrees(double margin) const {
    return std::abs(Difference()) < std::min(margin, kErrors * StandardError());
  }
  void Expect(const std::string& where, double margin) const {
    std::printf("[ row ] | %s | %s | %.4f ± %.4f | %.4f ± %.4f | %+.4f | %.4f | %+.1f | %s |\n",
                where.c_str(), name.c_str(), liggghts.Mean(), std::sqrt(liggghts.Variance()),
                embedded.Mean(), std::sqrt(embedded.Variance()), Difference(), StandardError(),
                Difference() / StandardError(), Agrees(margin) ? "agree" : "DIFFER");
    EXPECT_TRUE(Agrees(margin)) << where << ", " << name << ": " << Difference() << ", margin "
                                << margin << ", standard error " << StandardError();
  }
};

// Runs all programs in both engines, on two cores, and hands over what came out by number.
void RunAll(const std::vector<Program>& programs,
            const std::function<void(std::size_t, const TwoTraces&)>& take) {
  std::vector<TwoTraces> traces(programs.size());
  const auto work = [&](std::size_t first) {
    for (std::size_t n = first; n < programs.size(); n += 2) {
      traces[n] = {RunProgram(programs[n]), RunLiggghts(programs[n])};
    }
  };
  auto odd = std::async(std::launch::async, work, 1);
  work(0);
  odd.get();
  for (std::size_t n = 0; n < programs.size(); ++n) {
    ASSERT_TRUE(traces[n].embedded.outcome.ok()) << traces[n].embedded.outcome.message;
    ASSERT_TRUE(traces[n].liggghts.outcome.ok()) << traces[n].liggghts.outcome.message;
    take(n, traces[n]);
  }
}

// --- A box with frictionless sides ---------------------------------------------------------------

struct Case {
  double stress = 0;  // [Pa]
  ContactLaw::Tangential tangential = ContactLaw::Tangential::history;
  bool cohesive = false;

  std::string Name() const {
    return fmt::format("{:.0f}_Pa_{}_{}", stress,
                       TangentialLawNames()[static_cast<std::size_t>(tangential)],
                       cohesive ? "cohesive" : "dry");
  }
};

// As the consolidation experiment does it, but held by the clock: beds that creep without end
// (no_history) have to be compared at the same age. What is left is when the lid arrives.
Program Bed(const Case& c, std::uint64_t seed) {
  constexpr double d = 29e-6;
  constexpr double width = 10 * d;
  constexpr int count = 1000;
  Program program{.experiment = "bed"};
  Particles& particles = program.particles;
  particles = {.sizes = {.kind = SizeDistribution::Kind::normal,
                         .mean = d,
                         .standard_deviation = 6e-6,
                         .min = 12.5e-6,
                         .max = 37.5e-6},
               .count = count,
               .seed = seed};
  const ContactParameters contact = {.restitution = 0.4,
                                     .friction = 0.3,
                                     .rolling_friction = c.cohesive ? 0.4 : 0,
                                     .cohesion_energy_density = c.cohesive ? 7000.0 : 0};
  program.materials = {.density = kDensity,
                       .young_modulus = kYoung,
                       .poisson_ratio = kPoisson,
                       .particle_particle = contact,
                       .particle_wall = contact};
  program.law.tangential = c.tangential;
  if (c.cohesive) {
    program.law.cohesion = ContactLaw::Cohesion::sjkr2;
    program.law.rolling = ContactLaw::Rolling::epsd2;
  }
  program.time_step = 2.5e-7;
  const double solid = count * kPi / 6 * particles.sizes.Moment(3);
  const double top = solid / (width * width * 0.30);
  program.domain.lower = {0, 0, -0.5 * d};
  program.domain.upper = {width, width, top + 2 * d};
  program.domain.boundaries = {Boundary::open, Boundary::open, Boundary::open};
  program.walls = {{.name = "floor", .axis = 2, .position = 0},
                   {.name = "lid", .axis = 2, .position = top, .facing_positive = false}};
  for (const int axis : {0, 1}) {
    program.walls.push_back(
        {.name = fmt::format("low {}", axis), .axis = axis, .frictionless = true});
    program.walls.push_back({.name = fmt::format("high {}", axis),
                             .axis = axis,
                             .position = width,
                             .facing_positive = false,
                             .frictionless = true});
  }
  const double loading = kLoading * d * std::sqrt(kDensity / c.stress);
  program.stages = {
      Insert{.top = top, .velocity = {0, 0, -0.1}},
      Advance{.name = "settle", .duration = kSettling},
      Servo{.wall = "lid", .stress = c.stress, .max_velocity = 0.1, .max_duration = loading},
      Advance{.name = "loaded", .duration = loading}};
  return program;
}

double CentreOfMass(const Packing& packing) {
  double mass = 0;
  double moment = 0;
  for (const Sphere& s : packing) {
    mass += MassOf(s.radius);
    moment += MassOf(s.radius) * s.position[2];
  }
  return moment / mass;
}

struct BedFigures {
  double void_ratio = 0;
  double settled_height = 0;  // [m] of the centre of mass
  double coordination = 0;
  double stress = 0;  // [Pa] at the lid, over the last window
  double time = 0;    // [s]
};

BedFigures Measure(const Program& program, const Trace& trace) {
  const Moment& end = *trace.Find("loaded");
  const double lid = end.walls.at("lid").height;
  const std::array<WallPlane, 2> planes = {WallPlane{0, true}, WallPlane{lid, false}};
  const Contacts contacts = FindContacts(end.packing, program.domain, planes);
  const WallSeries& series = trace.series.front();
  double force = 0;
  constexpr std::size_t kWindows = 20;
  for (std::size_t n = 0; n < kWindows; ++n) {
    force += series.normal_force[series.normal_force.size() - 1 - n] / kWindows;
  }
  return {.void_ratio = CentralVoidRatio(end.packing, contacts, program.domain, 0, lid).value,
          .settled_height = CentreOfMass(trace.Find("settle")->packing),
          .coordination = MeasureContacts(end.packing, contacts).coordination_number,
          .stress = std::abs(force) / program.domain.BaseArea(),
          .time = end.time};
}

class BedsInTwoEngines : public ::testing::TestWithParam<Case> {};

TEST_P(BedsInTwoEngines, PackAlike) {
  std::vector<Program> programs;
  for (int seed = 1; seed <= kSeeds; ++seed) programs.push_back(Bed(GetParam(), seed));
  Figure e{.name = "void ratio"};
  Figure height{.name = "settled height over L"};
  Figure z{.name = "coordination"};
  Figure stress{.name = "stress over target"};
  const double width = programs[0].domain.upper[0];
  RunAll(programs, [&](std::size_t n, const TwoTraces& traces) {
    std::vector<double> ages;  // [s]
    const auto add = [&](const Trace& trace, Sample Figure::*side) {
      const BedFigures bed = Measure(programs[n], trace);
      (e.*side).values.push_back(bed.void_ratio);
      (height.*side).values.push_back(bed.settled_height / width);
      (z.*side).values.push_back(bed.coordination);
      (stress.*side).values.push_back(bed.stress / GetParam().stress);
      EXPECT_NEAR(bed.stress / GetParam().stress, 1, kStress);
      std::printf("[ run ] seed %zu: e %.4f, height %.4f, Z %.3f, stress %.1f Pa at %.3f ms\n",
                  n + 1, bed.void_ratio, bed.settled_height / width, bed.coordination, bed.stress,
                  1e3 * bed.time);
      ages.push_back(bed.time);
    };
    add(traces.liggghts, &Figure::liggghts);
    add(traces.embedded, &Figure::embedded);
    EXPECT_NEAR(ages[0] / ages[1], 1, kAges);
  });
  if (HasFatalFailure()) return;
  EXPECT_NEAR(stress.Difference(), 0, kMeanStress);
  const std::string where = GetParam().Name();
  e.Expect(where, kVoidRatio);
  height.Expect(where, kRelativeHeight * height.liggghts.Mean());
  z.Expect(where, kCoordination);
}

std::vector<Case> Cases() {
  std::vector<Case> cases;
  for (const auto tangential :
       {ContactLaw::Tangential::history, ContactLaw::Tangential::no_history}) {
    for (const bool cohesive : {false, true}) {
      for (const double stress : {300.0, 900.0, 1400.0}) {
        cases.push_back({stress, tangential, cohesive});
      }
    }
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Liggghts, BedsInTwoEngines, ::testing::ValuesIn(Cases()),
                         [](const auto& c) { return c.param.Name(); });

// --- The experiment ------------------------------------------------------------------------------

// As `powdercal simulate quickstart -p k=7000 -p mu_r=0.4` plans it.
TEST(ConsolidationInTwoEngines, GivesTheSameVoidRatio) {
  const Study study = Study::Load("quickstart");
  const Planner planner(study);
  std::vector<Program> programs;
  for (int replicate = 0; replicate < kSeeds; ++replicate) {
    programs.push_back(planner.Plan({7000, 0.4}, replicate)[0].program);
  }
  Figure e{.name = "void ratio"};
  Figure z{.name = "coordination"};
  RunAll(programs, [&](std::size_t n, const TwoTraces& traces) {
    const auto add = [&](const Trace& trace, Sample Figure::*side) {
      Outcome outcome;
      const Measurement measured = Consolidation().Measure(programs[n], trace, &outcome);
      ASSERT_TRUE(outcome.ok()) << outcome.message;
      (e.*side).values.push_back(measured.responses.at("void_ratio").value);
      (z.*side).values.push_back(measured.diagnostics.at("coordination_number"));
    };
    add(traces.liggghts, &Figure::liggghts);
    add(traces.embedded, &Figure::embedded);
  });
  if (HasFatalFailure()) return;
  e.Expect("quickstart, k = 7000 J/m3, mu_r = 0.4", kVoidRatio);
  z.Expect("quickstart, k = 7000 J/m3, mu_r = 0.4", kCoordination);
}

}  // namespace
}  // namespace powdercal::physics

#include "experiments/shear.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>
#include <set>

#include "experiments/shear_series.h"

namespace powdercal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kLaboratoryPreshear = 9000;  // [Pa]
constexpr double kPreshear = 900;             // [Pa] of the simulation
constexpr double kUnit = kLaboratoryPreshear / kPreshear;

SimulatedPowder Powder() {
  SimulatedPowder powder;
  powder.sizes = {SizeDistribution::Kind::normal, 29e-6, 6e-6, 12.5e-6, 37.5e-6};
  const ContactParameters contact{.restitution = 0.4, .friction = 0.3, .rolling_friction = 0.2};
  powder.materials = {8220, 5e6, 0.3, contact, contact, {}};
  powder.law.rolling = ContactLaw::Rolling::epsd2;
  return powder;
}

Shear At(const std::string& options) {
  Shear shear;
  ReadYaml(options, "x.yaml", [&](Archive& archive) { shear.Serialize(archive); });
  return shear;
}

Program PlanOf(const Shear& shear, Fidelity fidelity = Fidelity::quick) {
  const Conditions conditions{.stress = kPreshear};
  return shear.Plan(Powder(), conditions, {}, fidelity, 7);
}

template <typename T>
std::vector<T> StagesOf(const Program& program) {
  std::vector<T> stages;
  for (const Stage& stage : program.stages) {
    if (const T* found = std::get_if<T>(&stage)) stages.push_back(*found);
  }
  return stages;
}

// --- Planning -----------------------------------------------------------------------------------

TEST(Shear, EveryYieldPointStartsFromASavedState) {
  for (const char* cell : {"periodic", "platens"}) {
    const Program program = PlanOf(At(fmt::format("preshear: 9 kPa\nrepeats: 3\ncell: {}", cell)));
    EXPECT_EQ(StagesOf<Save>(program).size(), 3U) << cell;
    std::set<std::string> saved;
    for (std::size_t i = 0; i < program.stages.size(); ++i) {
      if (const Save* save = std::get_if<Save>(&program.stages[i])) saved.insert(save->name);
      if (const Restore* restore = std::get_if<Restore>(&program.stages[i])) {
        EXPECT_TRUE(saved.contains(restore->name));
      }
      const std::string& name = MomentName(program.stages[i]);
      if (!name.starts_with(kYieldPrefix)) continue;
      const bool servo = std::holds_alternative<Servo>(program.stages[i - 1]);
      const auto* restore = std::get_if<Restore>(&program.stages[i - (servo ? 2 : 1)]);
      ASSERT_NE(restore, nullptr) << name;
      EXPECT_EQ(restore->name, fmt::format("state_{}", name[6])) << name;
    }
  }
}

TEST(Shear, StatesLieInTheSecondHalfOfThePreshear) {
  const Program program = PlanOf(At("preshear: 9 kPa\nrepeats: 3\npreshear_strain: 4"));
  std::vector<double> strains;
  for (const Deform& deform : StagesOf<Deform>(program)) {
    if (deform.name.starts_with(kPreshearPrefix)) {
      strains.push_back(deform.duration * deform.shear_rate);
    }
  }
  ASSERT_EQ(strains.size(), 3U);
  EXPECT_NEAR(strains[0], 2, 1e-12);
  EXPECT_NEAR(strains[1], 1, 1e-12);
  EXPECT_NEAR(strains[2], 1, 1e-12);
}

TEST(Shear, InertialNumberIsTheSameAtEveryNormalStress) {
  const Program program = PlanOf(At("preshear: 9 kPa\ninertial_number: 0.003"));
  int yields = 0;
  for (const Deform& deform : StagesOf<Deform>(program)) {
    const double normal = deform.edges[2].value;
    const double time = program.particles.sizes.Moment(1) * std::sqrt(8220 / normal);
    EXPECT_NEAR(deform.shear_rate * time, 0.003, 1e-12);
    yields += normal < kPreshear ? 1 : 0;
  }
  EXPECT_EQ(yields, 3 * 5);
}

TEST(Shear, DefaultNormalStressesAreNinthsOfThePreshear) {
  std::set<int> normals;
  for (const Deform& deform : StagesOf<Deform>(PlanOf(At("preshear: 9 kPa")))) {
    normals.insert(static_cast<int>(std::lround(deform.edges[2].value)));
  }
  EXPECT_THAT(normals, ElementsAre(300, 500, 700, 900));
}

TEST(Shear, PlatensHoldTheSmallestParticles) {
  const Program program = PlanOf(At("preshear: 9 kPa\ncell: platens"));
  EXPECT_EQ(program.gravity, (Vector3{0, 0, 0}));
  ASSERT_EQ(program.groups.size(), 1U);
  const std::set<std::int64_t> glued(program.groups[0].ids.begin(), program.groups[0].ids.end());
  EXPECT_EQ(program.particles.packing->size(), 1000 + glued.size());
  // Nowhere in the layer's plane is there room for a sphere of half the smallest diameter.
  Packing layers;
  for (const Sphere& s : *program.particles.packing) {
    if (glued.contains(s.id)) {
      layers.push_back(s);
    } else {
      EXPECT_GT(s.position[2], s.radius + 0.5 * 29e-6);
    }
  }
  const Vector3 lengths = program.domain.Lengths();
  const double hole = 0.25 * program.particles.sizes.Quantile(0);
  double widest = 0;
  constexpr int kGrid = 120;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    double nearest = 1;
    for (const Sphere& s : layers) {
      const double x = std::remainder(s.position[0] - lengths[0] * (i % kGrid) / kGrid, lengths[0]);
      const double y = std::remainder(s.position[1] - lengths[1] * (i / kGrid) / kGrid, lengths[1]);
      nearest = std::min(nearest, std::hypot(x, y) - s.radius);
    }
    widest = std::max(widest, nearest);
  }
  EXPECT_GT(widest, 0);
  EXPECT_LE(widest, 1.01 * hole);
}

TEST(Shear, RidgesMeetTheirPeriodicImage) {
  const Program program = PlanOf(At("preshear: 9 kPa\ncell: platens"));
  const std::vector<Vector3>& vertices = program.meshes.at(0).vertices;
  EXPECT_EQ(vertices.front()[0], 0);
  EXPECT_EQ(vertices.back()[0], program.domain.upper[0]);
  EXPECT_EQ(vertices.front()[2], vertices.back()[2]);
}

TEST(Shear, RefusesBadOptions) {
  EXPECT_THROW(At("inertial_number: 0.001"), InputError) << "preshear is required";
  EXPECT_THROW(At("preshear: 9 kPa\nnormal_stresses: [3 kPa]"), InputError);
  EXPECT_THROW(At("preshear: 9 kPa\nnormal_stresses: [3 kPa, 3 kPa]"), InputError);
  EXPECT_THROW(At("preshear: 9 kPa\nnormal_stresses: [3 kPa, 10 kPa]"), InputError);
  EXPECT_THROW(At("preshear: 9 kPa\ncell: annular"), InputError);
  EXPECT_THROW(At("preshear: 9 kPa\ninertial_number: 1"), InputError);
}

TEST(Shear, RefusesALawWithoutStaticFriction) {
  SimulatedPowder powder = Powder();
  EXPECT_EQ(At("preshear: 9 kPa").ExplainUnsupported(powder), "");
  powder.law.tangential = ContactLaw::Tangential::no_history;
  EXPECT_THAT(At("preshear: 9 kPa").ExplainUnsupported(powder), HasSubstr("static friction"));
}

TEST(Shear, WarnsOfChatterOfCdtOnly) {
  const Shear shear = At("preshear: 9 kPa");
  Program program = PlanOf(shear);
  EXPECT_THAT(shear.Warnings(program), IsEmpty());
  program.law.rolling = ContactLaw::Rolling::cdt;
  EXPECT_THAT(shear.Warnings(program), ElementsAre(HasSubstr("dithers")));
  program.materials.particle_particle.rolling_friction = 0.05;
  EXPECT_THAT(shear.Warnings(program), IsEmpty());
}

TEST(Shear, DescribesTheRateOfTheSimulationOnly) {
  const Shear shear = At("preshear: 9 kPa");
  Conditions conditions{.gravity = 9.81};
  shear.DescribeConditions(Fidelity::quick, conditions);
  EXPECT_EQ(conditions.stress, kLaboratoryPreshear);
  EXPECT_FALSE(conditions.shear_rate);
  conditions.stress = kPreshear;
  shear.DescribeSimulation(Powder(), Fidelity::quick, conditions);
  const double time = Powder().sizes.Moment(1) * std::sqrt(8220 / kPreshear);
  EXPECT_NEAR(*conditions.shear_rate * time, 4e-3, 1e-12);
  EXPECT_FALSE(conditions.gravity) << "it has no part in the test";
}

TEST(Shear, HasAResponseForEachNormalStress) {
  const Shear shear = At("preshear: 9 kPa\nnormal_stresses: [7 kPa, 3 kPa]");
  std::vector<std::string> names;
  for (const ResponseDescription& response : shear.responses()) {
    names.push_back(response.name);
    if (response.name == "shear_stress_1") {
      EXPECT_THAT(response.description, HasSubstr("7 kPa"));
    }
  }
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
  EXPECT_THAT(names, ::testing::Contains("shear_stress_2"));
  EXPECT_THAT(names, ::testing::Not(::testing::Contains("shear_stress_3")));
}

// --- Measuring ----------------------------------------------------------------------------------

// What the cell is made to show: stresses over the strain of a stage under a normal stress.
using Law = std::function<StressPair(const std::string& stage, double normal, double strain)>;

constexpr double kVoidRatio = 0.8;

// A trace of the periodic cell without a simulation: windows of 100 steps, edges that give a void
// ratio of 0.8.
Trace MadeUp(const Program& program, const Law& law) {
  Trace trace;
  Moment moment;
  moment.packing = {{.id = 1, .radius = 1e-6}};
  const double solid = 4.0 / 3 * std::numbers::pi * 1e-18;
  const double edge = std::cbrt(solid * (1 + kVoidRatio));
  double begin = 0;
  for (const Deform& deform : StagesOf<Deform>(program)) {
    const double window = 100 * program.time_step;
    for (double t = window; t <= deform.duration; t += window) {
      const StressPair stress = law(deform.name, deform.edges[2].value, t * deform.shear_rate);
      std::array<Vector3, 3> tensor{};
      tensor[0][2] = tensor[2][0] = -stress.shear;
      tensor[2][2] = stress.normal;
      trace.cell.time.push_back(begin + t);
      trace.cell.strain.push_back(0);
      trace.cell.lengths.push_back({edge, edge, edge});
      trace.cell.stress.push_back(tensor);
    }
    begin += deform.duration;
    moment.name = deform.name;
    moment.time = begin;
    trace.moments.push_back(moment);
  }
  return trace;
}

constexpr double kCohesion = 50;  // [Pa] of the simulation
constexpr double kTanPhi = 0.45;

// A Coulomb powder: its normal stress falls to the target within a strain of 0.005; past a plateau
// its shear stress decays.
StressPair Coulomb(const std::string& stage, double normal, double strain) {
  if (stage == "preshear_1") return {normal, 450 * (1 - std::exp(-strain / 0.1))};
  if (stage.starts_with(kPreshearPrefix)) return {normal, 450};
  const double now = normal + (kPreshear - normal) * std::exp(-strain / 0.001);
  const double decay = 1 - 0.5 * std::max(0.0, strain - 0.03);
  return {now, decay * (kCohesion + kTanPhi * now)};
}

TEST(Shear, MeasuresAKnownLocusInLaboratoryStresses) {
  const Shear shear = At("preshear: 9 kPa\npreshear_strain: 6");
  const Program program = PlanOf(shear);
  Outcome outcome;
  const Measurement measured = shear.Measure(program, MadeUp(program, Coulomb), &outcome);
  ASSERT_TRUE(outcome.ok()) << outcome.message;
  const auto value = [&](const char* name) { return measured.responses.at(name).value; };
  EXPECT_NEAR(value("steady_state_void_ratio"), kVoidRatio, 1e-9);
  EXPECT_NEAR(value("steady_state_bulk_density"), 8220 / (1 + kVoidRatio), 1e-6);
  EXPECT_NEAR(value("steady_state_friction"), 0.5, 1e-3);
  EXPECT_NEAR(value("preshear_shear_stress"), 4500, 5);
  EXPECT_NEAR(value("tan_phi"), kTanPhi, 2e-3);
  EXPECT_NEAR(value("phi"), std::atan(kTanPhi), 2e-3);
  EXPECT_NEAR(value("cohesion"), kCohesion * kUnit, 10);
  EXPECT_NEAR(value("shear_stress_1"), kUnit * (kCohesion + kTanPhi * 300), 10);
  EXPECT_NEAR(value("shear_stress_3"), kUnit * (kCohesion + kTanPhi * 700), 10);
  EXPECT_NEAR(value("unconfined_yield_strength"),
              2 * value("cohesion") * (kTanPhi + std::hypot(1, kTanPhi)), 1e-6);
  EXPECT_NEAR(value("inverse_ffc"),
              value("unconfined_yield_strength") / value("major_principal_stress"), 1e-9);
  EXPECT_NEAR(measured.diagnostics.at("yield_normal_stress_1"), 300, 5);
  // Every response that is promised is there, and no other.
  EXPECT_EQ(measured.responses.size(), shear.responses().size());
  for (const ResponseDescription& response : shear.responses()) {
    EXPECT_TRUE(measured.responses.contains(response.name)) << response.name;
  }
}

TEST(Shear, ProratingTakesOutTheFluctuationOfTheState) {
  const Shear shear = At("preshear: 9 kPa\npreshear_strain: 12");
  const Program program = PlanOf(shear);
  // Each state, and with it all its yield points, is stronger or weaker than the mean.
  const auto factor = [](char state) { return 1 + 0.08 * std::sin(2.4 * (state - '0')); };
  const auto law = [&](const std::string& stage, double normal, double strain) {
    StressPair stress = Coulomb(stage, normal, strain);
    if (stage.starts_with(kYieldPrefix)) {
      stress.shear *= factor(stage[6]);
    } else {
      const double duration = stage == "preshear_1" ? 6 : 1.5;
      if (strain > duration - 0.04) stress.shear *= factor(stage[9]);
    }
    return stress;
  };
  Outcome outcome;
  const Measurement measured = shear.Measure(program, MadeUp(program, law), &outcome);
  ASSERT_TRUE(outcome.ok()) << outcome.message;
  EXPECT_GT(measured.diagnostics.at("plain_scatter"), 0.04);
  EXPECT_LT(measured.diagnostics.at("prorated_scatter"), 1e-6);
  EXPECT_NEAR(measured.responses.at("tan_phi").value, kTanPhi, 4e-3);
}

TEST(Shear, NegativeCohesionOfNoiseIsNoFailure) {
  const Shear shear = At("preshear: 9 kPa");
  const Program program = PlanOf(shear);
  const auto law = [](const std::string& stage, double normal, double strain) {
    StressPair stress = Coulomb(stage, normal, strain);
    if (stage.starts_with(kYieldPrefix)) stress.shear = 0.5 * stress.normal - 5;
    return stress;
  };
  Outcome outcome;
  const Measurement measured = shear.Measure(program, MadeUp(program, law), &outcome);
  ASSERT_TRUE(outcome.ok()) << outcome.message;
  EXPECT_LT(measured.responses.at("cohesion").value, 0);
  EXPECT_EQ(measured.responses.at("inverse_ffc").value, 0);
  EXPECT_EQ(measured.diagnostics.count("ffc"), 0U);
  EXPECT_EQ(measured.diagnostics.at("warning_cohesion_not_positive"), 1);
  for (const auto& [name, response] : measured.responses) {
    EXPECT_TRUE(std::isfinite(response.value)) << name;
    EXPECT_TRUE(std::isfinite(response.variance)) << name;
  }
}

std::string FailureOf(const Law& law) {
  const Shear shear = At("preshear: 9 kPa");
  const Program program = PlanOf(shear);
  Outcome outcome;
  const Measurement measured = shear.Measure(program, MadeUp(program, law), &outcome);
  EXPECT_THAT(measured.responses, IsEmpty());
  EXPECT_EQ(outcome.reason, Reason::not_quasi_static);
  return outcome.message;
}

TEST(Shear, DriftIsNoSteadyState) {
  EXPECT_THAT(FailureOf([](const std::string& stage, double normal, double strain) {
                StressPair stress = Coulomb(stage, normal, strain);
                if (stage == "preshear_1") stress.shear = 100 + 200 * strain;
                if (stage > "preshear_1" && stage < "q") {
                  stress.shear = 340 + 200 * (strain + 0.3 * (stage[9] - '2'));
                }
                return stress;
              }),
              HasSubstr("no steady state"));
}

TEST(Shear, NormalStressThatIsMissed) {
  EXPECT_THAT(FailureOf([](const std::string& stage, double normal, double strain) {
                StressPair stress = Coulomb(stage, normal, strain);
                if (stage.starts_with(kPreshearPrefix)) stress.normal *= 0.9;
                return stress;
              }),
              HasSubstr("810 Pa instead of 900 Pa"));
}

TEST(Shear, YieldStressThatIsNeverReached) {
  EXPECT_THAT(FailureOf([](const std::string& stage, double normal, double strain) {
                StressPair stress = Coulomb(stage, normal, strain);
                if (stage == "yield_2_1") stress.normal = 600;
                return stress;
              }),
              HasSubstr("never within 20 % of 300 Pa"));
}

TEST(Shear, TraceWithoutSeriesIsACrash) {
  Outcome outcome;
  const Shear shear = At("preshear: 9 kPa");
  shear.Measure(PlanOf(shear), Trace{}, &outcome);
  EXPECT_EQ(outcome.reason, Reason::crashed);
}

// --- Platens ------------------------------------------------------------------------------------

// Series of the platens with constant stresses in each stage; `bottom` falsifies the stresses
// there.
Trace MadeUpPlatens(const Program& program, const StressPair& bottom) {
  Trace trace;
  const double area = program.domain.BaseArea();
  trace.series = {{.wall = kTopPlaten}, {.wall = kBottomPlaten}};
  Moment moment;
  moment.packing = *program.particles.packing;
  double begin = 0;
  double normal = 0;
  for (const Stage& stage : program.stages) {
    if (std::holds_alternative<Save>(stage) || std::holds_alternative<Restore>(stage)) continue;
    const auto* advance = std::get_if<Advance>(&stage);
    if (const Servo* servo = std::get_if<Servo>(&stage)) normal = servo->stress;
    if (advance != nullptr && advance->name.starts_with(kPreshearPrefix)) normal = kPreshear;
    const double duration = advance != nullptr ? advance->duration : 1e-4;
    const double shear = advance != nullptr ? kCohesion + kTanPhi * normal : 0;
    for (double t = 3e-5; t <= duration; t += 3e-5) {
      const double ramp = advance != nullptr && advance->name == "preshear_1"
                              ? 1 - std::exp(-t / (0.02 * duration))
                              : 1;
      for (WallSeries& series : trace.series) {
        const bool top = series.wall == kTopPlaten;
        series.time.push_back(begin + t);
        series.height.push_back(top ? 10 * 29e-6 : 0);
        const double sign = top ? 1 : -1;
        const StressPair extra = top ? StressPair{} : bottom;
        series.normal_force.push_back(sign * normal * area);
        series.force.push_back({-sign * area * (ramp * shear + extra.shear), 0,
                                sign * area * (normal + extra.normal)});
      }
      trace.slab.time.push_back(begin + t);
      trace.slab.solid_fraction.push_back(1 / (1 + kVoidRatio));
      std::array<Vector3, 3> tensor{};
      tensor[0][2] = tensor[2][0] = -ramp * shear;
      tensor[2][2] = normal;
      trace.slab.stress.push_back(tensor);
    }
    begin += duration;
    moment.name = MomentName(stage);
    moment.time = begin;
    trace.moments.push_back(moment);
  }
  return trace;
}

TEST(Shear, MeasuresBetweenPlatens) {
  const Shear shear = At("preshear: 9 kPa\ncell: platens");
  const Program program = PlanOf(shear);
  Outcome outcome;
  const Measurement measured = shear.Measure(program, MadeUpPlatens(program, {}), &outcome);
  ASSERT_TRUE(outcome.ok()) << outcome.message;
  EXPECT_NEAR(measured.responses.at("tan_phi").value, kTanPhi, 1e-3);
  EXPECT_NEAR(measured.responses.at("cohesion").value, kCohesion * kUnit, 5);
  EXPECT_NEAR(measured.responses.at("steady_state_void_ratio").value, kVoidRatio, 1e-9);
  EXPECT_NEAR(measured.diagnostics.at("normal_stress_bottom"), kPreshear, 1e-6);
  EXPECT_NEAR(measured.diagnostics.at("shear_stress_bottom"),
              measured.diagnostics.at("shear_stress_top"), 1e-6);
}

TEST(Shear, PlatensThatDisagreeAreRefused) {
  const Shear shear = At("preshear: 9 kPa\ncell: platens");
  const Program program = PlanOf(shear);
  for (const StressPair& extra : {StressPair{0, 60}, StressPair{60, 0}, StressPair{0, -60}}) {
    Outcome outcome;
    shear.Measure(program, MadeUpPlatens(program, extra), &outcome);
    EXPECT_EQ(outcome.reason, Reason::not_quasi_static);
    EXPECT_THAT(outcome.message, HasSubstr("at the bottom"));
  }
  Outcome outcome;
  shear.Measure(program, MadeUpPlatens(program, {30, 30}), &outcome);
  EXPECT_TRUE(outcome.ok()) << outcome.message;
}

// --- Observed data ------------------------------------------------------------------------------

std::vector<ObservedValue> Observe(Shear* shear, const std::string& csv) {
  const std::string path = ::testing::TempDir() + "locus.csv";
  std::ofstream(path) << csv;
  return shear->ReadObserved("yield_locus", path);
}

constexpr const char* kHeader =
    "normal_stress [kPa],shear_stress [kPa],shear_stress_sd [kPa],preshear [1]\n";

TEST(Shear, TakesNormalStressesFromTheFile) {
  Shear shear = At("preshear: 9 kPa");
  const auto observed = Observe(&shear, std::string(kHeader) +
                                            "9,4.5,0.2,1\n9,4.7,0.2,1\n7,3.6,0.1,0\n"
                                            "4,2.1,0.1,0\n4.01,2.3,0.1,0\n");
  ASSERT_EQ(observed.size(), 3U);
  EXPECT_EQ(observed[0].response, "shear_stress_1");
  EXPECT_NEAR(observed[0].value, 2200, 1e-9) << "the mean of two trials";
  EXPECT_EQ(observed[1].response, "shear_stress_2");
  EXPECT_NEAR(observed[1].sd, 100, 1e-9);
  EXPECT_EQ(observed[2].response, "preshear_shear_stress");
  EXPECT_NEAR(observed[2].value, 4600, 1e-9);
  EXPECT_EQ(StagesOf<Deform>(PlanOf(shear))[1].edges[2].value, 0.1 * 4005);
}

TEST(Shear, FileMustMatchTheStudy) {
  Shear shear = At("preshear: 9 kPa\nnormal_stresses: [7 kPa, 3 kPa]");
  const auto observed = Observe(&shear, std::string(kHeader) + "3.02,1.6,0.1,0\n7,3.6,0.1,0\n");
  ASSERT_EQ(observed.size(), 2U);
  EXPECT_EQ(observed[0].response, "shear_stress_2") << "in the order of the study's list";
  EXPECT_THROW(Observe(&shear, std::string(kHeader) + "3.1,1.6,0.1,0\n7,3.6,0.1,0\n"), InputError);
  EXPECT_THROW(Observe(&shear, std::string(kHeader) + "6,3.1,0.1,1\n3,1.6,0.1,0\n7,3.6,0.1,0\n"),
               InputError);
}

TEST(Shear, FileNeedsStandardDeviations) {
  Shear shear = At("preshear: 9 kPa");
  EXPECT_THROW(Observe(&shear, "normal_stress [kPa],shear_stress [kPa]\n3,1.6\n7,3.6\n"),
               InputError);
  EXPECT_THROW(Observe(&shear, std::string(kHeader) + "3,1.6,0,0\n7,3.6,0.1,0\n"), InputError);
}

TEST(Shear, ResolvedOptionsReadBack) {
  Shear shear = At("preshear: 9 kPa\ncell: platens\nrepeats: 2");
  const std::string text = WriteYaml([&](Archive& archive) { shear.Serialize(archive); });
  Shear again = At(text);
  EXPECT_EQ(WriteYaml([&](Archive& archive) { again.Serialize(archive); }), text);
  EXPECT_EQ(PlanOf(again).Hash(), PlanOf(shear).Hash());
}

}  // namespace
}  // namespace powdercal

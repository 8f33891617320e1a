#include "scaling/groups.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scaling/scaling.h"

namespace powdercal {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;
using Verdict = GroupComparison::Verdict;

// The bed of the paper's consolidation: 500 000 spheres of the mean diameter on 2 x 2 mm, 2.85 mm
// high. Its weight per area is 128.7 Pa.
constexpr double kDiameter = 29e-6;
constexpr double kHeight = 2.85e-3;
constexpr double kSolidFraction =
    5e5 * pi / 6 * kDiameter * kDiameter * kDiameter / (2e-3 * 2e-3 * kHeight);

Conditions Powder() {
  return {.young_modulus = 200e9,
          .poisson_ratio = 0.3,
          .density = 8220,
          .diameter = kDiameter,
          .gravity = 9.81,
          .bulk_solid_fraction = kSolidFraction,
          .bed_height = kHeight};
}

Conditions Laboratory() {
  Conditions conditions = Powder();
  conditions.stress = 9e3;
  conditions.surface_energy = 1e-4;
  return conditions;
}

Conditions Simulation(double stress, double young_modulus, double k) {
  Conditions conditions = Powder();
  conditions.stress = stress;
  conditions.young_modulus = young_modulus;
  conditions.cohesion_energy_density = k;
  return conditions;
}

std::optional<double> Evaluate(const Conditions& conditions, const std::string& symbol) {
  for (const auto& [name, value] : EvaluateGroups(conditions)) {
    if (name == symbol) return value;
  }
  return std::nullopt;
}

GroupComparison Compare(const Conditions& experiment, const Conditions& simulation,
                        const std::string& symbol) {
  for (const GroupComparison& group : CompareGroups(experiment, simulation)) {
    if (group.symbol == symbol) return group;
  }
  ADD_FAILURE() << "no group " << symbol;
  return {};
}

struct Printed {
  double value;
  int digits;  // significant
};

struct Row {
  const char* name;
  Conditions conditions;
  Printed sigma_over_e, kappa, pull_off, bond, load_over_weight, weight_over_modulus;
};

void ExpectPrinted(const Row& row, const char* symbol, const Printed& printed) {
  const auto value = Evaluate(row.conditions, symbol);
  ASSERT_TRUE(value.has_value()) << row.name << ", " << symbol;
  const auto round = [&](double x) { return fmt::format("{:.{}e}", x, printed.digits - 1); };
  EXPECT_EQ(round(*value), round(printed.value)) << row.name << ", " << symbol;
}

// The simulation that is exactly similar to the laboratory's at E = 5 MPa: sigma and g scale as E,
// and k follows from equal F_c/(sigma d²).
Conditions ExactlySimilar() {
  const double scale = 5e6 / 200e9;
  const double effective_radius = kDiameter / 4;
  const double modulus = EffectiveModulus(5e6, 0.3);
  const double force = scale * PullOffForceDmt(1e-4, effective_radius);
  const double k = std::cbrt(3 * force * modulus * modulus /
                             (16 * pi * pi * pi * effective_radius * effective_radius));
  Conditions conditions = Simulation(9e3 * scale, 5e6, k);
  conditions.gravity = 9.81 * scale;
  return conditions;
}

TEST(PaperCases, ReproduceThePrintedTable) {
  const Row rows[] = {
      {"experiment",
       Laboratory(),
       {4.5e-8, 2},
       {8.4e4, 2},
       {1.2e-3, 2},
       {8.8, 2},
       {70, 2},
       {1.2e-11, 2}},
      {"calibration",
       Simulation(900, 5e6, 47500),
       {1.8e-4, 2},
       {334, 3},
       {0.163, 3},
       {120, 3},
       {7, 1},
       {4.7e-7, 2}},
      {"section 4.1",
       Simulation(0.225, 5e6, 48000),
       {4.5e-8, 2},
       {8.4e4, 2},
       {673, 3},
       {124, 3},
       {0.0017, 2},
       {4.7e-7, 2}},
      {"spreading",
       Simulation(45, 5e6, 15833),
       {9e-6, 1},
       {2460, 3},
       {0.12, 2},
       {4.4, 2},
       {0.35, 2},
       {4.7e-7, 2}},
      {"exact",
       ExactlySimilar(),
       {4.5e-8, 2},
       {8.4e4, 2},
       {1.2e-3, 2},
       {8.8, 2},
       {70, 2},
       {1.2e-11, 2}},
      {"rigid limit A",
       Simulation(9e3, 0.26e9, 2.77e5),
       {3.5e-5, 2},
       {1e3, 1},
       {1.2e-3, 2},
       {8.8, 2},
       {70, 2},
       {9e-9, 1}},
      {"rigid limit B",
       Simulation(9e3, 8.2e9, 2.77e6),
       {1.1e-6, 2},
       {1e4, 1},
       {1.2e-3, 2},
       {8.8, 2},
       {70, 2},
       {2.9e-10, 2}},
  };
  for (const Row& row : rows) {
    ExpectPrinted(row, "sigma/E", row.sigma_over_e);
    ExpectPrinted(row, "kappa", row.kappa);
    ExpectPrinted(row, "F_c/(sigma d^2)", row.pull_off);
    ExpectPrinted(row, "Bo", row.bond);
    ExpectPrinted(row, "sigma/(rho_b g h)", row.load_over_weight);
    ExpectPrinted(row, "rho g d/E", row.weight_over_modulus);
  }
}

// The table names the row by k = 583 J/m3 and g = 2.45e-4 m/s2, rounded from these; with the
// rounded k itself Bo would print as 8.9.
TEST(PaperCases, ExactRowHasTheNamedParameters) {
  const Conditions exact = ExactlySimilar();
  EXPECT_EQ(std::round(*exact.cohesion_energy_density), 583);
  EXPECT_NEAR(*exact.gravity, 2.45e-4, 0.005e-4);
  for (const GroupComparison& group : CompareGroups(Laboratory(), exact)) {
    if (group.symbol == "k/E" || group.symbol == "W/(m g d)" || group.symbol == "delta_0/d" ||
        group.symbol == "F_w/F_c") {
      continue;  // DMT and SJKR2 can agree in force, but not in shape
    }
    EXPECT_EQ(group.verdict, Verdict::ok) << group.symbol;
    EXPECT_NEAR(*group.ratio, 1, 1e-12) << group.symbol;
  }
}

TEST(PaperCases, Section41IsTwoPlainWarnings) {
  const Conditions simulation = Simulation(0.225, 5e6, 48000);
  const auto weight = Compare(Laboratory(), simulation, "sigma/(rho_b g h)");
  EXPECT_EQ(weight.verdict, Verdict::violated);
  EXPECT_THAT(weight.remark, HasSubstr("self-weight exceeds the applied stress 572 times: the void "
                                       "ratio follows gravity, not the stress"));
  const auto cohesion = Compare(Laboratory(), simulation, "F_c/(sigma d^2)");
  EXPECT_EQ(cohesion.verdict, Verdict::violated);
  EXPECT_THAT(cohesion.remark, HasSubstr("cohesion is 5.6e5 times too strong against the load"));
  EXPECT_EQ(Compare(Laboratory(), simulation, "sigma/E").verdict, Verdict::ok);
}

TEST(PaperCases, CalibrationWarnsOfSoftness) {
  const Conditions simulation = Simulation(900, 5e6, 47500);
  const auto stress = Compare(Laboratory(), simulation, "sigma/E");
  EXPECT_EQ(stress.verdict, Verdict::violated);
  EXPECT_NEAR(*stress.ratio, 4000, 1e-9);
  EXPECT_THAT(stress.remark, HasSubstr("4000 times too soft"));
  EXPECT_EQ(Compare(Laboratory(), simulation, "kappa").verdict, Verdict::violated);
  EXPECT_EQ(Compare(Laboratory(), simulation, "delta_0/d").verdict, Verdict::violated);
  // Exactly a factor of ten is not beyond it.
  EXPECT_EQ(Compare(Laboratory(), simulation, "sigma/(rho_b g h)").verdict, Verdict::warn);
}

TEST(Verdicts, RigidOnBothSidesIsNoAlarm) {
  const Conditions simulation = Simulation(9e3, 0.26e9, 2.77e5);
  for (const char* symbol : {"sigma/E", "kappa", "rho g d/E"}) {
    const auto group = Compare(Laboratory(), simulation, symbol);
    EXPECT_EQ(group.verdict, Verdict::ok) << symbol;
    EXPECT_THAT(group.remark, HasSubstr("should not matter")) << symbol;
  }
  EXPECT_EQ(Compare(Laboratory(), simulation, "F_c/(sigma d^2)").verdict, Verdict::ok);
}

TEST(Verdicts, QuasiStaticOnBothSidesIsNoAlarm) {
  Conditions experiment = Laboratory();
  experiment.shear_rate = 1e-2;
  Conditions simulation = experiment;
  simulation.shear_rate = 30;  // I = 8e-4
  auto group = Compare(experiment, simulation, "I");
  EXPECT_EQ(group.verdict, Verdict::ok);
  EXPECT_THAT(group.remark, HasSubstr("quasi-static"));
  simulation.shear_rate = 300;
  group = Compare(experiment, simulation, "I");
  EXPECT_EQ(group.verdict, Verdict::violated);
  EXPECT_THAT(group.remark, HasSubstr("too fast"));
}

TEST(Verdicts, FollowTheFactorEitherWay) {
  Conditions experiment;
  experiment.friction = 0.3;
  const auto verdict = [&](double factor) {
    Conditions simulation;
    simulation.friction = 0.3 * factor;
    return Compare(experiment, simulation, "mu").verdict;
  };
  EXPECT_EQ(verdict(1), Verdict::ok);
  EXPECT_EQ(verdict(1.1), Verdict::ok);
  EXPECT_EQ(verdict(1 / 1.1), Verdict::ok);
  EXPECT_EQ(verdict(1.11), Verdict::warn);
  EXPECT_EQ(verdict(10), Verdict::warn);
  EXPECT_EQ(verdict(0.1), Verdict::warn);
  EXPECT_EQ(verdict(10.1), Verdict::violated);
  EXPECT_EQ(verdict(0.099), Verdict::violated);
}

TEST(Verdicts, ZeroAndUnknownSides) {
  Conditions experiment = Laboratory();
  Conditions simulation = Simulation(900, 5e6, 0);
  auto group = Compare(experiment, simulation, "Bo");
  EXPECT_EQ(group.verdict, Verdict::violated);
  EXPECT_EQ(group.ratio, 0);
  EXPECT_THAT(group.remark, HasSubstr("zero in the simulation"));

  experiment.surface_energy = 0;
  group = Compare(experiment, simulation, "Bo");
  EXPECT_EQ(group.verdict, Verdict::ok);

  group = Compare(experiment, Simulation(900, 5e6, 1e4), "Bo");
  EXPECT_EQ(group.verdict, Verdict::violated);
  EXPECT_FALSE(group.ratio.has_value());
  EXPECT_THAT(group.remark, HasSubstr("zero in the experiment"));

  experiment.surface_energy.reset();
  group = Compare(experiment, simulation, "Bo");
  EXPECT_EQ(group.verdict, Verdict::unknown);
  EXPECT_FALSE(group.ratio.has_value());
  EXPECT_EQ(group.remark, "");
  EXPECT_EQ(ToString(group.verdict), "unknown");
}

TEST(Verdicts, RemarkWhereNotMatched) {
  for (const auto& simulation : {Simulation(900, 5e6, 47500), Simulation(45, 5e6, 15833)}) {
    for (const GroupComparison& group : CompareGroups(Laboratory(), simulation)) {
      if (group.verdict == Verdict::warn || group.verdict == Verdict::violated) {
        EXPECT_NE(group.remark, "") << group.symbol;
      } else if (!group.remark.empty()) {
        EXPECT_THAT(group.remark, HasSubstr("should not matter")) << group.symbol;
      }
      EXPECT_THAT(group.remark, ::testing::Not(HasSubstr("{"))) << group.symbol;
    }
  }
}

TEST(Groups, OrderAndPresence) {
  Conditions all = Laboratory();
  all.cohesion_energy_density = 1e4;
  all.shear_rate = 1;
  all.velocity = 0.025;
  all.gap = 80e-6;
  all.width = 2e-3;
  all.friction = 0.3;
  all.wall_friction = 0.3;
  all.rolling_friction = 0.1;
  all.restitution = 0.4;
  std::vector<std::string> symbols;
  for (const auto& [symbol, value] : EvaluateGroups(all)) symbols.push_back(symbol);
  EXPECT_THAT(symbols, ::testing::ElementsAre(
                           "sigma/E", "kappa", "k/E", "rho g d/E", "sigma/(rho_b g h)",
                           "F_c/(sigma d^2)", "Bo", "W/(m g d)", "I", "V/sqrt(g d)", "gap/d", "L/d",
                           "delta_0/d", "F_w/F_c", "nu", "mu", "mu_w", "mu_r", "e_n"));
  EXPECT_TRUE(EvaluateGroups({}).empty());
  EXPECT_TRUE(CompareGroups({}, {}).empty());
  EXPECT_NEAR(*Evaluate(all, "V/sqrt(g d)"), 0.025 / std::sqrt(9.81 * kDiameter), 1e-12);
  EXPECT_NEAR(*Evaluate(all, "I"), kDiameter * std::sqrt(8220 / 9e3), 1e-12);
  EXPECT_NEAR(*Evaluate(all, "gap/d"), 80.0 / 29, 1e-12);
}

TEST(Groups, NoGravityNoWeightGroups) {
  Conditions conditions = Laboratory();
  conditions.gravity = 0;
  conditions.velocity = 1;
  for (const char* symbol : {"sigma/(rho_b g h)", "Bo", "W/(m g d)", "V/sqrt(g d)"}) {
    EXPECT_FALSE(Evaluate(conditions, symbol).has_value()) << symbol;
  }
  EXPECT_EQ(*Evaluate(conditions, "rho g d/E"), 0);
}

// Force of two spheres at overlap x, for checking the closed forms numerically.
double SjkrForce(double x, double k, double radius, double modulus) {
  return 4.0 / 3 * modulus * std::sqrt(radius) * std::pow(x, 1.5) - 4 * pi * k * radius * x;
}

TEST(ContactFormulas, AgreeWithTheForceLaw) {
  constexpr double k = 47500;
  constexpr double radius = kDiameter / 4;
  const double modulus = EffectiveModulus(5e6, 0.3);
  EXPECT_DOUBLE_EQ(modulus, 5e6 / 1.82);

  const double equilibrium = EquilibriumOverlapSjkr2(k, radius, modulus);
  const double pull_off = PullOffForceSjkr2(k, radius, modulus);
  EXPECT_NEAR(SjkrForce(equilibrium, k, radius, modulus) / pull_off, 0, 1e-12);
  EXPECT_NEAR(SjkrForce(equilibrium * 4 / 9, k, radius, modulus) / pull_off, -1, 1e-12);
  double deepest = 0;
  double work = 0;  // midpoint rule
  constexpr int kSteps = 100000;
  for (int i = 0; i < kSteps; ++i) {
    const double force = SjkrForce((i + 0.5) / kSteps * equilibrium, k, radius, modulus);
    deepest = std::min(deepest, force);
    work -= force * equilibrium / kSteps;
  }
  EXPECT_NEAR(deepest / pull_off, -1, 1e-8);
  EXPECT_NEAR(pull_off / (165.4 * std::pow(k, 3) * radius * radius / (modulus * modulus)), 1, 1e-3);
  EXPECT_NEAR(equilibrium / kDiameter / (22.2 * std::pow(k / modulus, 2)), 1, 1e-3);

  const Conditions simulation = Simulation(900, 5e6, k);
  const double weight = 8220 * pi / 6 * std::pow(kDiameter, 3) * 9.81;
  const double well = *Evaluate(simulation, "W/(m g d)") * weight * kDiameter;
  EXPECT_NEAR(well / work, 1, 1e-6);
  EXPECT_NEAR(
      well / (32.4 * std::pow(pi, 5) * std::pow(k, 5) * std::pow(radius, 3) / std::pow(modulus, 4)),
      1, 1e-12);
}

TEST(ContactFormulas, DmtWellAgreesWithTheForceLaw) {
  const Conditions experiment = Laboratory();
  constexpr double radius = kDiameter / 4;
  const double modulus = EffectiveModulus(200e9, 0.3);
  const double pull_off = PullOffForceDmt(1e-4, radius);
  EXPECT_DOUBLE_EQ(pull_off, 4 * pi * 1e-4 * radius);
  const double equilibrium = *Evaluate(experiment, "delta_0/d") * kDiameter;
  const auto force = [&](double x) {
    return 4.0 / 3 * modulus * std::sqrt(radius) * std::pow(x, 1.5) - pull_off;
  };
  EXPECT_NEAR(force(equilibrium) / pull_off, 0, 1e-12);
  double work = 0;
  constexpr int kSteps = 100000;
  for (int i = 0; i < kSteps; ++i) work -= force((i + 0.5) / kSteps * equilibrium) / kSteps;
  work *= equilibrium;
  const double weight = 8220 * pi / 6 * std::pow(kDiameter, 3) * 9.81;
  EXPECT_NEAR(*Evaluate(experiment, "W/(m g d)") * weight * kDiameter / work, 1, 1e-6);
}

// k as it follows a reduced E: equal F_c wants E^(2/3), equal W wants E^(4/5).
TEST(ContactFormulas, ScalingOfCohesionWithStiffness) {
  constexpr double radius = kDiameter / 4;
  constexpr double factor = 1e-3;
  EXPECT_NEAR(PullOffForceSjkr2(1e5 * std::pow(factor, 2.0 / 3), radius, 1e9 * factor) /
                  PullOffForceSjkr2(1e5, radius, 1e9),
              1, 1e-12);
  EXPECT_NEAR(*Evaluate(Simulation(1, 1e9 * factor, 1e5 * std::pow(factor, 0.8)), "W/(m g d)") /
                  *Evaluate(Simulation(1, 1e9, 1e5), "W/(m g d)"),
              1, 1e-12);
}

TEST(Groups, CohesionEnergyDensityTakesPrecedence) {
  // A simulation whose surface energy was carried over from the powder runs with its k.
  Conditions simulation = Laboratory();
  simulation.cohesion_energy_density = 0;
  EXPECT_EQ(*Evaluate(simulation, "Bo"), 0);
}

TEST(Verdicts, HeavyLoadOnBothSidesMakesGravityHarmless) {
  Conditions simulation = Simulation(9e3, 0.26e9, 2.77e5);
  simulation.gravity = 9.81 / 4;
  for (const char* symbol : {"sigma/(rho_b g h)", "Bo"}) {
    const auto group = Compare(Laboratory(), simulation, symbol);
    EXPECT_NEAR(*group.ratio, 4, 0.1) << symbol;
    EXPECT_EQ(group.verdict, Verdict::ok) << symbol;
    EXPECT_THAT(group.remark, HasSubstr("ten times")) << symbol;
  }
  simulation.gravity = 9.81 * 10;  // the load is 7 times the weight
  EXPECT_EQ(Compare(Laboratory(), simulation, "sigma/(rho_b g h)").verdict, Verdict::warn);
}

// The tolerance and what matters depend on the test; each says where that comes from.
TEST(Relevance, DependsOnTheTest) {
  const Conditions experiment = Laboratory();
  Conditions simulation = experiment;
  *simulation.surface_energy *= 1.45;
  const auto verdict = [&](const std::string& test, const std::string& symbol) {
    for (const GroupComparison& group : CompareGroups(experiment, simulation, test)) {
      if (group.symbol != symbol) continue;
      EXPECT_NE(group.source, "") << test << ", " << symbol;
      return group.verdict;
    }
    return Verdict::unknown;
  };
  EXPECT_EQ(verdict("", "F_c/(sigma d^2)"), Verdict::warn);
  EXPECT_EQ(verdict("consolidation", "F_c/(sigma d^2)"), Verdict::ok);
  EXPECT_EQ(verdict("shear", "F_c/(sigma d^2)"), Verdict::warn);
  EXPECT_EQ(verdict("angle_of_repose", "W/(m g d)"), Verdict::warn);
  EXPECT_EQ(verdict("consolidation", "W/(m g d)"), Verdict::ok);
  simulation.cohesion_energy_density = 1e6;
  EXPECT_EQ(verdict("spreading", "F_w/F_c"), Verdict::warn);
  EXPECT_EQ(verdict("shear", "F_w/F_c"), Verdict::ok);
}

TEST(Walls, Sjkr2HoldsHalfAsMuchThereAndDmtTwiceAsMuch) {
  const auto group = Compare(Laboratory(), Simulation(900, 5e6, 47500), "F_w/F_c");
  EXPECT_EQ(*group.experiment, 2);
  EXPECT_EQ(*group.simulation, 0.5);
  EXPECT_EQ(group.verdict, Verdict::warn);
  EXPECT_FALSE(Evaluate(Simulation(900, 5e6, 0), "F_w/F_c").has_value());
  // The force law at a wall: 4/3 E* sqrt(r) x^1.5 - 2 pi k r x, with its least value.
  constexpr double k = 47500;
  constexpr double r = kDiameter / 2;
  const double modulus = EffectiveModulus(5e6, 0.3);
  double least = 0;
  for (int i = 0; i < 100000; ++i) {
    const double x = 1e-6 * i * r;
    least =
        std::min(least, 4.0 / 3 * modulus * std::sqrt(r) * std::pow(x, 1.5) - 2 * pi * k * r * x);
  }
  EXPECT_NEAR(-least / PullOffForceSjkr2(k, kDiameter / 4, modulus), 0.5, 1e-6);
}

TEST(Numerical, HaveLimitsOfTheirOwn) {
  Conditions simulation = Simulation(900, 5e6, 47500);
  simulation.time_step = 1e-6;
  simulation.rayleigh_time = 1.39e-6;
  simulation.rolling_friction = 0.7;
  simulation.shear_rate = 4e-3 / (kDiameter * std::sqrt(8220.0 / 900));  // I = 4e-3
  simulation.servo_gain = 0.3;
  const auto judge = [&](const char* symbol) { return Compare(Laboratory(), simulation, symbol); };
  EXPECT_EQ(judge("dt/T_R").verdict, Verdict::violated);
  EXPECT_THAT(judge("dt/T_R").remark, HasSubstr("0.719 Rayleigh times"));
  EXPECT_FALSE(judge("dt/T_R").experiment.has_value());
  EXPECT_EQ(judge("servo gain").verdict, Verdict::ok);
  EXPECT_FALSE(Evaluate(simulation, "chi").has_value());
  simulation.directional_torque = true;
  EXPECT_NEAR(*judge("chi").simulation, 0.7 * (1e-6 / 8.8e-5) / 4e-3, 0.02);
  EXPECT_EQ(judge("chi").verdict, Verdict::violated);
  simulation.time_step = 2.5e-7;
  simulation.rolling_friction = 0.07;
  EXPECT_EQ(judge("chi").verdict, Verdict::ok);
}

}  // namespace
}  // namespace powdercal

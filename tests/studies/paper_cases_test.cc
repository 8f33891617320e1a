#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "studies/planner.h"

namespace powdercal {
namespace {

using ::testing::HasSubstr;
using Verdict = GroupComparison::Verdict;

// Groups of the seed paper's cases, as a table prints them.
struct Printed {
  const char* symbol;
  double value;
  int digits;  // significant
};

struct Case {
  const char* file;
  double cohesion_energy_density;  // [J/m3] to `k_digits`
  int k_digits;
  std::vector<Printed> simulation;
};

std::string Rounded(double value, int digits) { return fmt::format("{:.{}e}", value, digits - 1); }

ScalingTable TableOf(const std::string& name) {
  const Study study = Study::Load(std::string(POWDERCAL_SOURCE_DIR) +
                                  "/tests/studies/paper_cases/" + name + ".yaml");
  const Planner planner(study);
  EXPECT_EQ(planner.ExplainUnplanned(0), "") << name;
  return planner.ScalingTables({0}, planner.Centre()).at(0);
}

const GroupComparison& GroupOf(const ScalingTable& table, const std::string& symbol) {
  for (const GroupComparison& group : table.groups) {
    if (group.symbol == symbol) return group;
  }
  throw std::out_of_range(symbol);
}

void ExpectPrinted(const ScalingTable& table, const Printed& printed, bool experiment,
                   const char* file) {
  const GroupComparison& group = GroupOf(table, printed.symbol);
  const std::optional<double>& value = experiment ? group.experiment : group.simulation;
  ASSERT_TRUE(value.has_value()) << printed.symbol;
  EXPECT_EQ(Rounded(*value, printed.digits), Rounded(printed.value, printed.digits))
      << printed.symbol << " of " << file;
}

const std::vector<Printed> kExperiment = {
    {"sigma/E", 4.5e-8, 2}, {"kappa", 8.4e4, 2},          {"F_c/(sigma d^2)", 1.2e-3, 2},
    {"Bo", 8.8, 2},         {"sigma/(rho_b g h)", 70, 2}, {"rho g d/E", 1.2e-11, 2}};

TEST(PaperCases, StudyFilesReproduceThePrintedTable) {
  const Case cases[] = {
      {"calibration",
       47500,
       5,
       {{"sigma/E", 1.8e-4, 2},
        {"kappa", 334, 3},
        {"F_c/(sigma d^2)", 0.163, 3},
        {"Bo", 120, 3},
        {"sigma/(rho_b g h)", 7, 1},
        {"rho g d/E", 4.7e-7, 2}}},
      {"section_4_1",
       48000,
       5,
       {{"sigma/E", 4.5e-8, 2},
        {"kappa", 8.4e4, 2},
        {"F_c/(sigma d^2)", 673, 3},
        {"Bo", 124, 3},
        {"sigma/(rho_b g h)", 0.0017, 2},
        {"rho g d/E", 4.7e-7, 2}}},
      {"spreading",
       15833,
       5,
       {{"sigma/E", 9e-6, 1},
        {"kappa", 2460, 3},
        {"F_c/(sigma d^2)", 0.12, 2},
        {"Bo", 4.4, 2},
        {"sigma/(rho_b g h)", 0.35, 2},
        {"rho g d/E", 4.7e-7, 2}}},
      {"exact", 583, 3, kExperiment},
      {"rigid_limit_a",
       2.77e5,
       3,
       {{"sigma/E", 3.5e-5, 2},
        {"kappa", 1e3, 1},
        {"F_c/(sigma d^2)", 1.2e-3, 2},
        {"Bo", 8.8, 2},
        {"sigma/(rho_b g h)", 70, 2},
        {"rho g d/E", 9e-9, 1}}},
      {"rigid_limit_b",
       2.77e6,
       3,
       {{"sigma/E", 1.1e-6, 2},
        {"kappa", 1e4, 1},
        {"F_c/(sigma d^2)", 1.2e-3, 2},
        {"Bo", 8.8, 2},
        {"sigma/(rho_b g h)", 70, 2},
        {"rho g d/E", 2.9e-10, 2}}},
  };
  for (const Case& one : cases) {
    const ScalingTable table = TableOf(one.file);
    for (const Printed& printed : kExperiment) ExpectPrinted(table, printed, true, one.file);
    for (const Printed& printed : one.simulation) ExpectPrinted(table, printed, false, one.file);
    EXPECT_EQ(Rounded(table.simulation.cohesion_energy_density.value(), one.k_digits),
              Rounded(one.cohesion_energy_density, one.k_digits))
        << one.file;
  }
}

// What its authors would have been told.
TEST(PaperCases, Section41NamesGravityAndCohesion) {
  const ScalingTable table = TableOf("section_4_1");
  EXPECT_EQ(GroupOf(table, "sigma/E").verdict, Verdict::ok);
  const GroupComparison& weight = GroupOf(table, "sigma/(rho_b g h)");
  EXPECT_EQ(weight.verdict, Verdict::violated);
  EXPECT_THAT(weight.remark, HasSubstr("self-weight exceeds the applied stress 572 times"));
  const GroupComparison& cohesion = GroupOf(table, "F_c/(sigma d^2)");
  EXPECT_EQ(cohesion.verdict, Verdict::violated);
  EXPECT_THAT(cohesion.remark, HasSubstr("cohesion is 5.6e5 times too strong against the load"));
}

TEST(PaperCases, ExactAndRigidLimitViolateNothing) {
  for (const char* name : {"exact", "rigid_limit_a", "rigid_limit_b"}) {
    for (const GroupComparison& group : TableOf(name).groups) {
      EXPECT_NE(group.verdict, Verdict::violated) << name << ", " << group.symbol;
    }
  }
}

}  // namespace
}  // namespace powdercal

#include "scaling/pi_engine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/errors.h"
#include "core/random.h"

namespace powdercal {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::UnorderedElementsAre;

std::vector<Variable> Variables(const std::vector<std::pair<std::string, std::string>>& units) {
  std::vector<Variable> variables;
  for (const auto& [name, unit] : units) {
    variables.push_back({name, Unit::Parse(unit).dimension()});
  }
  return variables;
}

Variable Raw(const std::string& name, int mass, int length, int time) {
  return {name, {{mass, length, time}}};
}

std::string ErrorOf(const std::string& text) {
  try {
    ParseVariables(text, "v.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

// Textbook cases: Barenblatt (1996), Szirtes (2007).

TEST(FindGroups, Pendulum) {
  const auto variables = Variables({{"m", "kg"}, {"l", "m"}, {"g", "m/s2"}, {"t", "s"}});
  const PiBasis basis = FindGroups(variables);
  EXPECT_THAT(basis.groups, ElementsAre(Monomial{{"g", 1}, {"t", 2}, {"l", -1}}));
  EXPECT_THAT(basis.unused, ElementsAre("m"));
  EXPECT_EQ(basis.rank, 3);
  EXPECT_FALSE(basis.rank_deficient());
  EXPECT_THAT(basis.dimensions, ElementsAre("M", "L", "T"));
  EXPECT_EQ(ExplainIncomplete(variables, basis.groups), "");
}

TEST(FindGroups, DragWithPreferredVariables) {
  const auto variables =
      Variables({{"F", "N"}, {"rho", "kg/m3"}, {"V", "m/s"}, {"D", "m"}, {"mu", "Pa s"}});
  const std::vector<std::string> prefer = {"rho", "V", "D"};
  const PiBasis basis = FindGroups(variables, prefer);
  EXPECT_THAT(basis.repeating, ElementsAre("rho", "V", "D"));
  EXPECT_THAT(basis.groups, ElementsAre(Monomial{{"F", 1}, {"rho", -1}, {"V", -2}, {"D", -2}},
                                        Monomial{{"mu", 1}, {"rho", -1}, {"V", -1}, {"D", -1}}));
  EXPECT_EQ(ToString(basis.groups[0]), "F / (D^2 V^2 rho)");
}

TEST(FindGroups, PipeFlowWithNamedGroups) {
  const auto variables = Variables({{"dp", "Pa"},
                                    {"L", "m"},
                                    {"D", "m"},
                                    {"eps", "mm"},
                                    {"rho", "kg/m3"},
                                    {"mu", "Pa s"},
                                    {"V", "m/s"}});
  const std::vector<std::string> prefer = {"rho", "V", "D"};
  const NamedGroup reynolds{"Re", {{"rho", 1}, {"V", 1}, {"D", 1}, {"mu", -1}}};
  const PiBasis basis = FindGroups(variables, prefer, std::span(&reynolds, 1));
  EXPECT_THAT(basis.names, ElementsAre("Re", "", "", ""));
  EXPECT_THAT(basis.groups, ElementsAre(reynolds.exponents, Monomial{{"L", 1}, {"D", -1}},
                                        Monomial{{"dp", 1}, {"rho", -1}, {"V", -2}},
                                        Monomial{{"eps", 1}, {"D", -1}}));
  EXPECT_EQ(ExplainIncomplete(variables, basis.groups), "");
}

// Mass and time occur in one combination only: statics.
TEST(FindGroups, RankDeficientSet) {
  const auto variables = Variables({{"F", "N"}, {"E", "Pa"}, {"L", "m"}, {"w", "m"}});
  const PiBasis basis = FindGroups(variables);
  EXPECT_EQ(basis.rank, 2);
  EXPECT_TRUE(basis.rank_deficient());
  EXPECT_EQ(basis.groups.size(), 2);
  EXPECT_EQ(ExplainIncomplete(variables, basis.groups), "");
}

TEST(FindGroups, IntegersByTheLeastCommonMultiple) {
  const std::vector<Variable> variables = {Raw("a", 0, 2, 0), Raw("b", 0, 0, 3), Raw("c", 0, 1, 1)};
  const PiBasis basis = FindGroups(variables);
  EXPECT_THAT(basis.groups, ElementsAre(Monomial{{"a", -3}, {"b", -2}, {"c", 6}}));
}

TEST(FindGroups, NoGroupAndNothingButPureNumbers) {
  EXPECT_THAT(FindGroups(Variables({{"L", "m"}, {"t", "s"}})).groups, IsEmpty());
  EXPECT_THAT(FindGroups({}).groups, IsEmpty());
  const PiBasis numbers = FindGroups(Variables({{"mu", "1"}, {"angle", "deg"}}));
  EXPECT_EQ(numbers.rank, 0);
  EXPECT_THAT(numbers.groups, ElementsAre(Monomial{{"angle", 1}}, Monomial{{"mu", 1}}));
}

TEST(FindGroups, PreferenceThatCannotRepeatIsTold) {
  const auto variables = Variables({{"D", "m"}, {"L", "m"}, {"V", "m/s"}, {"mu", "1"}});
  const std::vector<std::string> prefer = {"L", "D", "mu", "V"};
  const PiBasis basis = FindGroups(variables, prefer);
  EXPECT_THAT(basis.repeating, ElementsAre("L", "V"));
  EXPECT_THAT(basis.not_repeating, ElementsAre("D", "mu"));
}

std::vector<Variable> PowderVariables() {
  return Variables({{"sigma", "kPa"},
                    {"E", "GPa"},
                    {"k", "J/m3"},
                    {"rho", "kg/m3"},
                    {"d", "um"},
                    {"g", "m/s2"},
                    {"V", "mm/s"},
                    {"h", "mm"},
                    {"L", "mm"},
                    {"gap", "um"},
                    {"gamma", "mJ/m2"},
                    {"rate", "1/s"}});
}

TEST(FindGroups, TwelveVariablesOfAPowder) {
  const std::vector<std::string> prefer = {"rho", "d", "sigma"};
  const PiBasis basis = FindGroups(PowderVariables(), prefer);
  EXPECT_EQ(basis.groups.size(), 9);
  EXPECT_THAT(basis.groups, ::testing::Contains(Monomial{{"E", 1}, {"sigma", -1}}));
  // I², since every exponent is an integer.
  EXPECT_THAT(basis.groups,
              ::testing::Contains(Monomial{{"rate", 2}, {"d", 2}, {"rho", 1}, {"sigma", -1}}));
}

TEST(ExpressIn, ChangesTheBasis) {
  const PiBasis basis = FindGroups(PowderVariables());
  const std::vector<Fraction> load = ExpressIn(basis, {{"sigma", 1}, {"E", -1}});
  // Multiplied out again, the powers give the group.
  std::map<std::string, double> product;
  for (std::size_t i = 0; i < load.size(); ++i) {
    for (const auto& [name, exponent] : basis.groups[i]) {
      product[name] += static_cast<double>(exponent) * static_cast<double>(load[i].numerator) /
                       static_cast<double>(load[i].denominator);
    }
  }
  for (const auto& [name, exponent] : product) {
    EXPECT_NEAR(exponent, name == "sigma" ? 1 : name == "E" ? -1 : 0, 1e-12) << name;
  }
  EXPECT_THROW(ExpressIn(basis, {{"sigma", 1}}), InputError);
  EXPECT_THROW(ExpressIn(basis, {{"sigmaa", 1}}), InputError);
}

TEST(ExpressIn, NeedsFractions) {
  const std::vector<Variable> variables = {Raw("a", 0, 2, 0), Raw("b", 0, 0, 3), Raw("c", 0, 1, 1)};
  const NamedGroup square{"square", {{"a", -6}, {"b", -4}, {"c", 12}}};
  const PiBasis basis = FindGroups(variables, {}, std::span(&square, 1));
  EXPECT_THAT(ExpressIn(basis, {{"a", -3}, {"b", -2}, {"c", 6}}), ElementsAre(Fraction{1, 2}));
}

TEST(ExplainIncomplete, NamesWhatIsWrong) {
  const auto variables = Variables({{"D", "m"}, {"L", "m"}, {"t", "s"}, {"V", "m/s"}});
  const auto explain = [&](const std::vector<Monomial>& groups) {
    return ExplainIncomplete(variables, groups);
  };
  EXPECT_THAT(explain({{{"D", 1}}}), HasSubstr("D is not dimensionless: it has the dimension L"));
  EXPECT_THAT(explain({{{"D", 1}, {"L", -1}}, {{"D", -2}, {"L", 2}}}), HasSubstr("follows from"));
  EXPECT_EQ(explain({{{"D", 1}, {"L", -1}}}), "1 groups of 2");
  EXPECT_EQ(explain({{{"D", 1}, {"L", -1}}, {{"V", 1}, {"t", 1}, {"L", -1}}}), "");
}

// Random problems: up to 12 variables with small exponents of three to five base quantities.
std::vector<Variable> RandomVariables(RandomStream& stream) {
  const int count = 1 + static_cast<int>(12 * stream.Uniform());
  const int bases = 1 + static_cast<int>(5 * stream.Uniform());
  std::vector<Variable> variables;
  for (int i = 0; i < count; ++i) {
    Variable variable{.name = "x" + std::to_string(i)};
    for (int b = 0; b < bases; ++b) {
      variable.dimension.exponents[static_cast<std::size_t>(b)] =
          static_cast<int>(7 * stream.Uniform()) - 3;
    }
    variables.push_back(variable);
  }
  return variables;
}

TEST(Properties, GroupsAreDimensionlessIntegerAndComplete) {
  RandomStream stream(5);
  for (int trial = 0; trial < 300; ++trial) {
    const std::vector<Variable> variables = RandomVariables(stream);
    const PiBasis basis = FindGroups(variables);
    ASSERT_EQ(ExplainIncomplete(variables, basis.groups), "");
    ASSERT_EQ(basis.groups.size() + static_cast<std::size_t>(basis.rank), variables.size());
    for (const Monomial& group : basis.groups) {
      std::int64_t divisor = 0;
      for (const auto& [name, exponent] : group) {
        EXPECT_NE(exponent, 0);
        divisor = std::gcd(divisor, exponent);
      }
      EXPECT_EQ(divisor, 1);
    }
  }
}

TEST(Properties, OrderOfVariablesAndSystemOfUnitsChangeNothing) {
  RandomStream stream(6);
  for (int trial = 0; trial < 300; ++trial) {
    const std::vector<Variable> variables = RandomVariables(stream);
    std::vector<std::string> prefer;
    for (const Variable& v : variables) {
      if (stream.Uniform() < 0.2) prefer.push_back(v.name);
    }
    const PiBasis basis = FindGroups(variables, prefer);
    std::vector<Variable> other = variables;
    for (std::size_t i = other.size(); i > 1; --i) {
      std::swap(other[i - 1], other[static_cast<std::size_t>(stream.Uniform() * double(i))]);
    }
    EXPECT_EQ(FindGroups(other, prefer).groups, basis.groups);
    // Force instead of mass as a base quantity: M = F L^-1 T^2.
    for (Variable& v : other) {
      auto& x = v.dimension.exponents;
      x[1] -= x[0];
      x[2] += 2 * x[0];
    }
    EXPECT_EQ(FindGroups(other, prefer).groups, basis.groups);
  }
}

TEST(Properties, UnitsChangeNothing) {
  const auto si =
      Variables({{"p", "Pa"}, {"rho", "kg/m3"}, {"V", "m/s"}, {"nu", "m2/s"}, {"D", "m"}});
  const auto other =
      Variables({{"p", "psi"}, {"rho", "g/cm3"}, {"V", "km/hour"}, {"nu", "cSt"}, {"D", "inch"}});
  EXPECT_EQ(FindGroups(si).groups, FindGroups(other).groups);
}

TEST(ParseVariables, ReadsUnitsPreferencesAndNames) {
  const VariablesFile file = ParseVariables(
      "variables: {F: N, rho: kg/m3, V: m/s, D: {unit: mm}, mu: Pa s, n: 1}\n"
      "prefer: [rho, V, D]\n"
      "named: {Re: {rho: 1, V: 1, D: 1, mu: -1}}\n",
      "v.yaml");
  EXPECT_EQ(file.variables.size(), 6);
  EXPECT_EQ(file.units[3], "mm");
  EXPECT_THAT(file.prefer, ElementsAre("rho", "V", "D"));
  EXPECT_THAT(file.named[0].exponents,
              UnorderedElementsAre(Pair("rho", 1), Pair("V", 1), Pair("D", 1), Pair("mu", -1)));
}

TEST(ParseVariables, ErrorsNamePlaceAndNearestName) {
  EXPECT_THAT(
      ErrorOf("variables:\n  F: N\n  rho: kgg/m3\n"),
      AllOf(HasSubstr("v.yaml:3:8: variables.rho.unit"), HasSubstr("'kgg/m3' is not a unit")));
  EXPECT_THAT(ErrorOf("variables: {F: 3 N}\n"), HasSubstr("it holds a number"));
  EXPECT_THAT(ErrorOf("variables: {T: degC}\n"), HasSubstr("v.yaml:1:16"));
  EXPECT_THAT(ErrorOf("variables: {rho: kg/m3, V: m/s}\nprefer: [rho, v]\n"),
              AllOf(HasSubstr("v.yaml:2:15: prefer"), HasSubstr("unknown variable 'v'"),
                    HasSubstr("did you mean 'V'?")));
  EXPECT_THAT(ErrorOf("variables: {V: m/s}\nprefer: [V, V]\n"), HasSubstr("named twice"));
  EXPECT_THAT(ErrorOf("variables: {V: m/s}\nprefer: {V: 1}\n"), HasSubstr("expected a list"));
  EXPECT_THAT(ErrorOf("variables: {V: m/s, V: m}\n"), HasSubstr("appears twice"));
  EXPECT_THAT(ErrorOf("variabels: {V: m/s}\n"),
              AllOf(HasSubstr("missing key 'variables'"), HasSubstr("'variabels'")));
  EXPECT_THAT(ErrorOf("variables: {}\n"), HasSubstr("no variable"));
  EXPECT_THAT(ErrorOf("variables: [m, s]\n"), HasSubstr("expected a map"));
  EXPECT_THAT(ErrorOf("variables: {V: m/s, D: m}\nnamed: {a: {V: 1, d: 1}}\n"),
              HasSubstr("did you mean 'D'?"));
  EXPECT_THAT(
      ErrorOf("variables: {V: m/s, D: m}\nnamed:\n  a: {V: 1, D: -1}\n"),
      AllOf(HasSubstr("v.yaml:3:3: named.a"), HasSubstr("not dimensionless"), HasSubstr("T^-1")));
  EXPECT_THAT(ErrorOf("variables: {V: m/s, D: 4}\n"), HasSubstr("holds a number"));
}

}  // namespace
}  // namespace powdercal

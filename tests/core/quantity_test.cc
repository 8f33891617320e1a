#include "core/quantity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

#include "core/errors.h"

namespace powdercal {
namespace {

using testing::HasSubstr;

template <typename Function>
std::string ProblemOf(Function function) {
  try {
    function();
  } catch (const InputError& error) {
    return error.problem();
  }
  return "no error";
}

TEST(Quantity, ConvertsToSi) {
  EXPECT_DOUBLE_EQ(ParseQuantity("9 kPa", "Pa"), 9000);
  EXPECT_DOUBLE_EQ(ParseQuantity("29 um", "m"), 29e-6);
  EXPECT_DOUBLE_EQ(ParseQuantity("5 mm/s", "m/s"), 0.005);
  EXPECT_DOUBLE_EQ(ParseQuantity("4.75e4 J/m3", "Pa"), 4.75e4);
  EXPECT_DOUBLE_EQ(ParseQuantity("8.22 g/cm3", "kg/m3"), 8220);
  EXPECT_DOUBLE_EQ(ParseQuantity("2 h", "s"), 7200);
  EXPECT_DOUBLE_EQ(ParseQuantity("1.5 mN/m", "J/m2"), 1.5e-3);
  EXPECT_DOUBLE_EQ(ParseQuantity("30 deg", "1"), 0.52359877559829887);
  EXPECT_DOUBLE_EQ(ParseQuantity("5 %", "1"), 0.05);
  EXPECT_DOUBLE_EQ(ParseQuantity("4 1/s", "s-1"), 4);
}

TEST(Quantity, BlanksAndSignsAreFree) {
  EXPECT_DOUBLE_EQ(ParseQuantity("  9kPa\t", "Pa"), 9000);
  EXPECT_DOUBLE_EQ(ParseQuantity("+9 kPa", "Pa"), 9000);
  EXPECT_DOUBLE_EQ(ParseQuantity("-9.5 mm", "m"), -9.5e-3);
}

TEST(Quantity, BothMicroSignsAreUnderstood) {
  EXPECT_DOUBLE_EQ(ParseQuantity("3 \u00b5m", "m"), 3e-6);  // MICRO SIGN
  EXPECT_DOUBLE_EQ(ParseQuantity("3 \u03bcm", "m"), 3e-6);  // GREEK SMALL LETTER MU
}

TEST(Quantity, PureNumbersNeedNoUnit) {
  EXPECT_EQ(ParseQuantity("0.3", "1"), 0.3);
  EXPECT_EQ(Quantity::Parse("1e-3").si, 1e-3);
  EXPECT_TRUE(Quantity::Parse("1e-3").dimension.dimensionless());
}

TEST(Quantity, AMissingUnitIsAnError) {
  EXPECT_EQ(ProblemOf([] { ParseQuantity("9000", "Pa"); }),
            "'9000' has no unit; expected a pressure or energy density (such as Pa)");
}

TEST(Quantity, ABareNumberIsNoAngleInDegrees) {
  EXPECT_THAT(ProblemOf([] { ParseQuantity("30", "deg"); }), HasSubstr("'30' has no unit"));
  EXPECT_DOUBLE_EQ(ParseQuantity("30 deg", "deg"), 0.52359877559829887);
}

TEST(Quantity, AWrongDimensionNamesBoth) {
  EXPECT_EQ(ProblemOf([] { ParseQuantity("5 mm/s", "Pa"); }),
            "expected a pressure or energy density (such as Pa), got a speed ('5 mm/s')");
  EXPECT_EQ(ProblemOf([] { ParseQuantity("5 kg A", "m2"); }),
            "expected an area (such as m2), got a quantity of dimension M I ('5 kg A')");
  EXPECT_EQ(ProblemOf([] { ParseQuantity("5 mm", "1"); }),
            "expected a pure number (such as 1), got a length ('5 mm')");
}

TEST(Quantity, WhatIsNoQuantityIsAnError) {
  for (const char* text : {"", "kPa", "nan Pa", "inf", "1,5 kPa", "9 kPaa", "1e308 GPa", "+-5",
                           "--5", "5 kPa extra", "20 degC", "3 dB", "1e999"}) {
    EXPECT_THROW(Quantity::Parse(text), InputError) << text;
  }
}

// udunits2 would take the second number for a factor: "1 500 Pa" for 500 Pa.
TEST(Quantity, ASecondNumberIsAnErrorAndNotAFactor) {
  for (const char* text :
       {"1 500 Pa", "9 kPa 3", "1.5.3 Pa", "5-3 Pa", "5 2*Pa", "5 1/2", "1 m/10"}) {
    EXPECT_THAT(ProblemOf([&] { Quantity::Parse(text); }), HasSubstr("it holds a number")) << text;
  }
}

TEST(Unit, KeepsTextDimensionAndFactor) {
  const Unit unit = Unit::Parse(" kPa ");
  EXPECT_EQ(unit.text(), "kPa");
  EXPECT_EQ(unit.to_si(), 1000);
  EXPECT_EQ(unit.dimension(), (Dimension{{1, -1, -2}}));
  EXPECT_EQ(unit.dimension().ToString(), "M L^-1 T^-2");
  EXPECT_EQ(unit.dimension().Name(), "pressure or energy density");
  EXPECT_EQ(Unit::Parse("mol K A cd").dimension().ToString(), "Theta I N J");
}

TEST(Unit, AnEmptyOrUnknownUnitIsAnError) {
  EXPECT_THAT(ProblemOf([] { Unit::Parse("  "); }), HasSubstr("empty unit"));
  EXPECT_EQ(ProblemOf([] { Unit::Parse("parsec2x"); }), "'parsec2x' is not a unit");
}

TEST(FormatQuantity, ParsesBackToTheSameNumber) {
  for (const double value :
       {9e3, 29e-6, 0.1 + 0.2, -1.0 / 3, 5e-324, 1.7976931348623157e308, 0.0}) {
    for (const char* unit : {"1", "Pa", "m/s", "J/m2", "kg/m3"}) {
      const std::string text = FormatQuantity(value, unit);
      EXPECT_EQ(ParseQuantity(text, unit), value) << text;
    }
  }
}

TEST(FormatQuantity, IsTheShortestText) {
  EXPECT_EQ(FormatQuantity(9000, "Pa"), "9000 Pa");
  EXPECT_EQ(FormatQuantity(0.3, "1"), "0.3");
  EXPECT_EQ(FormatQuantity(29e-6, "m"), "2.9e-05 m");
}

TEST(HumanQuantity, PicksThePrefix) {
  EXPECT_EQ(HumanQuantity(29e-6, "m"), "29 um");
  EXPECT_EQ(HumanQuantity(9000, "Pa"), "9 kPa");
  EXPECT_EQ(HumanQuantity(-2.1e11, "Pa"), "-210 GPa");
  EXPECT_EQ(HumanQuantity(4.75e4, "J/m3"), "4.75e+04 J/m3");
  EXPECT_EQ(HumanQuantity(0.025, "m/s"), "25 mm/s");
  EXPECT_EQ(HumanQuantity(7200, "s"), "7200 s");
  EXPECT_EQ(HumanQuantity(0, "Pa"), "0 Pa");
  EXPECT_EQ(HumanQuantity(0.78349, "1", 3), "0.783");
}

// udunits2 itself is not thread-safe.
TEST(Unit, MayBeParsedByManyThreads) {
  std::vector<double> sums(4);
  {
    std::vector<std::jthread> threads;
    for (double& sum : sums) {
      threads.emplace_back([&sum] {
        for (int i = 0; i < 200; ++i) sum += ParseQuantity("1 kPa", "J/m3");
      });
    }
  }
  for (const double sum : sums) EXPECT_EQ(sum, 200000);
}

}  // namespace
}  // namespace powdercal

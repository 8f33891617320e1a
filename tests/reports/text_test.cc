#include "reports/text.h"

#include <gtest/gtest.h>

#include <cmath>

namespace powdercal {
namespace {

TEST(TextTest, EscapesMarkup) {
  EXPECT_EQ(EscapeHtml("<a href=\"x\">'&'</a>"),
            "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
  EXPECT_EQ(EscapeHtml("µ²→\n\t"), "µ²→\n\t");
}

TEST(TextTest, ReplacesWhatIsNotUtf8) {
  EXPECT_EQ(EscapeHtml("a\xFFz"), "a\xEF\xBF\xBDz");
  EXPECT_EQ(EscapeHtml("cut \xC2"), "cut \xEF\xBF\xBD");
  EXPECT_EQ(EscapeHtml("bell\a"), "bell\xEF\xBF\xBD");
}

TEST(TextTest, Names) {
  EXPECT_EQ(ReadableName("consolidation.void_ratio"), "void ratio");
  EXPECT_EQ(PrettyUnit("J/m3"), "J/m³");
  EXPECT_EQ(PrettyUnit("um"), "µm");
  EXPECT_EQ(PrettyUnit("1"), "");
}

TEST(TextTest, Symbols) {
  EXPECT_EQ(SymbolText("mu_r"), "μᵣ");
  EXPECT_EQ(SymbolHtml("mu_r"), "μ<sub>r</sub>");
  EXPECT_EQ(SymbolText("sigma/(rho_b g h)"), "σ/(ρ_b g h)");
  EXPECT_EQ(SymbolHtml("F_c/(sigma d^2)"), "F<sub>c</sub>/(σ d²)");
  EXPECT_EQ(SymbolText("V/sqrt(g d)"), "V/√(g d)");
  EXPECT_EQ(SymbolText("gap/d"), "gap/d");
  EXPECT_EQ(SymbolText("rolling_friction"), "rolling friction");
  EXPECT_EQ(SymbolHtml("<b>"), "&lt;b&gt;");
}

TEST(TextTest, Numbers) {
  EXPECT_EQ(NumberText(0.783), "0.783");
  EXPECT_EQ(NumberText(0.77886), "0.7789");
  EXPECT_EQ(NumberText(47512), "47512");
  EXPECT_EQ(NumberText(-0.0041, 2), "−0.0041");
  EXPECT_EQ(NumberText(5e6), "5×10⁶");
  EXPECT_EQ(NumberText(1e9), "10⁹");
  EXPECT_EQ(NumberText(4.5e-8, 3), "4.5×10⁻⁸");
  EXPECT_EQ(NumberText(0), "0");
  EXPECT_EQ(NumberText(NAN), "—");
  EXPECT_EQ(ValueText(900, "Pa"), "900 Pa");
  EXPECT_EQ(ValueText(0.5235988, "rad"), "30 deg");
}

TEST(TextTest, Durations) {
  EXPECT_EQ(DurationText(3.14159), "3.14 s");
  EXPECT_EQ(DurationText(412.6), "6 min 53 s");
  EXPECT_EQ(DurationText(7380), "2 h 3 min");
}

}  // namespace
}  // namespace powdercal

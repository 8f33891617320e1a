#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace powdercal {

/// The text with &, <, >, " and ' as entities, bytes that are not UTF-8 and control characters
/// replaced: safe as an element's content and inside a quoted attribute.
std::string EscapeHtml(std::string_view text);
/// The same, where pages are put together.
inline std::string H(std::string_view text) { return EscapeHtml(text); }

/// "consolidation.void_ratio" → "void ratio", "cohesion_energy_density" → "cohesion energy
/// density".
std::string ReadableName(std::string_view name);

/// "J/m3" → "J/m³", "um" → "µm", "1" → "".
std::string PrettyUnit(std::string_view unit);

/// Names of Greek letters and subscripts as people write them: "mu_r" → "μᵣ", "sigma/E" → "σ/E";
/// with markup, subscripts are <sub> elements and all else is escaped.
std::string SymbolText(std::string_view symbol);
std::string SymbolHtml(std::string_view symbol);

/// A number for people: `digits` significant digits, integer digits never rounded away, powers of
/// ten as ×10ⁿ outside 1e-4 … 1e6. "—" where it is not finite.
std::string NumberText(double value, int digits = 4);

/// How people read a quantity: angles in degrees, all else in SI.
struct DisplayUnit {
  std::string_view name;
  double per_si = 1;
};
DisplayUnit DisplayUnitOf(std::string_view si_unit);

/// The number in its display unit and, where there is one, the unit: "47500 J/m³", "30.2 deg".
std::string ValueText(double value, std::string_view unit, int digits = 4);

/// "12.3 s", "4 min 10 s", "2 h 3 min".
std::string DurationText(double seconds);

/// "1 evaluation", "3 evaluations".
std::string CountText(int count, std::string_view singular, std::string_view plural = "");

/// With a capital (a to z) at the beginning.
std::string Capitalised(std::string text);
/// With a full stop at the end where there is no mark.
std::string WithFullStop(std::string text);
/// Capitalised and with a full stop.
std::string Sentence(std::string text);
/// "a", "a and b", "a, b and c".
std::string Enumerated(const std::vector<std::string>& items);

}  // namespace powdercal

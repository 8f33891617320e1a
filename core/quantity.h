#pragma once

#include <array>
#include <string>
#include <string_view>

namespace powdercal {

/// Exponents of the SI base quantities, in the order mass, length, time, temperature, current,
/// amount, luminous intensity.
struct Dimension {
  std::array<int, 7> exponents{};

  friend bool operator==(const Dimension&, const Dimension&) = default;
  bool dimensionless() const { return *this == Dimension{}; }

  /// "M L^-1 T^-2", or "1" when dimensionless.
  std::string ToString() const;
  /// The everyday name where there is one ("pressure", "length", "speed", …), else ToString().
  std::string Name() const;
};

/// A unit of measurement known to udunits2, e.g. "kPa", "um", "mm/s", "J/m3". Temperatures with an
/// offset and logarithmic units are refused: no physical constant of a study needs them.
class Unit {
 public:
  /// Throws InputError if the text is not a unit.
  static Unit Parse(std::string_view text);

  const std::string& text() const { return text_; }
  const Dimension& dimension() const { return dimension_; }
  double to_si() const { return to_si_; }  ///< multiply a value in this unit to get SI

 private:
  std::string text_;
  Dimension dimension_;
  double to_si_ = 1;
};

/// A number with a unit, as in "9 kPa" or "29 um". Held in SI.
struct Quantity {
  double si = 0;
  Dimension dimension;

  /// Throws InputError if the text is not a finite number, optionally followed by a unit.
  static Quantity Parse(std::string_view text);
};

/// The value of `text` in SI, which must have the dimension of `unit`. A bare number is accepted
/// only where `unit` is dimensionless. Errors name both dimensions: "expected a pressure (such as
/// Pa), got a speed (5 mm/s)".
double ParseQuantity(std::string_view text, const Unit& unit);
double ParseQuantity(std::string_view text, std::string_view unit);

/// "9000 Pa": the shortest text that parses back to the same double, with the SI unit's own text.
/// "0.3" when the unit is "1".
std::string FormatQuantity(double si, std::string_view si_unit);

/// For people: three or four significant digits and an SI prefix where it helps ("29 um",
/// "9 kPa", "4.75e+04 J/m3").
std::string HumanQuantity(double si, std::string_view si_unit, int digits = 4);

}  // namespace powdercal

#include "core/quantity.h"

#include <fmt/format.h>
#include <udunits2.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <memory>
#include <mutex>
#include <vector>

#include "core/errors.h"
#include "core/text.h"

namespace powdercal {
namespace {

constexpr std::array<const char*, 7> kBaseNames = {"kilogram", "meter", "second", "kelvin",
                                                   "ampere",   "mole",  "candela"};
constexpr std::array<const char*, 7> kSymbols = {"M", "L", "T", "Theta", "I", "N", "J"};

// udunits2 keeps global state and is not thread-safe; everything goes through this one lock.
class UnitSystem {
 public:
  static UnitSystem& Get() {
    static UnitSystem system;
    return system;
  }

  void Resolve(const std::string& text, Dimension* dimension, double* to_si) {
    const std::lock_guard lock(mutex_);
    UnitPointer unit(ut_parse(system_, text.c_str(), UT_UTF8));
    if (!unit) throw InputError(fmt::format("'{}' is not a unit", text), {.value = text});
    Visit visit;
    ut_accept_visitor(unit.get(), &kVisitor, &visit);
    if (!visit.supported) {
      throw InputError(fmt::format("'{}' is not a proportional unit", text), {.value = text});
    }
    *dimension = visit.dimension;
    *to_si = visit.scale;
  }

 private:
  struct FreeUnit {
    void operator()(ut_unit* unit) const { ut_free(unit); }
  };
  using UnitPointer = std::unique_ptr<ut_unit, FreeUnit>;

  struct Visit {
    Dimension dimension;
    double scale = 1;
    bool supported = true;
  };

  UnitSystem() {
    ut_set_error_message_handler(ut_ignore);
    system_ = ut_read_xml(nullptr);
    if (system_ == nullptr) {
      throw InputError(
          "cannot read the unit database of udunits2 (is libudunits2-data installed?)");
    }
    UnitPointer degree(ut_parse(system_, "arc_degree", UT_UTF8));
    ut_map_name_to_unit("deg", UT_ASCII, degree.get());
  }
  ~UnitSystem() { ut_free_system(system_); }

  static void AddBase(const ut_unit* basic, int power, Visit* visit) {
    const char* name = ut_get_name(basic, UT_ASCII);
    for (std::size_t i = 0; i < kBaseNames.size(); ++i) {
      if (name != nullptr && std::string_view(name) == kBaseNames[i]) {
        visit->dimension.exponents[i] += power;
        return;
      }
    }
    // radian and the like: dimensionless by the SI's own convention
  }
  static ut_status VisitBasic(const ut_unit* unit, void* arg) {
    AddBase(unit, 1, static_cast<Visit*>(arg));
    return UT_SUCCESS;
  }
  static ut_status VisitProduct(const ut_unit*, int count, const ut_unit* const* units,
                                const int* powers, void* arg) {
    for (int i = 0; i < count; ++i) AddBase(units[i], powers[i], static_cast<Visit*>(arg));
    return UT_SUCCESS;
  }
  static ut_status VisitScaled(const ut_unit*, double scale, const ut_unit* underlying,
                               double origin, void* arg) {
    auto* visit = static_cast<Visit*>(arg);
    if (origin != 0) visit->supported = false;
    visit->scale *= scale;
    return ut_accept_visitor(underlying, &kVisitor, arg);
  }
  static ut_status VisitLogarithmic(const ut_unit*, double, const ut_unit*, void* arg) {
    static_cast<Visit*>(arg)->supported = false;
    return UT_SUCCESS;
  }
  static ut_status VisitTimestamp(const ut_unit*, const ut_unit*, double, void* arg) {
    static_cast<Visit*>(arg)->supported = false;
    return UT_SUCCESS;
  }

  static constexpr ut_visitor kVisitor = {VisitBasic, VisitProduct, VisitScaled, VisitTimestamp,
                                          VisitLogarithmic};

  std::mutex mutex_;
  ut_system* system_ = nullptr;
};

// udunits2 takes numbers inside a unit for factors: "1 500 Pa" would be 1 times the unit "500 Pa".
bool HasFactor(std::string_view unit) {
  if (unit == "1") return false;
  if (unit.starts_with("1/")) unit.remove_prefix(2);  // "1/s"
  bool separated = true;
  for (const char c : unit) {
    const bool starts_number = std::isdigit(static_cast<unsigned char>(c)) || c == '.';
    if (separated && (starts_number || c == '+' || c == '-')) return true;
    separated = c == ' ' || c == '\t' || c == '*' || c == '/' || c == '(';
  }
  return false;
}

// A number and the text after it, "" when there is none.
struct Split {
  double value = 0;
  std::string_view unit;
};

Split SplitQuantity(std::string_view text) {
  const std::string_view trimmed = Trim(text);
  const char* begin = trimmed.data();
  const char* const end = begin + trimmed.size();
  if (trimmed.starts_with('+') && !trimmed.starts_with("+-")) ++begin;
  Split split;
  const auto [rest, error] = std::from_chars(begin, end, split.value);
  if (error != std::errc() || !std::isfinite(split.value)) {
    throw InputError(fmt::format("'{}' is not a number with a unit", trimmed),
                     {.value = std::string(trimmed)});
  }
  split.unit = Trim({rest, static_cast<std::size_t>(end - rest)});
  return split;
}

// "a length", "an energy".
std::string WithArticle(const std::string& name) {
  return (std::string_view("aeiou").find(name.front()) != std::string_view::npos ? "an " : "a ") +
         name;
}

struct NamedDimension {
  std::array<int, 7> exponents;
  const char* name;
  const char* unit;
};
constexpr NamedDimension kNamed[] = {
    {{0, 0, 0}, "pure number", "1"},    {{0, 1, 0}, "length", "m"},
    {{1, 0, 0}, "mass", "kg"},          {{0, 0, 1}, "time", "s"},
    {{0, 2, 0}, "area", "m2"},          {{0, 3, 0}, "volume", "m3"},
    {{0, 1, -1}, "speed", "m/s"},       {{0, 1, -2}, "acceleration", "m/s2"},
    {{1, -3, 0}, "density", "kg/m3"},   {{1, -1, -2}, "pressure or energy density", "Pa"},
    {{1, 1, -2}, "force", "N"},         {{1, 0, -2}, "surface energy or stiffness", "J/m2"},
    {{1, 2, -2}, "energy", "J"},        {{0, 0, -1}, "rate", "1/s"},
    {{0, 0, 0, 1}, "temperature", "K"}, {{1, -1, -1}, "viscosity", "Pa s"},
};

const NamedDimension* FindNamed(const Dimension& dimension) {
  for (const NamedDimension& named : kNamed) {
    if (named.exponents == dimension.exponents) return &named;
  }
  return nullptr;
}

}  // namespace

std::string Dimension::ToString() const {
  std::string text;
  for (std::size_t i = 0; i < exponents.size(); ++i) {
    if (exponents[i] == 0) continue;
    if (!text.empty()) text += ' ';
    text += kSymbols[i];
    if (exponents[i] != 1) text += fmt::format("^{}", exponents[i]);
  }
  return text.empty() ? "1" : text;
}

std::string Dimension::Name() const {
  const NamedDimension* named = FindNamed(*this);
  return named != nullptr ? named->name : "quantity of dimension " + ToString();
}

Unit Unit::Parse(std::string_view text) {
  Unit unit;
  unit.text_ = std::string(Trim(text));
  if (unit.text_.empty()) throw InputError("an empty unit; write '1' for a pure number");
  if (HasFactor(unit.text_)) {
    throw InputError(fmt::format("'{}' is not a unit: it holds a number", unit.text_),
                     {.value = unit.text_});
  }
  UnitSystem::Get().Resolve(unit.text_, &unit.dimension_, &unit.to_si_);
  return unit;
}

Quantity Quantity::Parse(std::string_view text) {
  const Split split = SplitQuantity(text);
  if (split.unit.empty()) return {split.value, {}};
  const Unit unit = Unit::Parse(split.unit);
  const double si = split.value * unit.to_si();
  if (!std::isfinite(si)) {
    throw InputError(fmt::format("'{}' is too large", Trim(text)),
                     {.value = std::string(Trim(text))});
  }
  return {si, unit.dimension()};
}

double ParseQuantity(std::string_view text, const Unit& unit) {
  const Quantity quantity = Quantity::Parse(text);
  const std::string_view trimmed = Trim(text);
  const std::string wanted =
      fmt::format("{} (such as {})", WithArticle(unit.dimension().Name()), unit.text());
  // Dimensionless is not enough: where "deg" is expected, a bare 30 would be taken for radians.
  const bool bare = SplitQuantity(text).unit.empty();
  if (bare && !(unit.dimension().dimensionless() && unit.to_si() == 1)) {
    throw InputError(fmt::format("'{}' has no unit; expected {}", trimmed, wanted),
                     {.value = std::string(trimmed)});
  }
  if (quantity.dimension == unit.dimension()) return quantity.si;
  throw InputError(fmt::format("expected {}, got {} ('{}')", wanted,
                               WithArticle(quantity.dimension.Name()), trimmed),
                   {.value = std::string(trimmed)});
}

double ParseQuantity(std::string_view text, std::string_view unit) {
  return ParseQuantity(text, Unit::Parse(unit));
}

std::string FormatQuantity(double si, std::string_view si_unit) {
  return si_unit == "1" ? fmt::format("{}", si) : fmt::format("{} {}", si, si_unit);
}

std::string HumanQuantity(double si, std::string_view si_unit, int digits) {
  static constexpr std::array<std::string_view, 6> kPrefixed = {"Pa", "m", "s", "N", "J", "m/s"};
  if (si_unit == "1") return fmt::format("{:.{}g}", si, digits);
  const double magnitude = std::abs(si);
  const bool prefixed = std::find(kPrefixed.begin(), kPrefixed.end(), si_unit) != kPrefixed.end();
  if (prefixed && magnitude > 0 && std::isfinite(si)) {
    static constexpr std::pair<double, const char*> kPrefixes[] = {
        {1e9, "G"}, {1e6, "M"}, {1e3, "k"}, {1, ""}, {1e-3, "m"}, {1e-6, "u"}, {1e-9, "n"}};
    const bool length = si_unit == "m" || si_unit == "m/s" || si_unit == "s";
    for (const auto& [factor, prefix] : kPrefixes) {
      if (length && factor > 1) continue;
      if (magnitude >= factor * 0.9999995) {
        return fmt::format("{:.{}g} {}{}", si / factor, digits, prefix, si_unit);
      }
    }
  }
  return fmt::format("{:.{}g} {}", si, digits, si_unit);
}

}  // namespace powdercal

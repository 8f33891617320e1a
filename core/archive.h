#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/errors.h"

namespace powdercal {

/// Bounds of a number in SI units.
struct Range {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool lower_open = false;  ///< the lower bound itself is excluded
  bool upper_open = false;

  bool Contains(double value) const;
};

inline constexpr Range kPositive{.lower = 0, .lower_open = true};
inline constexpr Range kNonNegative{.lower = 0};
inline constexpr Range kUnitInterval{.lower = 0, .upper = 1};

/// Visits the members of an options struct by name. One `Serialize(Archive&)` per struct both reads
/// a study file and writes the resolved one: in-class defaults are the schema's defaults.
///
///   struct ConsolidationOptions {
///     double stress = 9e3;  // [Pa]
///     void Serialize(Archive& archive) { archive.Quantity("stress", stress, "Pa", kPositive); }
///   };
///
/// Reading: a key that is absent leaves the member at its default, unless `Require()`d; a value of
/// the wrong kind, dimension or range throws InputError with file, line, column and key path; a key
/// that was never visited is an error with the nearest visited name, raised when the section ends.
/// Writing: every member is written, quantities in SI with their unit.
class Archive {
 public:
  using Visitor = std::function<void(Archive&)>;
  using KeyedVisitor = std::function<void(const std::string& key, Archive&)>;

  virtual ~Archive() = default;

  virtual bool reading() const = 0;

  /// Reading: whether the current section has the key. Writing: always false.
  virtual bool Has(std::string_view key) const = 0;
  /// Reading: throws if the current section lacks the key. Writing: nothing.
  virtual void Require(std::string_view key) = 0;
  /// An InputError at the key (or at the section, if the key is "" or absent).
  virtual InputError ErrorAt(std::string_view key, const std::string& problem) const = 0;
  /// Reading: the place of the key, for errors raised later, when other things are known.
  virtual SourceLocation LocationOf(std::string_view key) const = 0;

  /// A physical quantity held in SI. `unit` is "1" for pure numbers. Optional members that are
  /// absent stay empty and are not written.
  virtual void Quantity(std::string_view key, double& value, std::string_view unit,
                        Range range = {}) = 0;
  virtual void Quantity(std::string_view key, std::optional<double>& value, std::string_view unit,
                        Range range = {}) = 0;
  /// A list of quantities; each item carries its own unit ([3 kPa, 5 kPa]) unless `unit` is "1".
  virtual void Quantities(std::string_view key, std::vector<double>& values, std::string_view unit,
                          Range range = {}) = 0;
  /// [lower, upper], lower < upper; the items are bare numbers in a unit that the study names.
  virtual void Interval(std::string_view key, double& lower, double& upper) = 0;
  virtual void Number(std::string_view key, double& value, Range range = {}) {
    Quantity(key, value, "1", range);
  }
  virtual void Integer(std::string_view key, std::int64_t& value, Range range = {}) = 0;
  void Integer(std::string_view key, int& value, Range range = {});
  virtual void Flag(std::string_view key, bool& value) = 0;
  virtual void Text(std::string_view key, std::string& value) = 0;
  /// A name out of `valid`. `what` names it in errors ("backend", "optimizer").
  virtual void Choice(std::string_view key, std::string& value, std::string_view what,
                      std::span<const std::string> valid) = 0;
  /// A list of names out of `valid`, each at most once; a single name is short for a list of one.
  virtual void Names(std::string_view key, std::vector<std::string>& names, std::string_view what,
                     std::span<const std::string> valid) = 0;
  /// An enumeration: `names[i]` is the spelling of static_cast<E>(i).
  template <typename E>
  void Enumeration(std::string_view key, E& value, std::string_view what,
                   std::span<const std::string> names) {
    std::string name = names[static_cast<std::size_t>(value)];
    Choice(key, name, what, names);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == name) value = static_cast<E>(i);
    }
  }

  /// A nested map. Reading: skipped when absent. A scalar where a map is expected is an error,
  /// unless `scalar_key` is given: then `backend: liggghts` reads as `backend: {name: liggghts}`.
  virtual void Section(std::string_view key, const Visitor& visit,
                       std::string_view scalar_key = "") = 0;
  /// A map whose keys are the user's own. Reading: calls visit once for each key, with the archive
  /// placed inside that key's section (a scalar value reads through `scalar_key`, as in Section).
  /// Writing: visits `keys`.
  virtual void Map(std::string_view key, std::span<const std::string> keys,
                   const KeyedVisitor& visit, std::string_view scalar_key = "") = 0;
  /// A list of sections. Reading: calls visit once for each item. Writing: `count` times.
  virtual void List(std::string_view key, std::size_t count, const Visitor& visit) = 0;
  /// For list items of the form `- name: {…}`: Reading: the only key of the current section is the
  /// name; visit is called inside its section. Writing: writes `name: {…}`.
  virtual void Tagged(std::string& name, const KeyedVisitor& visit) = 0;
};

/// Values that take precedence over a file's, by key path: {"budget.evaluations", "10"}.
using Overrides = std::map<std::string, std::string>;
/// Adds what was given as KEY=VALUE on a command line. Throws InputError for another form, and for
/// a key that is there already.
void AddOverrides(std::span<const std::string> texts, Overrides* overrides);

/// Reads a YAML text; `file` is only for messages. The visitor sees the root map; throws InputError
/// for YAML syntax errors, and for keys (of the file or of `overrides`) that the visitor did not
/// visit.
void ReadYaml(const std::string& text, const std::string& file, const Archive::Visitor& visit,
              const Overrides& overrides = {});
/// The same from a file; throws InputError when it cannot be read.
void ReadYamlFile(const std::string& path, const Archive::Visitor& visit);
/// The YAML text that ReadYaml would read back to the same values.
std::string WriteYaml(const Archive::Visitor& visit);

}  // namespace powdercal

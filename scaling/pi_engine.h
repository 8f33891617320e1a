#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/quantity.h"

namespace powdercal {

/// A quantity of a problem: any problem, not only a powder's.
struct Variable {
  std::string name;
  Dimension dimension;
};

/// A product of powers of variables: {"rho": 1, "V": 1, "D": 1, "mu": -1}. No exponent is 0.
using Monomial = std::map<std::string, std::int64_t>;

/// "rho V D / mu", "V^2 / (g L)", "1 / Re"; "1" for an empty product.
std::string ToString(const Monomial& monomial);

/// A dimensionless product with the user's name for it, such as Re.
struct NamedGroup {
  std::string name;
  Monomial exponents;
};

/// The groups of a problem (Buckingham 1914): a basis of the null space of its dimension matrix,
/// computed exactly in rational numbers.
///
/// The basis is canonical: it depends on the set of variables and their dimensions alone, neither
/// on their units nor on their order. `repeating` variables span the dimensions: the preferred ones
/// in the order of the preference, then the others by name, as far as each is dimensionally
/// independent of those before. Every other variable is in one group of its own, together with
/// repeating ones: its exponent is positive, and all exponents are integers without a common
/// divisor. These groups follow in the order of their own variables' names, after the named ones.
struct PiBasis {
  std::vector<std::string> variables;   ///< sorted
  std::vector<std::string> dimensions;  ///< symbols of the base quantities that occur: "M", "L", …
  int rank = 0;                         ///< of the dimension matrix
  std::vector<std::string> repeating;   ///< as many as the rank
  std::vector<std::string> names;       ///< of the groups; "" where the user gave none
  std::vector<Monomial> groups;         ///< as many as variables less the rank: a complete set
  /// In no group, because no product of the others has the dimension: they have no influence on a
  /// relation among the rest.
  std::vector<std::string> unused;
  /// Preferred variables that could not repeat, for those before them span their dimension.
  std::vector<std::string> not_repeating;

  /// The base quantities occur in fewer independent combinations than there are of them: they
  /// could be merged, such as mass and time in a static problem.
  bool rank_deficient() const { return rank < static_cast<int>(dimensions.size()); }
};

/// Throws InputError for a name that is given twice or preferred and unknown, for a named group
/// that is not dimensionless or follows from those before it, and for exponents beyond 64 bits.
PiBasis FindGroups(std::span<const Variable> variables, std::span<const std::string> prefer = {},
                   std::span<const NamedGroup> named = {});

/// An exact fraction in lowest terms, denominator > 0.
struct Fraction {
  std::int64_t numerator = 0;
  std::int64_t denominator = 1;
  friend bool operator==(const Fraction&, const Fraction&) = default;
};

/// Writes `group` as a product of powers of the basis' groups, in their order. Throws InputError
/// where it is not dimensionless: then it is no such product.
std::vector<Fraction> ExpressIn(const PiBasis& basis, const Monomial& group);

/// Whether the groups are as many as a complete set has, dimensionless and independent; "" or what
/// is wrong.
std::string ExplainIncomplete(std::span<const Variable> variables,
                              std::span<const Monomial> groups);

/// A file of variables: `variables: {name: unit, …}` and, optionally, `prefer: [names]` and
/// `named: {Re: {rho: 1, V: 1, D: 1, mu: -1}, …}`.
struct VariablesFile {
  std::vector<Variable> variables;
  std::vector<std::string> units;  ///< as written, of each variable
  std::vector<std::string> prefer;
  std::vector<NamedGroup> named;
};
/// Throws InputError with the place of whatever is wrong in the file.
VariablesFile ReadVariables(const std::string& path);
/// The same from a text; `file` is only for messages.
VariablesFile ParseVariables(const std::string& text, const std::string& file);

}  // namespace powdercal

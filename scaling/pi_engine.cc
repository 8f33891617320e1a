#include "scaling/pi_engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "core/archive.h"
#include "core/errors.h"
#include "core/files.h"
#include "scaling/rational_matrix.h"

namespace powdercal {
namespace {

constexpr std::array<const char*, 7> kBaseSymbols = {"M", "L", "T", "Theta", "I", "N", "J"};

std::int64_t ToInt64(const boost::multiprecision::cpp_int& value) {
  if (value > std::numeric_limits<std::int64_t>::max() ||
      value < std::numeric_limits<std::int64_t>::min()) {
    throw InputError("a group has an exponent beyond 64 bits; are the units meant so?");
  }
  return value.convert_to<std::int64_t>();
}

std::vector<Variable> Sorted(std::span<const Variable> variables) {
  std::vector<Variable> sorted(variables.begin(), variables.end());
  const auto by_name = [](const Variable& a, const Variable& b) { return a.name < b.name; };
  std::sort(sorted.begin(), sorted.end(), by_name);
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i].name == sorted[i - 1].name) {
      throw InputError(fmt::format("variable '{}' is given twice", sorted[i].name),
                       {.value = sorted[i].name});
    }
  }
  return sorted;
}

std::vector<std::string> NamesOf(std::span<const Variable> variables) {
  std::vector<std::string> names;
  for (const Variable& variable : variables) names.push_back(variable.name);
  return names;
}

const Variable& Find(std::span<const Variable> variables, const std::string& name) {
  for (const Variable& variable : variables) {
    if (variable.name == name) return variable;
  }
  throw UnknownName("variable", name, NamesOf(variables));
}

// Rows: base quantities. Columns: the variables in the given order.
std::vector<RationalRow> DimensionMatrix(std::span<const Variable> variables) {
  std::vector<RationalRow> rows(kBaseSymbols.size());
  for (const Variable& variable : variables) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      rows[i].push_back(variable.dimension.exponents[i]);
    }
  }
  return rows;
}

// The preferred ones first, the rest by name.
std::vector<Variable> InOrderOfPreference(std::span<const Variable> sorted,
                                          std::span<const std::string> prefer) {
  std::vector<Variable> ordered;
  for (const std::string& name : prefer) {
    if (std::count(prefer.begin(), prefer.end(), name) > 1) {
      throw InputError(fmt::format("variable '{}' is preferred twice", name), {.value = name});
    }
    ordered.push_back(Find(sorted, name));
  }
  for (const Variable& variable : sorted) {
    if (std::find(prefer.begin(), prefer.end(), variable.name) == prefer.end()) {
      ordered.push_back(variable);
    }
  }
  return ordered;
}

Dimension DimensionOf(std::span<const Variable> variables, const Monomial& monomial) {
  std::array<Rational, 7> sum{};
  for (const auto& [name, exponent] : monomial) {
    const Variable& variable = Find(variables, name);
    for (std::size_t i = 0; i < sum.size(); ++i) {
      sum[i] += Rational(exponent) * variable.dimension.exponents[i];
    }
  }
  Dimension dimension;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const std::int64_t exponent = ToInt64(numerator(sum[i]));
    dimension.exponents[i] = static_cast<int>(std::clamp<std::int64_t>(
        exponent, std::numeric_limits<int>::min(), std::numeric_limits<int>::max()));
  }
  return dimension;
}

RationalRow RowOf(const std::vector<std::string>& variables, const Monomial& monomial) {
  RationalRow row(variables.size(), 0);
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const auto exponent = monomial.find(variables[i]);
    if (exponent != monomial.end()) row[i] = exponent->second;
  }
  return row;
}

bool Independent(const std::vector<RationalRow>& rows) {
  return Reduce(rows).pivots.size() == rows.size();
}

// The groups with one non-repeating variable each, by the names of those.
std::vector<Monomial> PlainGroups(std::span<const Variable> ordered, PiBasis* basis) {
  const EchelonForm form = Reduce(DimensionMatrix(ordered));
  basis->rank = static_cast<int>(form.pivots.size());
  for (const std::size_t pivot : form.pivots) basis->repeating.push_back(ordered[pivot].name);
  std::vector<std::pair<std::string, Monomial>> groups;
  for (const RationalRow& vector : NullSpace(form, ordered.size())) {
    const RationalRow integers = WithIntegers(vector);
    Monomial group;
    std::string own;
    for (std::size_t i = 0; i < ordered.size(); ++i) {
      if (integers[i] != 0) group[ordered[i].name] = ToInt64(numerator(integers[i]));
      const bool pivot = std::find(form.pivots.begin(), form.pivots.end(), i) != form.pivots.end();
      if (!pivot && integers[i] != 0) own = ordered[i].name;
    }
    groups.emplace_back(own, std::move(group));
  }
  std::sort(groups.begin(), groups.end());
  std::vector<Monomial> plain;
  for (auto& [own, group] : groups) plain.push_back(std::move(group));
  return plain;
}

// The named groups first, then as many of the plain ones as are independent of what is there.
void Assemble(std::span<const Variable> sorted, std::span<const NamedGroup> named,
              std::vector<Monomial> plain, PiBasis* basis) {
  std::vector<RationalRow> rows;
  for (const NamedGroup& group : named) {
    const Dimension dimension = DimensionOf(sorted, group.exponents);
    if (!dimension.dimensionless()) {
      throw InputError(fmt::format("group '{}' is not dimensionless: it has the dimension {}",
                                   group.name, dimension.ToString()),
                       {.value = ToString(group.exponents)});
    }
    rows.push_back(RowOf(basis->variables, group.exponents));
    if (!Independent(rows)) {
      throw InputError(fmt::format("group '{}' follows from those before it", group.name),
                       {.value = ToString(group.exponents)});
    }
    basis->names.push_back(group.name);
    basis->groups.push_back(group.exponents);
  }
  for (Monomial& group : plain) {
    rows.push_back(RowOf(basis->variables, group));
    if (!Independent(rows)) {
      rows.pop_back();
      continue;
    }
    basis->names.emplace_back();
    basis->groups.push_back(std::move(group));
  }
}

std::string Power(const std::string& name, std::int64_t exponent) {
  return exponent == 1 ? name : fmt::format("{}^{}", name, exponent);
}

}  // namespace

std::string ToString(const Monomial& monomial) {
  std::string above;
  std::string below;
  int divisors = 0;
  for (const auto& [name, exponent] : monomial) {
    if (exponent == 0) continue;
    std::string& text = exponent > 0 ? above : below;
    if (!text.empty()) text += ' ';
    text += Power(name, exponent > 0 ? exponent : -exponent);
    if (exponent < 0) ++divisors;
  }
  if (above.empty()) above = "1";
  if (below.empty()) return above;
  return above + (divisors > 1 ? " / (" + below + ")" : " / " + below);
}

PiBasis FindGroups(std::span<const Variable> variables, std::span<const std::string> prefer,
                   std::span<const NamedGroup> named) {
  const std::vector<Variable> sorted = Sorted(variables);
  PiBasis basis{.variables = NamesOf(sorted)};
  for (std::size_t i = 0; i < kBaseSymbols.size(); ++i) {
    const bool occurs = std::any_of(sorted.begin(), sorted.end(), [i](const Variable& variable) {
      return variable.dimension.exponents[i] != 0;
    });
    if (occurs) basis.dimensions.emplace_back(kBaseSymbols[i]);
  }
  std::vector<Monomial> plain = PlainGroups(InOrderOfPreference(sorted, prefer), &basis);
  for (const std::string& name : prefer) {
    if (std::find(basis.repeating.begin(), basis.repeating.end(), name) == basis.repeating.end()) {
      basis.not_repeating.push_back(name);
    }
  }
  for (const std::string& name : basis.variables) {
    const bool used = std::any_of(plain.begin(), plain.end(),
                                  [&](const Monomial& group) { return group.contains(name); });
    if (!used) basis.unused.push_back(name);
  }
  Assemble(sorted, named, std::move(plain), &basis);
  return basis;
}

std::vector<Fraction> ExpressIn(const PiBasis& basis, const Monomial& group) {
  for (const auto& [name, exponent] : group) {
    if (std::find(basis.variables.begin(), basis.variables.end(), name) == basis.variables.end()) {
      throw UnknownName("variable", name, basis.variables);
    }
  }
  // (groups as columns) x = group, as an augmented matrix with a row for each variable.
  std::vector<RationalRow> rows;
  const RationalRow wanted = RowOf(basis.variables, group);
  std::vector<RationalRow> columns;
  for (const Monomial& one : basis.groups) columns.push_back(RowOf(basis.variables, one));
  for (std::size_t i = 0; i < basis.variables.size(); ++i) {
    RationalRow row;
    for (const RationalRow& column : columns) row.push_back(column[i]);
    row.push_back(wanted[i]);
    rows.push_back(std::move(row));
  }
  const EchelonForm form = Reduce(std::move(rows));
  std::vector<Fraction> exponents(columns.size());
  for (std::size_t i = 0; i < form.rows.size(); ++i) {
    if (form.pivots[i] == columns.size()) {
      throw InputError("the product is not dimensionless", {.value = ToString(group)});
    }
    const Rational& value = form.rows[i].back();
    exponents[form.pivots[i]] = {ToInt64(numerator(value)), ToInt64(denominator(value))};
  }
  return exponents;
}

std::string ExplainIncomplete(std::span<const Variable> variables,
                              std::span<const Monomial> groups) {
  const std::vector<Variable> sorted = Sorted(variables);
  const std::vector<std::string> names = NamesOf(sorted);
  std::vector<RationalRow> rows;
  for (const Monomial& group : groups) {
    const Dimension dimension = DimensionOf(sorted, group);
    if (!dimension.dimensionless()) {
      return fmt::format("{} is not dimensionless: it has the dimension {}", ToString(group),
                         dimension.ToString());
    }
    rows.push_back(RowOf(names, group));
    if (!Independent(rows)) {
      return fmt::format("{} follows from the groups before it", ToString(group));
    }
  }
  const std::size_t needed = sorted.size() - Reduce(DimensionMatrix(sorted)).pivots.size();
  if (groups.size() == needed) return "";
  return fmt::format("{} groups of {}", groups.size(), needed);
}

namespace {

void SerializeVariable(const std::string& name, Archive& section, VariablesFile* file) {
  section.Require("unit");
  std::string text;
  section.Text("unit", text);
  try {
    file->variables.push_back({name, Unit::Parse(text).dimension()});
  } catch (const InputError& error) {
    throw section.ErrorAt("unit", error.problem());
  }
  file->units.push_back(text);
}

void SerializeNamed(const std::string& name, Archive& section, VariablesFile* file) {
  NamedGroup group{.name = name};
  for (const Variable& variable : file->variables) {
    std::int64_t exponent = 0;
    section.Integer(variable.name, exponent, {.lower = -1e6, .upper = 1e6});
    if (exponent != 0) group.exponents[variable.name] = exponent;
  }
  file->named.push_back(std::move(group));
}

}  // namespace

VariablesFile ParseVariables(const std::string& text, const std::string& file) {
  VariablesFile variables;
  std::vector<SourceLocation> places;
  ReadYaml(text, file, [&](Archive& archive) {
    archive.Require("variables");
    archive.Map(
        "variables", {},
        [&](const std::string& name, Archive& section) {
          SerializeVariable(name, section, &variables);
        },
        "unit");
    if (variables.variables.empty()) {
      throw archive.ErrorAt("variables", "there is no variable: expected name: unit");
    }
    archive.Names("prefer", variables.prefer, "variable", NamesOf(variables.variables));
    archive.Map("named", {}, [&](const std::string& name, Archive& section) {
      places.push_back(section.LocationOf(""));
      SerializeNamed(name, section, &variables);
    });
  });
  for (std::size_t i = 0; i < variables.named.size(); ++i) {
    try {
      FindGroups(variables.variables, {}, std::span(variables.named).first(i + 1));
    } catch (const InputError& error) {
      throw InputError(error.problem(),
                       {.location = places[i], .key = "named." + variables.named[i].name});
    }
  }
  return variables;
}

VariablesFile ReadVariables(const std::string& path) {
  return ParseVariables(ReadFile(path), path);
}

}  // namespace powdercal

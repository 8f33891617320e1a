#include "scaling/rational_matrix.h"

#include <algorithm>
#include <utility>

namespace powdercal {

using boost::multiprecision::cpp_int;

EchelonForm Reduce(std::vector<RationalRow> rows) {
  EchelonForm form;
  const std::size_t columns = rows.empty() ? 0 : rows.front().size();
  std::size_t next = 0;
  for (std::size_t column = 0; column < columns && next < rows.size(); ++column) {
    std::size_t pivot = next;
    while (pivot < rows.size() && rows[pivot][column] == 0) ++pivot;
    if (pivot == rows.size()) continue;
    std::swap(rows[next], rows[pivot]);
    const Rational lead = rows[next][column];
    for (Rational& entry : rows[next]) entry /= lead;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Rational factor = rows[i][column];
      if (i == next || factor == 0) continue;
      for (std::size_t j = 0; j < columns; ++j) rows[i][j] -= factor * rows[next][j];
    }
    form.pivots.push_back(column);
    ++next;
  }
  rows.resize(next);
  form.rows = std::move(rows);
  return form;
}

std::vector<RationalRow> NullSpace(const EchelonForm& form, std::size_t columns) {
  std::vector<RationalRow> basis;
  for (std::size_t column = 0; column < columns; ++column) {
    if (std::find(form.pivots.begin(), form.pivots.end(), column) != form.pivots.end()) continue;
    RationalRow vector(columns, 0);
    vector[column] = 1;
    for (std::size_t i = 0; i < form.rows.size(); ++i) {
      vector[form.pivots[i]] = -form.rows[i][column];
    }
    basis.push_back(std::move(vector));
  }
  return basis;
}

RationalRow WithIntegers(RationalRow row) {
  cpp_int multiple = 1;
  for (const Rational& entry : row) multiple = lcm(multiple, denominator(entry));
  cpp_int divisor = 0;
  for (Rational& entry : row) {
    entry *= multiple;
    divisor = gcd(divisor, numerator(entry));
  }
  if (divisor == 0) return row;
  for (Rational& entry : row) entry /= divisor;
  return row;
}

}  // namespace powdercal

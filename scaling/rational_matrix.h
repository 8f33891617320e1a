#pragma once

#include <boost/multiprecision/cpp_int.hpp>
#include <cstddef>
#include <vector>

namespace powdercal {

/// Fractions of any length: elimination cannot overflow or round.
using Rational = boost::multiprecision::cpp_rational;
using RationalRow = std::vector<Rational>;

/// Reduced row echelon form, without its zero rows.
struct EchelonForm {
  std::vector<RationalRow> rows;
  std::vector<std::size_t> pivots;  ///< the column of each row's leading one
};

/// Gauss–Jordan elimination; pivots are sought from the first column to the last. `rows` must be
/// equally long.
EchelonForm Reduce(std::vector<RationalRow> rows);

/// A basis of the vectors x with (rows) x = 0, one for each column without a pivot, whose own entry
/// is 1. `columns` is the length of the rows.
std::vector<RationalRow> NullSpace(const EchelonForm& form, std::size_t columns);

/// The multiple by a positive factor whose entries are integers without a common divisor.
RationalRow WithIntegers(RationalRow row);

}  // namespace powdercal

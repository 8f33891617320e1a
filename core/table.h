#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/errors.h"

namespace powdercal {

/// A table of numbers read from a CSV file (RFC 4180; lines starting with '#' are comments). The
/// first row names the columns, with the unit in brackets: "cohesion_energy_density [J/m3]";
/// no brackets: a pure number. Values are converted to SI.
class Table {
 public:
  struct Column {
    std::string name;
    std::string unit;            ///< as written; "1" without brackets
    std::vector<double> values;  ///< SI, one per row
  };

  /// Throws InputError, with file, line and column, when the file is missing or empty, a row has
  /// the wrong number of fields, a field is not a finite number, a unit is unknown, a name appears
  /// twice.
  static Table ReadCsv(const std::string& path);
  static Table ParseCsv(const std::string& text, const std::string& file);

  const std::string& file() const { return file_; }
  const std::vector<Column>& columns() const { return columns_; }
  std::size_t row_count() const { return lines_.size(); }
  /// Line of the file that a row came from.
  int line_of_row(std::size_t row) const { return lines_[row]; }
  std::vector<std::string> column_names() const;

  /// Throws InputError with the nearest name if there is no such column, or if its unit has another
  /// dimension than `unit`.
  const Column& Get(std::string_view name, std::string_view unit) const;
  bool Has(std::string_view name) const;

 private:
  std::string file_;
  std::vector<Column> columns_;
  std::vector<int> lines_;
};

}  // namespace powdercal

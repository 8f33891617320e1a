#include "core/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "core/files.h"
#include "core/quantity.h"
#include "core/text.h"

namespace powdercal {
namespace {

struct Field {
  std::string text;
  SourceLocation location;
};

struct Record {
  std::vector<Field> fields;
  SourceLocation end;  // where a missing field would stand
};

// Splits CSV text (RFC 4180) into records. Fields without quotes lose the blanks around them.
class CsvScanner {
 public:
  CsvScanner(std::string_view text, const std::string& file) : text_(text), file_(file) {
    if (text_.starts_with("\xEF\xBB\xBF")) position_ = line_start_ = 3;  // byte-order mark
  }

  // The next record that is neither blank nor a comment; none at the end of the text.
  std::optional<Record> Next() {
    while (position_ < text_.size()) {
      const std::size_t first = text_.find_first_not_of(" \t", position_);
      if (first == std::string_view::npos) return std::nullopt;
      if (text_[first] == '#') {
        position_ = std::min(text_.find_first_of("\r\n", first), text_.size());
        SkipLineEnd();
      } else if (text_[first] == '\r' || text_[first] == '\n') {
        position_ = first;
        SkipLineEnd();
      } else {
        return ScanRecord();
      }
    }
    return std::nullopt;
  }

 private:
  Record ScanRecord() {
    Record record;
    while (true) {
      record.fields.push_back(ScanField());
      if (position_ >= text_.size() || text_[position_] != ',') break;
      ++position_;
    }
    record.end = Here();
    SkipLineEnd();
    return record;
  }

  Field ScanField() {
    SkipBlanks();
    if (position_ < text_.size() && text_[position_] == '"') return ScanQuoted();
    Field field{.text = {}, .location = Here()};
    const std::size_t end = std::min(text_.find_first_of(",\r\n\"", position_), text_.size());
    field.text = Trim(text_.substr(position_, end - position_));
    position_ = end;
    if (end < text_.size() && text_[end] == '"') {
      throw InputError("a quote inside a field without quotes", {.location = Here()});
    }
    return field;
  }

  Field ScanQuoted() {
    Field field{.text = {}, .location = Here()};
    ++position_;
    while (true) {
      if (position_ >= text_.size()) {
        throw InputError("this quote is never closed", {.location = field.location});
      }
      const char c = text_[position_++];
      if (c == '\n') StartLine();
      if (c == '"') {
        if (position_ >= text_.size() || text_[position_] != '"') break;
        ++position_;  // "" stands for a quote
      }
      field.text += c;
    }
    SkipBlanks();
    if (position_ < text_.size() &&
        std::string_view(",\r\n").find(text_[position_]) == std::string_view::npos) {
      throw InputError("expected a comma or the end of the line after the closing quote",
                       {.location = Here()});
    }
    return field;
  }

  void SkipBlanks() {
    while (position_ < text_.size() && (text_[position_] == ' ' || text_[position_] == '\t')) {
      ++position_;
    }
  }

  void SkipLineEnd() {
    if (position_ >= text_.size()) return;
    position_ += text_.substr(position_).starts_with("\r\n") ? 2 : 1;
    StartLine();
  }

  void StartLine() {
    ++line_;
    line_start_ = position_;
  }

  SourceLocation Here() const {
    const std::string_view before = text_.substr(line_start_, position_ - line_start_);
    return {file_, line_, 1 + CountCharacters(before)};
  }

  std::string_view text_;
  std::string file_;
  std::size_t position_ = 0;
  std::size_t line_start_ = 0;
  int line_ = 1;
};

struct Header {
  Table::Column column;
  Unit unit;
};

Header ParseHeader(const Field& field) {
  const InputError::Details details{.location = field.location, .value = field.text};
  const std::string_view text = Trim(field.text);
  const std::size_t bracket = text.find('[');
  Header header;
  header.column.name = Trim(text.substr(0, bracket));
  header.column.unit = "1";
  if (header.column.name.empty()) throw InputError("a column without a name", details);
  if (header.column.name.find_first_of(";\t") != std::string::npos) {
    throw InputError("columns must be separated by commas", details);
  }
  if (bracket != std::string_view::npos) {
    if (text.back() != ']') throw InputError("expected 'name [unit]'", details);
    header.column.unit = Trim(text.substr(bracket + 1, text.size() - bracket - 2));
  }
  try {
    header.unit = Unit::Parse(header.column.unit);
  } catch (const InputError& error) {
    throw InputError(
        error.problem(),
        {.location = field.location, .key = header.column.name, .value = header.column.unit});
  }
  return header;
}

std::vector<Header> ParseHeaders(const Record& record) {
  std::vector<Header> headers;
  for (const Field& field : record.fields) {
    Header header = ParseHeader(field);
    for (const Header& earlier : headers) {
      if (earlier.column.name != header.column.name) continue;
      throw InputError(fmt::format("column '{}' appears twice", header.column.name),
                       {.location = field.location, .value = header.column.name});
    }
    headers.push_back(std::move(header));
  }
  return headers;
}

// In SI.
double ParseNumber(const Field& field, const std::string& column, double to_si) {
  const InputError::Details details{.location = field.location, .key = column, .value = field.text};
  const std::string_view text = Trim(field.text);
  if (text.empty()) throw InputError("a number is missing", details);
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  const char* const end = text.data() + text.size();
  double value = 0;
  const auto [rest, error] = std::from_chars(text.data() + (plus ? 1 : 0), end, value);
  if (error == std::errc::result_out_of_range) {
    throw InputError("the number is too large or too small", details);
  }
  if (error != std::errc() || rest != end) throw InputError("expected a number", details);
  if (!std::isfinite(value * to_si)) throw InputError("expected a finite number", details);
  return value * to_si;
}

void CheckFieldCount(const Record& record, std::size_t expected) {
  const std::size_t found = record.fields.size();
  if (found == expected) return;
  const bool surplus = found > expected;
  throw InputError(
      fmt::format("expected {} {}, found {}", expected, expected == 1 ? "field" : "fields", found),
      {.location = surplus ? record.fields[expected].location : record.end,
       .value = surplus ? record.fields[expected].text : ""});
}

}  // namespace

Table Table::ReadCsv(const std::string& path) { return ParseCsv(ReadFile(path), path); }

Table Table::ParseCsv(const std::string& text, const std::string& file) {
  CsvScanner scanner(text, file);
  const std::optional<Record> first = scanner.Next();
  if (!first) throw InputError("the file is empty", {.location = {file}});
  const std::vector<Header> headers = ParseHeaders(*first);

  Table table;
  table.file_ = file;
  for (const Header& header : headers) table.columns_.push_back(header.column);
  while (const std::optional<Record> record = scanner.Next()) {
    CheckFieldCount(*record, headers.size());
    for (std::size_t i = 0; i < headers.size(); ++i) {
      Column& column = table.columns_[i];
      column.values.push_back(ParseNumber(record->fields[i], column.name, headers[i].unit.to_si()));
    }
    table.lines_.push_back(record->fields.front().location.line);
  }
  if (table.lines_.empty()) throw InputError("the table has no rows", {.location = first->end});
  return table;
}

std::vector<std::string> Table::column_names() const {
  std::vector<std::string> names;
  for (const Column& column : columns_) names.push_back(column.name);
  return names;
}

const Table::Column& Table::Get(std::string_view name, std::string_view unit) const {
  const auto column = std::find_if(columns_.begin(), columns_.end(),
                                   [&](const Column& c) { return c.name == name; });
  if (column == columns_.end()) {
    throw UnknownName("column", name, column_names(), {.location = {file_}});
  }
  const Dimension found = Unit::Parse(column->unit).dimension();
  const Dimension wanted = Unit::Parse(unit).dimension();
  if (found != wanted) {
    throw InputError(fmt::format("expected a unit of {} (such as {}), found '{}', a unit of {}",
                                 wanted.Name(), unit, column->unit, found.Name()),
                     {.location = {file_}, .key = column->name, .value = column->unit});
  }
  return *column;
}

bool Table::Has(std::string_view name) const {
  return std::any_of(columns_.begin(), columns_.end(),
                     [&](const Column& column) { return column.name == name; });
}

}  // namespace powdercal

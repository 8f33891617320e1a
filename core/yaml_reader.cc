#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "core/archive.h"
#include "core/files.h"
#include "core/quantity.h"
#include "core/text.h"

namespace powdercal {
namespace {

std::string Bound(double value, std::string_view unit) { return FormatQuantity(value, unit); }

std::string Describe(const Range& range, std::string_view unit) {
  const bool low = std::isfinite(range.lower);
  const bool high = std::isfinite(range.upper);
  if (low && high) {
    return fmt::format("must lie in {}{}, {}{}", range.lower_open ? '(' : '[',
                       Bound(range.lower, unit), Bound(range.upper, unit),
                       range.upper_open ? ')' : ']');
  }
  if (low) {
    return fmt::format("must be {} {}", range.lower_open ? "above" : "at least",
                       Bound(range.lower, unit));
  }
  return fmt::format("must be {} {}", range.upper_open ? "below" : "at most",
                     Bound(range.upper, unit));
}

std::string_view KindOf(const YAML::Node& node) {
  switch (node.Type()) {
    case YAML::NodeType::Map:
      return "a map";
    case YAML::NodeType::Sequence:
      return "a list";
    case YAML::NodeType::Scalar:
      return "a single value";
    default:
      return "nothing";
  }
}

struct Source {
  std::string file;
  std::string_view text;
  const Overrides& overrides;  // values that take precedence over the file's
  mutable std::set<std::string> used_overrides{};
  mutable std::vector<std::string> known_paths{};  // that an override could have

  bool OverridesBelow(const std::string& path) const {
    const auto next = overrides.lower_bound(path + ".");
    return next != overrides.end() && next->first.starts_with(path + ".");
  }

  SourceLocation Locate(const YAML::Mark& mark) const {
    if (mark.is_null()) return {overrides.empty() ? file : "command line", 0, 0};
    // yaml-cpp counts bytes, people count characters.
    const auto column = static_cast<std::size_t>(mark.column);
    const auto position = static_cast<std::size_t>(mark.pos);
    if (column > position || position > text.size()) return {file, mark.line + 1, mark.column + 1};
    const std::string_view before = text.substr(position - column, column);
    return {file, mark.line + 1, CountCharacters(before) + 1};
  }
};

// One map of the file, with the keys that have been visited.
class YamlReader final : public Archive {
 public:
  // `location` is that of the map, which may have been made up and then has none of its own.
  YamlReader(YAML::Node map, const Source& source, SourceLocation location, std::string path)
      : map_(std::move(map)),
        source_(source),
        location_(std::move(location)),
        path_(std::move(path)) {
    RejectDuplicateKeys(map_, path_);
  }

  bool reading() const override { return true; }

  bool Has(std::string_view key) const override {
    visited_.emplace_back(key);
    const auto node = Find(key);
    return node && !node->IsNull();
  }

  void Require(std::string_view key) override {
    if (Has(key)) return;
    if (const auto node = Find(key)) throw Error(*node, key, "a value is missing");
    std::string problem = fmt::format("missing key '{}'", key);
    // A misspelt key is the likeliest reason for a missing one.
    InputError::Details details{.location = location_, .key = path_};
    const std::string wanted(key);
    for (const auto& item : map_) {
      const std::string found = item.first.Scalar();
      if (NearestName(found, std::span(&wanted, 1)).empty()) continue;
      details.location = Location(item.first);
      problem += fmt::format(" (found '{}')", found);
    }
    throw InputError(problem, details);
  }

  InputError ErrorAt(std::string_view key, const std::string& problem) const override {
    if (const auto node = Find(key)) return Error(*node, key, problem);
    return InputError(problem, {.location = location_, .key = PathTo(key)});
  }

  SourceLocation LocationOf(std::string_view key) const override {
    for (const auto& item : map_) {
      if (item.first.Scalar() == key) return Location(item.first);
    }
    return location_;
  }

  void Quantity(std::string_view key, double& value, std::string_view unit, Range range) override {
    if (const auto node = Take(key)) value = ReadQuantity(*node, key, unit, range);
  }

  void Quantity(std::string_view key, std::optional<double>& value, std::string_view unit,
                Range range) override {
    if (const auto node = Take(key)) value = ReadQuantity(*node, key, unit, range);
  }

  void Quantities(std::string_view key, std::vector<double>& values, std::string_view unit,
                  Range range) override {
    const auto node = Take(key);
    if (!node) return;
    if (!node->IsSequence()) {
      throw Error(*node, key, fmt::format("expected a list, found {}", KindOf(*node)));
    }
    values.clear();
    for (const YAML::Node& item : *node) values.push_back(ReadQuantity(item, key, unit, range));
  }

  void Interval(std::string_view key, double& lower, double& upper) override {
    const auto node = Take(key);
    if (!node) return;
    if (!node->IsSequence() || node->size() != 2) {
      throw Error(*node, key, "expected [lower, upper]");
    }
    lower = ReadQuantity((*node)[0], key, "1", {});
    upper = ReadQuantity((*node)[1], key, "1", {});
    if (!(lower < upper)) {
      throw Error(*node, key,
                  fmt::format("the lower bound {} is not below the upper bound {}", lower, upper));
    }
  }

  void Integer(std::string_view key, std::int64_t& value, Range range) override {
    const auto node = Take(key);
    if (!node) return;
    const std::string text = ScalarText(*node, key, "an integer");
    std::int64_t parsed = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), parsed);
    if (error != std::errc() || end != text.data() + text.size()) {
      throw Error(*node, key, "expected an integer");
    }
    if (!range.Contains(static_cast<double>(parsed))) throw Error(*node, key, Describe(range, "1"));
    value = parsed;
  }

  void Flag(std::string_view key, bool& value) override {
    const auto node = Take(key);
    if (!node) return;
    const std::string text = ScalarText(*node, key, "true or false");
    if (text != "true" && text != "false") throw Error(*node, key, "expected true or false");
    value = text == "true";
  }

  void Text(std::string_view key, std::string& value) override {
    if (const auto node = Take(key)) value = ScalarText(*node, key, "a text");
  }

  void Choice(std::string_view key, std::string& value, std::string_view what,
              std::span<const std::string> valid) override {
    if (const auto node = Take(key)) value = ReadChoice(*node, key, what, valid);
  }

  void Names(std::string_view key, std::vector<std::string>& names, std::string_view what,
             std::span<const std::string> valid) override {
    const auto node = Take(key);
    if (!node) return;
    if (node->IsMap()) throw Error(*node, key, "expected a list, found a map");
    names.clear();
    if (node->IsScalar()) {
      names.push_back(ReadChoice(*node, key, what, valid));
      return;
    }
    for (const YAML::Node& item : *node) {
      std::string name = ReadChoice(item, key, what, valid);
      if (std::find(names.begin(), names.end(), name) != names.end()) {
        throw Error(item, key, "named twice");
      }
      names.push_back(std::move(name));
    }
  }

  void Section(std::string_view key, const Visitor& visit, std::string_view scalar_key) override {
    const auto node = Take(key);
    if (node) VisitSection(*node, Location(*node), PathTo(key), visit, scalar_key);
  }

  void Map(std::string_view key, std::span<const std::string>, const KeyedVisitor& visit,
           std::string_view scalar_key) override {
    const auto node = Take(key);
    if (!node) return;
    if (!node->IsMap()) {
      throw Error(*node, key, fmt::format("expected a map, found {}", KindOf(*node)));
    }
    RejectDuplicateKeys(*node, PathTo(key));
    for (const auto& item : *node) {
      const std::string name = item.first.Scalar();
      VisitSection(
          item.second, Location(item.first), PathTo(key) + "." + name,
          [&](Archive& archive) { visit(name, archive); }, scalar_key);
    }
  }

  void List(std::string_view key, std::size_t, const Visitor& visit) override {
    const auto node = Take(key);
    if (!node) return;
    if (!node->IsSequence()) {
      throw Error(*node, key, fmt::format("expected a list, found {}", KindOf(*node)));
    }
    std::size_t index = 0;
    for (const YAML::Node& item : *node) {
      VisitSection(item, Location(item), fmt::format("{}[{}]", PathTo(key), index++), visit, "");
    }
  }

  void Tagged(std::string& name, const KeyedVisitor& visit) override {
    if (map_.size() != 1) {
      throw InputError("expected one '- name: {…}' per item",
                       {.location = location_, .key = path_});
    }
    const auto item = *map_.begin();
    name = item.first.Scalar();
    visited_.push_back(name);
    const bool empty = item.second.IsNull();  // `- consolidation:` without options
    VisitSection(
        empty ? YAML::Node(YAML::NodeType::Map) : item.second,
        Location(empty ? item.first : item.second), path_ + "." + name,
        [&](Archive& archive) { visit(name, archive); }, "");
  }

  // Every key must have been visited.
  void Finish() const {
    for (const auto& item : map_) {
      const std::string key = item.first.Scalar();
      if (std::find(visited_.begin(), visited_.end(), key) != visited_.end()) continue;
      std::vector<std::string> valid = visited_;
      std::sort(valid.begin(), valid.end());
      valid.erase(std::unique(valid.begin(), valid.end()), valid.end());
      throw UnknownName("key", key, valid, {.location = Location(item.first), .key = path_});
    }
  }

 private:
  std::optional<YAML::Node> Find(std::string_view key) const {
    if (key.empty()) return std::nullopt;
    const std::string path = PathTo(key);
    if (!source_.overrides.empty()) source_.known_paths.push_back(path);
    const auto value = source_.overrides.find(path);
    if (value != source_.overrides.end()) {
      source_.used_overrides.insert(path);
      return OverrideNode(value->second);
    }
    std::optional<YAML::Node> found;
    for (const auto& item : map_) {
      if (item.first.Scalar() == key) found.emplace(item.second);
    }
    const bool empty = !found || found->IsNull();
    if (empty && source_.OverridesBelow(path)) return YAML::Node(YAML::NodeType::Map);
    return found;
  }

  // "[0.1, 0.2]" is a list, everything else a single value. Built anew, since nodes that were
  // parsed would point into the override's text as if it were the file.
  static YAML::Node OverrideNode(const std::string& text) {
    if (!text.starts_with('[')) return YAML::Node(text);
    YAML::Node list(YAML::NodeType::Sequence);
    try {
      for (const YAML::Node& item : YAML::Load(text)) list.push_back(item.Scalar());
    } catch (const YAML::Exception&) {
      return YAML::Node(text);
    }
    return list;
  }

  // Marks the key as visited; an explicit null counts as absent.
  std::optional<YAML::Node> Take(std::string_view key) {
    visited_.emplace_back(key);
    auto node = Find(key);
    if (node && node->IsNull()) return std::nullopt;
    return node;
  }

  void RejectDuplicateKeys(const YAML::Node& map, const std::string& path) const {
    std::vector<std::string> seen;
    for (const auto& item : map) {
      if (!item.first.IsScalar()) {
        throw InputError("a key must be a plain name",
                         {.location = Location(item.first), .key = path});
      }
      const std::string key = item.first.Scalar();
      if (std::find(seen.begin(), seen.end(), key) != seen.end()) {
        throw InputError(fmt::format("key '{}' appears twice", key),
                         {.location = Location(item.first), .key = path});
      }
      seen.push_back(key);
    }
  }

  // Assigning to a YAML::Node writes through to the tree, so a node is never reused for another.
  static YAML::Node AsMap(const YAML::Node& node, std::string_view scalar_key) {
    if (!node.IsScalar() || scalar_key.empty()) return node;
    YAML::Node map(YAML::NodeType::Map);
    map.force_insert(std::string(scalar_key), node);
    return map;
  }

  void VisitSection(const YAML::Node& node, const SourceLocation& location, const std::string& path,
                    const Visitor& visit, std::string_view scalar_key) const {
    const YAML::Node map = AsMap(node, scalar_key);
    if (!map.IsMap()) {
      throw InputError(
          fmt::format("expected a map, found {}", KindOf(node)),
          {.location = location, .key = path, .value = node.IsScalar() ? node.Scalar() : ""});
    }
    YamlReader reader(map, source_, location, path);
    visit(reader);
    reader.Finish();
  }

  std::string ScalarText(const YAML::Node& node, std::string_view key,
                         std::string_view expected) const {
    if (!node.IsScalar()) {
      throw Error(node, key, fmt::format("expected {}, found {}", expected, KindOf(node)));
    }
    return node.Scalar();
  }

  std::string ReadChoice(const YAML::Node& node, std::string_view key, std::string_view what,
                         std::span<const std::string> valid) const {
    std::string name = ScalarText(node, key, fmt::format("the name of one {}", what));
    if (std::find(valid.begin(), valid.end(), name) == valid.end()) {
      throw UnknownName(what, name, valid, {.location = Location(node), .key = PathTo(key)});
    }
    return name;
  }

  double ReadQuantity(const YAML::Node& node, std::string_view key, std::string_view unit,
                      const Range& range) const {
    const std::string text =
        ScalarText(node, key, unit == "1" ? "a number" : "a number with a unit");
    double value = 0;
    try {
      value = ParseQuantity(text, unit);
    } catch (const InputError& error) {
      throw Error(node, key, error.problem());
    }
    if (!range.Contains(value)) throw Error(node, key, Describe(range, unit));
    return value;
  }

  InputError Error(const YAML::Node& node, std::string_view key, const std::string& problem) const {
    return InputError(problem, {.location = Location(node),
                                .key = PathTo(key),
                                .value = node.IsScalar() ? node.Scalar() : ""});
  }

  SourceLocation Location(const YAML::Node& node) const { return source_.Locate(node.Mark()); }

  std::string PathTo(std::string_view key) const {
    if (key.empty()) return path_;
    return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
  }

  YAML::Node map_;
  const Source& source_;
  SourceLocation location_;
  std::string path_;
  mutable std::vector<std::string> visited_;
};

// YAML's commonest trap, which yaml-cpp does not name.
std::string TabRemark(std::string_view text, const YAML::Mark& mark) {
  if (mark.is_null() || static_cast<std::size_t>(mark.pos) > text.size()) return "";
  const std::size_t end = text.rfind('\n', static_cast<std::size_t>(mark.pos));
  const std::size_t line = end == std::string_view::npos ? 0 : end + 1;
  const std::size_t first = text.find_first_not_of(" \t", line);
  const bool tab = text.substr(line, first - line).find('\t') != std::string_view::npos;
  return tab ? "; YAML allows no tabs as indentation" : "";
}

}  // namespace

void ReadYaml(const std::string& text, const std::string& file, const Archive::Visitor& visit,
              const Overrides& overrides) {
  Source source{file, text, overrides};
  if (source.text.starts_with("\xEF\xBB\xBF")) source.text.remove_prefix(3);  // byte-order mark
  std::vector<YAML::Node> documents;
  try {
    documents = YAML::LoadAll(std::string(source.text));
  } catch (const YAML::Exception& error) {
    throw InputError(error.msg + TabRemark(source.text, error.mark),
                     {.location = source.Locate(error.mark)});
  }
  if (documents.size() > 1) {
    throw InputError("expected one document, found another after '---'",
                     {.location = source.Locate(documents[1].Mark())});
  }
  const YAML::Node root = documents.empty() ? YAML::Node() : documents.front();
  if (!root.IsMap()) {
    throw InputError(fmt::format("expected a map of keys, found {}", KindOf(root)),
                     {.location = {file, 1, 1}});
  }
  YamlReader reader(root, source, source.Locate(root.Mark()), "");
  visit(reader);
  reader.Finish();
  for (const auto& [path, value] : overrides) {
    if (source.used_overrides.contains(path)) continue;
    throw InputError("no such key in a study of this kind",
                     {.location = {"command line"},
                      .key = path,
                      .value = value,
                      .suggestion = NearestName(path, source.known_paths)});
  }
}

void ReadYamlFile(const std::string& path, const Archive::Visitor& visit) {
  ReadYaml(ReadFile(path), path, visit);
}

}  // namespace powdercal

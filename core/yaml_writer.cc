#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "core/archive.h"
#include "core/quantity.h"

namespace powdercal {
namespace {

class YamlWriter final : public Archive {
 public:
  explicit YamlWriter(YAML::Emitter& out) : out_(out) {}

  bool reading() const override { return false; }
  bool Has(std::string_view) const override { return false; }
  void Require(std::string_view) override {}
  InputError ErrorAt(std::string_view key, const std::string& problem) const override {
    return InputError(problem, {.key = std::string(key)});
  }
  SourceLocation LocationOf(std::string_view) const override { return {}; }

  void Quantity(std::string_view key, double& value, std::string_view unit, Range) override {
    Key(key);
    out_ << FormatQuantity(value, unit);
  }

  void Quantity(std::string_view key, std::optional<double>& value, std::string_view unit,
                Range range) override {
    if (value) Quantity(key, *value, unit, range);
  }

  void Quantities(std::string_view key, std::vector<double>& values, std::string_view unit,
                  Range) override {
    Key(key);
    out_ << YAML::Flow << YAML::BeginSeq;
    for (const double value : values) out_ << FormatQuantity(value, unit);
    out_ << YAML::EndSeq;
  }

  void Interval(std::string_view key, double& lower, double& upper) override {
    Key(key);
    out_ << YAML::Flow << YAML::BeginSeq << fmt::format("{}", lower) << fmt::format("{}", upper)
         << YAML::EndSeq;
  }

  void Integer(std::string_view key, std::int64_t& value, Range) override {
    Key(key);
    out_ << value;
  }

  void Flag(std::string_view key, bool& value) override {
    Key(key);
    out_ << (value ? "true" : "false");
  }

  void Text(std::string_view key, std::string& value) override {
    Key(key);
    out_ << value;  // yaml-cpp quotes what a reader would take for something else (null, a list)
  }

  void Choice(std::string_view key, std::string& value, std::string_view,
              std::span<const std::string>) override {
    Text(key, value);
  }

  void Choices(std::string_view key, std::vector<std::string>& values, std::string_view,
               std::span<const std::string>) override {
    Key(key);
    out_ << YAML::Flow << YAML::BeginSeq;
    for (const std::string& value : values) out_ << value;
    out_ << YAML::EndSeq;
  }

  void Section(std::string_view key, const Visitor& visit, std::string_view) override {
    Key(key);
    Nested(visit);
  }

  void Map(std::string_view key, std::span<const std::string> keys, const KeyedVisitor& visit,
           std::string_view) override {
    Key(key);
    out_ << YAML::BeginMap;
    for (const std::string& name : keys) {
      Key(name);
      Nested([&](Archive& archive) { visit(name, archive); });
    }
    out_ << YAML::EndMap;
  }

  void List(std::string_view key, std::size_t count, const Visitor& visit) override {
    Key(key);
    out_ << YAML::BeginSeq;
    for (std::size_t i = 0; i < count; ++i) Nested(visit);
    out_ << YAML::EndSeq;
  }

  void Tagged(std::string& name, const KeyedVisitor& visit) override {
    Key(name);
    Nested([&](Archive& archive) { visit(name, archive); });
  }

 private:
  void Key(std::string_view key) { out_ << YAML::Key << std::string(key) << YAML::Value; }

  void Nested(const Visitor& visit) {
    out_ << YAML::BeginMap;
    visit(*this);
    out_ << YAML::EndMap;
  }

  YAML::Emitter& out_;
};

}  // namespace

std::string WriteYaml(const Archive::Visitor& visit) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  YamlWriter writer(out);
  visit(writer);
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

}  // namespace powdercal

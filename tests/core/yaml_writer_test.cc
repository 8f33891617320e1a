#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/archive.h"

namespace powdercal {
namespace {

// One member of every kind.
struct Sample {
  double stress = 9e3;
  double friction = 0.1 + 0.2;
  std::optional<double> gap;
  std::optional<double> width = 5e-3;
  std::vector<double> stresses = {3e3, 1.0 / 3};
  std::vector<double> none;
  double lower = 1e-3;
  double upper = 1e5;
  std::int64_t seed = 9007199254740993;
  int count = -3;
  bool keep = true;
  std::string title = "a: b # c";
  std::string backend = "yade";
  std::vector<std::string> backends = {"yade", "embedded"};
  double nested = 2;
  std::map<std::string, double> named = {{"mu_r", 0.3}, {"true", 1}};
  std::vector<double> items = {4, 5};
  std::vector<std::pair<std::string, double>> experiments = {{"shear", 6}, {"spreading", 7}};

  void Serialize(Archive& archive) {
    static const std::vector<std::string> kBackends = {"embedded", "yade"};
    archive.Quantity("stress", stress, "Pa", kPositive);
    archive.Number("friction", friction);
    archive.Quantity("gap", gap, "m");
    archive.Quantity("width", width, "m");
    archive.Quantities("stresses", stresses, "Pa");
    archive.Quantities("none", none, "Pa");
    archive.Interval("range", lower, upper);
    archive.Integer("seed", seed);
    archive.Integer("count", count);
    archive.Flag("keep", keep);
    archive.Text("title", title);
    archive.Choice("backend", backend, "backend", kBackends);
    archive.Names("backends", backends, "backend", kBackends);
    archive.Section("section", [&](Archive& inner) { inner.Number("nested", nested); });
    SerializeContainers(archive);
  }

 private:
  void SerializeContainers(Archive& archive) {
    std::vector<std::string> names;
    for (const auto& entry : named) names.push_back(entry.first);
    archive.Map("named", names,
                [&](const std::string& name, Archive& inner) { inner.Number("v", named[name]); });
    std::size_t next = 0;
    archive.List("items", items.size(), [&](Archive& inner) {
      if (next == items.size()) items.emplace_back();
      inner.Number("v", items[next++]);
    });
    next = 0;
    archive.List("experiments", experiments.size(), [&](Archive& item) {
      if (next == experiments.size()) experiments.emplace_back();
      auto& [name, value] = experiments[next++];
      item.Tagged(name, [&](const std::string&, Archive& inner) { inner.Number("v", value); });
    });
  }
};

std::string Write(Sample& sample) {
  return WriteYaml([&](Archive& archive) {
    EXPECT_FALSE(archive.reading());
    EXPECT_FALSE(archive.Has("stress"));
    archive.Require("stress");
    sample.Serialize(archive);
  });
}

TEST(YamlWriter, EveryKindOfMemberComesBack) {
  Sample sample;
  const std::string text = Write(sample);
  Sample read{.stress = 0,
              .friction = 0,
              .gap = {},
              .width = {},
              .stresses = {},
              .none = {1},
              .lower = 0,
              .upper = 0,
              .seed = 0,
              .count = 0,
              .keep = false,
              .title = "",
              .backend = "",
              .backends = {},
              .nested = 0,
              .named = {},
              .items = {},
              .experiments = {}};
  read.backend = "embedded";
  ReadYaml(text, "written", [&](Archive& archive) { read.Serialize(archive); });
  EXPECT_EQ(read.stress, sample.stress);
  EXPECT_EQ(read.friction, sample.friction);
  EXPECT_EQ(read.gap, sample.gap);
  EXPECT_EQ(read.width, sample.width);
  EXPECT_EQ(read.stresses, sample.stresses);
  EXPECT_EQ(read.none, sample.none);
  EXPECT_EQ(read.lower, sample.lower);
  EXPECT_EQ(read.upper, sample.upper);
  EXPECT_EQ(read.seed, sample.seed);
  EXPECT_EQ(read.count, sample.count);
  EXPECT_EQ(read.keep, sample.keep);
  EXPECT_EQ(read.title, sample.title);
  EXPECT_EQ(read.backend, sample.backend);
  EXPECT_EQ(read.backends, sample.backends);
  EXPECT_EQ(read.nested, sample.nested);
  EXPECT_EQ(read.named, sample.named);
  EXPECT_EQ(read.items, sample.items);
  EXPECT_EQ(read.experiments, sample.experiments);
  EXPECT_EQ(Write(read), text);
}

TEST(YamlWriter, QuantitiesCarryTheirUnitAndAbsentOnesAreLeftOut) {
  Sample sample;
  const std::string text = Write(sample);
  EXPECT_NE(text.find("stress: 9000 Pa\n"), std::string::npos) << text;
  EXPECT_NE(text.find("stresses: [3000 Pa, "), std::string::npos) << text;
  EXPECT_EQ(text.find("gap"), std::string::npos) << text;
}

TEST(YamlWriter, AnyTextComesBack) {
  for (const std::string text :
       {"",       "~",    "null",  "Null",   "NULL",       "true",      "1.5", "- x",
        "# c",    "a: b", " lead", "trail ", "two\nlines", "tab\there", "µm",  "[x",
        "{",      "*a",   "&b",    "!t",     "%d",         "@x",        "`x",  "'q'",
        "\"dq\"", "x #y", "ends:", "-",      "?",          "\x01"}) {
    std::string written = text;
    const std::string yaml = WriteYaml([&](Archive& archive) { archive.Text("text", written); });
    std::string read = "untouched";
    ReadYaml(yaml, "written", [&](Archive& archive) { archive.Text("text", read); });
    EXPECT_EQ(read, text) << yaml;
  }
}

TEST(YamlWriter, AnyKeyComesBack) {
  const std::vector<std::string> keys = {"",      "~",          "null", "a: b",
                                         " lead", "two\nlines", "é",    "- x"};
  const std::string yaml = WriteYaml([&](Archive& archive) {
    archive.Map("map", keys, [](const std::string&, Archive& inner) {
      double value = 1;
      inner.Number("value", value);
    });
  });
  std::vector<std::string> read;
  ReadYaml(yaml, "written", [&](Archive& archive) {
    archive.Map("map", {}, [&](const std::string& key, Archive& inner) {
      double value = 0;
      inner.Number("value", value);
      read.push_back(key);
    });
  });
  EXPECT_EQ(read, keys) << yaml;
}

TEST(YamlWriter, WritesListsOfNames) {
  std::vector<std::string> names = {"stress", "gravity"};
  EXPECT_EQ(WriteYaml([&](Archive& archive) { archive.Names("keep", names, "quantity", names); }),
            "keep: [stress, gravity]\n");
}

}  // namespace
}  // namespace powdercal

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/archive.h"

namespace powdercal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;
using testing::StartsWith;

// The whole message that reading the text gives.
std::string MessageOf(const std::string& text, const Archive::Visitor& visit) {
  try {
    ReadYaml(text, "s.yaml", visit);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

void VisitStress(Archive& archive) {
  double stress = 0;
  archive.Quantity("stress", stress, "Pa", kPositive);
}

TEST(YamlReader, ReadsScalars) {
  double stress = 0;
  double friction = 0;
  std::optional<double> gap;
  std::optional<double> width;
  std::int64_t seed = 0;
  bool keep = false;
  std::string title;
  ReadYaml(
      "stress: 9 kPa\nfriction: 0.3\ngap: 80 um\nseed: 9007199254740993\nkeep: true\n"
      "title: \"a: b\"\n",
      "s.yaml", [&](Archive& archive) {
        EXPECT_TRUE(archive.reading());
        archive.Quantity("stress", stress, "Pa", kPositive);
        archive.Number("friction", friction, kUnitInterval);
        archive.Quantity("gap", gap, "m");
        archive.Quantity("width", width, "m");
        archive.Integer("seed", seed);
        archive.Flag("keep", keep);
        archive.Text("title", title);
      });
  EXPECT_DOUBLE_EQ(stress, 9000);
  EXPECT_EQ(friction, 0.3);
  ASSERT_TRUE(gap.has_value());
  EXPECT_DOUBLE_EQ(*gap, 80e-6);
  EXPECT_FALSE(width.has_value());
  EXPECT_EQ(seed, 9007199254740993);  // more digits than a double has
  EXPECT_TRUE(keep);
  EXPECT_EQ(title, "a: b");
}

TEST(YamlReader, ReadsLists) {
  std::vector<double> stresses = {1};
  std::vector<double> weights = {1};
  double lower = 0;
  double upper = 0;
  ReadYaml("stresses: [3 kPa, 5e3 Pa]\nweights: []\nrange: [1e2, 1e5]\n", "s.yaml",
           [&](Archive& archive) {
             archive.Quantities("stresses", stresses, "Pa", kPositive);
             archive.Quantities("weights", weights, "1");
             archive.Interval("range", lower, upper);
           });
  EXPECT_THAT(stresses, ElementsAre(3000, 5000));
  EXPECT_TRUE(weights.empty());
  EXPECT_EQ(lower, 100);
  EXPECT_EQ(upper, 1e5);
}

TEST(YamlReader, AbsentAndNullKeysLeaveDefaults) {
  double stress = 7;
  std::vector<double> list = {1, 2};
  std::string name = "bayesian";
  int visits = 0;
  ReadYaml("stress:\nlist: ~\n", "s.yaml", [&](Archive& archive) {
    EXPECT_FALSE(archive.Has("stress"));
    archive.Quantity("stress", stress, "Pa");
    archive.Quantities("list", list, "Pa");
    archive.Text("name", name);
    archive.Section("section", [&](Archive&) { ++visits; });
    archive.List("items", 3, [&](Archive&) { ++visits; });
    archive.Map("map", {}, [&](const std::string&, Archive&) { ++visits; });
  });
  EXPECT_EQ(stress, 7);
  EXPECT_EQ(list.size(), 2U);
  EXPECT_EQ(name, "bayesian");
  EXPECT_EQ(visits, 0);
}

TEST(YamlReader, ReadsSectionsMapsAndLists) {
  std::vector<std::pair<std::string, double>> found;
  const auto read_value = [&](const std::string& name, Archive& archive) {
    double value = 0;
    archive.Number("value", value);
    found.emplace_back(name, value);
  };
  ReadYaml(
      "section: {value: 1}\n"
      "map: {a: {value: 2}, b: 3}\n"
      "list:\n  - {value: 4}\n  - {value: 5}\n"
      "tagged:\n  - shear: {value: 6}\n  - consolidation:\n",
      "s.yaml", [&](Archive& archive) {
        archive.Section("section", [&](Archive& inner) { read_value("section", inner); });
        archive.Map("map", {}, read_value, "value");
        archive.List("list", 0, [&](Archive& inner) { read_value("item", inner); });
        archive.List("tagged", 0, [&](Archive& item) {
          std::string name;
          item.Tagged(name, read_value);
        });
      });
  EXPECT_THAT(found, ElementsAre(Pair("section", 1), Pair("a", 2), Pair("b", 3), Pair("item", 4),
                                 Pair("item", 5), Pair("shear", 6), Pair("consolidation", 0)));
}

TEST(YamlReader, AScalarMayStandForASection) {
  for (const char* text : {"backend: liggghts", "backend: {name: liggghts}"}) {
    std::string name;
    ReadYaml(text, "s.yaml", [&](Archive& archive) {
      archive.Section(
          "backend", [&](Archive& inner) { inner.Text("name", name); }, "name");
      EXPECT_TRUE(archive.Has("backend"));
    });
    EXPECT_EQ(name, "liggghts");
  }
  const auto no_scalar = [](Archive& archive) { archive.Section("shear", VisitStress); };
  EXPECT_EQ(MessageOf("shear: 9 kPa", no_scalar),
            "s.yaml:1:8: shear: expected a map, found a single value (found '9 kPa')");
}

TEST(YamlReader, ErrorsInAScalarSectionHaveAPlace) {
  const auto visit = [](Archive& archive) {
    archive.Section(
        "backend",
        [](Archive& inner) {
          std::string name;
          inner.Text("name", name);
          inner.Require("fidelity");
        },
        "name");
  };
  EXPECT_EQ(MessageOf("backend: yade", visit), "s.yaml:1:10: backend: missing key 'fidelity'");
}

TEST(YamlReader, UnknownKeysNameTheNearest) {
  EXPECT_EQ(MessageOf("stress: 9 kPa\n\nstres: 1\n", VisitStress),
            "s.yaml:3:1: unknown key 'stres' (valid: stress); did you mean 'stress'?");
  const auto nested = [](Archive& archive) {
    archive.List("experiments", 0, [](Archive& item) {
      std::string name;
      item.Tagged(name, [](const std::string&, Archive& inner) { VisitStress(inner); });
    });
  };
  EXPECT_EQ(
      MessageOf("experiments:\n  - shear: {stress: 1 Pa}\n  - shear:\n      strss: 2 Pa\n", nested),
      "s.yaml:4:7: experiments[1].shear: unknown key 'strss' (valid: stress); "
      "did you mean 'stress'?");
}

TEST(YamlReader, DuplicateKeysAreErrors) {
  EXPECT_EQ(MessageOf("stress: 1 Pa\nstress: 2 Pa\n", VisitStress),
            "s.yaml:2:1: key 'stress' appears twice");
  const auto map = [](Archive& archive) {
    archive.Map("m", {}, [](const std::string&, Archive& inner) { VisitStress(inner); });
  };
  EXPECT_EQ(MessageOf("m: {a: {stress: 1 Pa}, a: {}}", map),
            "s.yaml:1:24: m: key 'a' appears twice");
  EXPECT_THAT(MessageOf("[1, 2]: 3", VisitStress), HasSubstr("a key must be a plain name"));
}

TEST(YamlReader, WrongValuesHaveAPlace) {
  EXPECT_EQ(MessageOf("stress: 5 mm/s", VisitStress),
            "s.yaml:1:9: stress: expected a pressure or energy density (such as Pa), got a speed "
            "('5 mm/s')");
  EXPECT_THAT(MessageOf("stress: 9000", VisitStress), HasSubstr("'9000' has no unit"));
  EXPECT_EQ(MessageOf("stress: -9 kPa", VisitStress),
            "s.yaml:1:9: stress: must be above 0 Pa (found '-9 kPa')");
  EXPECT_EQ(MessageOf("stress: [9 kPa]", VisitStress),
            "s.yaml:1:9: stress: expected a number with a unit, found a list");
}

TEST(YamlReader, RangesAreDescribed) {
  const auto within = [](Range range) {
    return MessageOf("x: 5", [range](Archive& archive) {
      double x = 0;
      archive.Number("x", x, range);
    });
  };
  EXPECT_THAT(within({.lower = 0, .upper = 1}), HasSubstr("must lie in [0, 1] (found '5')"));
  EXPECT_THAT(within({.lower = 5, .upper = 6, .lower_open = true, .upper_open = true}),
              HasSubstr("must lie in (5, 6) (found '5')"));
  EXPECT_THAT(within({.lower = 6}), HasSubstr("must be at least 6"));
  EXPECT_THAT(within({.upper = 4}), HasSubstr("must be at most 4"));
  EXPECT_THAT(within({.upper = 5, .upper_open = true}), HasSubstr("must be below 5"));
  EXPECT_EQ(within({.lower = 5, .upper = 5}), "no error");
}

TEST(YamlReader, WrongKindsAreErrors) {
  const auto visit = [](Archive& archive) {
    std::vector<double> list;
    double lower = 0;
    double upper = 0;
    std::int64_t count = 0;
    bool flag = false;
    std::string text;
    archive.Quantities("list", list, "Pa");
    archive.Interval("range", lower, upper);
    archive.Integer("count", count, kNonNegative);
    archive.Flag("flag", flag);
    archive.Text("text", text);
    archive.List("items", 0, [](Archive&) {});
    archive.Map("map", {}, [](const std::string&, Archive&) {});
  };
  EXPECT_EQ(MessageOf("list: 3 kPa", visit),
            "s.yaml:1:7: list: expected a list, found a single value (found '3 kPa')");
  EXPECT_EQ(MessageOf("list: [1 Pa, 2 m]", visit),
            "s.yaml:1:14: list: expected a pressure or energy density (such as Pa), got a length "
            "('2 m')");
  EXPECT_EQ(MessageOf("range: [1]", visit), "s.yaml:1:8: range: expected [lower, upper]");
  EXPECT_EQ(MessageOf("range: [2, 2]", visit),
            "s.yaml:1:8: range: the lower bound 2 is not below the upper bound 2");
  for (const char* value : {"1.5", "1e3", "ten", "99999999999999999999"}) {
    EXPECT_THAT(MessageOf(std::string("count: ") + value, visit), HasSubstr("expected an integer"));
  }
  EXPECT_EQ(MessageOf("count: -1", visit), "s.yaml:1:8: count: must be at least 0 (found '-1')");
  EXPECT_EQ(MessageOf("flag: yes", visit),
            "s.yaml:1:7: flag: expected true or false (found 'yes')");
  EXPECT_THAT(MessageOf("text: {a: 1}", visit), HasSubstr("expected a text, found a map"));
  EXPECT_THAT(MessageOf("items: {a: 1}", visit), HasSubstr("expected a list, found a map"));
  EXPECT_THAT(MessageOf("items: [3]", visit), HasSubstr("items[0]: expected a map"));
  EXPECT_THAT(MessageOf("map: [1]", visit), HasSubstr("expected a map, found a list"));
  EXPECT_THAT(MessageOf("map: {a: 1}", visit), HasSubstr("map.a: expected a map"));
}

TEST(YamlReader, NamesFromAListOrASingleName) {
  static const std::vector<std::string> kValid = {"embedded", "liggghts", "yade"};
  std::vector<std::string> names;
  const auto visit = [&](Archive& archive) { archive.Names("with", names, "backend", kValid); };
  ReadYaml("with: [yade, embedded]\n", "s.yaml", visit);
  EXPECT_THAT(names, ElementsAre("yade", "embedded"));
  ReadYaml("with: liggghts\n", "s.yaml", visit);
  EXPECT_THAT(names, ElementsAre("liggghts"));
  ReadYaml("with: [yade]\n", "s.yaml", visit, {{"with", "[embedded, liggghts]"}});
  EXPECT_THAT(names, ElementsAre("embedded", "liggghts"));
  ReadYaml("with:\n", "s.yaml", visit);
  EXPECT_THAT(names, ElementsAre("embedded", "liggghts")) << "an empty value counts as absent";
  ReadYaml("with: []\n", "s.yaml", visit);
  EXPECT_TRUE(names.empty());
  EXPECT_THAT(
      MessageOf("with: [yade, ligghts]\n", visit),
      testing::AllOf(StartsWith("s.yaml:1:14: with: "), HasSubstr("did you mean 'liggghts'?")));
  EXPECT_THAT(MessageOf("with: [yade, yade]\n", visit), HasSubstr("named twice (found 'yade')"));
  EXPECT_THAT(MessageOf("with: {yade: 1}\n", visit), HasSubstr("expected a list, found a map"));
  EXPECT_THAT(MessageOf("with: [[yade]]\n", visit),
              HasSubstr("expected the name of one backend, found a list"));
}

TEST(YamlReader, ChoicesNameTheNearest) {
  const std::vector<std::string> backends = {"embedded", "liggghts"};
  std::string backend = "embedded";
  const auto visit = [&](Archive& archive) {
    archive.Choice("backend", backend, "backend", backends);
  };
  EXPECT_EQ(MessageOf("backend: ligghts", visit),
            "s.yaml:1:10: backend: unknown backend 'ligghts' (valid: embedded, liggghts); "
            "did you mean 'liggghts'?");
  EXPECT_EQ(backend, "embedded");
  ReadYaml("backend: liggghts", "s.yaml", visit);
  EXPECT_EQ(backend, "liggghts");
}

TEST(YamlReader, RequiredKeys) {
  const auto visit = [](Archive& archive) {
    archive.Section("shear", [](Archive& inner) {
      inner.Require("preshear");
      double preshear = 0;
      inner.Quantity("preshear", preshear, "Pa");
    });
  };
  EXPECT_EQ(MessageOf("shear: {preshear: 1 Pa}", visit), "no error");
  EXPECT_EQ(MessageOf("\nshear: {}", visit), "s.yaml:2:8: shear: missing key 'preshear'");
  EXPECT_EQ(MessageOf("shear: {presher: 1 Pa}", visit),
            "s.yaml:1:9: shear: missing key 'preshear' (found 'presher')");
  EXPECT_EQ(MessageOf("shear: {preshear: }", visit),
            "s.yaml:1:19: shear.preshear: a value is missing");
}

TEST(YamlReader, TaggedItemsHaveOneName) {
  const auto visit = [](Archive& archive) {
    archive.List("list", 0, [](Archive& item) {
      std::string name;
      item.Tagged(name, [](const std::string& tag, Archive& inner) {
        if (tag == "shear") inner.Require("preshear");
      });
    });
  };
  EXPECT_EQ(MessageOf("list: [{a: {}, b: {}}]", visit),
            "s.yaml:1:8: list[0]: expected one '- name: {…}' per item");
  EXPECT_EQ(MessageOf("list:\n  - shear:\n", visit),
            "s.yaml:2:5: list[0].shear: missing key 'preshear'");
}

TEST(YamlReader, ErrorsOfLaterChecksHaveAPlace) {
  const auto visit = [](Archive& archive) {
    double stress = 0;
    archive.Quantity("stress", stress, "Pa");
    EXPECT_EQ(archive.LocationOf("stress").ToString(), "s.yaml:2:1");
    EXPECT_EQ(archive.LocationOf("absent").ToString(), "s.yaml:2:1");
    EXPECT_STREQ(archive.ErrorAt("", "odd").what(), "s.yaml:2:1: odd");
    throw archive.ErrorAt("stress", "too much for this powder");
  };
  EXPECT_EQ(MessageOf("# comment\nstress: 9 kPa", visit),
            "s.yaml:2:9: stress: too much for this powder (found '9 kPa')");
}

TEST(YamlReader, ColumnsCountCharactersAndNotBytes) {
  const auto visit = [](Archive& archive) {
    std::string title;
    archive.Text("title", title);
    VisitStress(archive);
  };
  EXPECT_THAT(MessageOf("{title: µµ, stress: 1 m}", visit), HasSubstr("s.yaml:1:21: "));
  EXPECT_THAT(MessageOf("\xEF\xBB\xBF{title: µµ, stress: 1 m}", visit), HasSubstr("s.yaml:1:21: "));
}

TEST(YamlReader, SyntaxErrorsHaveAPlace) {
  EXPECT_EQ(MessageOf("a: [1, 2\nb: 3\n", VisitStress),
            "s.yaml:2:2: end of sequence flow not found");
  EXPECT_THAT(MessageOf("stress: 1 Pa\n  - b\n c: d: e", VisitStress), HasSubstr("s.yaml:"));
  EXPECT_THAT(MessageOf("stress: \"1 Pa", VisitStress), HasSubstr("s.yaml:1:"));
}

TEST(YamlReader, TheRootMustBeOneMap) {
  EXPECT_EQ(MessageOf("", VisitStress), "s.yaml:1:1: expected a map of keys, found nothing");
  EXPECT_EQ(MessageOf("- 1\n", VisitStress), "s.yaml:1:1: expected a map of keys, found a list");
  EXPECT_EQ(MessageOf("stress: 1 Pa\n---\nstress: 2 Pa\n", VisitStress),
            "s.yaml:3:1: expected one document, found another after '---'");
}

TEST(YamlReader, OverridesTakePrecedence) {
  const Overrides overrides = {{"stress", "5 kPa"}, {"backend.fidelity", "paper"}, {"gap", "1 mm"}};
  for (const char* backend :
       {"", "backend:\n", "backend: {fidelity: quick}\n", "backend: yade\n"}) {
    double stress = 0;
    double gap = 0;
    std::string name = "embedded";
    std::string fidelity;
    ReadYaml(
        std::string("stress: 9 kPa\n") + backend, "s.yaml",
        [&](Archive& archive) {
          archive.Quantity("stress", stress, "Pa");
          EXPECT_TRUE(archive.Has("gap"));
          archive.Quantity("gap", gap, "m");
          archive.Section(
              "backend",
              [&](Archive& inner) {
                inner.Text("name", name);
                inner.Text("fidelity", fidelity);
              },
              "name");
        },
        overrides);
    EXPECT_DOUBLE_EQ(stress, 5000);
    EXPECT_DOUBLE_EQ(gap, 1e-3);
    EXPECT_EQ(fidelity, "paper") << backend;
    EXPECT_EQ(name, std::string(backend) == "backend: yade\n" ? "yade" : "embedded");
  }
}

TEST(YamlReader, OverridesAreCheckedLikeTheFile) {
  const auto message_of = [](const Overrides& overrides) -> std::string {
    try {
      ReadYaml("stress: 9 kPa", "s.yaml", VisitStress, overrides);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(message_of({{"stress", "1 Pa"}}), "no error");
  EXPECT_EQ(message_of({{"stress", "-1 Pa"}}),
            "command line: stress: must be above 0 Pa (found '-1 Pa')");
  EXPECT_THAT(message_of({{"stres", "1 Pa"}}), StartsWith("command line: stres: no such key"));
  EXPECT_THAT(message_of({{"a.b", "1 Pa"}}), StartsWith("command line: a.b: no such key"));
}

TEST(YamlReader, ReadsFiles) {
  const std::string path =
      testing::TempDir() + "powdercal_yaml_test." + std::to_string(getpid()) + ".yaml";
  std::ofstream(path) << "stress: 9 m\n";
  try {
    ReadYamlFile(path, VisitStress);
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(error.details().location.ToString(), path + ":1:9");
  }
  unlink(path.c_str());
  EXPECT_THROW(ReadYamlFile(path, VisitStress), InputError);
}

}  // namespace
}  // namespace powdercal

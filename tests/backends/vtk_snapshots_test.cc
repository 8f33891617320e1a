#include "backends/vtk_snapshots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <regex>

#include "core/files.h"
#include "tests/support/program.h"

namespace powdercal {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// "" if every tag is closed in its turn, and there is one root; else the trouble.
std::string ExplainIllFormed(const std::string& xml) {
  std::vector<std::string> open;
  std::size_t roots = 0;
  std::size_t at = xml.find("?>");
  if (!xml.starts_with("<?xml version=\"1.0\"") || at == std::string::npos) return "no declaration";
  while ((at = xml.find('<', at)) != std::string::npos) {
    const std::size_t end = xml.find('>', at);
    if (end == std::string::npos) return "a tag without end";
    const std::string tag = xml.substr(at + 1, end - at - 1);
    at = end;
    if (tag.starts_with('/')) {
      if (open.empty() || open.back() != tag.substr(1)) return "unexpected <" + tag + ">";
      open.pop_back();
      continue;
    }
    static const std::regex kTag(R"re(\w+( \w+="[^"<&]*")*/?)re");
    if (!std::regex_match(tag, kTag)) return "not a tag: <" + tag + ">";
    if (open.empty()) ++roots;
    if (!tag.ends_with('/')) open.push_back(tag.substr(0, tag.find(' ')));
  }
  if (!open.empty()) return "<" + open.back() + "> is not closed";
  return roots == 1 ? "" : "not one root";
}

std::string DecodeBase64(const std::string& text) {
  static const std::string kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  EXPECT_EQ(text.size() % 4, 0u);
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  const std::size_t end = text.find('=');
  for (const char c : text.substr(0, end)) {
    const std::size_t digit = kDigits.find(c);
    EXPECT_NE(digit, std::string::npos) << c;
    bits = bits << 6 | static_cast<unsigned>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<char>(bits >> count & 255));
  }
  if (end != std::string::npos) {
    EXPECT_LE(text.size() - end, 2u);
  }
  return bytes;
}

std::string Attribute(const std::string& tag, const std::string& name) {
  const std::string start = " " + name + "=\"";
  const std::size_t at = tag.find(start);
  if (at == std::string::npos) return "";
  return tag.substr(at + start.size(), tag.find('"', at + start.size()) - at - start.size());
}

// A .vtp file, read back.
class PolyData {
 public:
  explicit PolyData(const fs::path& file) : text_(ReadFile(file)) {
    EXPECT_EQ(ExplainIllFormed(text_), "");
    EXPECT_THAT(text_, HasSubstr("<VTKFile type=\"PolyData\" version=\"1.0\" "
                                 "byte_order=\"LittleEndian\" header_type=\"UInt64\">"));
  }

  int Size(const std::string& what) const {
    const std::size_t piece = text_.find("<Piece");
    return std::stoi(Attribute(text_.substr(piece, text_.find('>', piece) - piece), what));
  }

  // Bytes of the array `name` of a section, whose type and number of components must be these.
  std::string Bytes(const std::string& section, const std::string& name, const std::string& type,
                    const std::string& components) const {
    const std::size_t start = text_.find("<" + section + ">");
    const std::size_t end = text_.find("</" + section + ">");
    const std::size_t found = text_.find("Name=\"" + name + "\"", start);
    if (found >= end) {
      ADD_FAILURE() << section << " has no " << name;
      return "";
    }
    const std::size_t data = text_.find('>', found) + 2;
    const std::string tag = text_.substr(text_.rfind('<', found), data - text_.rfind('<', found));
    EXPECT_EQ(Attribute(tag, "type"), type) << name;
    EXPECT_EQ(Attribute(tag, "NumberOfComponents"), components) << name;
    EXPECT_EQ(Attribute(tag, "format"), "binary") << name;
    const std::string bytes = DecodeBase64(text_.substr(data, text_.find('\n', data) - data));
    std::uint64_t size = 0;
    std::memcpy(&size, bytes.data(), sizeof size);
    EXPECT_EQ(bytes.size(), sizeof size + size);
    return bytes.substr(sizeof size);
  }

  template <typename T>
  std::vector<T> Values(const std::string& section, const std::string& name,
                        const std::string& type, const std::string& components) const {
    const std::string bytes = Bytes(section, name, type, components);
    std::vector<T> values(bytes.size() / sizeof(T));
    if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }

 private:
  std::string text_;
};

struct Listed {
  std::string time;
  std::string file;
  friend bool operator==(const Listed&, const Listed&) = default;
  friend void PrintTo(const Listed& l, std::ostream* out) { *out << l.time << ' ' << l.file; }
};

// What a .pvd file lists; all of it must be there.
std::vector<Listed> ReadList(const fs::path& file) {
  const std::string text = ReadFile(file);
  EXPECT_EQ(ExplainIllFormed(text), "");
  EXPECT_THAT(text, HasSubstr("<VTKFile type=\"Collection\""));
  std::vector<Listed> list;
  for (std::size_t at = 0; (at = text.find("<DataSet", at)) != std::string::npos; ++at) {
    const std::string tag = text.substr(at, text.find('>', at) - at);
    list.push_back({Attribute(tag, "timestep"), Attribute(tag, "file")});
    EXPECT_TRUE(fs::exists(file.parent_path() / list.back().file)) << list.back().file;
  }
  return list;
}

std::vector<std::string> FilesOf(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

Packing MakePacking(int count) {
  Packing packing;
  for (int i = 0; i < count; ++i) {
    const double x = 1e-5 / 3 * (i + 1);
    packing.push_back({.id = (std::int64_t{1} << 40) + 7 * i,
                       .radius = x,
                       .position = {x, -2 * x, 0.1 + x},
                       .velocity = {-x, 1e3 * x, 0},
                       .spin = {0, 1e30, -x}});
  }
  return packing;
}

SnapshotSurface Triangle(const std::string& name, double height) {
  return {.name = name,
          .vertices = {{0, 0, height}, {1, 0, height}, {0, 1, height}},
          .triangles = {{2, 1, 0}}};
}

std::string ErrorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

// One, two and three spheres end their arrays with all paddings of base64.
class SnapshotParticles : public ::testing::TestWithParam<int> {};

TEST_P(SnapshotParticles, ReadBackAsTheyWere) {
  const TemporaryFolder folder;
  const Packing packing = MakePacking(GetParam());
  const std::size_t count = packing.size();
  SnapshotWriter(folder.path()).Write(0.1, packing, {});
  const PolyData file(folder / "particles_000000.vtp");
  EXPECT_EQ(file.Size("NumberOfPoints"), GetParam());
  EXPECT_EQ(file.Size("NumberOfVerts"), GetParam());
  EXPECT_THAT(file.Values<double>("FieldData", "TimeValue", "Float64", ""), ElementsAre(0.1));
  const auto id = file.Values<std::int64_t>("PointData", "id", "Int64", "1");
  const auto radius = file.Values<double>("PointData", "radius", "Float64", "1");
  const auto diameter = file.Values<float>("PointData", "diameter", "Float32", "1");
  const auto velocity = file.Values<float>("PointData", "velocity", "Float32", "3");
  const auto spin = file.Values<float>("PointData", "spin", "Float32", "3");
  const auto position = file.Values<double>("Points", "position", "Float64", "3");
  const auto vertex = file.Values<std::int32_t>("Verts", "connectivity", "Int32", "1");
  const auto offset = file.Values<std::int32_t>("Verts", "offsets", "Int32", "1");
  ASSERT_EQ(id.size(), count);
  ASSERT_EQ(radius.size(), count);
  ASSERT_EQ(diameter.size(), count);
  ASSERT_EQ(velocity.size(), 3 * count);
  ASSERT_EQ(spin.size(), 3 * count);
  ASSERT_EQ(position.size(), 3 * count);
  ASSERT_EQ(vertex.size(), count);
  ASSERT_EQ(offset.size(), count);
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(id[i], packing[i].id);
    EXPECT_EQ(radius[i], packing[i].radius);
    EXPECT_EQ(diameter[i], static_cast<float>(2 * packing[i].radius));
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(position[3 * i + k], packing[i].position[k]);
      EXPECT_EQ(velocity[3 * i + k], static_cast<float>(packing[i].velocity[k]));
      EXPECT_EQ(spin[3 * i + k], static_cast<float>(packing[i].spin[k]));
    }
    EXPECT_EQ(vertex[i], static_cast<int>(i));
    EXPECT_EQ(offset[i], static_cast<int>(i) + 1);
  }
}
INSTANTIATE_TEST_SUITE_P(Counts, SnapshotParticles, ::testing::Values(0, 1, 2, 3, 1000));

TEST(SnapshotWalls, ReadBackWithBodyAndForce) {
  const TemporaryFolder folder;
  const std::vector<SnapshotSurface> surfaces = {
      {.name = "lid <\"&\">",
       .vertices = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
       .triangles = {{0, 1, 2}, {0, 2, 3}},
       .force = Vector3{1.5, 0, -2e-9}},
      Triangle("blade", 0.25)};
  SnapshotWriter(folder.path()).Write(3e-7, {}, surfaces);
  const PolyData file(folder / "walls_000000.vtp");
  EXPECT_EQ(file.Size("NumberOfPoints"), 7);
  EXPECT_EQ(file.Size("NumberOfPolys"), 3);
  EXPECT_EQ(file.Bytes("FieldData", "body_names", "String", ""),
            std::string("lid <\"&\">\0blade\0", 16));
  EXPECT_THAT(file.Values<std::int32_t>("CellData", "body", "Int32", "1"), ElementsAre(0, 0, 1));
  const auto force = file.Values<double>("CellData", "force", "Float64", "3");
  ASSERT_EQ(force.size(), 9u);
  EXPECT_THAT(std::vector<double>(force.begin(), force.begin() + 6),
              ElementsAre(1.5, 0, -2e-9, 1.5, 0, -2e-9));
  EXPECT_TRUE(std::isnan(force[6]) && std::isnan(force[7]) && std::isnan(force[8]));
  const auto points = file.Values<double>("Points", "position", "Float64", "3");
  ASSERT_EQ(points.size(), 21u);
  EXPECT_EQ(points[3], 1);
  EXPECT_EQ(points[20], 0.25);
  EXPECT_THAT(file.Values<std::int32_t>("Polys", "connectivity", "Int32", "1"),
              ElementsAre(0, 1, 2, 0, 2, 3, 6, 5, 4));
  EXPECT_THAT(file.Values<std::int32_t>("Polys", "offsets", "Int32", "1"), ElementsAre(3, 6, 9));
}

TEST(SnapshotPlane, IsTheDomainsCrossSectionFacingTheParticles) {
  const Domain domain{.lower = {-1, 2, 5}, .upper = {1, 5, 9}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool facing_positive : {false, true}) {
      const PlaneWall wall{
          .name = "w", .axis = axis, .position = 42, .facing_positive = facing_positive};
      const SnapshotSurface surface = PlaneSurface(wall, domain);
      EXPECT_EQ(surface.name, "w");
      EXPECT_FALSE(surface.force);
      double area = 0;
      for (const auto& [a, b, c] : surface.triangles) {
        Vector3 u;
        Vector3 v;
        for (std::size_t k = 0; k < 3; ++k) {
          const Vector3& corner = surface.vertices.at(static_cast<std::size_t>(a));
          u[k] = surface.vertices.at(static_cast<std::size_t>(b))[k] - corner[k];
          v[k] = surface.vertices.at(static_cast<std::size_t>(c))[k] - corner[k];
        }
        const auto i = static_cast<std::size_t>(axis);
        const std::size_t j = (i + 1) % 3;
        const std::size_t k = (i + 2) % 3;
        const double normal = u[j] * v[k] - u[k] * v[j];
        EXPECT_EQ(normal > 0, facing_positive);
        area += std::abs(normal) / 2;
        EXPECT_EQ(u[i], 0);
        EXPECT_EQ(v[i], 0);
      }
      const Vector3 lengths = domain.Lengths();
      const auto i = static_cast<std::size_t>(axis);
      EXPECT_EQ(area, lengths[(i + 1) % 3] * lengths[(i + 2) % 3]);
      for (const Vector3& vertex : surface.vertices) {
        for (std::size_t k = 0; k < 3; ++k) {
          if (k == i) {
            EXPECT_EQ(vertex[k], 42);
          } else {
            EXPECT_TRUE(vertex[k] == domain.lower[k] || vertex[k] == domain.upper[k]);
          }
        }
      }
    }
  }
}

TEST(SnapshotLists, NameAllFilesAfterEveryWrite) {
  const TemporaryFolder folder;
  SnapshotWriter writer(folder / "a/b");
  EXPECT_EQ(writer.folder(), folder / "a/b");
  EXPECT_THAT(FilesOf(writer.folder()), IsEmpty());
  const Packing packing = MakePacking(2);
  const std::vector<SnapshotSurface> lid = {Triangle("lid", 1)};
  writer.Write(0, packing, {});
  EXPECT_THAT(FilesOf(writer.folder()), ElementsAre("particles.pvd", "particles_000000.vtp"));
  writer.Write(1.0 / 3, packing, lid);
  writer.Write(1e-9, packing, lid);
  const std::vector<Listed> particles = ReadList(writer.folder() / "particles.pvd");
  EXPECT_THAT(particles, ElementsAre(Listed{"0", "particles_000000.vtp"},
                                     Listed{"0.3333333333333333", "particles_000001.vtp"},
                                     Listed{"1e-09", "particles_000002.vtp"}));
  EXPECT_THAT(ReadList(writer.folder() / "walls.pvd"),
              ElementsAre(Listed{"0.3333333333333333", "walls_000001.vtp"},
                          Listed{"1e-09", "walls_000002.vtp"}));
  EXPECT_EQ(FilesOf(writer.folder()).size(), 7u);
}

TEST(SnapshotWriter, RemovesAnEarlierRunsSnapshotsOnly) {
  const TemporaryFolder folder;
  {
    SnapshotWriter writer(folder.path());
    for (int i = 0; i < 3; ++i) {
      writer.Write(i, MakePacking(1), std::vector<SnapshotSurface>{Triangle("lid", 1)});
    }
  }
  for (const char* name : {"view.pvsm", "particles_.vtp", "particles_1a.vtp", "walls.vtp"}) {
    std::ofstream(folder / name) << "mine";
  }
  const SnapshotWriter again(folder.path());
  EXPECT_THAT(FilesOf(folder.path()),
              ElementsAre("particles_.vtp", "particles_1a.vtp", "view.pvsm", "walls.vtp"));
}

TEST(SnapshotWriter, ErrorsNameThePathAndLeaveTheListsValid) {
  const TemporaryFolder folder;
  std::ofstream(folder / "file") << "";
  EXPECT_THAT(ErrorOf([&] { SnapshotWriter(folder / "file/snapshots"); }),
              HasSubstr((folder / "file/snapshots").string() + ": cannot make the folder"));

  SnapshotWriter writer(folder / "s");
  const Packing packing = MakePacking(2);
  writer.Write(0, packing, {});
  fs::create_directories(folder / "s/particles_000001.vtp/in the way");
  EXPECT_THAT(ErrorOf([&] { writer.Write(1, packing, {}); }),
              HasSubstr((folder / "s/particles_000001.vtp").string() + ": cannot write the file"));
  writer.Write(2, packing, {});
  EXPECT_THAT(
      ReadList(folder / "s/particles.pvd"),
      ElementsAre(Listed{"0", "particles_000000.vtp"}, Listed{"2", "particles_000002.vtp"}));

  fs::remove_all(folder / "s");
  EXPECT_THAT(ErrorOf([&] { writer.Write(3, packing, {}); }),
              HasSubstr((folder / "s/particles_000003.vtp").string()));
}

TEST(SnapshotWriter, WritesAFewHundredThousandParticlesInSeconds) {
  const TemporaryFolder folder;
  const Packing packing = MakePacking(500'000);
  SnapshotWriter writer(folder.path());
  const auto start = std::chrono::steady_clock::now();
  writer.Write(0, packing, {});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
  EXPECT_LT(fs::file_size(folder / "particles_000000.vtp"), 55'000'000u);
}

}  // namespace
}  // namespace powdercal

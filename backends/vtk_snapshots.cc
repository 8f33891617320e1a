#include "backends/vtk_snapshots.h"

#include <fmt/format.h>

#include <bit>
#include <concepts>
#include <cstring>
#include <iterator>
#include <limits>
#include <type_traits>

#include "core/errors.h"
#include "core/files.h"

namespace powdercal {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "the files say LittleEndian");

constexpr std::string_view kParticles = "particles";
constexpr std::string_view kWalls = "walls";

template <typename T>
std::string_view VtkType() {
  if constexpr (std::same_as<T, double>) return "Float64";
  if constexpr (std::same_as<T, float>) return "Float32";
  if constexpr (std::same_as<T, std::int64_t>) return "Int64";
  if constexpr (std::same_as<T, std::int32_t>) return "Int32";
}

void AppendBase64(std::string& text, const std::vector<unsigned char>& bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::size_t start = text.size();
  text.resize(start + (bytes.size() + 2) / 3 * 4);
  char* out = text.data() + start;
  const auto put = [&out](unsigned bits, int digits) {
    for (int i = 0; i < 4; ++i) *out++ = i < digits ? kDigits[bits >> (18 - 6 * i) & 63] : '=';
  };
  std::size_t i = 0;
  for (; i + 3 <= bytes.size(); i += 3) {
    put(unsigned{bytes[i]} << 16 | unsigned{bytes[i + 1]} << 8 | bytes[i + 2], 4);
  }
  const std::size_t rest = bytes.size() - i;
  if (rest == 1) put(unsigned{bytes[i]} << 16, 2);
  if (rest == 2) put(unsigned{bytes[i]} << 16 | unsigned{bytes[i + 1]} << 8, 3);
}

/// A VTK XML file of polygonal data, put together as text.
class PolyDataText {
 public:
  PolyDataText(double time, std::size_t expected_size) {
    text_.reserve(expected_size);
    text_ +=
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<PolyData>\n<FieldData>\n";
    Encode(1, [time](std::size_t) { return std::array{time}; });
    Element("<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\"", "</DataArray>");
  }

  void Strings(std::string_view name, std::span<const std::string> strings) {
    data_.assign(kHeader, 0);
    for (const std::string& s : strings)
      data_.insert(data_.end(), s.c_str(), s.c_str() + s.size() + 1);
    Element(fmt::format("<Array type=\"String\" Name=\"{}\" NumberOfTuples=\"{}\"", name,
                        strings.size()),
            "</Array>");
  }

  void BeginPiece(std::size_t points, std::size_t vertices, std::size_t polygons) {
    Append(
        "</FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" "
        "NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n",
        points, vertices, polygons);
  }

  void Begin(std::string_view section) { Append("<{}>\n", section); }
  void End(std::string_view section) { Append("</{}>\n", section); }

  /// `tuple(i)`: a std::array with the components of tuple i.
  template <typename Tuple>
  void Array(std::string_view name, std::size_t tuples, Tuple tuple) {
    Numbers(name, std::tuple_size_v<TupleOf<Tuple>>, tuples, tuple);
  }

  /// `tuple(i)`: a std::array with the points of cell i. VTK wants them as one row of numbers.
  template <typename Tuple>
  void Cells(std::string_view section, std::size_t cells, Tuple tuple) {
    constexpr auto kCorners = std::tuple_size_v<TupleOf<Tuple>>;
    Begin(section);
    Numbers("connectivity", 1, cells, tuple);
    Array("offsets", cells,
          [](std::size_t i) { return std::array{static_cast<std::int32_t>((i + 1) * kCorners)}; });
    End(section);
  }

  std::string Finish() && {
    text_ += "</Piece>\n</PolyData>\n</VTKFile>\n";
    return std::move(text_);
  }

 private:
  static constexpr std::size_t kHeader = sizeof(std::uint64_t);  // number of bytes that follow

  template <typename Tuple>
  using TupleOf = std::invoke_result_t<Tuple, std::size_t>;

  template <typename... T>
  void Append(fmt::format_string<T...> format, T&&... arguments) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<T>(arguments)...);
  }

  template <typename Tuple>
  void Numbers(std::string_view name, std::size_t components, std::size_t tuples, Tuple tuple) {
    Encode(tuples, tuple);
    Element(fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"",
                        VtkType<typename TupleOf<Tuple>::value_type>(), name, components),
            "</DataArray>");
  }

  template <typename Tuple>
  void Encode(std::size_t tuples, Tuple tuple) {
    using Values = TupleOf<Tuple>;
    data_.resize(kHeader + tuples * sizeof(Values));
    unsigned char* out = data_.data() + kHeader;
    for (std::size_t i = 0; i < tuples; ++i, out += sizeof(Values)) {
      const Values values = tuple(i);
      std::memcpy(out, &values, sizeof values);
    }
  }

  void Element(std::string_view start, std::string_view end) {
    const std::uint64_t size = data_.size() - kHeader;
    std::memcpy(data_.data(), &size, sizeof size);
    Append("{} format=\"binary\">\n", start);
    AppendBase64(text_, data_);
    Append("\n{}\n", end);
  }

  std::string text_;
  std::vector<unsigned char> data_;
};

std::array<float, 3> Single(const Vector3& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

// What places and sizes particles is in double precision, since overlaps are differences of it.
std::string ParticleText(double time, std::span<const Sphere> spheres) {
  constexpr std::size_t kTextPerSphere = 104;  // 4/3 of the 76 bytes below, and some
  PolyDataText text(time, 4096 + kTextPerSphere * spheres.size());
  const std::size_t count = spheres.size();
  text.BeginPiece(count, count, 0);
  text.Begin("PointData");
  text.Array("id", count, [&](std::size_t i) { return std::array{spheres[i].id}; });
  text.Array("radius", count, [&](std::size_t i) { return std::array{spheres[i].radius}; });
  text.Array("diameter", count,
             [&](std::size_t i) { return std::array{static_cast<float>(2 * spheres[i].radius)}; });
  text.Array("velocity", count, [&](std::size_t i) { return Single(spheres[i].velocity); });
  text.Array("spin", count, [&](std::size_t i) { return Single(spheres[i].spin); });
  text.End("PointData");
  text.Begin("Points");
  text.Array("position", count, [&](std::size_t i) { return spheres[i].position; });
  text.End("Points");
  text.Cells("Verts", count,
             [](std::size_t i) { return std::array{static_cast<std::int32_t>(i)}; });
  return std::move(text).Finish();
}

std::string WallText(double time, std::span<const SnapshotSurface> surfaces) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::string> names;
  std::vector<Vector3> points;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<std::int32_t> bodies;
  for (const SnapshotSurface& surface : surfaces) {
    const auto first = static_cast<std::int32_t>(points.size());
    points.insert(points.end(), surface.vertices.begin(), surface.vertices.end());
    for (const auto& [a, b, c] : surface.triangles) {
      triangles.push_back({first + a, first + b, first + c});
    }
    bodies.resize(triangles.size(), static_cast<std::int32_t>(names.size()));
    names.push_back(surface.name);
  }
  PolyDataText text(time, 4096 + 32 * points.size() + 64 * triangles.size());
  text.Strings("body_names", names);
  text.BeginPiece(points.size(), 0, triangles.size());
  text.Begin("CellData");
  text.Array("body", bodies.size(), [&](std::size_t i) { return std::array{bodies[i]}; });
  text.Array("force", bodies.size(), [&](std::size_t i) {
    return surfaces[static_cast<std::size_t>(bodies[i])].force.value_or(
        Vector3{kUnknown, kUnknown, kUnknown});
  });
  text.End("CellData");
  text.Begin("Points");
  text.Array("position", points.size(), [&](std::size_t i) { return points[i]; });
  text.End("Points");
  text.Cells("Polys", triangles.size(), [&](std::size_t i) { return triangles[i]; });
  return std::move(text).Finish();
}

// "particles.pvd", "walls_000012.vtp": what a writer writes, and nothing else.
bool IsSnapshotFile(std::string_view name) {
  for (const std::string_view series : {kParticles, kWalls}) {
    if (!name.starts_with(series)) continue;
    std::string_view rest = name.substr(series.size());
    if (rest == ".pvd") return true;
    if (!rest.starts_with('_') || !rest.ends_with(".vtp")) return false;
    rest = rest.substr(1, rest.size() - 5);
    return !rest.empty() && rest.find_first_not_of("0123456789") == std::string_view::npos;
  }
  return false;
}

}  // namespace

SnapshotSurface PlaneSurface(const PlaneWall& wall, const Domain& domain) {
  const auto axis = static_cast<std::size_t>(wall.axis);
  const std::size_t u = (axis + 1) % 3;
  const std::size_t v = (axis + 2) % 3;
  SnapshotSurface surface{.name = wall.name, .vertices = std::vector<Vector3>(4)};
  for (std::size_t corner = 0; corner < 4; ++corner) {
    Vector3& vertex = surface.vertices[corner];
    vertex[axis] = wall.position;
    vertex[u] = (corner == 1 || corner == 2 ? domain.upper : domain.lower)[u];
    vertex[v] = (corner >= 2 ? domain.upper : domain.lower)[v];
  }
  if (wall.facing_positive) {
    surface.triangles = {{0, 1, 2}, {0, 2, 3}};
  } else {
    surface.triangles = {{0, 2, 1}, {0, 3, 2}};
  }
  return surface;
}

SnapshotWriter::SnapshotWriter(fs::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) {
    throw InputError(fmt::format("cannot make the folder: {}", error.message()),
                     {.location = {folder_.string()}});
  }
  std::vector<fs::path> old;
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end;
       entry.increment(error)) {
    if (IsSnapshotFile(entry->path().filename().string())) old.push_back(entry->path());
  }
  for (const fs::path& file : old) {
    if (!error) fs::remove(file, error);
  }
  if (error) {
    throw InputError(fmt::format("cannot remove earlier snapshots: {}", error.message()),
                     {.location = {folder_.string()}});
  }
}

void SnapshotWriter::Write(double time, std::span<const Sphere> spheres,
                           std::span<const SnapshotSurface> surfaces) {
  ++count_;
  Add(kParticles, time, ParticleText(time, spheres), particle_entries_);
  if (!surfaces.empty()) Add(kWalls, time, WallText(time, surfaces), wall_entries_);
}

void SnapshotWriter::Add(std::string_view series, double time, std::string_view text,
                         std::string& entries) {
  const std::string file = fmt::format("{}_{:06}.vtp", series, count_ - 1);
  WriteFileAtomically(folder_ / file, text);
  const std::string grown =
      entries + fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", time, file);
  WriteFileAtomically(folder_ / fmt::format("{}.pvd", series),
                      fmt::format("<?xml version=\"1.0\"?>\n"
                                  "<VTKFile type=\"Collection\" version=\"0.1\" "
                                  "byte_order=\"LittleEndian\">\n<Collection>\n{}</Collection>\n"
                                  "</VTKFile>\n",
                                  grown));
  entries = grown;
}

}  // namespace powdercal

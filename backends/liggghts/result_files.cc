#include "backends/liggghts/result_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "backends/liggghts/deck.h"
#include "backends/liggghts/stage_states.h"

namespace powdercal::liggghts {
namespace {

void ReadSpheres(std::istream& stream, Frame& frame) {
  frame.packing.reserve(frame.particle_count);
  Sphere s;
  int type = 0;
  while (frame.packing.size() < frame.particle_count &&
         stream >> s.id >> type >> s.position[0] >> s.position[1] >> s.position[2] >> s.radius >>
             s.velocity[0] >> s.velocity[1] >> s.velocity[2] >> s.spin[0] >> s.spin[1] >>
             s.spin[2]) {
    frame.packing.push_back(s);
  }
}

// Rows of `fix ave/time`, step and `columns` means, of all segments; a segment without the file has
// none.
std::vector<std::vector<double>> ReadTable(const std::filesystem::path& folder,
                                           const std::vector<double>& shifts,
                                           const std::string& tag, std::size_t columns) {
  std::vector<std::vector<double>> rows;
  for (std::size_t segment = 0; segment < shifts.size(); ++segment) {
    std::ifstream stream(folder / SeriesFile(static_cast<int>(segment), tag));
    for (std::string line; std::getline(stream, line);) {
      if (line.empty() || line[0] == '#') continue;
      std::istringstream words(line);
      std::vector<double> row;
      for (double value = 0; words >> value;) row.push_back(value);
      if (row.size() != columns + 1) continue;
      row[0] += shifts[segment];
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

}  // namespace

std::vector<Record> ReadRecords(const std::string& screen) {
  std::vector<Record> records;
  std::istringstream lines(screen);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("PC ")) continue;  // print echoes the command with its quotes first
    std::istringstream words(line.substr(3));
    Record record;
    words >> record.kind;
    for (std::string word; words >> word;) {
      const std::size_t equals = word.find('=');
      if (equals == std::string::npos) continue;
      double value = 0;
      const char* begin = word.data() + equals + 1;
      const auto [end, error] = std::from_chars(begin, word.data() + word.size(), value);
      if (error == std::errc()) record.values[word.substr(0, equals)] = value;
    }
    records.push_back(std::move(record));
  }
  return records;
}

double Value(const Record& record, const std::string& key) {
  const auto found = record.values.find(key);
  if (found == record.values.end()) {
    throw std::runtime_error(fmt::format("record {} lacks '{}'", record.kind, key));
  }
  return found->second;
}

const Record* EndOf(const std::vector<Record>& records, std::size_t stage) {
  const auto found = std::find_if(records.begin(), records.end(), [&](const Record& record) {
    return record.kind == "END" && Value(record, "stage") == static_cast<double>(stage);
  });
  return found == records.end() ? nullptr : &*found;
}

std::vector<double> ShiftsOf(const std::vector<Record>& records) {
  std::vector<double> shifts = {0};
  for (const Record& record : records) {
    if (record.kind == "RESTORE") shifts.push_back(Value(record, "shift"));
  }
  return shifts;
}

std::vector<Frame> ReadDump(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(fmt::format("no file {}", file.filename().string()));
  std::vector<Frame> frames;
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("ITEM: TIMESTEP")) {
      stream >> frames.emplace_back().step;
    } else if (line.starts_with("ITEM: NUMBER OF ATOMS") && !frames.empty()) {
      stream >> frames.back().particle_count;
    } else if (line.starts_with("ITEM: ATOMS") && !frames.empty()) {
      ReadSpheres(stream, frames.back());
    }
  }
  const bool whole =
      !frames.empty() && std::all_of(frames.begin(), frames.end(), [](const Frame& f) {
        return f.particle_count > 0 && f.packing.size() == f.particle_count;
      });
  if (!whole) throw std::runtime_error(fmt::format("{} is damaged", file.filename().string()));
  return frames;
}

std::vector<WallSeries> ReadForces(const Program& program, const std::filesystem::path& folder,
                                   const std::vector<double>& shifts) {
  std::vector<WallSeries> all;
  const auto read = [&](const std::string& body, const std::string& tag, bool height) {
    WallSeries series{.wall = body};
    for (const std::vector<double>& row : ReadTable(folder, shifts, tag, height ? 4 : 3)) {
      series.time.push_back(row[0] * program.time_step);
      series.force.push_back({row[1], row[2], row[3]});
      series.normal_force.push_back(row[3]);
      if (height) series.height.push_back(row[4]);
    }
    all.push_back(std::move(series));
  };
  const Servo* servo = FirstServo(program);
  if (servo != nullptr) read(servo->wall, "lid", true);
  for (std::size_t i = 0; i < program.meshes.size(); ++i) {
    const std::string& name = program.meshes[i].name;
    if (servo == nullptr || servo->wall != name) read(name, fmt::format("mesh_{}", i), false);
  }
  for (std::size_t i = 0; i < program.groups.size(); ++i) {
    read(program.groups[i].name, fmt::format("group_{}", i), false);
  }
  return all;
}

// Columns xx yy zz xy xz yz of LIGGGHTS' stress times volume, tensile, with the motion in the frame
// at rest; then mass and momentum.
SlabSeries ReadSlab(const Program& program, const std::filesystem::path& folder,
                    const std::vector<double>& shifts) {
  SlabSeries slab;
  if (!program.stress_slab) return slab;
  const auto [bottom, top] = *program.stress_slab;
  const double volume = (top - bottom) * program.domain.BaseArea();
  constexpr std::size_t kColumn[3][3] = {{1, 4, 5}, {4, 2, 6}, {5, 6, 3}};
  for (const std::vector<double>& row : ReadTable(folder, shifts, "slab", 10)) {
    const double mass = row[7];
    std::array<Vector3, 3> stress{};
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) {
        const double common = mass > 0 ? row[8 + a] * row[8 + b] / mass : 0;
        stress[a][b] = -(row[kColumn[a][b]] + common) / volume;
      }
    }
    slab.time.push_back(row[0] * program.time_step);
    slab.solid_fraction.push_back(mass / (program.materials.density * volume));
    slab.stress.push_back(stress);
  }
  return slab;
}

}  // namespace powdercal::liggghts

#include "backends/liggghts/result.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "backends/liggghts/deck.h"
#include "core/errors.h"
#include "core/files.h"

namespace powdercal::liggghts {
namespace {

constexpr double kStressTolerance = 0.05;
constexpr double kFast = 1.0;              // [m/s]
constexpr double kUnstableRayleigh = 0.4;  // of the Rayleigh time

std::string ReadIfThere(const std::filesystem::path& path) {
  try {
    return ReadFile(path);
  } catch (const InputError&) {
    return "";
  }
}

const Record* Last(const std::vector<Record>& records, const std::string& kind) {
  const auto found = std::find_if(records.rbegin(), records.rend(),
                                  [&](const Record& record) { return record.kind == kind; });
  return found == records.rend() ? nullptr : &*found;
}

double Value(const Record& record, const std::string& key) {
  const auto found = record.values.find(key);
  if (found == record.values.end()) {
    throw std::runtime_error(fmt::format("record {} lacks '{}'", record.kind, key));
  }
  return found->second;
}

// The first line that LIGGGHTS marks as an error, made printable.
std::string ErrorLine(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.find("ERROR") == std::string::npos) continue;
    std::erase_if(line, [](unsigned char c) { return c < 32 || c > 126; });
    return line;
  }
  return "";
}

double SmallestRadius(const Program& program) { return program.particles.sizes.Quantile(0) / 2; }

Outcome LostAtoms(const Program& program, const std::vector<Record>& records, int particle_count) {
  const Materials& m = program.materials;
  const double fraction = program.time_step / RayleighTime(SmallestRadius(program), m.density,
                                                           m.young_modulus, m.poisson_ratio);
  std::string seen = fmt::format(
      "LIGGGHTS lost particles; time step {:.3g} s is {:.2f} of the Rayleigh time of the smallest "
      "particle",
      program.time_step, fraction);
  double speed = 0;
  if (!records.empty() && records.back().values.contains("ke")) {
    const double mass =
        particle_count * m.density * std::numbers::pi / 6 * program.particles.sizes.Moment(3);
    speed = std::sqrt(2 * records.back().values.at("ke") / mass);
    seen += fmt::format("; speed at the last check {:.3g} m/s", speed);
  }
  const bool unstable = fraction > kUnstableRayleigh || speed > kFast;
  return {unstable ? Reason::unstable : Reason::lost_particles, seen};
}

// Failures that show before the result is looked at.
Outcome ProcessOutcome(const Program& program, int particle_count, const ProcessResult& process,
                       const std::string& screen, const std::vector<Record>& records) {
  if (process.end == ProcessResult::End::cancelled)
    return {Reason::cancelled, "stopped on request"};
  if (process.end == ProcessResult::End::time_limit) {
    const Record* last = records.empty() ? nullptr : &records.back();
    return {Reason::timeout, fmt::format("LIGGGHTS {}; last record: {}", process.Describe(),
                                         last != nullptr ? last->kind : "none")};
  }
  if (screen.find("Lost atoms") != std::string::npos ||
      process.output.find("Lost atoms") != std::string::npos) {
    return LostAtoms(program, records, particle_count);
  }
  const std::string error = ErrorLine(screen + "\n" + process.output);
  if (!process.succeeded() || !error.empty()) {
    const bool started = Last(records, "START") != nullptr;
    const bool refused = process.end == ProcessResult::End::exited && !started;
    return {refused ? Reason::invalid_input : Reason::crashed,
            fmt::format("LIGGGHTS {}{}{}", process.Describe(), error.empty() ? "" : ": ", error)};
  }
  if (Last(records, "RESULT") == nullptr) {
    return {Reason::crashed, "LIGGGHTS ended without leaving a result"};
  }
  return {};
}

Outcome ResultOutcome(const Program& program, const Record& result, int particle_count) {
  const int lost = particle_count - static_cast<int>(Value(result, "n"));
  if (lost != 0) {
    return {Reason::lost_particles, fmt::format("{} of {} particles lost", lost, particle_count)};
  }
  const Servo& servo = std::get<Servo>(program.stages[2]);
  const double stress = std::abs(Value(result, "p"));
  if (std::abs(stress / servo.stress - 1) > kStressTolerance) {
    return {Reason::not_quasi_static,
            fmt::format("the wall bears {:.4g} Pa instead of {:.4g} Pa", stress, servo.stress)};
  }
  if (Value(result, "rest") == 0) {
    const Hold& hold = std::get<Hold>(program.stages[3]);
    return {Reason::not_quasi_static,
            fmt::format("the bed still moves after {:.3g} s under load: stress {:.4g} Pa, relative "
                        "change of height {:.2g} in {:.2g} s, kinetic to elastic energy {:.2g}",
                        hold.max_duration, stress, Value(result, "change"), hold.window,
                        Value(result, "quiet"))};
  }
  return {};
}

WallSeries ReadSeries(const std::filesystem::path& file, const Program& program) {
  const double area = program.domain.BaseArea();
  WallSeries series{.wall = std::get<Servo>(program.stages[2]).wall};
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line[0] == '#') continue;
    double step = 0;
    double stress = 0;
    double height = 0;
    if (!(std::istringstream(line) >> step >> stress >> height)) continue;
    if (height == 0) continue;  // a window that began before the wall was there
    series.time.push_back(step * program.time_step);
    series.height.push_back(height);
    series.normal_force.push_back(-stress * area);
  }
  return series;
}

void ReadMoments(const Program& program, const std::filesystem::path& folder,
                 const std::vector<Record>& records, Trace& trace) {
  for (const char* name : {"settle", "hold"}) {
    Moment moment{.name = name, .packing = ReadDump(folder / DumpFile(name))};
    const Record* record = Last(records, std::string(name) == "hold" ? "RESULT" : "SETTLE");
    moment.time = Value(*record, "step") * program.time_step;
    for (const PlaneWall& wall : program.walls) moment.walls[wall.name].height = wall.position;
    const Servo& servo = std::get<Servo>(program.stages[2]);
    if (record->kind == "RESULT") {
      WallState& state = moment.walls[servo.wall];
      state.height = Value(*record, "h");
      state.force[2] = -Value(*record, "p") * program.domain.BaseArea();
      state.velocity = Value(*record, "velocity");
    } else {
      moment.walls.erase(servo.wall);
    }
    trace.moments.push_back(std::move(moment));
  }
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

Packing ReadDump(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(fmt::format("no file {}", file.filename().string()));
  std::string line;
  std::size_t count = 0;
  while (std::getline(stream, line) && !line.starts_with("ITEM: ATOMS")) {
    if (line.starts_with("ITEM: NUMBER OF ATOMS")) stream >> count;
  }
  Packing packing;
  packing.reserve(count);
  Sphere s;
  int type = 0;
  while (stream >> s.id >> type >> s.position[0] >> s.position[1] >> s.position[2] >> s.radius >>
         s.velocity[0] >> s.velocity[1] >> s.velocity[2] >> s.spin[0] >> s.spin[1] >> s.spin[2]) {
    packing.push_back(s);
  }
  if (packing.empty() || packing.size() != count) {
    throw std::runtime_error(fmt::format("{} holds {} of {} particles", file.filename().string(),
                                         packing.size(), count));
  }
  return packing;
}

Trace ReadTrace(const Program& program, int particle_count, const std::filesystem::path& folder,
                const ProcessResult& process) {
  Trace trace;
  const std::string screen = ReadIfThere(folder / kScreenFile);
  const std::vector<Record> records = ReadRecords(screen);
  trace.diagnostics.time_step = program.time_step;
  trace.diagnostics.wall_seconds = process.wall_seconds;
  trace.diagnostics.law = PairStyle(program.law);
  if (!records.empty() && records.back().values.contains("step")) {
    trace.diagnostics.steps = static_cast<std::int64_t>(records.back().values.at("step"));
  }
  trace.outcome = ProcessOutcome(program, particle_count, process, screen, records);
  if (!trace.outcome.ok()) return trace;
  try {
    const Record& result = *Last(records, "RESULT");
    trace.diagnostics.lost_particles = particle_count - static_cast<int>(Value(result, "n"));
    trace.diagnostics.kinetic_energy = Value(result, "ke");
    trace.diagnostics.kinetic_energy_ratio = Value(result, "quiet");
    trace.series.push_back(ReadSeries(folder / kSeriesFile, program));
    ReadMoments(program, folder, records, trace);
    trace.outcome = ResultOutcome(program, result, particle_count);
  } catch (const std::exception& error) {
    trace.outcome = {Reason::crashed, fmt::format("the result cannot be read: {}", error.what())};
  }
  return trace;
}

}  // namespace powdercal::liggghts

#include "backends/liggghts/result.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "backends/liggghts/deck.h"
#include "backends/liggghts/deck_model.h"
#include "backends/particle_summary.h"
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

Outcome LostAtoms(const Program& program, const std::vector<Record>& records) {
  const Materials& m = program.materials;
  const ParticleSummary particles = Summarise(program.particles);
  std::string seen = "LIGGGHTS lost particles";
  bool unstable = false;
  if (program.law.normal == ContactLaw::Normal::hertz) {
    const double fraction =
        program.time_step /
        RayleighTime(particles.smallest_diameter / 2, m.density, m.young_modulus, m.poisson_ratio);
    seen +=
        fmt::format("; time step {:.3g} s is {:.2f} of the Rayleigh time of the smallest particle",
                    program.time_step, fraction);
    unstable = fraction > kUnstableRayleigh;
  }
  if (!records.empty() && records.back().values.contains("ke")) {
    const double speed = std::sqrt(2 * records.back().values.at("ke") / particles.Mass(m.density));
    seen += fmt::format("; speed at the last check {:.3g} m/s", speed);
    unstable = unstable || speed > kFast;
  }
  return {unstable ? Reason::unstable : Reason::lost_particles, seen};
}

// The record END of a stage; null if the run did not come that far.
const Record* EndOf(const std::vector<Record>& records, std::size_t stage) {
  const auto found = std::find_if(records.begin(), records.end(), [&](const Record& record) {
    return record.kind == "END" && Value(record, "stage") == static_cast<double>(stage);
  });
  return found == records.end() ? nullptr : &*found;
}

// Failures that show before the result is looked at.
Outcome ProcessOutcome(const Program& program, const ProcessResult& process,
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
    return LostAtoms(program, records);
  }
  const std::string error = ErrorLine(screen + "\n" + process.output);
  if (!process.succeeded() || !error.empty()) {
    const bool started = Last(records, "START") != nullptr;
    const bool refused = process.end == ProcessResult::End::exited && !started;
    return {refused ? Reason::invalid_input : Reason::crashed,
            fmt::format("LIGGGHTS {}{}{}", process.Describe(), error.empty() ? "" : ": ", error)};
  }
  if (EndOf(records, program.stages.size() - 1) == nullptr) {
    return {Reason::crashed, "LIGGGHTS ended without leaving a result"};
  }
  return {};
}

const Servo* FindServo(const Program& program) {
  for (const Stage& stage : program.stages) {
    if (const auto* servo = std::get_if<Servo>(&stage)) return servo;
  }
  return nullptr;
}

Outcome HoldOutcome(const Hold& hold, const Servo& servo, const Record& end) {
  const double stress = std::abs(Value(end, "p"));
  if (std::abs(stress / servo.stress - 1) > kStressTolerance) {
    return {Reason::not_quasi_static,
            fmt::format("the wall bears {:.4g} Pa instead of {:.4g} Pa", stress, servo.stress)};
  }
  if (Value(end, "rest") == 0) {
    return {Reason::not_quasi_static,
            fmt::format("the bed still moves after {:.3g} s under load: stress {:.4g} Pa, relative "
                        "change of height {:.2g} in {:.2g} s, kinetic to elastic energy {:.2g}",
                        hold.max_duration, stress, Value(end, "change"), hold.window,
                        Value(end, "quiet"))};
  }
  return {};
}

Outcome ResultOutcome(const Program& program, const std::vector<Record>& records,
                      int particle_count) {
  const Record& last = *EndOf(records, program.stages.size() - 1);
  const int lost = particle_count - static_cast<int>(Value(last, "n"));
  if (lost != 0) {
    return {Reason::lost_particles, fmt::format("{} of {} particles lost", lost, particle_count)};
  }
  for (std::size_t i = 0; i < program.stages.size(); ++i) {
    const auto* hold = std::get_if<Hold>(&program.stages[i]);
    if (hold == nullptr) continue;
    const Outcome outcome = HoldOutcome(*hold, *FindServo(program), *EndOf(records, i));
    if (!outcome.ok()) return outcome;
  }
  return {};
}

WallSeries ReadSeries(const std::filesystem::path& file, const Program& program,
                      const Servo& servo) {
  const double area = program.domain.BaseArea();
  WallSeries series{.wall = servo.wall};
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

// The servo's wall at the end of a stage: means over the last window of Hold, else of the series.
WallState ServoState(const Program& program, const Record& end, const WallSeries& series) {
  WallState state{.height = Value(end, "h"), .displacement = {0, 0, Value(end, "rise")}};
  if (end.values.contains("p")) {
    state.force[2] = -Value(end, "p") * program.domain.BaseArea();
    state.velocity = Value(end, "velocity");
    return state;
  }
  const double now = (Value(end, "step") + 0.5) * program.time_step;
  const auto next = std::upper_bound(series.time.begin(), series.time.end(), now);
  const auto count = static_cast<std::size_t>(next - series.time.begin());
  if (count > 0) state.force[2] = series.normal_force[count - 1];
  if (count > 1) {
    state.velocity = (series.height[count - 1] - series.height[count - 2]) /
                     (series.time[count - 1] - series.time[count - 2]);
  }
  return state;
}

// Into the domain along its periodic axes: LIGGGHTS wraps particles only when it sorts them.
void Wrap(const Domain& domain, Packing& packing) {
  const Vector3 lengths = domain.Lengths();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (domain.boundaries[axis] != Boundary::periodic) continue;
    for (Sphere& sphere : packing) {
      double& x = sphere.position[axis];
      if (x < domain.lower[axis]) x += lengths[axis];
      if (x >= domain.upper[axis]) x -= lengths[axis];
    }
  }
}

class MomentReader {
 public:
  MomentReader(const Program& program, const std::filesystem::path& folder, Trace& trace)
      : program_(program), folder_(folder), trace_(trace) {
    for (const PlaneWall& wall : program.walls) planes_[wall.name].height = wall.position;
    // The servo's wall is nowhere until the servo begins.
    if (const Servo* servo = FindServo(program)) planes_.erase(servo->wall);
  }

  void Read(std::size_t stage, const Record& end) {
    const Stage& what = program_.stages[stage];
    const double end_step = Value(end, "step");
    const auto* advance = std::get_if<Advance>(&what);
    if (advance != nullptr && advance->packing_every > 0) {
      for (Frame& frame : ReadDump(folder_ / FramesFile(program_, stage))) {
        if (static_cast<double>(frame.step) < end_step) Append(what, std::move(frame));
      }
    }
    std::vector<Frame> frames = ReadDump(folder_ / DumpFile(program_, stage));
    if (frames.size() != 1) throw std::runtime_error("a dump holds more than one packing");
    Append(what, std::move(frames.front()));
    const Servo* servo = FindServo(program_);
    if (end.values.contains("h")) {
      trace_.moments.back().walls[servo->wall] = ServoState(program_, end, trace_.series.front());
    }
  }

 private:
  void Append(const Stage& stage, Frame frame) {
    Wrap(program_.domain, frame.packing);
    trace_.moments.push_back({.name = MomentName(stage),
                              .time = static_cast<double>(frame.step) * program_.time_step,
                              .packing = std::move(frame.packing),
                              .walls = planes_});
  }

  const Program& program_;
  const std::filesystem::path& folder_;
  Trace& trace_;
  std::map<std::string, WallState> planes_;
};

void ReadMoments(const Program& program, const std::filesystem::path& folder,
                 const std::vector<Record>& records, Trace& trace) {
  if (const Servo* servo = FindServo(program)) {
    trace.series.push_back(ReadSeries(folder / kSeriesFile, program, *servo));
  }
  MomentReader reader(program, folder, trace);
  for (std::size_t i = 0; i < program.stages.size(); ++i) {
    if (std::holds_alternative<Insert>(program.stages[i])) continue;
    const Record* end = EndOf(records, i);
    if (end == nullptr) throw std::runtime_error(fmt::format("stage {} did not end", i));
    reader.Read(i, *end);
  }
}

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
  trace.outcome = ProcessOutcome(program, process, screen, records);
  if (!trace.outcome.ok()) return trace;
  try {
    const Record& end = *EndOf(records, program.stages.size() - 1);
    trace.diagnostics.lost_particles = particle_count - static_cast<int>(Value(end, "n"));
    trace.diagnostics.kinetic_energy = Value(end, "ke");
    if (end.values.contains("quiet")) trace.diagnostics.kinetic_energy_ratio = Value(end, "quiet");
    ReadMoments(program, folder, records, trace);
    trace.outcome = ResultOutcome(program, records, particle_count);
  } catch (const std::exception& error) {
    trace.outcome = {Reason::crashed, fmt::format("the result cannot be read: {}", error.what())};
  }
  return trace;
}

}  // namespace powdercal::liggghts

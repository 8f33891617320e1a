#include "backends/yade/result.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "backends/yade/unsupported.h"
#include "core/errors.h"

namespace powdercal::yade {
namespace {

using nlohmann::json;

Vector3 ToVector(const json& value) {
  return {value.at(0).get<double>(), value.at(1).get<double>(), value.at(2).get<double>()};
}

std::array<Vector3, 3> ToMatrix(const json& value) {
  return {ToVector(value.at(0)), ToVector(value.at(1)), ToVector(value.at(2))};
}

Sphere ToSphere(const json& row) {
  const auto at = [&](std::size_t i) { return row.at(i).get<double>(); };
  return {row.at(0).get<std::int64_t>(),
          at(1),
          {at(2), at(3), at(4)},
          {at(5), at(6), at(7)},
          {at(8), at(9), at(10)}};
}

class Reader {
 public:
  Reader(const Program& program, Trace& trace) : program_(program), trace_(trace) {}

  void Read(const json& record) {
    const std::string kind = record.at("record");
    if (kind == "stage") stage_ = record.at("index");
    if (kind == "stage" || kind == "alive") trace_.diagnostics.steps = record.at("step");
    if (kind == "moment") ReadMoment(record);
    if (kind == "series") ReadSeries(record);
    if (kind == "cell") ReadCell(record);
    if (kind == "end") ReadEnd(record);
  }

  bool ended() const { return ended_; }

  /// "before the first stage", "in stage 2 (servo), step 1200".
  std::string Where() const {
    if (stage_ < 0) return "before the first stage";
    const auto stage = static_cast<std::size_t>(stage_);
    if (stage >= program_.stages.size()) return "";
    return fmt::format("in stage {} ({}), after step {}", stage, StageName(program_.stages[stage]),
                       trace_.diagnostics.steps);
  }
  bool started() const { return stage_ >= 0; }

 private:
  void ReadMoment(const json& record) {
    Moment moment{.name = record.at("name"), .time = record.at("time")};
    for (const json& row : record.at("packing")) moment.packing.push_back(ToSphere(row));
    for (const auto& [name, wall] : record.at("walls").items()) {
      moment.walls[name] = {.height = wall.at("height"),
                            .displacement = ToVector(wall.at("displacement")),
                            .force = ToVector(wall.at("force")),
                            .velocity = wall.at("velocity")};
    }
    if (const json& cell = record.at("cell"); !cell.is_null()) {
      moment.cell = {.lower = ToVector(cell.at("lower")),
                     .upper = ToVector(cell.at("upper")),
                     .shear_offset = cell.at("shear_offset"),
                     .shear_rate = cell.at("shear_rate"),
                     .stress = ToMatrix(cell.at("stress"))};
    }
    trace_.moments.push_back(std::move(moment));
  }

  void ReadSeries(const json& record) {
    WallSeries series{
        .wall = record.at("wall"), .time = record.at("time"), .height = record.at("height")};
    for (const json& force : record.at("force")) {
      series.force.push_back(ToVector(force));
      series.normal_force.push_back(series.force.back()[2]);
    }
    trace_.series.push_back(std::move(series));
  }

  void ReadCell(const json& record) {
    trace_.cell.time = record.at("time").get<std::vector<double>>();
    trace_.cell.strain = record.at("strain").get<std::vector<double>>();
    for (const json& lengths : record.at("lengths")) {
      trace_.cell.lengths.push_back(ToVector(lengths));
    }
    for (const json& stress : record.at("stress")) {
      trace_.cell.stress.push_back(ToMatrix(stress));
    }
  }

  void ReadEnd(const json& record) {
    const std::string name = record.at("reason");
    const std::span<const std::string> names = ReasonNames();
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) throw std::runtime_error("unknown reason " + name);
    trace_.outcome = {static_cast<Reason>(found - names.begin()), record.at("message")};
    Diagnostics& d = trace_.diagnostics;
    d.steps = record.value("steps", d.steps);
    d.leavers = record.value("leavers", 0);
    d.lost_particles = record.value("lost_particles", 0);
    d.kinetic_energy = record.value("kinetic_energy", 0.0);
    d.kinetic_energy_ratio = record.value("kinetic_energy_ratio", 0.0);
    d.max_overlap = record.value("max_overlap", 0.0);
    for (const char* figure : {"contacts", "elastic_energy", "cell_flips", "rolling_stiffness"}) {
      if (record.contains(figure)) d.figures[figure] = record.at(figure).get<double>();
    }
    ended_ = true;
  }

  const Program& program_;
  Trace& trace_;
  int stage_ = -1;
  bool ended_ = false;
};

// The last lines that the driver or YADE wrote before they died: Python's has the reason.
std::string LastLine(const std::string& output) {
  std::size_t end = output.find_last_not_of(" \n\r\t");
  if (end == std::string::npos) return "";
  const std::size_t begin = output.rfind('\n', end);
  const std::size_t first = begin == std::string::npos ? 0 : begin + 1;
  return output.substr(first, end + 1 - first);
}

Outcome WithoutEnd(const Reader& reader, const ProcessResult& process) {
  const std::string where = reader.Where();
  if (process.end == ProcessResult::End::cancelled) {
    return {Reason::cancelled, "stopped on request"};
  }
  if (process.end == ProcessResult::End::time_limit) {
    return {Reason::timeout, fmt::format("YADE {}, {}", process.Describe(), where)};
  }
  if (process.succeeded()) {
    return {Reason::crashed, fmt::format("YADE ended without leaving a result, {}", where)};
  }
  const std::string line = LastLine(process.output);
  return {Reason::crashed, fmt::format("YADE {}, {}{}{}", process.Describe(), where,
                                       line.empty() ? "" : ": ", line)};
}

}  // namespace

Trace ReadTrace(const Program& program, const std::filesystem::path& result,
                const ProcessResult& process) {
  Trace trace;
  trace.diagnostics.time_step = program.time_step;
  trace.diagnostics.wall_seconds = process.wall_seconds;
  trace.diagnostics.law = DescribeLaw(program);
  Reader reader(program, trace);
  std::ifstream stream(result);
  std::string problem;
  for (std::string line; std::getline(stream, line);) {
    if (stream.eof()) break;  // a record is whole with its end of line
    try {
      reader.Read(json::parse(line));
    } catch (const std::exception& error) {
      problem = error.what();
      break;
    }
  }
  if (!reader.ended() || !process.succeeded()) trace.outcome = WithoutEnd(reader, process);
  if (!problem.empty() && process.succeeded()) {
    trace.outcome = {Reason::crashed, "the result cannot be read: " + problem};
  }
  const double wall = trace.diagnostics.wall_seconds;
  if (wall > 0 && !trace.moments.empty()) {
    const auto count = static_cast<double>(trace.moments.front().packing.size());
    trace.diagnostics.figures["particle_steps_per_second"] =
        count * static_cast<double>(trace.diagnostics.steps) / wall;
  }
  return trace;
}

}  // namespace powdercal::yade

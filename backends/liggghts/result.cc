#include "backends/liggghts/result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "backends/liggghts/deck.h"
#include "backends/liggghts/deck_model.h"
#include "backends/liggghts/result_files.h"
#include "backends/liggghts/result_moments.h"
#include "backends/liggghts/stage_states.h"
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
  for (const char* sign : {"Lost atoms", "too large for neighbor bins", "Too many neighbor bins"}) {
    if (screen.find(sign) != std::string::npos || process.output.find(sign) != std::string::npos) {
      return LostAtoms(program, records);
    }
  }
  const std::string error = ErrorLine(screen + "\n" + process.output);
  if (!process.succeeded() || !error.empty()) {
    const bool started = Last(records, "START") != nullptr;
    const bool refused = process.end == ProcessResult::End::exited && !started;
    return {refused ? Reason::invalid_input : Reason::crashed,
            fmt::format("LIGGGHTS {}{}{}", process.Describe(), error.empty() ? "" : ": ", error)};
  }
  if (EndOf(records, *LastMoment(program)) == nullptr) {
    return {Reason::crashed, "LIGGGHTS ended without leaving a result"};
  }
  return {};
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

// `gone`: particles that the last packing lacks; `beyond`: seen beyond an open side.
Outcome ParticleOutcome(const Program& program, const std::vector<Record>& records, int gone,
                        int beyond) {
  if (!HasOutflow(program)) {
    if (gone == 0) return {};
    return {Reason::lost_particles, fmt::format("{} particles lost", gone)};
  }
  Outcome outcome = LostAtoms(program, records);
  if (beyond > 0) return outcome;
  // A simulation that blows up may well throw its particles through the outflow sides.
  if (gone > 0 && outcome.reason == Reason::unstable) return outcome;
  return {};
}

Outcome HoldOutcomes(const Program& program, const std::vector<Record>& records) {
  const std::vector<StageState> states =
      StatesOf(program, std::vector<double>(program.stages.size()));
  for (std::size_t i = 0; i < program.stages.size(); ++i) {
    const auto* hold = std::get_if<Hold>(&program.stages[i]);
    if (hold == nullptr) continue;
    Outcome outcome = HoldOutcome(*hold, *states[i].servo, *EndOf(records, i));
    if (!outcome.ok()) return outcome;
  }
  return {};
}

}  // namespace

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
    const Record& end = *EndOf(records, *LastMoment(program));
    trace.diagnostics.kinetic_energy = Value(end, "ke");
    if (end.values.contains("quiet")) trace.diagnostics.kinetic_energy_ratio = Value(end, "quiet");
    const int beyond = ReadMoments(program, folder, records, trace);
    const int gone = particle_count - static_cast<int>(trace.moments.back().packing.size());
    trace.diagnostics.lost_particles = HasOutflow(program) ? beyond : gone;
    trace.diagnostics.leavers = HasOutflow(program) ? gone : 0;
    trace.outcome = ParticleOutcome(program, records, gone, beyond);
    if (trace.outcome.ok()) trace.outcome = HoldOutcomes(program, records);
  } catch (const std::exception& error) {
    trace.outcome = {Reason::crashed, fmt::format("the result cannot be read: {}", error.what())};
  }
  return trace;
}

}  // namespace powdercal::liggghts

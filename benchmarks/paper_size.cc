// The paper's consolidation at the paper's own size, in pieces: the program works for a while,
// leaves its whole state in a file, and goes on from there the next time. Readings stand at fixed
// steps, so that they do not depend on where it was cut. See docs/validation/paper_causes.md.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "backends/embedded/simulation.h"
#include "backends/embedded/stages.h"
#include "backends/insertion.h"
#include "benchmarks/paper_bed.h"
#include "benchmarks/run_program.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/quantity.h"

namespace {

using namespace powdercal;
using namespace powdercal::benchmarks;
using embedded::Simulation;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr double kPaperWidth = 2e-3;       // [m]
constexpr double kPaperHeight = 5e-3;      // [m]
constexpr double kPaperParticles = 5e5;    // on kPaperWidth squared
constexpr double kDensestPlaced = 0.33;    // solid fraction that can be placed
constexpr std::int64_t kPiece = 100;       // steps between two looks at the clock
constexpr std::int64_t kReadEvery = 2000;  // steps

struct Options {
  int particles = 500'000;
  std::string state;
  std::string work_for = "20 min";
  std::string save_every = "10 min";
  double cohesion = 47'500;
  double rolling = 0.5;
  std::string sizes = "equal";
  double time_step = 1e-6;
  double hold = 0.03;
  double drop = 0;
  std::uint64_t seed = 1;
  int threads = 2;
  bool as_json = false;
};

BedSetup SetupOf(const Options& options) {
  BedSetup setup{.time_step = options.time_step, .particles = options.particles};
  setup.sizes = options.sizes == "equal"    ? BedSetup::Sizes::equal
                : options.sizes == "narrow" ? BedSetup::Sizes::narrow
                                            : BedSetup::Sizes::wide;
  setup.hold = options.hold;
  setup.drop = options.drop;
  const double width = kPaperWidth * std::sqrt(options.particles / kPaperParticles);
  setup.width = width / setup.diameter;
  // From the floor to the top of the paper's cell, or as low as particles can be placed.
  const Program trial = MakeBed(setup, options.cohesion, options.rolling, options.seed);
  const double solid = options.particles * std::numbers::pi / 6 * trial.particles.sizes.Moment(3);
  setup.solid_fraction = std::min(kDensestPlaced, solid / (width * width * kPaperHeight));
  return setup;
}

// Where a run is. The file holds this as a line of JSON, then the simulation's state.
struct Progress {
  std::string phase = "settle";  // then "load", "hold", "done", or "failed"
  std::string failure;
  std::int64_t phase_steps = 0;
  std::int64_t window_steps = 0;  // of the lid's force below
  double window_force = 0;        // [N]
  double settled = 0;             // [s] simulated, end of settling
  double seconds = 0;             // wall clock of all pieces
  json readings = json::array();

  json ToJson() const {
    return {{"phase", phase},
            {"failure", failure},
            {"phase_steps", phase_steps},
            {"window_steps", window_steps},
            {"window_force", window_force},
            {"settled", settled},
            {"seconds", seconds},
            {"readings", readings}};
  }
  static Progress FromJson(const json& j) {
    return {.phase = j.at("phase"),
            .failure = j.at("failure"),
            .phase_steps = j.at("phase_steps"),
            .window_steps = j.at("window_steps"),
            .window_force = j.at("window_force"),
            .settled = j.at("settled"),
            .seconds = j.at("seconds"),
            .readings = j.at("readings")};
  }
};

class PaperSize {
 public:
  explicit PaperSize(const Options& options)
      : options_(options),
        setup_(SetupOf(options)),
        program_(MakeBed(setup_, options.cohesion, options.rolling, options.seed)),
        simulation_(program_, FirstPacking(),
                    {.isa = embedded::BestIsa(), .threads = options.threads}) {
    simulation_.planes()[1].wall.position = HUGE_VAL;
    if (!options.state.empty() && std::filesystem::exists(options.state)) Load();
    simulation_.after_step = [this] {
      progress_.window_force += simulation_.planes()[1].force[2];
      ++progress_.window_steps;
    };
  }

  // Until the time is up or there is nothing more to do.
  void Work() {
    const auto limit = std::chrono::duration<double>(ParseQuantity(options_.work_for, "s"));
    const auto save_every = std::chrono::duration<double>(ParseQuantity(options_.save_every, "s"));
    const Clock::time_point start = Clock::now();
    Clock::time_point saved = start;
    Clock::time_point last = start;
    bool worked = false;
    while (progress_.phase != "done" && progress_.phase != "failed" &&
           Clock::now() - start < limit) {
      Piece();
      worked = true;
      const Clock::time_point now = Clock::now();
      progress_.seconds += std::chrono::duration<double>(now - last).count();
      last = now;
      if (now - saved < save_every) continue;
      Save();
      saved = Clock::now();
    }
    if (worked) Save();
  }

  json Report() const {
    const double count = program_.particles.count;
    const double done = static_cast<double>(simulation_.steps()) * count;
    const double rate = progress_.seconds > 0 ? done / progress_.seconds : 0;
    const double remaining = std::max(0.0, ExpectedSteps() * count - done);
    json report = {{"particles", program_.particles.count},
                   {"time_step", program_.time_step},
                   {"k", options_.cohesion},
                   {"mu_r", options_.rolling},
                   {"sizes", options_.sizes},
                   {"phase", progress_.phase},
                   {"failure", progress_.failure},
                   {"simulated_time", simulation_.time()},
                   {"steps", simulation_.steps()},
                   {"particle_steps", done},
                   {"particle_steps_per_second", rate},
                   {"seconds", progress_.seconds},
                   {"readings", progress_.readings}};
    report["predicted_remaining_seconds"] = progress_.phase == "done" ? json(0)
                                            : rate > 0                ? json(remaining / rate)
                                                                      : json();
    return report;
  }

 private:
  Packing FirstPacking() const {
    if (!options_.state.empty() && std::filesystem::exists(options_.state)) return {};
    return PlaceParticles(program_.particles, program_.domain,
                          std::get<Insert>(program_.stages[0]));
  }

  const Settle& settle() const { return std::get<Settle>(program_.stages[1]); }
  const Servo& servo() const { return std::get<Servo>(program_.stages[2]); }

  // Settling ends soon after its least duration; the lid then closes a gap of a fifth of the bed.
  double ExpectedSteps() const {
    const double settling = progress_.settled > 0 ? progress_.settled : 1.2 * settle().min_duration;
    const double loading = 0.2 * kPaperHeight / 2 / embedded::ControlOf(program_, servo(), 0).speed;
    return (settling + loading + options_.hold) / program_.time_step;
  }

  void Load() {
    const std::string text = ReadFile(options_.state);
    const std::size_t line = text.find('\n');
    const json head = json::parse(text.substr(0, line), nullptr, false);
    if (line == std::string::npos || head.is_discarded()) {
      throw InputError("not a state of paper_size", {.location = {.file = options_.state}});
    }
    progress_ = Progress::FromJson(head);
    simulation_.LoadState(std::string_view(text).substr(line + 1));
  }

  void Save() const {
    if (options_.state.empty() || progress_.phase == "failed") return;
    WriteFileAtomically(options_.state, progress_.ToJson().dump() + "\n" + simulation_.SaveState());
  }

  void Piece() {
    if (!simulation_.Run(kPiece, {})) {
      progress_.phase = "failed";
      progress_.failure = simulation_.failure()->message;
      return;
    }
    progress_.phase_steps += kPiece;
    const bool read = simulation_.steps() % kReadEvery == 0;
    if (read && simulation_.CountLost() > 0) {
      progress_.phase = "failed";
      progress_.failure = fmt::format("{} particles lost", simulation_.CountLost());
      return;
    }
    const double time = static_cast<double>(progress_.phase_steps) * program_.time_step;
    const std::string before = progress_.phase;
    if (progress_.phase == "settle") {
      if (read && (time > settle().max_duration || AtRest(time))) Advance("load");
    } else if (progress_.phase == "load") {
      const double force = simulation_.planes()[1].force[2];
      if (force > 0.9 * servo().stress * program_.domain.BaseArea()) Advance("hold");
    } else if (time >= options_.hold) {
      Advance("done");
    }
    if (read && progress_.phase == before) AddReading(before);
  }

  bool AtRest(double time) const {
    if (time < settle().min_duration) return false;
    const double d = program_.particles.sizes.Moment(1);
    double mass = 0;
    for (std::int32_t p = 0; p < simulation_.particles().count(); ++p) {
      mass += simulation_.particles().Mass(p);
    }
    return simulation_.MakeSurvey().kinetic_energy <
           settle().kinetic_energy_ratio * mass * -program_.gravity[2] * d;
  }

  void Advance(const std::string& phase) {
    AddReading(progress_.phase + " ends");
    if (phase == "load") {
      progress_.settled = simulation_.time();
      embedded::PlaneBody& lid = simulation_.planes()[1];
      lid.wall.position = simulation_.MakeSurvey().top + 0.03 * program_.particles.sizes.Moment(1);
      lid.servo = embedded::ControlOf(program_, servo(), lid.wall.position);
      simulation_.BodiesMoved();
    }
    progress_.phase = phase;
    progress_.phase_steps = 0;
  }

  void AddReading(const std::string& moment) {
    const double stress = progress_.window_steps > 0
                              ? progress_.window_force /
                                    static_cast<double>(progress_.window_steps) /
                                    program_.domain.BaseArea()
                              : 0;
    progress_.window_force = 0;
    progress_.window_steps = 0;
    Reading reading =
        Read(program_, simulation_.CurrentPacking(), simulation_.planes()[1].wall.position, stress);
    reading.moment = moment;
    reading.time = simulation_.time();
    progress_.readings.push_back(ToJson(reading));
    fmt::print(stderr,
               "{:.4g} ms, {}: e {:.4f} central, {:.4f} wall to wall; {:.4g} Pa; {:.3g} s\n",
               1e3 * reading.time, moment, reading.central, reading.wall_to_wall, reading.stress,
               progress_.seconds);
  }

  const Options& options_;
  BedSetup setup_;
  Program program_;
  Simulation simulation_;
  Progress progress_;
};

void Print(const json& report) {
  fmt::print("{} particles, {} steps ({:.3g} ms), {:.3g} particle steps, {:.3g} a second\n",
             report["particles"].get<int>(), report["steps"].get<std::int64_t>(),
             1e3 * report["simulated_time"].get<double>(), report["particle_steps"].get<double>(),
             report["particle_steps_per_second"].get<double>());
  fmt::print("phase: {} {}\n", report["phase"].get<std::string>(),
             report["failure"].get<std::string>());
  fmt::print("predicted remaining: {} s\n", report["predicted_remaining_seconds"].dump());
  for (const json& reading : report["readings"]) {
    fmt::print("{:>10.4g} ms  {:<12} e {:.4f} (wall to wall {:.4f})  {:.4g} Pa\n",
               1e3 * reading["time"].get<double>(), reading["moment"].get<std::string>(),
               reading["central"].get<double>(), reading["wall_to_wall"].get<double>(),
               reading["stress"].get<double>());
  }
}

int RunProgram(int argc, char** argv) {
  CLI::App program{"The paper's consolidation at its own size, in pieces"};
  Options options;
  program.add_option("--particles", options.particles, "on a base in proportion")
      ->capture_default_str();
  program.add_option("--state", options.state, "file to go on from, and to leave the state in");
  program.add_option("--for", options.work_for, "time to work; '0 s' reports only")
      ->capture_default_str();
  program.add_option("--save-every", options.save_every, "wall clock")->capture_default_str();
  program.add_option("--cohesion", options.cohesion, "k [J/m3]")->capture_default_str();
  program.add_option("--rolling", options.rolling, "mu_r")->capture_default_str();
  program.add_option("--sizes", options.sizes, "equal, narrow or wide")
      ->check(CLI::IsMember({"equal", "narrow", "wide"}))
      ->capture_default_str();
  program.add_option("--time-step", options.time_step, "[s]")->capture_default_str();
  program.add_option("--hold", options.hold, "[s] under load")->capture_default_str();
  program.add_option("--drop", options.drop, "[m] of the lowest particle")->capture_default_str();
  program.add_option("--seed", options.seed, "of the particles")->capture_default_str();
  program.add_option("--threads", options.threads, "threads")->capture_default_str();
  program.add_flag("--json", options.as_json, "print JSON");
  CLI11_PARSE(program, argc, argv);
  PaperSize run(options);
  run.Work();
  const json report = run.Report();
  if (options.as_json) {
    fmt::print("{}\n", report.dump(1));
  } else {
    Print(report);
  }
  return report["phase"] == "failed" ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) { return Main(RunProgram, argc, argv); }

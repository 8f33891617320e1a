// Throughput of the embedded DEM engine, with LIGGGHTS beside it: the same settled bed, the same
// law, the same number of steps, one core, taking turns. Wall clock and processor time: they differ
// where the machine is busy with other work. See docs/validation/embedded_speed.md.

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "backends/embedded/stages.h"
#include "backends/liggghts/liggghts.h"
#include "core/process.h"
#include "core/statistics.h"

namespace {

using namespace powdercal;
namespace fs = std::filesystem;

// The seed paper's powder at its strongest cohesion.
constexpr double kDensity = 8220;                                             // [kg/m3]
constexpr double kYoungModulus = 5e6;                                         // [Pa]
constexpr double kCohesion = 47500;                                           // [J/m3]
constexpr double kStress = 900;                                               // [Pa]
constexpr double kTimeStep = 2.5e-7;                                          // [s]
constexpr double kSolidFraction = 0.34;                                       // as inserted
constexpr std::int64_t kWarmUp = 500;                                         // steps, not timed
const std::vector<double> kSkins = {0.5e-6, 1e-6, 1.5e-6, 2e-6, 3e-6, 4e-6};  // [m] of LIGGGHTS

struct Options {
  std::string isa = "auto";
  std::vector<int> particles = {5000, 20000};
  std::vector<std::string> tangential = {"history", "no_history"};
  std::vector<std::string> rolling = {"cdt", "epsd2"};
  std::vector<int> threads = {1, 2};
  int repeats = 5;
  double seconds = 2;  // of LIGGGHTS in one timing
  bool json = false;
  bool no_liggghts = false;
  bool memory = false;
};

int Quit(const std::string& message) {
  fmt::print(stderr, "dem_throughput: {}\n", message);
  return 1;
}

void Say(const std::string& message) { fmt::print(stderr, "{}\n", message); }

template <typename Enum>
Enum Named(std::span<const std::string> names, const std::string& name) {
  return static_cast<Enum>(std::find(names.begin(), names.end(), name) - names.begin());
}

std::string CpuModel() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

// --- The bed ------------------------------------------------------------------------------------

struct Bed {
  Program program;  // explicit packing with its contacts, between two planes at rest
  int particles = 0;
};

// Particles in a box periodic in x and y, `width` wide, between a floor and a lid.
Program MakeProgram(int particles, double width, const ContactLaw& law) {
  Program program;
  program.particles.sizes = {SizeDistribution::Kind::normal, 29e-6, 6e-6, 12.5e-6, 37.5e-6};
  program.particles.count = particles;
  program.particles.seed = 1;
  const ContactParameters contact = {.restitution = 0.4,
                                     .friction = 0.3,
                                     .rolling_friction = 0.5,
                                     .cohesion_energy_density = kCohesion};
  program.materials = {.density = kDensity,
                       .young_modulus = kYoungModulus,
                       .poisson_ratio = 0.3,
                       .particle_particle = contact,
                       .particle_wall = contact};
  program.law = law;
  program.time_step = kTimeStep;
  const double volume = std::numbers::pi / 6 * program.particles.sizes.Moment(3) * particles;
  const double top = volume / (width * width * kSolidFraction);
  const double d = program.particles.sizes.Moment(1);
  program.domain.lower = {0, 0, -0.5 * d};
  program.domain.upper = {width, width, top + 2 * d};
  program.walls = {{.name = "floor", .position = 0},
                   {.name = "lid", .position = top, .facing_positive = false}};
  return program;
}

Bed PrepareBed(int particles, const ContactLaw& law, embedded::Isa isa, int threads) {
  const SizeDistribution sizes = MakeProgram(1, 1, law).particles.sizes;
  const double d = sizes.Moment(1);
  Bed bed = {MakeProgram(particles, 10 * d * std::cbrt(particles / 1000.0), law), particles};
  Program& program = bed.program;
  const double top = program.walls[1].position;
  const double pace = d * std::sqrt(kDensity / kStress);  // [s] inertial time
  program.stages = {Insert{.bottom = 0, .top = top, .velocity = {0, 0, -0.1}},
                    Servo{.wall = "lid",
                          .stress = kStress,
                          .max_velocity = 0.2,
                          .max_duration = 300 * pace * top / d},
                    Advance{.name = "relax", .duration = 30 * pace}};
  const RunContext context;
  const Trace trace = embedded::StageRunner(program, context, {isa, threads}).Run();
  if (!trace.outcome.ok()) {
    throw std::runtime_error("the bed could not be prepared: " + trace.outcome.message);
  }
  const Moment& end = trace.moments.back();
  program.walls[1].position = end.walls.at("lid").height;
  program.particles.packing = end.packing;
  program.particles.contacts = end.contacts;
  program.stages.clear();
  return bed;
}

// --- Timing -------------------------------------------------------------------------------------

// Particle steps per second [1/s].
struct Throughput {
  double wall = 0;  // by the clock on the wall
  double cpu = 0;   // by the time that the processor gave
};

struct EmbeddedTiming {
  Throughput pps;
  embedded::Simulation::Counters counters;
  std::int64_t contacts = 0;
};

// Of this thread [s].
double CpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

EmbeddedTiming TimeEmbedded(const Bed& bed, std::int64_t steps, embedded::Isa isa, int threads) {
  embedded::Simulation simulation(bed.program, *bed.program.particles.packing, {isa, threads});
  simulation.Run(kWarmUp, nullptr);
  const auto begin = std::chrono::steady_clock::now();
  const double cpu = CpuSeconds();
  const bool done = simulation.Run(steps, nullptr);
  const double cpu_seconds = CpuSeconds() - cpu;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  if (!done) throw std::runtime_error("the embedded engine gave up");
  const double work = static_cast<double>(steps) * bed.particles;
  return {{work / elapsed.count(), work / cpu_seconds},
          simulation.counters(),
          simulation.MakeSurvey().contacts};
}

class Liggghts {
 public:
  explicit Liggghts(const Bed& bed)
      : bed_(bed), folder_(fs::temp_directory_path() / fmt::format("throughput-{}", getpid())) {
    fs::create_directories(folder_);
    WriteData();
  }
  ~Liggghts() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Liggghts(const Liggghts&) = delete;
  Liggghts& operator=(const Liggghts&) = delete;

  // Of the loop time that LIGGGHTS states for its last run, and of its processor time from the
  // beginning of that run to its end.
  Throughput Time(std::int64_t steps, double skin) const {
    std::ofstream(folder_ / "deck") << Deck(steps, skin);
    const ProcessResult process =
        RunProcess({.arguments = {"liggghts", "-in", "deck", "-log", "none"},
                    .working_directory = folder_,
                    .environment = {{"OMPI_MCA_ess_singleton_isolated", "1"},
                                    {"OMPI_MCA_orte_create_session_dirs", "0"},
                                    {"OMPI_ALLOW_RUN_AS_ROOT", "1"},
                                    {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"},
                                    {"OMP_NUM_THREADS", "1"}}});
    static constexpr std::string_view kMark = "Loop time of ";
    const std::size_t mark = process.output.rfind(kMark);
    if (!process.succeeded() || mark == std::string::npos) {
      throw std::runtime_error("LIGGGHTS " + process.Describe() + ":\n" + process.output);
    }
    const double seconds = std::stod(process.output.substr(mark + kMark.size()));
    const double cpu_seconds = CpuSecondsAt("end") - CpuSecondsAt("begin");
    const double work = static_cast<double>(steps) * bed_.particles;
    return {work / seconds, work / cpu_seconds};
  }

 private:
  void WriteData() const {
    const Domain& d = bed_.program.domain;
    std::ofstream data(folder_ / "data");
    data << fmt::format("a settled bed\n\n{} atoms\n1 atom types\n\n", bed_.particles);
    const char* axes[] = {"x", "y", "z"};
    for (std::size_t n = 0; n < 3; ++n) {
      data << fmt::format("{} {} {}lo {}hi\n", d.lower[n], d.upper[n], axes[n], axes[n]);
    }
    data << "\nAtoms\n\n";
    for (const Sphere& s : *bed_.program.particles.packing) {
      data << fmt::format("{} 1 {} {} {} {} {}\n", s.id, 2 * s.radius, kDensity, s.position[0],
                          s.position[1], s.position[2]);
    }
    data << "\nVelocities\n\n";
    for (const Sphere& s : *bed_.program.particles.packing) {
      data << fmt::format("{} {} {} {} {} {} {}\n", s.id, s.velocity[0], s.velocity[1],
                          s.velocity[2], s.spin[0], s.spin[1], s.spin[2]);
    }
  }

  // The first figure of Linux' schedstat: nanoseconds on a processor.
  double CpuSecondsAt(const char* name) const {
    double nanoseconds = 0;
    std::ifstream(folder_ / name) >> nanoseconds;
    return 1e-9 * nanoseconds;
  }

  // Nothing in it but what the simulation needs: no computes, no output. Particles are sorted in
  // space by LIGGGHTS itself (its default).
  std::string Deck(std::int64_t steps, double skin) const {
    const ContactParameters& contact = bed_.program.materials.particle_particle;
    const ContactLaw& law = bed_.program.law;
    const std::string model =
        fmt::format("gran model hertz tangential {} cohesion sjkr2 rolling_friction {}",
                    TangentialLawNames()[static_cast<std::size_t>(law.tangential)],
                    RollingNames()[static_cast<std::size_t>(law.rolling)]);
    const std::string options = "limitForce off torsionTorque on";
    std::string deck =
        "atom_style granular\natom_modify map array\nboundary p p f\nnewton off\n"
        "communicate single vel yes\nunits si\nhard_particles no\nread_data data\n";
    deck += fmt::format("neighbor {} bin\n", skin);
    deck += "neigh_modify delay 0 every 1 check yes contact_distance_factor 1\n";
    deck += fmt::format("pair_style {} {}\npair_coeff * *\n", model, options);
    const auto property = [&](const char* name, const char* kind, double value) {
      deck += fmt::format("fix {0} all property/global {0} {1} {2}\n", name, kind, value);
    };
    property("youngsModulus", "peratomtype", kYoungModulus);
    property("poissonsRatio", "peratomtype", bed_.program.materials.poisson_ratio);
    property("coefficientRestitution", "peratomtypepair 1", contact.restitution);
    property("coefficientFriction", "peratomtypepair 1", contact.friction);
    property("cohesionEnergyDensity", "peratomtypepair 1", contact.cohesion_energy_density);
    property("coefficientRollingFriction", "peratomtypepair 1", contact.rolling_friction);
    deck += fmt::format("timestep {}\nfix move all nve/sphere\n", kTimeStep);
    deck += fmt::format("fix gravity all gravity {} vector 0 0 -1\n", -bed_.program.gravity[2]);
    for (const PlaneWall& wall : bed_.program.walls) {
      deck += fmt::format("fix {} all wall/{} primitive type 1 zplane {} {}\n", wall.name, model,
                          wall.position, options);
    }
    deck += "thermo_style custom step atoms\nthermo 1000000000\nthermo_modify lost error\n";
    deck += fmt::format("run {} post no\n", kWarmUp);
    deck += "shell \"cat /proc/$PPID/schedstat > begin\"\n";
    deck += fmt::format("run {} pre no post no\n", steps);
    deck += "shell \"cat /proc/$PPID/schedstat > end\"\n";
    return deck;
  }

  const Bed& bed_;
  fs::path folder_;
};

struct Skin {
  double best = 0;  // [m]
  double pps = 0;   // [1/s] with it
  nlohmann::json tried = nlohmann::json::array();
};

// Two rounds, the better of both counts: the machine may be busy with other work.
Skin FindSkin(const Liggghts& liggghts, std::int64_t steps) {
  std::vector<double> pps(kSkins.size(), 0);
  for (int round = 0; round < 2; ++round) {
    for (std::size_t n = 0; n < kSkins.size(); ++n) {
      pps[n] = std::max(pps[n], liggghts.Time(steps, kSkins[n]).cpu);
    }
  }
  const auto best =
      static_cast<std::size_t>(std::max_element(pps.begin(), pps.end()) - pps.begin());
  Skin skin = {kSkins[best], pps[best]};
  for (std::size_t n = 0; n < kSkins.size(); ++n) {
    skin.tried.push_back({{"skin", kSkins[n]}, {"pps", pps[n]}});
  }
  return skin;
}

struct Samples {
  std::vector<double> wall;
  std::vector<double> cpu;
  void Add(const Throughput& pps) {
    wall.push_back(pps.wall);
    cpu.push_back(pps.cpu);
  }
};

double MedianRatio(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> ratios;
  for (std::size_t n = 0; n < a.size(); ++n) ratios.push_back(a[n] / b[n]);
  return Median(ratios);
}

nlohmann::json MeasureCase(const Bed& bed, embedded::Isa isa, const Options& options) {
  const double trial = std::max(400.0, 2e6 * options.seconds / bed.particles);
  nlohmann::json result;
  Skin skin;
  std::optional<Liggghts> liggghts;
  if (!options.no_liggghts) {
    liggghts.emplace(bed);
    skin = FindSkin(*liggghts, static_cast<std::int64_t>(trial));
    result["liggghts_skin"] = skin.best;
    result["liggghts_skins_tried"] = skin.tried;
  } else {
    skin.pps = TimeEmbedded(bed, static_cast<std::int64_t>(trial), isa, 1).pps.cpu;
  }
  const auto steps = static_cast<std::int64_t>(options.seconds * skin.pps / bed.particles) + 1;
  Samples embedded_samples;
  Samples liggghts_samples;
  EmbeddedTiming timing;
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    if (liggghts) liggghts_samples.Add(liggghts->Time(steps, skin.best));
    timing = TimeEmbedded(bed, steps, isa, 1);
    embedded_samples.Add(timing.pps);
  }
  const double n = bed.particles;
  const auto run = static_cast<double>(kWarmUp + steps);
  result["steps"] = steps;
  result["embedded_pps"] = Median(embedded_samples.wall);
  result["embedded_cpu_pps"] = Median(embedded_samples.cpu);
  result["embedded_samples"] = embedded_samples.wall;
  result["pairs_per_particle"] = static_cast<double>(timing.counters.pairs) / n;
  result["contacts_per_particle"] = static_cast<double>(timing.contacts) / n;
  result["steps_per_prune"] = run / static_cast<double>(timing.counters.prunes);
  result["steps_per_rebuild"] = run / static_cast<double>(timing.counters.rebuilds);
  if (liggghts) {
    result["liggghts_pps"] = Median(liggghts_samples.wall);
    result["liggghts_cpu_pps"] = Median(liggghts_samples.cpu);
    result["liggghts_samples"] = liggghts_samples.wall;
    result["ratio"] = MedianRatio(embedded_samples.wall, liggghts_samples.wall);
    result["cpu_ratio"] = MedianRatio(embedded_samples.cpu, liggghts_samples.cpu);
  }
  return result;
}

nlohmann::json MeasureThreads(const Bed& bed, embedded::Isa isa, const Options& options) {
  const double alone = TimeEmbedded(bed, kWarmUp, isa, 1).pps.cpu;
  const auto steps = static_cast<std::int64_t>(options.seconds * alone / bed.particles) + 1;
  nlohmann::json results = nlohmann::json::array();
  for (const int threads : options.threads) {
    if (threads < 2) continue;
    std::vector<double> speedups;
    for (int repeat = 0; repeat < options.repeats; ++repeat) {
      const double one = TimeEmbedded(bed, steps, isa, 1).pps.wall;
      speedups.push_back(TimeEmbedded(bed, steps, isa, threads).pps.wall / one);
    }
    results.push_back({{"particles", bed.particles},
                       {"threads", threads},
                       {"speedup", Median(speedups)},
                       {"samples", speedups}});
  }
  return results;
}

// --- Memory -------------------------------------------------------------------------------------

double PeakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

// A bed `times` by `times` as wide, of copies side by side.
void Tile(Program& program, int times) {
  Domain& domain = program.domain;
  const Vector3 size = domain.Lengths();
  Packing tiled;
  for (int x = 0; x < times; ++x) {
    for (int y = 0; y < times; ++y) {
      for (Sphere sphere : *program.particles.packing) {
        sphere.id = static_cast<std::int64_t>(tiled.size()) + 1;
        sphere.position[0] += x * size[0];
        sphere.position[1] += y * size[1];
        tiled.push_back(sphere);
      }
    }
  }
  domain.upper[0] = domain.lower[0] + times * size[0];
  domain.upper[1] = domain.lower[1] + times * size[1];
  program.particles.packing = std::move(tiled);
  program.particles.contacts.clear();
}

// Peak of this process in bytes [B]. First as inserted, on the 2 mm × 2 mm base of the fidelity
// `paper`; then a settled bed, which has more contacts, with the moments of three stages.
nlohmann::json MeasureMemory(embedded::Isa isa) {
  constexpr int kParticles = 500000;
  constexpr int kTiles = 10;
  const ContactLaw law = {.tangential = ContactLaw::Tangential::history,
                          .cohesion = ContactLaw::Cohesion::sjkr2,
                          .rolling = ContactLaw::Rolling::epsd2};
  const RunContext context;
  const Advance advance = {.name = "advance", .duration = 300 * kTimeStep};
  const auto run = [&](const Program& program) {
    const Trace trace = embedded::StageRunner(program, context, {isa, 1}).Run();
    if (!trace.outcome.ok()) throw std::runtime_error(trace.outcome.message);
    return nlohmann::json{{"particles", program.particles.count},
                          {"steps", trace.diagnostics.steps},
                          {"contacts_with_memory", trace.moments.back().contacts.size()},
                          {"peak_bytes", PeakMemory()}};
  };
  nlohmann::json result;
  {
    Program program = MakeProgram(kParticles, 2e-3, law);
    program.stages = {Insert{.bottom = 0, .top = program.walls[1].position}, advance};
    result["inserted"] = run(program);
  }
  Program program = PrepareBed(kParticles / (kTiles * kTiles), law, isa, 2).program;
  Tile(program, kTiles);
  program.particles.count = kParticles;
  program.stages = {advance, advance, advance};
  result["settled"] = run(program);
  return result;
}

// --- Output -------------------------------------------------------------------------------------

void PrintCase(const nlohmann::json& c) {
  std::string liggghts = "         -      -      -      -";
  if (c.contains("liggghts_pps")) {
    liggghts = fmt::format("{:10.3g} {:6.2f} {:6.2f} {:6.1f}", c["liggghts_pps"].get<double>(),
                           c["ratio"].get<double>(), c["cpu_ratio"].get<double>(),
                           1e6 * c["liggghts_skin"].get<double>());
  }
  fmt::print("{:9} {:10} {:5} {:10.3g} {} {:6.2f} {:8.2f} {:7.0f} {:8.0f}\n",
             c["particles"].get<int>(), c["tangential"].get<std::string>(),
             c["rolling"].get<std::string>(), c["embedded_pps"].get<double>(), liggghts,
             c["pairs_per_particle"].get<double>(), c["contacts_per_particle"].get<double>(),
             c["steps_per_prune"].get<double>(), c["steps_per_rebuild"].get<double>());
  std::fflush(stdout);
}

void PrintHead(const nlohmann::json& report) {
  fmt::print("{}, {}, {} lanes; throughput in particle steps per second (1/s), medians;\n",
             report["cpu"].get<std::string>(), report["isa"].get<std::string>(),
             report["lanes"].get<int>());
  fmt::print("ratios by the wall clock and by processor time; skin of LIGGGHTS in µm\n");
  const auto line = [](const auto&... words) {
    fmt::print("{:>9} {:10} {:5} {:>10} {:>10} {:>6} {:>6} {:>6} {:>6} {:>8} {:>7} {:>8}\n",
               words...);
  };
  line("particles", "tangential", "roll", "embedded", "LIGGGHTS", "ratio", "ratio", "skin", "pairs",
       "contacts", "steps/", "steps/");
  line("", "", "", "", "", "", "cpu", "", "/part.", "/part.", "prune", "rebuild");
}

void PrintMemory(const nlohmann::json& memory) {
  for (const auto& [name, figures] : memory.items()) {
    fmt::print("peak memory, {} particles {}: {:.0f} MiB\n", figures["particles"].get<int>(), name,
               figures["peak_bytes"].get<double>() / (1024 * 1024));
  }
}

int Measure(const Options& options) {
  const embedded::Isa isa = options.isa == "auto"
                                ? embedded::BestIsa()
                                : Named<embedded::Isa>(embedded::IsaNames(), options.isa);
  if (!embedded::Has(isa)) return Quit("this processor has no " + options.isa);
  nlohmann::json report = {
      {"isa", embedded::IsaNames()[static_cast<std::size_t>(isa)]},
      {"lanes", embedded::KernelsFor(isa, {}).lanes},
      {"cpu", CpuModel()},
  };
  if (options.memory) {
    report["memory"] = MeasureMemory(isa);
    if (options.json) fmt::print("{}\n", report.dump(2));
    if (!options.json) PrintMemory(report["memory"]);
    return 0;
  }
  if (!options.no_liggghts) {
    const Availability liggghts = MakeLiggghtsBackend()->availability();
    if (!liggghts.available) return Quit(liggghts.why_not + "; or use --no-liggghts");
    report["liggghts"] = liggghts.version;
  }
  if (!options.json) PrintHead(report);
  report["cases"] = nlohmann::json::array();
  report["threads"] = nlohmann::json::array();
  const int most_threads = *std::max_element(options.threads.begin(), options.threads.end());
  for (const int particles : options.particles) {
    bool first = true;
    for (const std::string& tangential : options.tangential) {
      for (const std::string& rolling : options.rolling) {
        const ContactLaw law = {
            .tangential = Named<ContactLaw::Tangential>(TangentialLawNames(), tangential),
            .cohesion = ContactLaw::Cohesion::sjkr2,
            .rolling = Named<ContactLaw::Rolling>(RollingNames(), rolling)};
        if (options.json) Say(fmt::format("{} particles, {}, {}", particles, tangential, rolling));
        const Bed bed = PrepareBed(particles, law, isa, most_threads);
        nlohmann::json figures = MeasureCase(bed, isa, options);
        figures.update(
            {{"particles", particles}, {"tangential", tangential}, {"rolling", rolling}});
        if (!options.json) PrintCase(figures);
        report["cases"].push_back(std::move(figures));
        if (!first) continue;
        for (auto& entry : MeasureThreads(bed, isa, options)) report["threads"].push_back(entry);
        first = false;
      }
    }
  }
  if (options.json) {
    fmt::print("{}\n", report.dump(2));
    return 0;
  }
  for (const auto& entry : report["threads"]) {
    fmt::print("{} particles: {} threads are {:.2f} times as fast as one\n",
               entry["particles"].get<int>(), entry["threads"].get<int>(),
               entry["speedup"].get<double>());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program{"Throughput of the embedded DEM engine, with LIGGGHTS beside it"};
  Options options;
  std::vector<std::string> isas = {"auto"};
  isas.insert(isas.end(), embedded::IsaNames().begin(), embedded::IsaNames().end());
  program.add_option("--isa", options.isa, "instruction set")->check(CLI::IsMember(isas));
  program.add_option("--particles", options.particles, "numbers of particles")
      ->delimiter(',')
      ->check(CLI::Range(200, 2'000'000));
  program.add_option("--tangential", options.tangential, "tangential laws")
      ->delimiter(',')
      ->check(CLI::IsMember({"history", "no_history"}));
  program.add_option("--rolling", options.rolling, "laws of rolling friction")
      ->delimiter(',')
      ->check(CLI::IsMember({"cdt", "epsd2"}));
  program.add_option("--repeats", options.repeats, "timings of each case")
      ->check(CLI::PositiveNumber);
  program.add_option("--threads", options.threads, "threads to compare with one")
      ->delimiter(',')
      ->check(CLI::Range(1, 64));
  program.add_option("--seconds", options.seconds, "[s] about as long is one timing of LIGGGHTS")
      ->check(CLI::PositiveNumber);
  program.add_flag("--no-liggghts", options.no_liggghts, "the embedded engine alone");
  program.add_flag("--memory", options.memory, "peak memory of 500 000 particles, nothing else");
  program.add_flag("--json", options.json, "print JSON");
  CLI11_PARSE(program, argc, argv);
  try {
    return Measure(options);
  } catch (const std::exception& error) {
    return Quit(error.what());
  }
}

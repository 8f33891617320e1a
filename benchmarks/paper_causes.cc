// Why the void ratios of the seed paper's Table 3 and those of our simulations differ: the paper's
// law and figures as they stand, then one change at a time, then the best changes together. What
// the paper does not say (insertion, sizes, time under load, estimate of e) counts as a change like
// any other. See docs/validation/paper_causes.md.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "backends/registry.h"
#include "benchmarks/liggghts_insertion.h"
#include "benchmarks/paper_bed.h"
#include "benchmarks/run_program.h"
#include "core/errors.h"
#include "core/statistics.h"

namespace {

using namespace powdercal;
using namespace powdercal::benchmarks;
using nlohmann::json;
using Law = ContactLaw;

// A way of making a bed and of reading e from it.
struct Protocol {
  BedSetup bed;
  std::string moment = "hold";  // the last reading of that name counts
  double Reading::*estimate = &Reading::central;
  bool inserted_by_liggghts = false;
};

struct Variant {
  const char* name;
  const char* axis;  // variants of one axis exclude each other
  std::function<void(Protocol&)> change;
};

// As many particles above each other, by weight, as in the paper's bed: gravity makes up for the
// lower bed, so that its weight, the pressure of the impact and the speed of a fall over the
// correspondingly lower height are the paper's.
void WeighAsThePapers(BedSetup& bed) {
  constexpr double kPaper = 500'000 / (2e-3 * 2e-3);  // particles per area [1/m2]
  bed.gravity *= kPaper / (bed.particles / (bed.Width() * bed.Width()));
}

Variant TimeStep(const char* name, double time_step) {
  return {name, "time step", [=](Protocol& p) { p.bed.time_step = time_step; }};
}
Variant Slides(const char* name, double friction) {
  return {name, "friction", [=](Protocol& p) { p.bed.friction = friction; }};
}
Variant Held(const char* name, double hold) {
  return {name, "hold", [=](Protocol& p) { p.bed.hold = hold; }};
}
Variant Loaded(const char* name, double stress) {
  return {name, "stress", [=](Protocol& p) { p.bed.stress = stress; }};
}
Variant Estimated(const char* name, double Reading::*estimate) {
  return {name, "estimate", [=](Protocol& p) { p.estimate = estimate; }};
}
Variant Filled(const char* name, double fraction, double velocity = 0, double drop = 0) {
  return {name, "filling", [=](Protocol& p) {
            p.bed.solid_fraction = fraction;
            p.bed.velocity = velocity;
            p.bed.drop = drop;
          }};
}

std::vector<Variant> NumericsAndLaw() {
  return {
      TimeStep("dt 5e-7", 5e-7),
      TimeStep("dt 2.5e-7", 2.5e-7),
      TimeStep("dt 1.25e-7", 1.25e-7),
      {"epsd2", "rolling", [](Protocol& p) { p.bed.law.rolling = Law::Rolling::epsd2; }},
      {"no rolling friction", "rolling",
       [](Protocol& p) { p.bed.law.rolling = Law::Rolling::none; }},
      {"torsion", "torsion", [](Protocol& p) { p.bed.law.torsion = true; }},
      {"history", "tangential",
       [](Protocol& p) { p.bed.law.tangential = Law::Tangential::history; }},
      {"history, epsd2, torsion", "tangential",
       [](Protocol& p) {
         p.bed.law.tangential = Law::Tangential::history;
         p.bed.law.rolling = Law::Rolling::epsd2;
         p.bed.law.torsion = true;
       }},
      {"tangential_reduce", "tangential_reduce",
       [](Protocol& p) { p.bed.law.tangential_reduce = true; }},
      {"limit_force", "limit_force", [](Protocol& p) { p.bed.law.limit_force = true; }},
      Slides("friction 0", 0),
      Slides("friction 0.03", 0.03),
      Slides("friction 0.06", 0.06),
      Slides("friction 0.1", 0.1),
      Slides("friction 10 (never slides)", 10),
      {"walls without cohesion", "walls", [](Protocol& p) { p.bed.sticky_walls = false; }},
      {"k/2", "cohesion", [](Protocol& p) { p.bed.cohesion_factor = 0.5; }},
      {"2k", "cohesion", [](Protocol& p) { p.bed.cohesion_factor = 2; }},
      {"restitution 0.9", "restitution", [](Protocol& p) { p.bed.restitution = 0.9; }},
  };
}

std::vector<Variant> BedAndLoad() {
  using Sizes = BedSetup::Sizes;
  return {
      {"equal spheres", "sizes", [](Protocol& p) { p.bed.sizes = Sizes::equal; }},
      {"narrow sizes (sd 2 um)", "sizes", [](Protocol& p) { p.bed.sizes = Sizes::narrow; }},
      Filled("placed at 0.20", 0.20),
      Filled("placed at 0.34", 0.34),
      Filled("placed at 0.05", 0.05),
      Filled("moving at 0.1 m/s", 0.30, 0.1),
      Filled("moving at 0.3 m/s", 0.30, 0.3),
      Filled("dropped by 4.5 mm", 0.30, 0, 4.5e-3),
      Filled("rain from up to 5 mm", 0.03),
      {"inserted by LIGGGHTS", "insertion", [](Protocol& p) { p.inserted_by_liggghts = true; }},
      {"weight of the paper's bed", "weight", [](Protocol& p) { WeighAsThePapers(p.bed); }},
      {"tall bed (5000 on 6 d)", "weight",
       [](Protocol& p) {
         p.bed.particles *= 5;
         p.bed.width = 6;
       }},
      {"3000 particles on 14.4 d", "particles",
       [](Protocol& p) {
         p.bed.particles *= 3;
         p.bed.width = 14.4;
       }},
      Held("held 2 ms", 2e-3),
      Held("held 64 ms", 64e-3),
      Held("held 256 ms", 256e-3),
      Loaded("90 Pa", 90),
      Loaded("300 Pa", 300),
      Loaded("9 kPa", 9000),
      Loaded("never loaded", 0),
      {"as settled, before the load", "moment", [](Protocol& p) { p.moment = "settle"; }},
      {"as soon as 90 % of the load is borne", "moment", [](Protocol& p) { p.moment = "servo"; }},
      {"loaded at 10 mm/s at most", "lid", [](Protocol& p) { p.bed.lid_speed = 0.01; }},
      {"settling for 100 ms", "settling", [](Protocol& p) { p.bed.settle_time = 0.1; }},
      Estimated("wall to wall", &Reading::wall_to_wall),
      Estimated("overlaps counted once", &Reading::less_overlaps),
      Estimated("solid volume from the mean diameter", &Reading::mean_diameter),
  };
}

std::vector<Variant> AllVariants() {
  std::vector<Variant> all = NumericsAndLaw();
  for (Variant& variant : BedAndLoad()) all.push_back(std::move(variant));
  return all;
}

struct Options {
  std::vector<std::string> variants;  // empty: all
  std::vector<std::string> base;      // changes that hold for all
  std::vector<std::string> rows = {"0-1", "3", "5", "10", "0-4", "0-2"};
  bool all_rows = false;
  int seeds = 2;
  int particles = 1000;
  int parallel = 2;
  std::string backend = "embedded";
  std::string keep;
  bool greedy = false;
  bool as_json = false;
};

// Runs, remembered in a file of lines if there is one.
class Laboratory {
 public:
  explicit Laboratory(const Options& options)
      : options_(options), backend_(MakeBackend(options.backend)) {
    backend_->Prepare({});
    std::ifstream in(options.keep);
    for (std::string line; std::getline(in, line);) {
      // A last line that was cut short is run again.
      const json entry = json::parse(line, nullptr, false);
      if (!entry.is_discarded()) known_[entry.at("key").get<std::string>()] = entry;
    }
  }

  // Those that are not known yet, several at a time.
  void RunAll(const std::vector<Program>& programs) {
    std::set<std::string> keys;
    std::vector<const Program*> open;
    for (const Program& program : programs) {
      const std::string key = KeyOf(program);
      if (Find(key) == nullptr && keys.insert(key).second) open.push_back(&program);
    }
    std::atomic<std::size_t> next = 0;
    std::vector<std::jthread> workers;
    for (int worker = 0; worker < options_.parallel; ++worker) {
      workers.emplace_back([&] {
        for (std::size_t i = next++; i < open.size(); i = next++) Run(*open[i]);
      });
    }
  }

  // {"outcome": …, "message": …, "readings": [...]}.
  const json& Run(const Program& program) {
    const std::string key = KeyOf(program);
    if (const json* known = Find(key)) return *known;
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() /
        fmt::format("paper_causes-{}-{}", getpid(), program.Hash().substr(0, 16));
    const Trace trace = backend_->Run(program, {.work_folder = folder});
    std::filesystem::remove_all(folder);
    json readings = json::array();
    for (const Reading& reading : ReadAll(program, trace)) readings.push_back(ToJson(reading));
    json entry = {{"key", key},
                  {"outcome", ToString(trace.outcome.reason)},
                  {"message", trace.outcome.message},
                  {"steps", trace.diagnostics.steps},
                  {"seconds", trace.diagnostics.wall_seconds},
                  {"readings", std::move(readings)}};
    const std::lock_guard lock(mutex_);
    if (!options_.keep.empty()) {
      std::ofstream(options_.keep, std::ios::app) << entry.dump() << std::endl;
    }
    return known_.emplace(key, std::move(entry)).first->second;
  }

 private:
  std::string KeyOf(const Program& program) const {
    return options_.backend + " " + program.Hash();
  }
  const json* Find(const std::string& key) {
    const std::lock_guard lock(mutex_);
    const auto known = known_.find(key);
    return known != known_.end() ? &known->second : nullptr;
  }

  const Options& options_;
  std::unique_ptr<Backend> backend_;
  std::mutex mutex_;
  std::map<std::string, json> known_;
};

const Variant& Named(const std::string& name) {
  static const std::vector<Variant> kAll = AllVariants();
  std::vector<std::string> names;
  for (const Variant& variant : kAll) {
    if (variant.name == name) return variant;
    names.emplace_back(variant.name);
  }
  throw UnknownName("variant", name, names, {.key = "--variant"});
}

std::vector<TableRow> ChosenRows(const Options& options) {
  std::vector<TableRow> rows;
  std::vector<std::string> names;
  for (const TableRow& row : Table3()) {
    names.push_back(row.name);
    const bool named = std::ranges::find(options.rows, row.name) != options.rows.end();
    if (options.all_rows || named) rows.push_back(row);
  }
  for (const std::string& name : options.rows) {
    if (std::ranges::find(names, name) == names.end()) {
      throw UnknownName("row of Table 3", name, names, {.key = "--rows"});
    }
  }
  return rows;
}

Program ProgramOf(const Protocol& protocol, const TableRow& row, int seed) {
  Program program =
      MakeBed(protocol.bed, row.cohesion, row.rolling, static_cast<std::uint64_t>(seed));
  if (protocol.inserted_by_liggghts) program.particles.packing = InsertByLiggghts(program);
  return program;
}

void RunAll(Laboratory& laboratory, const std::vector<Protocol>& protocols,
            const std::vector<TableRow>& rows, int seeds) {
  std::vector<Program> programs;
  for (const Protocol& protocol : protocols) {
    for (const TableRow& row : rows) {
      for (int seed = 1; seed <= seeds; ++seed) programs.push_back(ProgramOf(protocol, row, seed));
    }
  }
  laboratory.RunAll(programs);
}

// One row of the table under a protocol.
json Measure(Laboratory& laboratory, const Protocol& protocol, const TableRow& row, int seeds) {
  std::vector<double> values;
  std::vector<double> stresses;
  json failures = json::array();
  for (int seed = 1; seed <= seeds; ++seed) {
    const json& run = laboratory.Run(ProgramOf(protocol, row, seed));
    std::optional<Reading> last;
    for (const json& reading : run.at("readings")) {
      if (reading.at("moment") == protocol.moment) last = ReadingFromJson(reading);
    }
    if (run.at("outcome") != "ok") {
      failures.push_back(fmt::format("{}: {}", run.at("outcome").get<std::string>(),
                                     run.at("message").get<std::string>()));
    } else if (last) {
      values.push_back((*last).*protocol.estimate);
      stresses.push_back(last->stress);
    }
  }
  json entry = {{"row", row.name},         {"k", row.cohesion}, {"mu_r", row.rolling},
                {"paper", row.void_ratio}, {"values", values},  {"failures", failures}};
  if (values.empty()) return entry;
  entry["mean"] = Mean(values);
  entry["sd"] = StandardDeviation(values);
  entry["stress"] = Mean(stresses);
  return entry;
}

// A protocol at all rows: their entries, root mean square and largest difference from the paper.
json Compare(Laboratory& laboratory, const std::string& name, const Protocol& protocol,
             const std::vector<TableRow>& rows, int seeds) {
  json entries = json::array();
  double squares = 0;
  double worst = 0;
  int measured = 0;
  for (const TableRow& row : rows) {
    json entry = Measure(laboratory, protocol, row, seeds);
    if (entry.contains("mean")) {
      const double difference = entry["mean"].get<double>() - row.void_ratio;
      squares += difference * difference;
      worst = std::max(worst, std::abs(difference));
      ++measured;
    }
    entries.push_back(std::move(entry));
  }
  json result = {{"variant", name},
                 {"rows", std::move(entries)},
                 {"measured", measured},
                 {"missing", static_cast<int>(rows.size()) - measured}};
  result["rms"] = measured > 0 ? json(std::sqrt(squares / measured)) : json();
  result["worst"] = measured > 0 ? json(worst) : json();
  fmt::print(stderr, "{}: rms {}\n", name, result["rms"].dump());
  return result;
}

// Variants without all rows come last.
double Rank(const json& result) {
  if (result["missing"].get<int>() > 0 || result["rms"].is_null()) {
    return 1e6 + result["missing"].get<double>();
  }
  return result["rms"];
}

json Sorted(std::vector<json> results) {
  std::ranges::stable_sort(results, {}, Rank);
  return results;
}

// Adds the change that helps most, as long as one helps by 2 %.
json Greedy(Laboratory& laboratory, const Protocol& base, const json& start,
            const std::vector<const Variant*>& variants, const std::vector<TableRow>& rows,
            int seeds) {
  json path = json::array();
  std::vector<const Variant*> taken;
  Protocol best = base;
  double reached = Rank(start);
  std::string name;
  for (;;) {
    std::vector<const Variant*> open;
    std::vector<Protocol> protocols;
    for (const Variant* variant : variants) {
      const bool excluded = std::ranges::any_of(
          taken, [&](const Variant* t) { return std::string(t->axis) == variant->axis; });
      if (excluded) continue;
      open.push_back(variant);
      variant->change(protocols.emplace_back(best));
    }
    RunAll(laboratory, protocols, rows, seeds);
    const Variant* next = nullptr;
    json next_result;
    for (std::size_t i = 0; i < open.size(); ++i) {
      json result = Compare(laboratory, name.empty() ? open[i]->name : name + " + " + open[i]->name,
                            protocols[i], rows, seeds);
      if (next != nullptr && Rank(result) >= Rank(next_result)) continue;
      next = open[i];
      next_result = std::move(result);
    }
    if (next == nullptr || Rank(next_result) > 0.98 * reached) return path;
    next->change(best);
    taken.push_back(next);
    reached = Rank(next_result);
    name = next_result["variant"];
    path.push_back(std::move(next_result));
  }
}

json Run(const Options& options) {
  Laboratory laboratory(options);
  const std::vector<TableRow> rows = ChosenRows(options);
  std::vector<const Variant*> variants;
  static const std::vector<Variant> kAll = AllVariants();
  if (options.variants.empty()) {
    for (const Variant& variant : kAll) variants.push_back(&variant);
  }
  for (const std::string& name : options.variants) {
    if (name != "base") variants.push_back(&Named(name));
  }
  Protocol base;
  base.bed.particles = options.particles;
  for (const std::string& name : options.base) Named(name).change(base);
  std::vector<Protocol> protocols = {base};
  for (const Variant* variant : variants) variant->change(protocols.emplace_back(base));
  RunAll(laboratory, protocols, rows, options.seeds);
  const json start = Compare(laboratory, "base", base, rows, options.seeds);
  std::vector<json> results = {start};
  for (std::size_t i = 0; i < variants.size(); ++i) {
    results.push_back(
        Compare(laboratory, variants[i]->name, protocols[i + 1], rows, options.seeds));
  }
  json report = {{"backend", options.backend},
                 {"particles", options.particles},
                 {"seeds", options.seeds},
                 {"base", options.base},
                 {"variants", Sorted(std::move(results))}};
  if (options.greedy) {
    report["greedy"] = Greedy(laboratory, base, start, variants, rows, options.seeds);
  }
  return report;
}

void PrintTable(const json& results) {
  if (results.empty()) return;
  fmt::print("| variant | rms | worst |");
  for (const json& row : results[0]["rows"]) {
    fmt::print(" {:g}, {:g} |", row["k"].get<double>(), row["mu_r"].get<double>());
  }
  fmt::print("\n|---|---|---|");
  for (std::size_t n = 0; n < results[0]["rows"].size(); ++n) fmt::print("---|");
  fmt::print("\n| the paper | | |");
  for (const json& row : results[0]["rows"]) fmt::print(" {:.3f} |", row["paper"].get<double>());
  fmt::print("\n");
  for (const json& result : results) {
    fmt::print("| {} |", result["variant"].get<std::string>());
    for (const char* figure : {"rms", "worst"}) {
      fmt::print(" {} |", result[figure].is_null()
                              ? "-"
                              : fmt::format("{:.3f}", result[figure].get<double>()));
    }
    for (const json& row : result["rows"]) {
      fmt::print(" {} |", row.contains("mean") ? fmt::format("{:.3f}", row["mean"].get<double>())
                                               : "failed");
    }
    fmt::print("\n");
  }
}

int RunProgram(int argc, char** argv) {
  CLI::App program{"Why our void ratios differ from those of the seed paper's Table 3"};
  Options options;
  program.add_option("--variant", options.variants, "changes to try, by name; base: none");
  program.add_option("--base", options.base, "changes that hold for all variants");
  program.add_option("--rows", options.rows, "of the table, by their case")->capture_default_str();
  program.add_flag("--all-rows", options.all_rows, "all 18 rows of the table");
  program.add_option("--seeds", options.seeds, "particle seeds of each row")->capture_default_str();
  program.add_option("--particles", options.particles, "in a cell 10 mean diameters wide")
      ->capture_default_str();
  program.add_option("--parallel", options.parallel, "simulations at a time")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  program.add_option("--backend", options.backend, "embedded or liggghts")->capture_default_str();
  program.add_option("--keep", options.keep, "file of runs: those in it are not repeated");
  program.add_flag("--greedy", options.greedy, "then combine the changes that help most");
  program.add_flag("--json", options.as_json, "print JSON");
  CLI11_PARSE(program, argc, argv);
  const json report = Run(options);
  if (options.as_json) {
    fmt::print("{}\n", report.dump(1));
    return 0;
  }
  PrintTable(report["variants"]);
  if (options.greedy) PrintTable(report["greedy"]);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return Main(RunProgram, argc, argv); }

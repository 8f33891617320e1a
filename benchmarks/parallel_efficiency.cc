// How well optimizers keep workers busy: an event simulation in virtual time, where each worker
// that is free asks for a point and each evaluation takes a time of its own. Efficiency = work done
// / (workers · makespan). Nothing is slept through; the optimizer's own time counts nothing.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <queue>
#include <string>
#include <vector>

#include "core/errors.h"
#include "core/random.h"
#include "optimizers/designs/design.h"
#include "optimizers/optimizer.h"

namespace {

using namespace powdercal;
using json = nlohmann::ordered_json;

struct Options {
  int workers = 2;
  int evaluations = 400;
  int dimension = 4;
  double spread = 0;
  std::uint64_t seed = 1;
};

SearchSpace Box(int dimension) {
  SearchSpace space;
  for (int k = 0; k < dimension; ++k) {
    space.parameters.push_back({.name = fmt::format("x{}", k), .unit = "1"});
  }
  return space;
}

// The parameters themselves are observed and wanted at 0.3, or, of the second of two objectives, at
// 0.7.
Objectives Wanted(int dimension, int objectives) {
  Objectives wanted;
  if (objectives > 1) wanted.kind = Objectives::Kind::pareto;
  for (int k = 0; k < objectives * dimension; ++k) {
    wanted.targets.push_back({.response = fmt::format("y{}", k),
                              .unit = "1",
                              .value = k < dimension ? 0.3 : 0.7,
                              .sd = 0.1,
                              .objective = k / dimension});
  }
  return wanted;
}

struct Running {
  double end = 0;
  Candidate candidate;
  bool operator>(const Running& other) const {
    return end != other.end ? end > other.end : candidate.id > other.candidate.id;
  }
};

struct Outcome {
  int evaluations = 0;
  double efficiency = 0;
};

Outcome Simulate(Optimizer* optimizer, int objectives, const Options& options) {
  RandomStream random(options.seed);
  std::priority_queue<Running, std::vector<Running>, std::greater<>> running;
  double now = 0;
  double work = 0;
  int asked = 0;
  for (;;) {
    const int free = options.workers - static_cast<int>(running.size());
    for (int i = 0; i < free && asked < options.evaluations; ++i) {
      for (Candidate& candidate : optimizer->Ask(1)) {
        const double length = 1 + options.spread * random.Uniform(-1, 1);
        work += length;
        ++asked;
        running.push({now + length, std::move(candidate)});
      }
    }
    if (running.empty()) break;
    const Running done = running.top();
    running.pop();
    now = done.end;
    const Observation observation{.id = done.candidate.id,
                                  .point = done.candidate.point,
                                  .responses = done.candidate.point.replicate(objectives, 1)};
    optimizer->Tell(std::span(&observation, 1));
  }
  return {asked, asked > 0 ? work / (options.workers * now) : 0};
}

// NAME, or NAME with pagmo's implementation.
json Measure(const std::string& name, bool pagmo, const Options& options) {
  const SearchSpace space = Box(options.dimension);
  const std::unique_ptr<OptimizerFactory> factory = MakeOptimizerFactory(name);
  ReadYaml(pagmo ? "implementation: pagmo" : "{}", name,
           [&](Archive& archive) { factory->Serialize(archive, space); });
  for (const int objectives : {1, 2}) {
    const Objectives wanted = Wanted(options.dimension, objectives);
    const auto optimizer = factory->Make(space, wanted, options.seed);
    if (!optimizer->ExplainUnsupported(space, wanted).empty()) continue;
    const Outcome outcome = Simulate(optimizer.get(), objectives, options);
    return {{"objectives", objectives},
            {"evaluations", outcome.evaluations},
            {"efficiency", outcome.efficiency}};
  }
  return nullptr;
}

const std::vector<std::string> kOwnAndPagmo = {"cma_es", "differential_evolution", "genetic",
                                               "moead"};

}  // namespace

int main(int argc, char** argv) {
  CLI::App program{"Share of the workers' time that optimizers keep busy, in virtual time"};
  Options options;
  bool as_json = false;
  std::vector<std::string> names;
  program.add_option("--optimizer", names, "optimizers; all but `list` unless given");
  program.add_option("--workers", options.workers)->check(CLI::PositiveNumber);
  program.add_option("--evaluations", options.evaluations)->check(CLI::PositiveNumber);
  program.add_option("--parameters", options.dimension)->check(CLI::PositiveNumber);
  program.add_option("--spread", options.spread, "lengths are uniform in 1 ± SPREAD")
      ->check(CLI::Range(0.0, 0.99));
  program.add_option("--seed", options.seed);
  program.add_flag("--json", as_json, "print JSON");
  CLI11_PARSE(program, argc, argv);
  if (names.empty()) {
    for (const std::string& name : OptimizerNames()) {
      if (name != "list") names.push_back(name);
    }
  }
  json report = {{"workers", options.workers}, {"spread", options.spread}};
  try {
    for (const std::string& name : names) {
      const bool both = std::ranges::count(kOwnAndPagmo, name) > 0;
      for (const bool pagmo : {false, true}) {
        if (pagmo && !both) continue;
        const std::string label = pagmo ? name + ":implementation=pagmo" : name;
        const json& result = report["optimizers"][label] = Measure(name, pagmo, options);
        if (as_json || result.is_null()) continue;
        fmt::print("{:46} {:.3f} over {} evaluations\n", label, result["efficiency"].get<double>(),
                   result["evaluations"].get<int>());
      }
    }
  } catch (const InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
  if (as_json) fmt::print("{}\n", report.dump(2));
}

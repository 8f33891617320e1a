// Optimizers on problems with known answers (optimizers/test_problems.h), over many seeds. See
// docs/optimizers.md for the bars and docs/validation/optimizers.md for what was measured.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/errors.h"
#include "core/statistics.h"
#include "optimizers/optimizer_text.h"
#include "optimizers/test_problems.h"

namespace {

using namespace powdercal;
using json = nlohmann::ordered_json;

constexpr const char* kTable3 = POWDERCAL_SOURCE_DIR "/studies/library/hastelloy_x_table3.csv";

struct Options {
  std::vector<std::string> problems;
  std::vector<std::string> optimizers;
  int seeds = 20;
  int first_seed = 1;
  std::optional<int> evaluations;
  bool as_json = false;
};

struct Search {
  double measure = NAN;
  std::map<int, double> at;  // measure after so much cost, in evaluations at the target
  int evaluations = 0;
  double seconds_per_ask = 0;
  std::map<int, double> seconds_at;  // of one ask and tell with so many observations
};

std::vector<int> Checkpoints(int evaluations) {
  std::vector<int> result;
  for (const int count : {10, 20, 30, 50, 100, 200, 500, 1000, 2000}) {
    if (count < evaluations) result.push_back(count);
  }
  return result;
}

Search Run(const TestProblem& problem, Optimizer* optimizer, int evaluations, int seed) {
  using Clock = std::chrono::steady_clock;
  Search search;
  std::vector<Eigen::VectorXd> truth;
  std::vector<double> seconds;
  std::vector<double> costs;  // up to each evaluation
  double spent = 0;
  double telling = 0;
  while (spent < evaluations) {
    const auto begin = Clock::now();
    const std::vector<Candidate> candidates =
        optimizer->Ask(std::min(problem.batch, evaluations - static_cast<int>(spent)));
    const std::chrono::duration<double> asking = Clock::now() - begin;
    if (candidates.empty()) break;
    seconds.push_back((asking.count() + telling) / static_cast<double>(candidates.size()));
    std::vector<Observation> observations;
    for (const Candidate& candidate : candidates) {
      truth.push_back(candidate.fidelity < 1
                          ? Eigen::VectorXd()
                          : problem.respond(problem.space.FromUnit(candidate.point)));
      spent += CostOf(problem, candidate);
      costs.push_back(spent);
      observations.push_back(Observe(problem, candidate, static_cast<std::uint64_t>(seed)));
    }
    const auto told = Clock::now();
    optimizer->Tell(observations);
    telling = std::chrono::duration<double>(Clock::now() - told).count();
  }
  search.measure = problem.measure(truth);
  search.evaluations = static_cast<int>(truth.size());
  search.seconds_per_ask = Median(seconds);
  // Sums of tenths are a tenth off their value in the last digit.
  for (const int cost : Checkpoints(static_cast<int>(spent + 1e-9))) {
    const auto end = std::upper_bound(costs.begin(), costs.end(), cost + 1e-9);
    const auto count = static_cast<std::size_t>(end - costs.begin());
    search.seconds_at[cost] =
        seconds[std::min(count / static_cast<std::size_t>(problem.batch), seconds.size() - 1)];
    search.at[cost] = problem.measure(std::span(truth).first(count));
  }
  return search;
}

json Summary(const TestProblem& problem, const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {{"median", Median(values)},
          {"q25", Quantile(values, 0.25)},
          {"q75", Quantile(values, 0.75)},
          {"worst", problem.higher_is_better ? *low : *high}};
}

// One optimizer on one problem; null with a reason where it cannot treat it.
json Measure(const TestProblem& problem, const std::string& optimizer, const Options& options) {
  const std::unique_ptr<OptimizerFactory> factory =
      ParseOptimizer(optimizer, problem.space, &problem.initial_design);
  if (auto* fidelities = factory->fidelities()) *fidelities = problem.fidelities;
  std::vector<double> values;
  std::vector<double> seconds;
  std::map<int, std::vector<double>> at;
  std::map<int, std::vector<double>> seconds_at;
  int evaluations = 0;
  for (int i = 0; i < options.seeds; ++i) {
    const int seed = options.first_seed + i;
    const std::unique_ptr<Optimizer> made =
        factory->Make(problem.space, problem.objectives, static_cast<std::uint64_t>(seed));
    const std::string reason = made->ExplainUnsupported(problem.space, problem.objectives);
    if (!reason.empty()) return {{"unsupported", reason}};
    int budget = problem.evaluations;
    if (made->capabilities().noise && problem.modelled_evaluations > 0) {
      budget = problem.modelled_evaluations;
    }
    const Search search = Run(problem, made.get(), options.evaluations.value_or(budget), seed);
    values.push_back(search.measure);
    seconds.push_back(search.seconds_per_ask);
    for (const auto& [count, value] : search.at) at[count].push_back(value);
    for (const auto& [count, value] : search.seconds_at) seconds_at[count].push_back(value);
    evaluations = std::max(evaluations, search.evaluations);
  }
  json result = Summary(problem, values);
  result["seconds_per_ask"] = Median(seconds);
  result["evaluations"] = evaluations;
  result["seeds"] = options.seeds;
  for (const auto& [count, history] : at) {
    json& entry = result["at"][std::to_string(count)];
    entry = Summary(problem, history);
    entry["seconds_per_ask"] = Median(seconds_at.at(count));
  }
  result["values"] = values;
  return result;
}

json MeasureFailures(const TestProblem& problem, const std::string& optimizer,
                     const Options& options) {
  json result = Measure(problem, optimizer, options);
  if (result.contains("unsupported")) return result;
  const json without = Measure(MakeFailuresWithoutFailing(), optimizer, options);
  result["without_failures"] = without;
  result["cost_of_failures"] = result["median"].get<double>() / without["median"].get<double>() - 1;
  return result;
}

int Suite(const Options& options) {
  json report;
  for (const std::string& name : options.problems) {
    const TestProblem problem = MakeTestProblem(name, kTable3);
    report["measures"][name] = {{"description", problem.description},
                                {"measured", problem.measured},
                                {"higher_is_better", problem.higher_is_better}};
    for (const std::string& optimizer : options.optimizers) {
      const json result = name == "failures" ? MeasureFailures(problem, optimizer, options)
                                             : Measure(problem, optimizer, options);
      report["problems"][name][optimizer] = result;
      if (options.as_json) continue;
      if (result.contains("unsupported")) {
        fmt::print("{:20} {:32} cannot: {}\n", name, optimizer,
                   result["unsupported"].get<std::string>());
        continue;
      }
      fmt::print(
          "{:20} {:32} median {:<11.4g} quartiles {:.4g} … {:.4g}  worst {:.4g}  "
          "{:.2g} s per ask\n",
          name, optimizer, result["median"].get<double>(), result["q25"].get<double>(),
          result["q75"].get<double>(), result["worst"].get<double>(),
          result["seconds_per_ask"].get<double>());
      std::fflush(stdout);
    }
  }
  if (options.as_json) fmt::print("{}\n", report.dump(2));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program{"Optimizers on problems with known answers"};
  Options options;
  program.add_option("--problem", options.problems, "problems; all of them unless given");
  program.add_option("--optimizer", options.optimizers,
                     "NAME or NAME:KEY=VALUE,…; all that are not plain designs unless given");
  program.add_option("--seeds", options.seeds, "optimizer seeds")->check(CLI::PositiveNumber);
  program.add_option("--first-seed", options.first_seed, "the first of them");
  program.add_option("--evaluations", options.evaluations, "budget, instead of the problem's own")
      ->check(CLI::PositiveNumber);
  program.add_flag("--json", options.as_json, "print JSON");
  CLI11_PARSE(program, argc, argv);
  if (options.problems.empty()) {
    options.problems.assign(TestProblemNames().begin(), TestProblemNames().end());
  }
  if (options.optimizers.empty()) {
    for (const std::string& name : OptimizerNames()) {
      if (std::ranges::count(DesignNames(), name) == 0) options.optimizers.push_back(name);
    }
  }
  try {
    return Suite(options);
  } catch (const InputError& error) {
    std::cerr << "error: " << error.what() << '\n';
    return 2;
  }
}

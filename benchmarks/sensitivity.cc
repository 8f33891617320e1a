// Which experiment sees which parameter: derivatives of every response by ln k and by mu_r, in
// units of the response's standard deviation between particle seeds, at three points of the box.
// Central differences with the same particle seeds on both sides. See
// docs/validation/sensitivity.md.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "benchmarks/campaign.h"

namespace {

using namespace powdercal;
using namespace powdercal::benchmarks;
using nlohmann::json;

struct Point {
  const char* name;
  double cohesion;  // [J/m3]
  double rolling;   // [-]
};
constexpr Point kPoints[] = {
    {"weak cohesion", 2000, 0.15}, {"middle", 15'833, 0.25}, {"strong cohesion", 40'000, 0.45}};
constexpr double kLogStep = 0.25;      // of ln k, to both sides
constexpr double kRollingStep = 0.08;  // of mu_r, to both sides

// Responses at a point and at its four neighbours, in the order of these offsets.
constexpr double kOffsets[][2] = {{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}};

std::vector<Case> CasesOf(const Point& point, const std::string& experiment) {
  std::vector<Case> cases;
  for (const auto& [log_k, rolling] : kOffsets) {
    cases.push_back({.name = fmt::format("{} {}", experiment, point.name),
                     .experiment = experiment,
                     .parameters = {point.cohesion * std::exp(kLogStep * log_k),
                                    point.rolling + kRollingStep * rolling}});
  }
  return cases;
}

// Root mean square of the five standard deviations: the scatter of one run.
double PooledDeviation(std::span<const Sample> five, const std::string& response) {
  double sum = 0;
  int freedom = 0;
  for (const Sample& sample : five) {
    const auto found = sample.responses.find(response);
    if (found == sample.responses.end() || found->second.size() < 2) continue;
    const double sd = StandardDeviation(found->second);
    const int n = static_cast<int>(found->second.size()) - 1;
    sum += n * sd * sd;
    freedom += n;
  }
  return freedom > 0 ? std::sqrt(sum / freedom) : 0;
}

json Derivative(const Sample& above, const Sample& below, const std::string& response,
                double distance, double sd) {
  if (!above.responses.contains(response) || !below.responses.contains(response)) return nullptr;
  const std::vector<double>& up = above.responses.at(response);
  const std::vector<double>& down = below.responses.at(response);
  const double slope = (Mean(up) - Mean(down)) / distance;
  const double error =
      sd *
      std::sqrt(1.0 / static_cast<double>(up.size()) + 1.0 / static_cast<double>(down.size())) /
      distance;
  return {{"value", slope},
          {"in_seed_sds", sd > 0 ? json(slope / sd) : json(nullptr)},
          {"error_in_seed_sds", sd > 0 ? json(error / sd) : json(nullptr)}};
}

json Reduce(std::span<const Sample> five) {
  json responses = json::object();
  for (const auto& [name, values] : five[0].responses) {
    const double sd = PooledDeviation(five, name);
    responses[name] = {{"mean", Mean(values)},
                       {"seed_sd", sd},
                       {"by_ln_k", Derivative(five[1], five[2], name, 2 * kLogStep, sd)},
                       {"by_mu_r", Derivative(five[3], five[4], name, 2 * kRollingStep, sd)}};
  }
  json outcomes = json::array();
  for (const Sample& sample : five) outcomes.push_back(sample.outcomes);
  return {{"responses", responses}, {"outcomes", outcomes}};
}

void PrintTable(const json& report) {
  fmt::print("{:45}", "response");
  for (const Point& point : kPoints) fmt::print(" {:>26}", point.name);
  fmt::print("\n{:45}", "");
  for ([[maybe_unused]] const Point& point : kPoints)
    fmt::print(" {:>12} {:>13}", "d/d ln k", "d/d mu_r");
  fmt::print("\n");
  const auto cell = [](const json& derivative) {
    if (derivative.is_null() || derivative["in_seed_sds"].is_null()) return std::string("-");
    return fmt::format("{:.1f}±{:.1f}", derivative["in_seed_sds"].get<double>(),
                       derivative["error_in_seed_sds"].get<double>());
  };
  for (const auto& [experiment, points] : report["experiments"].items()) {
    for (const auto& [response, ignored] : points[1]["responses"].items()) {
      fmt::print("{:45}", experiment + "." + response);
      for (const json& point : points) {
        const json& entry = point["responses"].value(response, json());
        if (entry.is_null()) {
          fmt::print(" {:>12} {:>13}", "-", "-");
        } else {
          fmt::print(" {:>12} {:>13}", cell(entry["by_ln_k"]), cell(entry["by_mu_r"]));
        }
      }
      fmt::print("\n");
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program{"Sensitivity of every response to k and mu_r, in seed standard deviations"};
  CampaignOptions options{.seeds = 4};
  std::vector<std::string> experiments = {"angle_of_repose", "consolidation", "shear", "spreading"};
  bool as_json = false;
  program.add_option("--seeds", options.seeds, "particle seeds of each case")
      ->capture_default_str();
  program.add_option("--parallel", options.parallel, "simulations at a time")
      ->capture_default_str();
  program.add_option("--experiments", experiments, "of the study hastelloy_x_joint_soft");
  program.add_flag("--json", as_json, "print JSON");
  CLI11_PARSE(program, argc, argv);
  std::vector<Case> cases;
  for (const std::string& experiment : experiments) {
    for (const Point& point : kPoints) {
      for (Case& item : CasesOf(point, experiment)) cases.push_back(std::move(item));
    }
  }
  const std::vector<Sample> samples = RunCampaign(cases, options);
  json report = {{"study", options.study},
                 {"seeds", options.seeds},
                 {"steps", {{"ln_k", kLogStep}, {"mu_r", kRollingStep}}}};
  std::span<const Sample> rest = samples;
  for (const std::string& experiment : experiments) {
    for (const Point& point : kPoints) {
      json entry = Reduce(rest.first(std::size(kOffsets)));
      entry["point"] = {{"name", point.name}, {"k", point.cohesion}, {"mu_r", point.rolling}};
      report["experiments"][experiment].push_back(std::move(entry));
      rest = rest.subspan(std::size(kOffsets));
    }
  }
  if (as_json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    PrintTable(report);
  }
}

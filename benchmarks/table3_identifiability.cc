// What one void ratio says of k and mu_r on the paper's Table 3: a regression through its 18
// points, the line on which the target is met, slopes and standard deviations at the paper's
// choice, and Sobol' total indices over the box. See docs/validation/paper.md.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "benchmarks/run_program.h"
#include "core/table.h"
#include "optimizers/designs/design.h"
#include "studies/surrogate_comparison.h"
#include "surrogates/surrogate.h"

namespace {

using namespace powdercal;
using nlohmann::json;

constexpr const char* kTable = POWDERCAL_SOURCE_DIR "/studies/library/hastelloy_x_table3.csv";
constexpr double kCohesion = 47'500;  // [J/m3] the paper's choice
constexpr double kRolling = 0.5;

struct Options {
  std::string surrogate = "gaussian_process";
  double target = 0.783;
  double sd = 0.01;
  bool as_json = false;
};

// Over k and mu_r, on the box that the table's rows fill: the paper's.
class VoidRatio {
 public:
  explicit VoidRatio(const std::string& surrogate) : surrogate_(MakeSurrogate(surrogate)) {
    const KnownEvaluations known = EvaluationsOf(Table::ReadCsv(kTable), {}, {});
    space_ = known.space;
    surrogate_->Fit(known.responses[0].points, known.responses[0].values, {});
  }

  const Parameter& k() const { return space_.parameters[0]; }
  const Parameter& mu_r() const { return space_.parameters[1]; }

  double AtBox(double x, double y) const { return surrogate_->Predict(Eigen::Vector2d(x, y)).mean; }
  double At(double k, double mu_r) const {
    return surrogate_->Predict(space_.ToUnit(Eigen::Vector2d(k, mu_r))).mean;
  }
  std::string Describe() const { return surrogate_->Describe(); }

  // The least k at which e reaches the target; NaN where it never does.
  double KAt(double mu_r, double target) const {
    constexpr int kSteps = 2000;
    double before = At(k().lower, mu_r);
    const double width = (k().upper - k().lower) / kSteps;
    for (int i = 1; i <= kSteps; ++i) {
      const double cohesion = k().lower + i * width;
      const double e = At(cohesion, mu_r);
      if (before < target && e >= target) return cohesion - width * (e - target) / (e - before);
      before = e;
    }
    return NAN;
  }

 private:
  SearchSpace space_;
  std::unique_ptr<Surrogate> surrogate_;
};

// Total indices by the estimator of Jansen (1999): the mean square of what changes when one input
// alone is drawn anew, over twice the variance.
json TotalIndices(const VoidRatio& e) {
  constexpr int kSamples = 8192;
  const Eigen::MatrixXd points = SobolPoints(kSamples, 4, 1);
  double mean = 0;
  double square = 0;
  double change[2] = {0, 0};
  for (Eigen::Index i = 0; i < kSamples; ++i) {
    const double a = e.AtBox(points(i, 0), points(i, 1));
    mean += a / kSamples;
    square += a * a / kSamples;
    change[0] += std::pow(a - e.AtBox(points(i, 2), points(i, 1)), 2) / (2 * kSamples);
    change[1] += std::pow(a - e.AtBox(points(i, 0), points(i, 3)), 2) / (2 * kSamples);
  }
  const double variance = square - mean * mean;
  return {{"k", change[0] / variance}, {"mu_r", change[1] / variance}};
}

json Examine(const Options& options) {
  const VoidRatio e(options.surrogate);
  json line = json::array();
  double least = HUGE_VAL;
  double most = -HUGE_VAL;
  for (int i = 0; i <= 13; ++i) {
    const double mu_r = e.mu_r().lower + i * (e.mu_r().upper - e.mu_r().lower) / 13;
    const double k = e.KAt(mu_r, options.target);
    line.push_back({{"mu_r", mu_r}, {"k", std::isfinite(k) ? json(k) : json()}});
    if (!std::isfinite(k)) continue;
    least = std::min(least, k);
    most = std::max(most, k);
  }
  const double dk = 100;
  const double dmu = 0.01;
  const double by_k = (e.At(kCohesion + dk, kRolling) - e.At(kCohesion - dk, kRolling)) / (2 * dk);
  const double by_mu =
      (e.At(kCohesion, kRolling + dmu) - e.At(kCohesion, kRolling - dmu)) / (2 * dmu);
  json report = {{"surrogate", options.surrogate}, {"fit", e.Describe()},
                 {"target", options.target},       {"sd", options.sd},
                 {"line", std::move(line)},        {"total_indices", TotalIndices(e)}};
  report["k_on_line"] = least <= most ? json{least, most} : json();
  report["choice"] = {
      {"k", kCohesion},
      {"mu_r", kRolling},
      {"e", e.At(kCohesion, kRolling)},
      {"de_dk", by_k},
      {"de_dmu_r", by_mu},
      {"sd_k_at_that_mu_r", by_k != 0 ? json(options.sd / std::abs(by_k)) : json()},
      {"sd_mu_r_at_that_k", by_mu != 0 ? json(options.sd / std::abs(by_mu)) : json()}};
  return report;
}

std::string OrNoLimit(const json& sd) {
  return sd.is_null() ? "no limit" : fmt::format("{:.3g}", sd.get<double>());
}

void Print(const json& report) {
  const json& choice = report["choice"];
  fmt::print("{}\n", report["fit"].get<std::string>());
  for (const json& point : report["line"]) {
    fmt::print("e = {} at mu_r = {:.3f}: k = {} J/m3\n", report["target"].dump(),
               point["mu_r"].get<double>(),
               point["k"].is_null() ? "nowhere" : fmt::format("{:.0f}", point["k"].get<double>()));
  }
  fmt::print("at the paper's choice: de/dk = {:.3g} m3/J, de/dmu_r = {:.3g}\n",
             choice["de_dk"].get<double>(), choice["de_dmu_r"].get<double>());
  fmt::print(
      "an sd of e of {} is one of k of {} J/m3 with mu_r known, of mu_r of {} with k known\n",
      report["sd"].dump(), OrNoLimit(choice["sd_k_at_that_mu_r"]),
      OrNoLimit(choice["sd_mu_r_at_that_k"]));
  fmt::print("Sobol' total indices: k {:.4f}, mu_r {:.4f}\n",
             report["total_indices"]["k"].get<double>(),
             report["total_indices"]["mu_r"].get<double>());
}

int RunProgram(int argc, char** argv) {
  CLI::App program{"What one void ratio says of k and mu_r on the paper's Table 3"};
  Options options;
  program.add_option("--surrogate", options.surrogate, "regression through the 18 points")
      ->capture_default_str();
  program.add_option("--target", options.target, "void ratio [-]")->capture_default_str();
  program.add_option("--sd", options.sd, "of the target [-]")->capture_default_str();
  program.add_flag("--json", options.as_json, "print JSON");
  CLI11_PARSE(program, argc, argv);
  const json report = Examine(options);
  if (options.as_json) {
    fmt::print("{}\n", report.dump(1));
  } else {
    Print(report);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return benchmarks::Main(RunProgram, argc, argv); }

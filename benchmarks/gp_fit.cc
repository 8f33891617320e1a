// Cost and quality of the Gaussian process: seconds for a fit of a smooth function of 6 inputs with
// small noise, leave-one-out R² on the paper's Table 3, and the error of analytic gradients against
// central differences.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/random.h"
#include "core/table.h"
#include "studies/surrogate_comparison.h"
#include "surrogates/gaussian_process.h"
#include "surrogates/validation.h"

namespace powdercal {
namespace {

constexpr int kDimension = 6;
constexpr double kNoise = 0.01;  // standard deviation; the function itself has about 0.8

struct Data {
  Eigen::MatrixXd points;
  Eigen::VectorXd values;
};

Data SmoothData(int count, std::uint64_t seed) {
  RandomStream random(seed);
  Data data{Eigen::MatrixXd(count, kDimension), Eigen::VectorXd(count)};
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < kDimension; ++k) data.points(i, k) = random.Uniform();
    const auto x = data.points.row(i);
    data.values[i] = std::sin(3 * x[0]) + std::cos(4 * x[1] + x[2]) + x[2] * x[3] +
                     0.5 * x[4] * x[4] + 0.1 * x[5] + kNoise * random.Normal();
  }
  return data;
}

struct Timing {
  double median_s = 0;
  double evaluations = 0;
};

Timing FitSeconds(int count, int repeats) {
  std::vector<double> seconds;
  Timing timing;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const Data data = SmoothData(count, 1000 + static_cast<std::uint64_t>(repeat));
    GaussianProcess process;
    const auto begin = std::chrono::steady_clock::now();
    process.Fit(data.points, data.values, {});
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    seconds.push_back(elapsed.count());
    timing.evaluations += static_cast<double>(process.evaluations()) / repeats;
  }
  std::sort(seconds.begin(), seconds.end());
  timing.median_s = seconds[seconds.size() / 2];
  return timing;
}

Data Table3(const std::string& path) {
  const KnownEvaluations known = EvaluationsOf(Table::ReadCsv(path), {}, {});
  return {known.responses[0].points, known.responses[0].values};
}

// Largest difference to central differences, relative to the largest component of the gradient.
template <typename Function>
double GradientError(const Function& function, const Eigen::VectorXd& at,
                     const Eigen::VectorXd& gradient) {
  constexpr double kStep = 1e-5;
  double error = 0;
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    Eigen::VectorXd moved = at;
    moved[i] = at[i] + kStep;
    const double above = function(moved);
    moved[i] = at[i] - kStep;
    error = std::max(error, std::abs((above - function(moved)) / (2 * kStep) - gradient[i]));
  }
  return error / gradient.cwiseAbs().maxCoeff();
}

nlohmann::json GradientErrors(Kernel kernel) {
  const Data data = SmoothData(40, 7);
  GaussianProcess::Options options;
  options.model.kernel = kernel;
  GaussianProcess process(options);
  process.Fit(data.points, data.values, {});
  const Eigen::VectorXd standardised = data.values.array() - data.values.mean();
  const MarginalPosterior posterior(options.model, data.points, standardised,
                                    Eigen::VectorXd::Zero(40));
  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(posterior.size(), -0.5, -4);
  double value = 0;
  Eigen::VectorXd gradient;
  posterior.Evaluate(t, &value, &gradient);
  const auto density = [&](const Eigen::VectorXd& at) {
    double result = 0;
    posterior.Evaluate(at, &result, nullptr);
    return result;
  };
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(kDimension, 0.3, 0.6);
  Eigen::VectorXd mean;
  Eigen::VectorXd variance;
  process.PredictWithGradient(x, &mean, &variance);
  return {
      {"posterior", GradientError(density, t, gradient)},
      {"mean", GradientError([&](const auto& at) { return process.Predict(at).mean; }, x, mean)},
      {"variance",
       GradientError([&](const auto& at) { return process.Predict(at).variance; }, x, variance)},
  };
}

double TableR2(const Data& table, Kernel kernel) {
  GaussianProcess::Options options;
  options.model.kernel = kernel;
  return LeaveOneOut([&] { return std::make_unique<GaussianProcess>(options); }, table.points,
                     table.values)
      .r2;
}

}  // namespace
}  // namespace powdercal

int main(int argc, char** argv) {
  CLI::App app("Speed and accuracy of the Gaussian process");
  bool as_json = false;
  int repeats = 15;
  std::string table_path =
      std::string(POWDERCAL_SOURCE_DIR) + "/studies/library/hastelloy_x_table3.csv";
  app.add_flag("--json", as_json, "Print JSON");
  app.add_option("--repeats", repeats, "Fits for each median")->check(CLI::Range(1, 1000));
  app.add_option("--table", table_path, "Table 3 as a CSV file");
  CLI11_PARSE(app, argc, argv);
  try {
    using powdercal::Kernel;
    nlohmann::json result;
    for (const int count : {50, 100, 200, 400}) {
      const powdercal::Timing timing = powdercal::FitSeconds(count, repeats);
      result["fit_d6"][fmt::format("n{}", count)] = {{"median_s", timing.median_s},
                                                     {"mean_evaluations", timing.evaluations}};
    }
    const powdercal::Data table = powdercal::Table3(table_path);
    result["table3_loo_r2"] = {{"matern52", powdercal::TableR2(table, Kernel::matern52)},
                               {"rbf", powdercal::TableR2(table, Kernel::rbf)}};
    result["gradient_relative_error"] = {{"matern52", powdercal::GradientErrors(Kernel::matern52)},
                                         {"rbf", powdercal::GradientErrors(Kernel::rbf)}};
    result["repeats"] = repeats;
    if (as_json) {
      std::cout << result.dump(2) << '\n';
    } else {
      const nlohmann::json flat = result.flatten();
      for (const auto& [name, value] : flat.items()) {
        std::cout << name.substr(1) << "  " << value << '\n';
      }
    }
  } catch (const std::exception& error) {
    std::cerr << "gp_fit: " << error.what() << '\n';
    return 2;
  }
  return 0;
}

#include "benchmarks/campaign.h"

#include <fmt/format.h>
#include <unistd.h>

#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "studies/executor.h"
#include "studies/planner.h"

namespace powdercal::benchmarks {
namespace {

namespace fs = std::filesystem;

struct Prepared {
  std::unique_ptr<Study> study;
  std::unique_ptr<Planner> planner;
  std::size_t experiment = 0;
};

Prepared Prepare(const Case& item, const CampaignOptions& options) {
  Prepared prepared;
  prepared.study = std::make_unique<Study>(LoadShipped(options.study, item.overrides));
  prepared.planner = std::make_unique<Planner>(*prepared.study);
  prepared.experiment = IndexOf(*prepared.study, item.experiment);
  return prepared;
}

void Add(const LedgerRun& run, Sample& sample) {
  ++sample.outcomes[ToString(run.outcome.reason)];
  if (!run.outcome.ok()) {
    sample.failures.push_back(run.outcome.message);
    return;
  }
  for (const auto& [name, response] : run.measurement.responses) {
    sample.responses[name].push_back(response.value);
  }
  for (const auto& [name, value] : run.measurement.diagnostics) {
    sample.diagnostics[name].push_back(value);
  }
  sample.diagnostics["simulator_seconds"].push_back(run.diagnostics.wall_seconds);
  sample.diagnostics["steps"].push_back(static_cast<double>(run.diagnostics.steps));
}

}  // namespace

Study LoadShipped(const std::string& name, const Overrides& overrides) {
  return Study::Load(fmt::format("{}/studies/library/{}.yaml", POWDERCAL_SOURCE_DIR, name),
                     overrides);
}

std::size_t IndexOf(const Study& study, const std::string& experiment) {
  for (std::size_t i = 0; i < study.experiments.size(); ++i) {
    if (study.experiments[i].name() == experiment) return i;
  }
  throw std::invalid_argument(
      fmt::format("study '{}' has no experiment '{}'", study.name, experiment));
}

std::string SectionOf(const Study& study, const std::string& experiment) {
  return fmt::format("experiments[{}].{}", IndexOf(study, experiment), experiment);
}

std::vector<Sample> RunCampaign(std::span<const Case> cases, const CampaignOptions& options) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("campaign-{}", getpid());
  std::vector<Prepared> prepared;
  for (const Case& item : cases) prepared.push_back(Prepare(item, options));
  LocalExecutor executor(options.parallel);
  std::vector<Sample> samples(cases.size());
  const auto seeds = static_cast<std::size_t>(options.seeds);
  for (std::size_t job = 0; job < cases.size() * seeds; ++job) {
    const Prepared& setting = prepared[job / seeds];
    const auto seed = static_cast<std::uint64_t>(options.first_seed) + job % seeds;
    executor.Submit(static_cast<std::int64_t>(job),
                    [&setting, &options, seed, parameters = cases[job / seeds].parameters,
                     work = folder / std::to_string(job)](std::stop_token stop) {
                      const PlannedRun run =
                          setting.planner->PlanExperiment(setting.experiment, parameters, 0, seed);
                      return setting.planner->Execute(
                          run, {.work_folder = work,
                                .time_limit = std::chrono::duration<double>(options.time_limit),
                                .stop = std::move(stop)});
                    });
  }
  for (std::size_t done = 0; done < cases.size() * seeds;) {
    const auto finished = executor.Wait(std::chrono::seconds(1));
    if (!finished) continue;
    const auto job = static_cast<std::size_t>(finished->ticket);
    Add(finished->run, samples[job / seeds]);
    ++done;
    fmt::print(stderr, "{}/{} {}: {} in {:.1f} s\n", done, cases.size() * seeds,
               cases[job / seeds].name, ToString(finished->run.outcome.reason),
               finished->run.total_seconds);
  }
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  return samples;
}

Difference Welch(const std::vector<double>& a, const std::vector<double>& b) {
  const auto n = static_cast<double>(a.size());
  const auto m = static_cast<double>(b.size());
  const double va = std::pow(StandardDeviation(a), 2) / n;
  const double vb = std::pow(StandardDeviation(b), 2) / m;
  Difference difference{.value = Mean(a) - Mean(b)};
  if (va + vb <= 0) return difference;
  const double freedom = (va + vb) * (va + vb) / (va * va / (n - 1) + vb * vb / (m - 1));
  const boost::math::students_t distribution(freedom);
  difference.half_width = boost::math::quantile(distribution, 0.975) * std::sqrt(va + vb);
  return difference;
}

nlohmann::json Statistics(const std::vector<double>& values) {
  if (values.empty()) return nullptr;
  return {{"mean", Mean(values)}, {"sd", StandardDeviation(values)}, {"n", values.size()}};
}

nlohmann::json ToJson(const Sample& sample) {
  nlohmann::json json = {{"outcomes", sample.outcomes},
                         {"failures", sample.failures},
                         {"responses", nlohmann::json::object()},
                         {"diagnostics", nlohmann::json::object()}};
  for (const auto& [name, values] : sample.responses) json["responses"][name] = Statistics(values);
  for (const auto& [name, values] : sample.diagnostics) {
    json["diagnostics"][name] = Statistics(values);
  }
  return json;
}

}  // namespace powdercal::benchmarks

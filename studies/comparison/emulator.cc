#include "studies/comparison/emulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/hash.h"
#include "core/statistics.h"
#include "optimizers/models.h"
#include "studies/evaluation.h"

namespace powdercal::comparison {
namespace {

// Fewer say nothing of how the time of a simulation goes with the parameters.
constexpr int kFewestTimes = 5;

std::vector<const LedgerRun*> Pointers(const std::vector<LedgerRun>& runs) {
  std::vector<const LedgerRun*> pointers;
  for (const LedgerRun& run : runs) pointers.push_back(&run);
  return pointers;
}

std::vector<ReducedResponses> ReduceAll(const Objectives& objectives,
                                        const std::vector<KnownPoint>& points) {
  std::vector<ReducedResponses> reduced;
  for (const KnownPoint& point : points) {
    reduced.push_back(Reduce(objectives, Pointers(point.runs)));
  }
  return reduced;
}

struct Rows {
  Eigen::MatrixXd points;
  Eigen::VectorXd values;
  Eigen::VectorXd variances;

  Rows(std::size_t count, Eigen::Index dimension)
      : points(static_cast<Eigen::Index>(count), dimension),
        values(Eigen::VectorXd::Zero(points.rows())),
        variances(Eigen::VectorXd::Zero(points.rows())) {}
};

GaussianProcess Fit(const SearchSpace& space, const Rows& rows) {
  GaussianProcess::Options options{.inputs = InputsOf(space)};
  // A response that does not change at all has no scale to be learned.
  if (rows.values.maxCoeff() == rows.values.minCoeff()) options.model.signal_variance = 1;
  GaussianProcess process(options);
  process.Fit(rows.points, rows.values, rows.variances);
  return process;
}

RandomStream StreamOf(const RandomStream& world, std::size_t experiment,
                      const Eigen::VectorXd& point, int replicate) {
  RandomStream stream = world.Split("emulator").Split(static_cast<std::uint64_t>(experiment));
  for (const double u : point) stream = stream.Split(std::bit_cast<std::uint64_t>(u));
  return stream.Split(static_cast<std::uint64_t>(replicate));
}

std::string FingerprintOf(const Objectives& objectives, const std::vector<KnownPoint>& points) {
  std::string text = "emulator 1";
  for (const Target& target : objectives.targets) text += "\n" + target.response;
  for (const KnownPoint& point : points) {
    text += "\n";
    for (const double u : point.point) text += fmt::format("{} ", u);
    for (const LedgerRun& run : point.runs) {
      text += fmt::format("\n{} {} {}", run.key, ToString(run.outcome.reason),
                          run.diagnostics.wall_seconds);
      for (const auto& [name, response] : run.measurement.responses) {
        text += fmt::format(" {} {}", name, response.value);
      }
    }
  }
  return Sha256(text);
}

}  // namespace

Emulator::Emulator(const Study& study, const std::vector<KnownPoint>& points)
    : space_(study.space),
      objectives_(study.MakeObjectives()),
      backend_(study.backend.backend->name()),
      fingerprint_(FingerprintOf(objectives_, points)),
      points_(static_cast<int>(points.size())) {
  for (const KnownPoint& point : points) {
    runs_ += static_cast<int>(point.runs.size());
    failed_runs_ +=
        static_cast<int>(std::count_if(point.runs.begin(), point.runs.end(),
                                       [](const LedgerRun& run) { return !run.outcome.ok(); }));
  }
  for (const Target& target : objectives_.targets) FitResponse(target, points);
  for (const std::size_t i : study.CalibratedExperiments()) {
    Test test = FitTest(study.experiments[i].name(), points);
    for (std::size_t t = 0; t < objectives_.targets.size(); ++t) {
      if (objectives_.targets[t].response.starts_with(test.name + ".")) test.targets.push_back(t);
    }
    tests_.emplace(i, std::move(test));
  }
  Warn();
}

void Emulator::FitResponse(const Target& target, const std::vector<KnownPoint>& points) {
  const auto t = static_cast<Eigen::Index>(responses_.size());
  const std::vector<ReducedResponses> reduced = ReduceAll(objectives_, points);
  const Eigen::VectorXd pooled =
      PooledSeedVariance(reduced, static_cast<int>(objectives_.targets.size()));
  std::vector<std::size_t> with_value;
  bool replicated = false;
  for (std::size_t i = 0; i < reduced.size(); ++i) {
    if (reduced[i].counts[t] > 0) with_value.push_back(i);
    replicated = replicated || reduced[i].counts[t] > 1;
  }
  if (static_cast<int>(with_value.size()) < kFewestPoints) {
    throw InputError(
        fmt::format("an emulator needs {} evaluations with a value of {} at least, "
                    "and there are {}; simulate more with --design",
                    kFewestPoints, target.response, with_value.size()));
  }
  Rows rows(with_value.size(), points.front().point.size());
  for (Eigen::Index r = 0; r < rows.points.rows(); ++r) {
    const std::size_t i = with_value[static_cast<std::size_t>(r)];
    rows.points.row(r) = points[i].point;
    rows.values[r] = reduced[i].means[t];
    rows.variances[r] = pooled[t] / reduced[i].counts[t];
  }
  Response response{.name = target.response.substr(target.response.find('.') + 1),
                    .process = Fit(space_, rows)};
  Eigen::VectorXd means(rows.values.size());
  Eigen::VectorXd variances(rows.values.size());
  response.process.LeaveOneOut(&means, &variances);
  const double residuals = (rows.values - means).squaredNorm();
  const double spread = (rows.values.array() - rows.values.mean()).square().sum();
  const double rms = std::sqrt(residuals / static_cast<double>(means.size()));
  response.seed_sd = replicated ? std::sqrt(pooled[t]) : rms;
  quality_.push_back({.response = target.response,
                      .unit = target.unit,
                      .points = static_cast<int>(with_value.size()),
                      .leave_one_out_r2 = 1 - residuals / spread,  // NaN: 0/0
                      .seed_sd = response.seed_sd,
                      .from_replicates = replicated,
                      .share_of_sd = rms / target.sd});
  responses_.push_back(std::move(response));
}

Emulator::Test Emulator::FitTest(const std::string& name,
                                 const std::vector<KnownPoint>& points) const {
  Test test{.name = name};
  std::vector<std::pair<const KnownPoint*, double>> times;  // mean of those that succeeded
  std::vector<double> succeeded, failed;
  std::vector<std::pair<const KnownPoint*, double>> shares;
  for (const KnownPoint& point : points) {
    std::vector<double> here;
    int count = 0;
    for (const LedgerRun& run : point.runs) {
      if (run.experiment != name) continue;
      ++count;
      if (run.outcome.ok()) {
        here.push_back(run.diagnostics.wall_seconds);
      } else {
        failed.push_back(run.diagnostics.wall_seconds);
        test.failure = run.outcome.message;
      }
    }
    if (count == 0) continue;
    shares.emplace_back(&point, static_cast<double>(here.size()) / count);
    succeeded.insert(succeeded.end(), here.begin(), here.end());
    if (!here.empty() && Mean(here) > 0) times.emplace_back(&point, Mean(here));
  }
  test.median_seconds = succeeded.empty() ? 0 : Median(succeeded);
  test.failed_seconds = failed.empty() ? test.median_seconds : Median(failed);
  const Eigen::Index dimension = points.front().point.size();
  Rows known(shares.size(), dimension);
  for (Eigen::Index i = 0; i < known.points.rows(); ++i) {
    known.points.row(i) = shares[static_cast<std::size_t>(i)].first->point;
    known.values[i] = shares[static_cast<std::size_t>(i)].second;
  }
  test.feasibility.emplace(known.points, known.values);
  if (static_cast<int>(times.size()) < kFewestTimes) return test;
  Rows rows(times.size(), dimension);
  for (Eigen::Index i = 0; i < rows.points.rows(); ++i) {
    rows.points.row(i) = times[static_cast<std::size_t>(i)].first->point;
    rows.values[i] = std::log(times[static_cast<std::size_t>(i)].second);
  }
  test.log_seconds = Fit(space_, rows);
  return test;
}

void Emulator::Warn() {
  for (const Quality& one : quality_) {
    if (one.leave_one_out_r2 < kPoorR2) {
      warnings_.push_back(fmt::format(
          "{} is emulated poorly: leave-one-out R² {:.2f} from {} points, off by {:.2g} standard "
          "deviations of the observation; the comparison is one on the emulator, and says less of "
          "the simulator",
          one.response, one.leave_one_out_r2, one.points, one.share_of_sd));
    }
    if (!one.from_replicates) {
      warnings_.push_back(fmt::format(
          "{}: no point has several particle seeds; what cannot be predicted from the other points "
          "is taken for their scatter, standard deviation {:.2g}",
          one.response, one.seed_sd));
    }
  }
}

Eigen::VectorXd Emulator::Truth(const Eigen::VectorXd& point) const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(responses_.size()));
  for (std::size_t t = 0; t < responses_.size(); ++t) {
    values[static_cast<Eigen::Index>(t)] = responses_[t].process.Predict(point).mean;
  }
  return values;
}

LedgerRun Emulator::Simulate(std::size_t experiment, const Eigen::VectorXd& point, int replicate,
                             const RandomStream& world) const {
  const Test& test = tests_.at(experiment);
  RandomStream random = StreamOf(world, experiment, point, replicate);
  LedgerRun run{.experiment = test.name, .seed = random.seed(), .backend = backend_};
  const double success = std::exp(test.feasibility->LogProbability(point, nullptr));
  if (random.Uniform() >= success) {
    run.outcome = {Reason::crashed, test.failure};
    run.diagnostics.wall_seconds = test.failed_seconds;
  } else {
    run.diagnostics.wall_seconds =
        test.log_seconds ? std::exp(test.log_seconds->Predict(point).mean) : test.median_seconds;
    for (const std::size_t t : test.targets) {
      const Response& response = responses_[t];
      run.measurement.responses[response.name].value =
          response.process.Predict(point).mean + response.seed_sd * random.Normal();
    }
  }
  run.total_seconds = run.diagnostics.wall_seconds;
  return run;
}

}  // namespace powdercal::comparison

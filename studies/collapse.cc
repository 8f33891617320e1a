#include "studies/collapse.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/random.h"
#include "core/statistics.h"
#include "scaling/modes.h"

namespace powdercal {
namespace {

// Groups that distinguish the modes; the others are constant or follow from these.
constexpr const char* kGroups[] = {"sigma/E", "sigma/(rho_b g h)", "F_c/(sigma d^2)",
                                   "Bo",      "rho g d/E",         "delta_0/d"};

const std::vector<double>* ValuesOf(const CollapsePoint& point, const std::string& response) {
  const auto found = point.responses.find(response);
  return found == point.responses.end() || found->second.empty() ? nullptr : &found->second;
}

// Every experiment with each of its responses that some point has.
std::set<std::pair<std::size_t, std::string>> ResponsesOf(
    const std::vector<CollapsePoint>& points) {
  std::set<std::pair<std::size_t, std::string>> all;
  for (const CollapsePoint& point : points) {
    for (const auto& [response, values] : point.responses) all.emplace(point.experiment, response);
  }
  return all;
}

// Between seeds, pooled over the points of an experiment.
double PooledSd(const std::vector<CollapsePoint>& points, std::size_t experiment,
                const std::string& response) {
  double squares = 0;
  double freedom = 0;
  for (const CollapsePoint& point : points) {
    const std::vector<double>* values = ValuesOf(point, response);
    if (point.experiment != experiment || values == nullptr) continue;
    squares += SquaresAboutMean(*values);
    freedom += static_cast<double>(values->size()) - 1;
  }
  return freedom > 0 ? std::sqrt(squares / freedom) : 0;
}

// Of the inner points about the straight line between their neighbours; for values without any
// order it is their variance, for a smooth curve nearly zero.
double NeighbourVariance(const std::vector<std::pair<double, double>>& xy) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < xy.size(); ++i) {
    const double span = xy[i + 1].first - xy[i - 1].first;
    const double w = span > 0 ? (xy[i].first - xy[i - 1].first) / span : 0.5;
    const double residual = xy[i].second - (1 - w) * xy[i - 1].second - w * xy[i + 1].second;
    sum += residual * residual / (1 + (1 - w) * (1 - w) + w * w);
  }
  return sum / static_cast<double>(xy.size() - 2);
}

// Least squares of y = a + b x, with the standard error of b.
void FitLine(const std::vector<std::pair<double, double>>& xy, GroupTrend* trend) {
  const auto n = static_cast<double>(xy.size());
  double mean_x = 0;
  double mean_y = 0;
  for (const auto& [x, y] : xy) {
    mean_x += x / n;
    mean_y += y / n;
  }
  double xx = 0;
  double cross = 0;
  double yy = 0;
  for (const auto& [x, y] : xy) {
    xx += (x - mean_x) * (x - mean_x);
    cross += (x - mean_x) * (y - mean_y);
    yy += (y - mean_y) * (y - mean_y);
  }
  trend->slope = cross / xx;
  trend->slope_error = n > 2 ? std::sqrt(std::max(0.0, yy - trend->slope * cross) / (n - 2) / xx)
                             : std::numeric_limits<double>::infinity();
  trend->collapse = yy > 0 ? 1 - NeighbourVariance(xy) / (yy / (n - 1)) : 0;
}

}  // namespace

Collapse::Collapse(const Study& study, CollapseOptions options)
    : study_(study), options_(std::move(options)) {
  for (const double kappa : options_.kappas) {
    auto scaling = MakeScaling("rigid_limit");
    ReadYaml(fmt::format("scaling: {{mode: rigid_limit, kappa: {}}}", kappa), "",
             [&](Archive& archive) { SerializeScaling(archive, scaling); });
    const std::size_t first = points_.size();
    AddPoints("rigid_limit", std::move(scaling));
    for (std::size_t i = first; i < points_.size(); ++i) points_[i].kappa_floor = kappa;
  }
  AddPoints(study.scaling->name() + " (this study)", *study.scaling);
  const double own = points_.back().young_modulus;
  if (study.scaling->name() == "sigma_over_e") return;
  std::unique_ptr<Scaling> scaling;
  ReadYaml(fmt::format("scaling: {{mode: sigma_over_e, young_modulus: {} Pa}}", own), "",
           [&](Archive& archive) { SerializeScaling(archive, scaling); });
  std::vector<Conditions> all;
  const Planner planner(study, *scaling);
  for (std::size_t i = 0; i < study.experiments.size(); ++i) all.push_back(planner.Laboratory(i));
  if (scaling->ExplainWithoutEffect(all).empty() && own < study.powder.young_modulus) {
    AddPoints("sigma_over_e", std::move(scaling));
  }
}

void Collapse::AddPoints(const std::string& mode, std::unique_ptr<Scaling> scaling) {
  scalings_.push_back(std::move(scaling));
  AddPoints(mode, *scalings_.back());
}

void Collapse::AddPoints(const std::string& mode, const Scaling& scaling) {
  const Planner planner(study_, scaling);
  RandomStream seeds = RandomStream(study_.seed).Split("collapse");
  std::vector<std::uint64_t> particle_seeds;
  for (int r = 0; r < options_.replicates; ++r) particle_seeds.push_back(seeds.Bits() >> 33);
  for (const std::size_t i : options_.experiments) {
    if (const std::string reason = planner.ExplainUnplanned(i); !reason.empty()) {
      throw InputError("no collapse analysis: " + reason, {.location = {study_.file}});
    }
    std::vector<double> parameters = options_.parameters;
    const Conditions laboratory = planner.Laboratory(i);
    Conditions simulation = scaling.ToSimulation(laboratory);
    if (!scaling.scales_cohesion()) KeepCohesion(laboratory, 1, &simulation);
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      const std::string& name = study_.space.parameters[p].name;
      const bool k = name == "cohesion_energy_density";
      if (!k && name != "surface_energy") continue;
      const auto& value = k ? simulation.cohesion_energy_density : simulation.surface_energy;
      if (!value) {
        throw InputError(
            "a collapse analysis needs the powder's surface energy, for its cohesion "
            "is sought",
            {.location = {study_.file}, .key = "material.surface_energy"});
      }
      parameters[p] = *value;
    }
    CollapsePoint point{.mode = mode, .experiment = i};
    const Conditions run_with = planner.Simulation(i, parameters);
    point.young_modulus = run_with.young_modulus.value_or(0);
    for (const auto& [symbol, value] : EvaluateGroups(run_with)) point.groups[symbol] = value;
    for (int r = 0; r < options_.replicates; ++r) {
      point.runs.push_back(
          planner.PlanExperiment(i, parameters, r, particle_seeds[static_cast<std::size_t>(r)]));
    }
    points_.push_back(std::move(point));
  }
}

void Keep(const LedgerRun& run, CollapsePoint* point) {
  if (!run.outcome.ok()) {
    point->failures.push_back(
        fmt::format("{}: {}", ToString(run.outcome.reason), run.outcome.message));
    return;
  }
  for (const auto& [name, response] : run.measurement.responses) {
    point->responses[name].push_back(response.value);
  }
}

std::vector<GroupTrend> FindTrends(const Study& study, const std::vector<CollapsePoint>& points) {
  std::vector<GroupTrend> trends;
  for (const auto& [experiment, response] : ResponsesOf(points)) {
    for (const char* group : kGroups) {
      std::vector<std::pair<double, double>> xy;
      for (const CollapsePoint& point : points) {
        const std::vector<double>* values = ValuesOf(point, response);
        const auto value = point.groups.find(group);
        if (point.experiment != experiment || values == nullptr || value == point.groups.end() ||
            !(value->second > 0)) {
          continue;
        }
        xy.emplace_back(std::log(value->second), Mean(*values));
      }
      std::sort(xy.begin(), xy.end());
      // A group that is the same everywhere explains nothing.
      if (xy.size() < 3 || xy.back().first - xy.front().first < 1e-6) continue;
      GroupTrend trend{.experiment = study.experiments[experiment].name(),
                       .response = response,
                       .group = group,
                       .points = static_cast<int>(xy.size())};
      FitLine(xy, &trend);
      trends.push_back(std::move(trend));
    }
  }
  return trends;
}

std::vector<Plateau> FindPlateaus(const Study& study, const std::vector<CollapsePoint>& points) {
  std::vector<Plateau> plateaus;
  for (const auto& [experiment, response] : ResponsesOf(points)) {
    struct Level {
      double kappa = 0;
      double mean = 0;
      double count = 0;
    };
    std::vector<Level> levels;
    for (const CollapsePoint& point : points) {
      const std::vector<double>* values = ValuesOf(point, response);
      if (point.mode != "rigid_limit" || point.experiment != experiment || values == nullptr) {
        continue;
      }
      levels.push_back({point.kappa_floor, Mean(*values), static_cast<double>(values->size())});
    }
    if (levels.size() < 2) continue;
    std::sort(levels.begin(), levels.end(),
              [](const Level& a, const Level& b) { return a.kappa < b.kappa; });
    const Level& last = levels.back();
    Plateau plateau{.experiment = study.experiments[experiment].name(),
                    .response = response,
                    .seed_sd = PooledSd(points, experiment, response),
                    .largest_kappa = last.kappa};
    const auto error = [&](const Level& level) {
      return plateau.seed_sd * std::sqrt(1 / level.count + 1 / last.count);
    };
    std::size_t first = levels.size() - 1;
    while (first > 0 &&
           std::abs(levels[first - 1].mean - last.mean) <= 2 * error(levels[first - 1])) {
      --first;
    }
    const bool found = first + 1 < levels.size();
    const Level& level = found ? levels[first] : levels.front();
    plateau.kappa = found ? level.kappa : 0;
    plateau.change = level.mean - last.mean;
    plateau.error = error(level);
    plateaus.push_back(std::move(plateau));
  }
  return plateaus;
}

}  // namespace powdercal

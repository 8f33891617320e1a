#include "studies/comparison/measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/statistics.h"
#include "optimizers/pareto.h"

namespace powdercal::comparison {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kBandPoints = 80;
constexpr double kMargin = 0.1;  // [ln chi²] of the reference point beyond the front, at least

bool AllFinite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

Eigen::RowVectorXd Row(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::RowVectorXd>(values.data(),
                                              static_cast<Eigen::Index>(values.size()));
}

Eigen::MatrixXd Stack(const std::vector<std::vector<double>>& rows) {
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(rows.size()),
                         rows.empty() ? 0 : static_cast<Eigen::Index>(rows.front().size()));
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    matrix.row(i) = Row(rows[static_cast<std::size_t>(i)]);
  }
  return matrix;
}

// ln chi², ideal → 0, reference → 1.
double ScaledHypervolume(const Eigen::MatrixXd& logarithms, const FrontScale& scale) {
  const Eigen::MatrixXd rows = (logarithms.rowwise() - scale.ideal.transpose()).array().rowwise() /
                               (scale.reference - scale.ideal).transpose().array();
  return Hypervolume(rows, Eigen::VectorXd::Ones(scale.ideal.size()));
}

std::vector<double> Logarithms(std::vector<double> values) {
  for (double& value : values) value = std::log(std::max(value, kSmallestMisfit));
  return values;
}

bool Dominated(const std::vector<double>& point, const std::vector<std::vector<double>>& front) {
  return std::any_of(front.begin(), front.end(), [&](const std::vector<double>& other) {
    return std::equal(other.begin(), other.end(), point.begin(),
                      [](double a, double b) { return a <= b; });
  });
}

}  // namespace

Trajectory ReportedChi2(const ContestRecord& record) {
  Trajectory trajectory;
  for (const Step& step : record.steps) {
    trajectory.values.push_back(
        step.reported < 0 ? kInfinity
                          : record.steps[static_cast<std::size_t>(step.reported)].judged.front());
    trajectory.core_seconds.push_back(step.core_seconds);
  }
  return trajectory;
}

Trajectory LostHypervolume(const ContestRecord& record, const FrontScale& scale) {
  Trajectory trajectory;
  std::vector<std::vector<double>> front;
  double lost = kInfinity;
  for (const Step& step : record.steps) {
    if (AllFinite(step.judged)) {
      const std::vector<double> point = Logarithms(step.judged);
      if (!Dominated(point, front)) {
        front.push_back(point);
        const double reached = ScaledHypervolume(Stack(front), scale) / scale.hypervolume;
        lost = std::clamp(1 - reached, 0.0, 1.0);
      }
    }
    trajectory.values.push_back(lost);
    trajectory.core_seconds.push_back(step.core_seconds);
  }
  return trajectory;
}

FrontScale ScaleOfFront(std::span<const ContestRecord> records) {
  std::vector<std::vector<double>> all;
  for (const ContestRecord& record : records) {
    for (const Step& step : record.steps) {
      if (AllFinite(step.judged)) all.push_back(Logarithms(step.judged));
    }
  }
  if (all.empty()) return {};
  const Eigen::MatrixXd points = Stack(all);
  std::vector<std::vector<double>> front;
  for (const std::size_t i : NonDominated(points)) front.push_back(all[i]);
  const Eigen::MatrixXd rows = Stack(front);
  FrontScale scale{.ideal = rows.colwise().minCoeff(), .reference = rows.colwise().maxCoeff()};
  for (Eigen::Index o = 0; o < points.cols(); ++o) {
    const Eigen::VectorXd column = points.col(o);
    // Beyond the whole front, whose ends would be worth nothing else, and never at the ideal.
    scale.reference[o] =
        std::max({Quantile({column.begin(), column.end()}, 0.5), scale.reference[o] + kMargin});
  }
  scale.hypervolume = ScaledHypervolume(rows, scale);
  return scale;
}

double ValueAfter(const Trajectory& trajectory, int evaluations) {
  const auto count = std::min<std::size_t>(trajectory.values.size(),
                                           static_cast<std::size_t>(std::max(0, evaluations)));
  return count == 0 ? kInfinity : trajectory.values[count - 1];
}

double ValueWithin(const Trajectory& trajectory, double core_seconds) {
  const auto end = std::upper_bound(trajectory.core_seconds.begin(), trajectory.core_seconds.end(),
                                    core_seconds);
  return ValueAfter(trajectory, static_cast<int>(end - trajectory.core_seconds.begin()));
}

int EvaluationsTo(const Trajectory& trajectory, double level) {
  for (std::size_t i = 0; i < trajectory.values.size(); ++i) {
    if (trajectory.values[i] <= level) return static_cast<int>(i) + 1;
  }
  return 0;
}

Quartiles QuartilesOf(const std::vector<double>& values) {
  return {Quantile(values, 0.25), Quantile(values, 0.5), Quantile(values, 0.75)};
}

Band BandByEvaluations(std::span<const Trajectory> trajectories, int evaluations) {
  Band band;
  for (int n = 1; n <= evaluations; ++n) {
    std::vector<double> values;
    for (const Trajectory& trajectory : trajectories) values.push_back(ValueAfter(trajectory, n));
    band.x.push_back(n);
    band.y.push_back(QuartilesOf(values));
  }
  return band;
}

Band BandByCoreSeconds(std::span<const Trajectory> trajectories, double core_seconds) {
  Band band;
  for (int i = 1; i <= kBandPoints; ++i) {
    const double x = core_seconds * i / kBandPoints;
    std::vector<double> values;
    for (const Trajectory& trajectory : trajectories) values.push_back(ValueWithin(trajectory, x));
    band.x.push_back(x);
    band.y.push_back(QuartilesOf(values));
  }
  return band;
}

std::vector<double> TargetLevels(std::span<const Trajectory> trajectories, double floor,
                                 int count) {
  std::vector<double> first;
  double low = kInfinity;
  for (const Trajectory& trajectory : trajectories) {
    const auto found = std::find_if(trajectory.values.begin(), trajectory.values.end(),
                                    [](double v) { return std::isfinite(v); });
    if (found == trajectory.values.end()) continue;
    first.push_back(*found);
    low = std::min(low, *std::min_element(trajectory.values.begin(), trajectory.values.end()));
  }
  if (first.empty()) return {};
  low = std::max(low, floor);
  const double high = std::max(QuartilesOf(first).median, low);
  std::vector<double> levels;
  for (int i = 0; i < count; ++i) {
    levels.push_back(high *
                     std::pow(low / high, count > 1 ? static_cast<double>(i) / (count - 1) : 1));
  }
  levels.back() = low;
  return levels;
}

std::vector<double> ShareOfTargets(std::span<const Trajectory> trajectories,
                                   const std::vector<double>& levels, int evaluations) {
  std::vector<double> shares(static_cast<std::size_t>(evaluations), 0.0);
  const auto pairs = static_cast<double>(trajectories.size() * levels.size());
  for (const Trajectory& trajectory : trajectories) {
    for (const double level : levels) {
      const int first = EvaluationsTo(trajectory, level);
      if (first == 0) continue;
      for (int n = first; n <= evaluations; ++n)
        shares[static_cast<std::size_t>(n) - 1] += 1 / pairs;
    }
  }
  return shares;
}

}  // namespace powdercal::comparison

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/random.h"
#include "optimizers/bayesian/acquisition.h"
#include "optimizers/designs/design.h"

namespace powdercal {
namespace {

constexpr int kSobolStarts = 512;
constexpr int kStepsPerLength = 8;  // from each anchor
constexpr int kClimbs = 6;
constexpr double kStartSpacing = 0.03;  // in the box, between two climbs' starts
constexpr int kMaxIterations = 40;
constexpr int kMaxLevels =
    64;  // other levels of a discrete parameter that are tried from an anchor

// x = lower + (upper − lower)(1 − cos t)/2 in the continuous coordinates: every t is a point of the
// box, and the bounds are reached at finite t. Discrete coordinates stay as they are.
class Coordinates {
 public:
  Coordinates(const MaximisationLimits& limits, const Eigen::VectorXd& start)
      : start_(start), lower_(limits.lower), width_(limits.upper - limits.lower) {
    for (int k = 0; k < limits.space->dimension(); ++k) {
      if (limits.space->parameters[static_cast<std::size_t>(k)].levels() == 0) free_.push_back(k);
    }
  }

  int count() const { return static_cast<int>(free_.size()); }
  Eigen::VectorXd ToBox(const Eigen::VectorXd& t) const {
    Eigen::VectorXd x = start_;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      const int k = free_[i];
      x[k] = lower_[k] + width_[k] * 0.5 * (1 - std::cos(t[static_cast<Eigen::Index>(i)]));
    }
    return x;
  }
  Eigen::VectorXd Start() const {
    Eigen::VectorXd t(count());
    for (std::size_t i = 0; i < free_.size(); ++i) {
      const int k = free_[i];
      // Off the bounds, where the derivative by t is zero.
      const double u = std::clamp((start_[k] - lower_[k]) / width_[k], 1e-4, 1 - 1e-4);
      t[static_cast<Eigen::Index>(i)] = std::acos(1 - 2 * u);
    }
    return t;
  }
  Eigen::VectorXd Slope(const Eigen::VectorXd& t, const Eigen::VectorXd& gradient) const {
    Eigen::VectorXd slope(count());
    for (std::size_t i = 0; i < free_.size(); ++i) {
      const auto index = static_cast<Eigen::Index>(i);
      slope[index] = gradient[free_[i]] * width_[free_[i]] * 0.5 * std::sin(t[index]);
    }
    return slope;
  }
  /// Coordinates close to an end moved to it.
  Eigen::VectorXd Snapped(Eigen::VectorXd x) const {
    for (const int k : free_) {
      const double u = (x[k] - lower_[k]) / width_[k];
      if (u < 1e-3) x[k] = lower_[k];
      if (u > 1 - 1e-3) x[k] = lower_[k] + width_[k];
    }
    return x;
  }

 private:
  Eigen::VectorXd start_;
  Eigen::VectorXd lower_;
  Eigen::VectorXd width_;
  std::vector<int> free_;
};

class NegativeAcquisition final : public ceres::FirstOrderFunction {
 public:
  NegativeAcquisition(const Acquisition& acquisition, const Coordinates& coordinates)
      : acquisition_(acquisition), coordinates_(coordinates) {}

  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    const Eigen::VectorXd t = Eigen::Map<const Eigen::VectorXd>(parameters, NumParameters());
    if (!t.allFinite()) return false;
    Eigen::VectorXd slope;
    *cost = -acquisition_.Evaluate(coordinates_.ToBox(t), gradient != nullptr ? &slope : nullptr);
    if (gradient != nullptr) {
      if (!slope.allFinite()) return false;
      Eigen::Map<Eigen::VectorXd>(gradient, NumParameters()) = -coordinates_.Slope(t, slope);
    }
    return std::isfinite(*cost);
  }
  int NumParameters() const override { return coordinates_.count(); }

 private:
  const Acquisition& acquisition_;
  const Coordinates& coordinates_;
};

struct Summit {
  Eigen::VectorXd point;
  double value = -std::numeric_limits<double>::infinity();
};

Summit Climb(const Acquisition& acquisition, const MaximisationLimits& limits,
             const Eigen::VectorXd& start, double start_value) {
  Summit summit{start, start_value};
  const Coordinates coordinates(limits, start);
  if (coordinates.count() == 0) return summit;
  const ceres::GradientProblem problem(new NegativeAcquisition(acquisition, coordinates));
  ceres::GradientProblemSolver::Options options;
  options.logging_type = ceres::SILENT;
  options.minimizer_progress_to_stdout = false;
  options.max_num_iterations = kMaxIterations;
  options.function_tolerance = 1e-7;
  options.gradient_tolerance = 1e-5;
  ceres::GradientProblemSolver::Summary summary;
  Eigen::VectorXd t = coordinates.Start();
  ceres::Solve(options, problem, t.data(), &summary);
  if (!t.allFinite()) return summit;
  // Close to a bound the bound itself may be higher.
  const Eigen::VectorXd climbed = coordinates.ToBox(t);
  for (const Eigen::VectorXd& end : {climbed, coordinates.Snapped(climbed)}) {
    const double value = acquisition.Evaluate(end, nullptr);
    if (std::isfinite(value) && value >= summit.value) summit = {end, value};
  }
  return summit;
}

// The anchors with one discrete coordinate at each of its other levels.
std::vector<Eigen::VectorXd> OtherLevels(const SearchSpace& space, const Eigen::MatrixXd& anchors) {
  std::vector<Eigen::VectorXd> points;
  for (Eigen::Index a = 0; a < anchors.rows(); ++a) {
    for (int k = 0; k < space.dimension(); ++k) {
      const int levels =
          std::min(kMaxLevels, space.parameters[static_cast<std::size_t>(k)].levels());
      for (int level = 0; level < levels; ++level) {
        points.emplace_back(anchors.row(a).transpose());
        points.back()[k] = (level + 0.5) / levels;
      }
    }
  }
  return points;
}

Eigen::MatrixXd Starts(const MaximisationLimits& limits, const Eigen::MatrixXd& anchors,
                       std::uint64_t seed) {
  constexpr double kLengths[] = {1e-3, 1e-2, 0.1};
  const SearchSpace& space = *limits.space;
  const Eigen::Index dimension = space.dimension();
  const Eigen::VectorXd width = limits.upper - limits.lower;
  RandomStream random = RandomStream(seed).Split("steps");
  std::vector<Eigen::VectorXd> starts;
  const Eigen::MatrixXd sobol = SobolPoints(kSobolStarts, static_cast<int>(dimension), seed);
  for (Eigen::Index i = 0; i < sobol.rows(); ++i) {
    starts.emplace_back(limits.lower + width.cwiseProduct(sobol.row(i).transpose()));
  }
  for (Eigen::Index anchor = 0; anchor < anchors.rows(); ++anchor) {
    for (const double length : kLengths) {
      for (int i = 0; i < kStepsPerLength; ++i) {
        Eigen::VectorXd start = anchors.row(anchor).transpose();
        for (Eigen::Index k = 0; k < dimension; ++k)
          start[k] += width[k] * length * random.Normal();
        starts.push_back(start.cwiseMax(limits.lower).cwiseMin(limits.upper));
      }
    }
  }
  for (Eigen::VectorXd& point : OtherLevels(space, anchors)) starts.push_back(std::move(point));
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(starts.size()), dimension);
  for (std::size_t i = 0; i < starts.size(); ++i) {
    rows.row(static_cast<Eigen::Index>(i)) = space.Snap(starts[i]).transpose();
  }
  return rows;
}

class Gate {
 public:
  Gate(const Acquisition& acquisition, const MaximisationLimits& limits)
      : acquisition_(acquisition), limits_(limits) {}

  bool Admits(const Eigen::VectorXd& point) const {
    if (limits_.taken.rows() > 0 &&
        (limits_.taken.rowwise() - point.transpose()).rowwise().norm().minCoeff() <=
            limits_.radius) {
      return false;
    }
    return limits_.min_feasibility <= 0 ||
           acquisition_.LogFeasibility(point) >= std::log(limits_.min_feasibility);
  }

 private:
  const Acquisition& acquisition_;
  const MaximisationLimits& limits_;
};

}  // namespace

double LogMeanExp(const Eigen::ArrayXd& values, Eigen::ArrayXd* shares) {
  const double largest = values.maxCoeff();
  if (!std::isfinite(largest)) {
    *shares = Eigen::ArrayXd::Zero(values.size());
    return largest;
  }
  *shares = (values - largest).exp();
  const double sum = shares->sum();
  *shares /= sum;
  return largest + std::log(sum / static_cast<double>(values.size()));
}

Eigen::VectorXd MaximiseAcquisition(const Acquisition& acquisition, const Eigen::MatrixXd& anchors,
                                    const MaximisationLimits& limits, std::uint64_t seed) {
  const Gate gate(acquisition, limits);
  const Eigen::MatrixXd starts = Starts(limits, anchors, seed);
  const Eigen::VectorXd values = acquisition.EvaluateMany(starts);
  std::vector<Eigen::Index> order;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i]) && gate.Admits(starts.row(i).transpose())) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return values[a] > values[b]; });
  std::vector<Summit> summits;
  std::vector<Eigen::VectorXd> climbed_from;
  for (const Eigen::Index i : order) {
    if (static_cast<int>(climbed_from.size()) == kClimbs) break;
    const Eigen::VectorXd start = starts.row(i).transpose();
    const bool close = std::any_of(
        climbed_from.begin(), climbed_from.end(),
        [&](const Eigen::VectorXd& other) { return (other - start).norm() < kStartSpacing; });
    if (close) continue;
    climbed_from.push_back(start);
    summits.push_back(Climb(acquisition, limits, start, values[i]));
  }
  // Starts stand in when no summit is within the limits.
  for (const Eigen::Index i : order) summits.push_back({starts.row(i).transpose(), values[i]});
  Summit best;
  for (const Summit& summit : summits) {
    if (summit.value > best.value && gate.Admits(summit.point)) best = summit;
  }
  return best.point;
}

}  // namespace powdercal

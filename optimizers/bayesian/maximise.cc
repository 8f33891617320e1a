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

// x = (1 − cos t)/2: every t is a point of the box, and the bounds are reached at finite t.
Eigen::VectorXd ToBox(const Eigen::VectorXd& t) { return 0.5 * (1 - t.array().cos()); }

Eigen::VectorXd FromBox(const Eigen::VectorXd& x) {
  // Off the bounds, where the derivative by t is zero.
  return (1 - 2 * x.array().max(1e-4).min(1 - 1e-4)).acos();
}

class NegativeAcquisition final : public ceres::FirstOrderFunction {
 public:
  explicit NegativeAcquisition(const Acquisition& acquisition) : acquisition_(acquisition) {}

  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    const Eigen::VectorXd t = Eigen::Map<const Eigen::VectorXd>(parameters, NumParameters());
    if (!t.allFinite()) return false;
    Eigen::VectorXd slope;
    *cost = -acquisition_.Evaluate(ToBox(t), gradient != nullptr ? &slope : nullptr);
    if (gradient != nullptr) {
      if (!slope.allFinite()) return false;
      Eigen::Map<Eigen::ArrayXd>(gradient, NumParameters()) =
          -0.5 * slope.array() * t.array().sin();
    }
    return std::isfinite(*cost);
  }
  int NumParameters() const override { return static_cast<int>(acquisition_.dimension()); }

 private:
  const Acquisition& acquisition_;
};

struct Summit {
  Eigen::VectorXd point;
  double value = -std::numeric_limits<double>::infinity();
};

Summit Climb(const Acquisition& acquisition, const Eigen::VectorXd& start, double start_value) {
  const ceres::GradientProblem problem(new NegativeAcquisition(acquisition));
  ceres::GradientProblemSolver::Options options;
  options.logging_type = ceres::SILENT;
  options.minimizer_progress_to_stdout = false;
  options.max_num_iterations = kMaxIterations;
  options.function_tolerance = 1e-7;
  options.gradient_tolerance = 1e-5;
  ceres::GradientProblemSolver::Summary summary;
  Eigen::VectorXd t = FromBox(start);
  ceres::Solve(options, problem, t.data(), &summary);
  Summit summit{start, start_value};
  if (!t.allFinite()) return summit;
  // Close to a bound the bound itself may be higher.
  const Eigen::VectorXd climbed = ToBox(t);
  Eigen::VectorXd snapped = climbed;
  for (double& x : snapped) x = x < 1e-3 ? 0 : x > 1 - 1e-3 ? 1 : x;
  for (const Eigen::VectorXd& end : {climbed, snapped}) {
    const double value = acquisition.Evaluate(end, nullptr);
    if (std::isfinite(value) && value >= summit.value) summit = {end, value};
  }
  return summit;
}

Eigen::MatrixXd Starts(Eigen::Index dimension, const Eigen::MatrixXd& anchors, std::uint64_t seed) {
  constexpr double kLengths[] = {1e-3, 1e-2, 0.1};
  RandomStream random = RandomStream(seed).Split("steps");
  Eigen::MatrixXd starts(kSobolStarts + anchors.rows() * 3 * kStepsPerLength, dimension);
  starts.topRows(kSobolStarts) = SobolPoints(kSobolStarts, static_cast<int>(dimension), seed);
  Eigen::Index row = kSobolStarts;
  for (Eigen::Index anchor = 0; anchor < anchors.rows(); ++anchor) {
    for (const double length : kLengths) {
      for (int i = 0; i < kStepsPerLength; ++i, ++row) {
        for (Eigen::Index k = 0; k < dimension; ++k) {
          starts(row, k) = std::clamp(anchors(anchor, k) + length * random.Normal(), 0.0, 1.0);
        }
      }
    }
  }
  return starts;
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

Eigen::VectorXd MaximiseAcquisition(const Acquisition& acquisition, const Eigen::MatrixXd& anchors,
                                    const MaximisationLimits& limits, std::uint64_t seed) {
  const Gate gate(acquisition, limits);
  const Eigen::MatrixXd starts = Starts(acquisition.dimension(), anchors, seed);
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
    summits.push_back(Climb(acquisition, start, values[i]));
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

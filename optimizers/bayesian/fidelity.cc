#include "optimizers/bayesian/fidelity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "optimizers/observations.h"

namespace powdercal {
namespace {

class TargetAcquisition final : public Acquisition {
 public:
  explicit TargetAcquisition(std::unique_ptr<Acquisition> acquisition)
      : acquisition_(std::move(acquisition)),
        best_point_(acquisition_->best_point().head(acquisition_->best_point().size() - 1)) {}

  double Evaluate(const Eigen::VectorXd& point, Eigen::VectorXd* gradient) const override {
    if (gradient == nullptr) return acquisition_->Evaluate(WithFidelity(point, 1), nullptr);
    Eigen::VectorXd all;
    const double value = acquisition_->Evaluate(WithFidelity(point, 1), &all);
    *gradient = all.head(point.size());
    return value;
  }
  Eigen::VectorXd EvaluateMany(const Eigen::MatrixXd& points) const override {
    return acquisition_->EvaluateMany(WithFidelity(points, 1));
  }
  double LogFeasibility(const Eigen::VectorXd& point) const override {
    return acquisition_->LogFeasibility(WithFidelity(point, 1));
  }
  const Eigen::VectorXd& best_point() const override { return best_point_; }

 private:
  std::unique_ptr<Acquisition> acquisition_;
  Eigen::VectorXd best_point_;
};

}  // namespace

Eigen::VectorXd WithFidelity(const Eigen::VectorXd& point, double fidelity) {
  Eigen::VectorXd both(point.size() + 1);
  both << point, fidelity;
  return both;
}

Eigen::MatrixXd WithFidelity(const Eigen::MatrixXd& points, double fidelity) {
  Eigen::MatrixXd both(points.rows(), points.cols() + 1);
  both.leftCols(points.cols()) = points;
  both.rightCols(1).setConstant(fidelity);
  return both;
}

SearchSpace WithFidelity(SearchSpace space) {
  space.parameters.push_back({.name = "fidelity", .symbol = "s", .unit = "1"});
  return space;
}

Eigen::MatrixXd AtTarget(const Eigen::MatrixXd& points) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (points(i, points.cols() - 1) == 1) rows.push_back(i);
  }
  return points(rows, Eigen::seqN(0, points.cols() - 1));
}

std::unique_ptr<Acquisition> MakeTargetAcquisition(std::unique_ptr<Acquisition> acquisition) {
  return std::make_unique<TargetAcquisition>(std::move(acquisition));
}

std::string ExplainBadFidelities(std::span<const FidelityLevel> levels) {
  std::set<double> seen;
  for (const FidelityLevel& level : levels) {
    if (!(level.fidelity > 0) || level.fidelity > 1) {
      return fmt::format("a fidelity of {} does not lie in (0, 1]", level.fidelity);
    }
    if (!(level.cost > 0) || !std::isfinite(level.cost)) {
      return fmt::format("fidelity {} has no cost above 0", level.fidelity);
    }
    if (!seen.insert(level.fidelity).second) {
      return fmt::format("fidelity {} is given twice", level.fidelity);
    }
  }
  if (!levels.empty() && !seen.contains(1)) return "none of the fidelities is the target, 1";
  return "";
}

double ChooseFidelity(const std::vector<GaussianProcess>& processes, const Eigen::ArrayXd& weights,
                      const Eigen::ArrayXd& noise_variances, const Eigen::VectorXd& point,
                      std::span<const FidelityLevel> levels, const Eigen::MatrixXd& taken) {
  double best = 1;
  double best_gain = -1;
  for (const FidelityLevel& level : levels) {
    const Eigen::VectorXd candidate = WithFidelity(point, level.fidelity);
    if (level.fidelity < 1 && IsTaken(taken, candidate)) continue;
    Eigen::MatrixXd pair(2, candidate.size());
    pair << WithFidelity(point, 1).transpose(), candidate.transpose();
    double removed = 0;
    for (std::size_t j = 0; j < processes.size(); ++j) {
      const auto index = static_cast<Eigen::Index>(j);
      Eigen::VectorXd mean;
      Eigen::MatrixXd covariance;
      processes[j].PredictJoint(pair, &mean, &covariance);
      const double own = processes[j].noise_sd();
      const double variance = std::max(covariance(1, 1), 0.0) + own * own + noise_variances[index];
      if (variance > 0) {
        removed += weights[index] * covariance(0, 1) * covariance(0, 1) / variance;
      }
    }
    // The variance at the target is the same for all.
    if (removed / level.cost > best_gain) {
      best_gain = removed / level.cost;
      best = level.fidelity;
    }
  }
  return best;
}

}  // namespace powdercal

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "optimizers/bayesian/feasibility.h"
#include "surrogates/gaussian_process.h"

namespace powdercal {

/// What a new evaluation at a point promises, as a logarithm:
///   ln [ p(x) · (1/K) Σ_k E[max(0, best_k − objective_k(x))] ],
/// p the probability that the evaluation succeeds. Without pending evaluations K = 1. The outcome
/// of pending evaluations is sampled: each of K fixed samples (Sobol' points through the normal
/// quantile) moves the posterior means, shrinks the variances near the pending points and may lower
/// the best objective, so that a further point is worth what it adds to those under way (Snoek,
/// Larochelle & Adams 2012). A failed evaluation shrinks the variance near it and says
/// nothing else: it promises no more information.
class Acquisition {
 public:
  struct Objective {
    /// composite: Σ_j weights_j (f_j(x) − targets_j)², f_j the processes; else f_0(x) itself.
    bool composite = true;
    Eigen::ArrayXd targets;
    Eigen::ArrayXd weights;
    double margin = 0;  ///< of the improvement that counts (not composite): jitter
  };

  /// processes: fitted, one per response. evaluated: n × d, points at which the posterior mean of
  /// the objective counts as reached; n ≥ 1. seed: of the samples of pending evaluations.
  Acquisition(Objective objective, std::vector<GaussianProcess> processes, Feasibility feasibility,
              const Eigen::MatrixXd& evaluated, const Eigen::MatrixXd& failed, std::uint64_t seed);

  /// Conditions on a pending evaluation.
  void AddPending(const Eigen::VectorXd& point);

  double Evaluate(const Eigen::VectorXd& point, Eigen::VectorXd* gradient) const;
  /// At each row of points.
  Eigen::VectorXd EvaluateMany(const Eigen::MatrixXd& points) const;

  /// ln of the probability that an evaluation at the point succeeds.
  double LogFeasibility(const Eigen::VectorXd& point) const {
    return feasibility_.LogProbability(point, nullptr);
  }
  /// Lowest objective that the posterior means give at an evaluated point, and that point.
  double best() const { return best_; }
  const Eigen::VectorXd& best_point() const { return best_point_; }
  Eigen::Index dimension() const { return best_point_.size(); }

 private:
  double ObjectiveOf(const Eigen::ArrayXd& responses) const;
  /// ln improvement for given means and variances of the responses; derivatives unless null.
  double LogImprovementOf(double best, const Eigen::ArrayXd& means, const Eigen::ArrayXd& variances,
                          Eigen::ArrayXd* by_mean, Eigen::ArrayXd* by_variance) const;

  Objective objective_;
  std::vector<GaussianProcess> processes_;
  Feasibility feasibility_;
  std::uint64_t seed_;
  double best_ = 0;
  Eigen::VectorXd best_point_;
  int pending_ = 0;
  std::vector<double> sample_bests_;      // K, or 1
  std::vector<Eigen::MatrixXd> samples_;  // for each response: pending × K standard normals
};

/// Where a maximum of the acquisition may lie.
struct MaximisationLimits {
  Eigen::MatrixXd taken;       ///< m × d: points that must not be proposed again
  double radius = 1e-6;        ///< around them; < 0: they may
  double min_feasibility = 0;  ///< probability of success
};

/// A maximum of the acquisition: Sobol' points of the box and normal steps of several lengths from
/// `anchors` (m × d, good points known so far) are tried, the best of them climb by L-BFGS (Ceres,
/// in variables without bounds), and the highest end within the limits wins. Deterministic for a
/// given seed. Empty if none is within the limits or nothing is finite.
Eigen::VectorXd MaximiseAcquisition(const Acquisition& acquisition, const Eigen::MatrixXd& anchors,
                                    const MaximisationLimits& limits, std::uint64_t seed);

}  // namespace powdercal

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "optimizers/bayesian/acquisition.h"
#include "optimizers/feasibility.h"
#include "surrogates/gaussian_process.h"

namespace powdercal {

/// Expected improvement of one objective on the best that the posterior means give:
///   ln [ p(x) · (1/K) Σ_k E[max(0, best_k − objective_k(x))] ].
/// Without pending evaluations K = 1. The outcome of pending evaluations is sampled: each of K
/// fixed samples (Sobol' points through the normal quantile) moves the posterior means, shrinks the
/// variances near the pending points and may lower the best objective, so that a further point is
/// worth what it adds to those under way (Snoek, Larochelle & Adams 2012). A failed evaluation
/// shrinks the variance near it and says nothing else: it promises no more information.
class ImprovementAcquisition final : public Acquisition {
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
  ImprovementAcquisition(Objective objective, std::vector<GaussianProcess> processes,
                         Feasibility feasibility, const Eigen::MatrixXd& evaluated,
                         const Eigen::MatrixXd& failed, std::uint64_t seed);

  /// Conditions on a pending evaluation; `counts`: its outcome may become the best.
  void AddPending(const Eigen::VectorXd& point, bool counts = true);

  double Evaluate(const Eigen::VectorXd& point, Eigen::VectorXd* gradient) const override;
  Eigen::VectorXd EvaluateMany(const Eigen::MatrixXd& points) const override;
  double LogFeasibility(const Eigen::VectorXd& point) const override {
    return feasibility_.LogProbability(point, nullptr);
  }
  const Eigen::VectorXd& best_point() const override { return best_point_; }
  /// Lowest objective that the posterior means give at an evaluated point.
  double best() const { return best_; }

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

}  // namespace powdercal

#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "optimizers/bayesian/acquisition.h"
#include "optimizers/models.h"
#include "optimizers/optimizer.h"

namespace powdercal {

// Evaluations at several fidelities s. A process has s as one more input beside the point x, with a
// lengthscale of its own: k((x, s), (x', s')) is the product of a kernel over x and one over s
// (Kandasamy, Dasarathy, Schneider & Póczos 2017). Where x is to be is decided by what an
// evaluation at the target, s = 1, would gain; at which fidelity by what it costs to learn of that.

/// (x, s), a point of the models.
Eigen::VectorXd WithFidelity(const Eigen::VectorXd& point, double fidelity);
/// Points as rows, all with this fidelity.
Eigen::MatrixXd WithFidelity(const Eigen::MatrixXd& points, double fidelity);
/// The space with a last, continuous parameter "fidelity".
SearchSpace WithFidelity(SearchSpace space);
/// Of rows (x, s) the x of those at the target.
Eigen::MatrixXd AtTarget(const Eigen::MatrixXd& points);

/// An acquisition over (x, s) as one over x, at the target.
std::unique_ptr<Acquisition> MakeTargetAcquisition(std::unique_ptr<Acquisition> acquisition);

/// "" if the levels can be used, one of them the target, all different; else the reason.
std::string ExplainBadFidelities(std::span<const FidelityLevel> levels);

/// The fidelity at which an evaluation of `point` pays most: the highest
///   ρ²(s)/cost(s),   ρ²(s) = Σ_j w_j c_j(s)²/(v_j(s) + n_j) / Σ_j w_j v_j(1),
/// with v_j(s) the posterior variance of response j at (x, s), c_j(s) its covariance with (x, 1)
/// and n_j its noise: the share of the variance at the target that the evaluation takes away, over
/// what it costs. The factors by which Huang, Allen, Notz & Miller (2006, Struct. Multidisc. Optim.
/// 32:369) weigh expected improvement, correlation, noise and cost ratio, the correlation squared.
/// `taken`: rows (x, s) that are left out (by IsTaken), the target excepted.
/// processes: fitted, conditioned on what is under way; weights: w_j ≥ 0; noise_variances: n_j, the
/// process's own excluded.
double ChooseFidelity(const std::vector<GaussianProcess>& processes, const Eigen::ArrayXd& weights,
                      const Eigen::ArrayXd& noise_variances, const Eigen::VectorXd& point,
                      std::span<const FidelityLevel> levels, const Eigen::MatrixXd& taken);

}  // namespace powdercal

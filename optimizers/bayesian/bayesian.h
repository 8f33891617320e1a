#pragma once

#include <memory>
#include <vector>

#include "optimizers/designs/design.h"
#include "optimizers/optimizer.h"
#include "surrogates/kernel.h"

namespace powdercal {

/// `bayesian`: an initial design, then points that maximise an acquisition over Gaussian processes
/// fitted to all that is known (Jones, Schonlau & Welch 1998).
struct BayesianOptions {
  enum class Acquisition {
    /// composite_log_ei; where several responses are to be minimised qlog_nehvi, of more than 4
    /// qlog_nparego.
    automatic,
    composite_log_ei,  ///< a process per response; expected improvement of chi² built from them
    ei,                ///< one process on chi² itself, as GPyOpt (and the paper) do
    log_ei,            ///< the same without a jitter, as a logarithm
    qlog_nei,          ///< composite_log_ei, the best averaged over what noise leaves open
    qlog_nehvi,        ///< 2 … 4 objectives: gain of hypervolume, averaged in the same way
    qlog_nparego,      ///< several objectives: a random Chebyshev norm of them for each proposal
  };
  Acquisition acquisition = Acquisition::automatic;
  /// ei only: the improvement that counts begins so far below the best, in units of the standard
  /// deviation of the objective (GPyOpt's meaning: its objective is standardised; the paper's w_a).
  /// [1], ≥ 0
  double jitter = 0.01;
  Kernel kernel = Kernel::matern52;
  DesignOptions initial_design{.name = "sobol"};
  /// Never ask for a point within 1e-6 of the box of one that was evaluated or is pending. Without
  /// it noisy responses may be evaluated again where it pays.
  bool de_duplication = true;
  bool input_warping = false;  ///< learn for each response where it changes fast (see InputMap)
  enum class TrustRegion { automatic, on, off };
  TrustRegion trust_region = TrustRegion::automatic;  ///< automatic: above 10 parameters
  /// From which a fidelity is chosen for each candidate; empty: all are evaluated at the target.
  /// Not part of the study file. One objective, acquisitions composite_log_ei, ei and log_ei.
  std::vector<FidelityLevel> fidelities;

  /// Throws InputError.
  void Serialize(Archive& archive, const SearchSpace& space);
};

/// Life of the optimizer: the points of the initial design first, then one proposal at a time, each
/// given all observations and pending candidates. Never waits: where no model can be made (fewer
/// than two evaluations have succeeded, or a fit fails) it proposes the point of the box farthest
/// from all others, and says so in Candidate::origin and status().message. Failed evaluations lower
/// the probability of success nearby (Feasibility), which multiplies the acquisition; while more
/// than a quarter of all evaluations have failed, proposals are confined to where success is
/// likelier than not, if there is such a place. With several objectives qlog_nehvi adds the most to
/// the hypervolume; qlog_nparego reaches every part of the front at random; composite_log_ei
/// improves a weighted sum of them (Scalarisation), which leads to its convex part. With several
/// fidelities the initial design is evaluated at the cheapest, the first two proposals at the
/// target, and all others where it pays most (bayesian/fidelity.h); the models see all evaluations,
/// and only those at the target count as reached. Proposals are a
/// function of the options, the seed, the number asked and the observations (in any order of
/// telling) alone: no state of earlier fits goes in, so a study that is resumed goes on as if it
/// had not been interrupted.
std::unique_ptr<Optimizer> MakeBayesian(const BayesianOptions& options, const SearchSpace& space,
                                        const Objectives& objectives, std::uint64_t seed);

std::unique_ptr<OptimizerFactory> MakeBayesianFactory();

}  // namespace powdercal

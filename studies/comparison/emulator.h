#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/random.h"
#include "optimizers/feasibility.h"
#include "studies/ledger.h"
#include "studies/study.h"
#include "surrogates/gaussian_process.h"

namespace powdercal::comparison {

/// A point of the unit box with the simulations that a ledger holds of it.
struct KnownPoint {
  Eigen::VectorXd point;
  std::vector<LedgerRun> runs;
};

/// What a ledger knows of the study's calibrated experiments on its backend, without what was
/// simulated besides (confirmations, other laws). Points with equal parameters are one.
std::vector<KnownPoint> ReadKnownPoints(const Study& study, const Ledger& ledger);
/// Adds the points and runs of `more` that are not there yet.
void Merge(const std::vector<KnownPoint>& more, std::vector<KnownPoint>* points);

/// Why what was simulated for `other` says nothing of `study`, or "": the sections of the study
/// file in which they differ. Optimizer, seed, budget, objective, tolerances, replicates and
/// experiments that are not calibrated may differ.
std::string ExplainOtherProblem(Study& study, Study& other);

/// Stands in for the simulator: a Gaussian process for each response, fitted to the means of the
/// points that are known; normal scatter between particle seeds; a process for the logarithm of the
/// time of a simulation; and a probability of failure (Feasibility, optimizers/bayesian) for each
/// experiment. Responses of one simulation scatter independently of each other.
class Emulator {
 public:
  /// How well a response is emulated.
  struct Quality {
    std::string response;
    std::string unit;
    int points = 0;  ///< that have a value
    /// 1 − Σ (mean − prediction from all other points)²/Σ (mean − mean of means)²; NaN where all
    /// are equal. The hyperparameters are those of the fit to all points.
    double leave_one_out_r2 = 0;
    double seed_sd = 0;  ///< SI, between particle seeds
    /// Whether the scatter comes from replicates; else it is that of the leave-one-out residuals.
    bool from_replicates = false;
    double share_of_sd = 0;  ///< root mean square of those residuals over the observation's sd
  };

  /// Throws InputError where a response has a value at fewer than kFewestPoints points.
  Emulator(const Study& study, const std::vector<KnownPoint>& points);

  static constexpr int kFewestPoints = 5;
  /// Below it a response is said to be emulated poorly.
  static constexpr double kPoorR2 = 0.7;

  /// Responses without scatter, in the order of the targets.
  Eigen::VectorXd Truth(const Eigen::VectorXd& point) const;
  /// A simulation. `world` is the stream that chance is drawn from; the same world, point,
  /// experiment and replicate give the same run. From any thread.
  LedgerRun Simulate(std::size_t experiment, const Eigen::VectorXd& point, int replicate,
                     const RandomStream& world) const;

  const std::vector<Quality>& quality() const { return quality_; }
  int points() const { return points_; }
  int runs() const { return runs_; }
  int failed_runs() const { return failed_runs_; }
  /// What a user should know: responses that are emulated poorly, scatter that is not known.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// SHA-256 of all that determines the emulator.
  const std::string& fingerprint() const { return fingerprint_; }

 private:
  struct Response {
    std::string name;  // without the experiment
    GaussianProcess process;
    double seed_sd = 0;
  };
  struct Test {
    std::string name;
    std::vector<std::size_t> targets;
    std::optional<GaussianProcess> log_seconds;
    double median_seconds = 0;  // where there is no process
    double failed_seconds = 0;  // median of failed runs
    std::optional<Feasibility> feasibility;
    std::string failure;  // message of the last one
  };

  void FitResponse(const Target& target, const std::vector<KnownPoint>& points);
  Test FitTest(const std::string& name, const std::vector<KnownPoint>& points) const;
  void Warn();

  SearchSpace space_;
  Objectives objectives_;
  std::vector<Response> responses_;  // in the order of the targets
  std::map<std::size_t, Test> tests_;
  std::vector<Quality> quality_;
  std::vector<std::string> warnings_;
  std::string backend_;
  std::string fingerprint_;
  int points_ = 0;
  int runs_ = 0;
  int failed_runs_ = 0;
};

}  // namespace powdercal::comparison

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "optimizers/designs/design.h"
#include "optimizers/optimizer.h"

namespace powdercal {

/// A problem with a known answer, on which optimizers are measured (benchmarks/optimizer_suite).
struct TestProblem {
  std::string name;
  std::string description;  ///< one line, with the source
  SearchSpace space;
  Objectives objectives;
  DesignOptions initial_design;
  int evaluations = 0;  ///< budget, initial design included, in the cost of one at the target
  /// Budget of optimizers that fit models (Capabilities::noise), whose proposals cost more the more
  /// is known; 0: the same.
  int modelled_evaluations = 0;
  int batch = 1;             ///< points that are asked for at a time
  Eigen::VectorXd noise_sd;  ///< of the responses; empty: none
  /// Responses without noise at SI values (see SearchSpace::FromUnit); empty: the evaluation fails.
  std::function<Eigen::VectorXd(const Eigen::VectorXd& values)> respond;
  /// Fidelities at which evaluations can be made, for optimizers that choose; the others evaluate
  /// at the target. `respond_at` gives the responses below it.
  std::vector<FidelityLevel> fidelities;
  std::function<Eigen::VectorXd(const Eigen::VectorXd& values, double fidelity)> respond_at;

  /// Of a search, from the noise-free responses of its evaluations in order (empty: failed, or not
  /// at the target).
  std::function<double(std::span<const Eigen::VectorXd> responses)> measure;
  std::string measured;           ///< what `measure` returns: "regret of the best point evaluated"
  bool higher_is_better = false;  ///< hypervolume
};

/// branin, branin_currin, branin_currin_noisy, branin_multi_fidelity, dtlz2, environmental,
/// environmental_noisy, failures, hartmann6, hartmann6_noisy, mixed, table3, zdt1.
std::span<const std::string> TestProblemNames();

/// table3: CSV with the paper's Table 3, for the problem of that name. Throws InputError for an
/// unknown name or a file that cannot be read.
TestProblem MakeTestProblem(const std::string& name, const std::filesystem::path& table3);

/// `failures` without its failing region.
TestProblem MakeFailuresWithoutFailing();

/// Cost of an evaluation, in units of one at the target.
double CostOf(const TestProblem& problem, const Candidate& candidate);

/// What an evaluation of the problem observes: responses plus noise of the stream, and the noise's
/// variance as known.
Observation Observe(const TestProblem& problem, const Candidate& candidate, std::uint64_t seed);

}  // namespace powdercal

#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "verification/equivalence.h"
#include "verification/finding.h"
#include "verification/runs.h"

namespace powdercal::verification {

/// A quantity to be compared, and how closely.
struct Comparison {
  std::string name;
  std::string unit;
  double margin = 0;  ///< [unit] > 0; or, if `relative`, a fraction of the reference's mean
  bool relative = false;
  std::string margin_reason;  ///< one clause, for people
  bool counts = true;
};

/// One case of a rung with particle seeds: the same program in every backend, once for each seed.
struct SeedCase {
  std::string name;
  std::vector<std::uint64_t> seeds;
  std::vector<Program> programs;  ///< one for each seed
  std::vector<Comparison> comparisons;
  /// Measures a trace of one of the programs; responses have the names of the comparisons.
  std::function<Measurement(const Program&, const Trace&, Outcome*)> measure;
};

/// Runs the cases in every backend and tests each pair for equivalence, quantity by quantity, seed
/// by seed; in the first form of the law that both have (forms.h). A case of which a run failed is
/// `failed`, whatever the others say.
std::vector<Finding> CompareOverSeeds(Rung rung, std::span<const SeedCase> cases,
                                      std::span<const Contender> contenders, double level,
                                      const RunOptions& options);

}  // namespace powdercal::verification

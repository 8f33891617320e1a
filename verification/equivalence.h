#pragma once

#include <span>
#include <vector>

#include "verification/finding.h"

namespace powdercal::verification {

/// What a pair of backends gave for one quantity with one particle seed.
struct SeedPair {
  double a = 0;
  double b = 0;
};

/// Two one-sided tests (Schuirmann 1987, J. Pharmacokinet. Biopharm. 15:657): is the mean of b − a
/// shown to lie within ± margin? "No significant difference" would not do: few seeds, or much
/// scatter, would always pass.
struct EquivalenceTest {
  double margin = 0;    ///< > 0, in the unit of the values
  double level = 0.05;  ///< alpha of each of the two tests, in (0, 0.5)
};

/// Tests b − a, seed by seed: both backends begin with the same packing, so that what that packing
/// has of its own drops out. With d the mean of n differences, s their standard deviation and
/// t = s/√n · t(1 − level; n − 1), the interval is d ± t, whose confidence is 1 − 2·level.
///   equivalent: it lies inside (−margin, margin), which is p < level;
///   different:  it lies wholly outside;
///   undecided:  neither, or fewer than two pairs.
/// seeds_needed is the smallest n at which the interval would decide if d and s stayed what they
/// are. Throws std::invalid_argument for a margin that is not positive.
Verdict TestEquivalence(std::span<const SeedPair> pairs, const EquivalenceTest& test,
                        SeedStatistics* statistics);

/// Mean, and standard deviation with divisor n − 1 (0 for fewer than two).
struct MeanAndSd {
  double mean = 0;
  double sd = 0;
};
MeanAndSd Summarise(std::span<const double> values);

}  // namespace powdercal::verification

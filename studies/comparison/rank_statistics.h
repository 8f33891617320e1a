#pragma once

#include <Eigen/Core>

namespace powdercal::comparison {

/// Rank of each treatment (column) within each block (row), averaged over the blocks: 1 is the
/// lowest value, equal values share the mean of their ranks. Values that are not finite (nothing
/// was found) are equal to each other and above all others. At least one block.
Eigen::VectorXd MeanRanks(const Eigen::MatrixXd& values);

/// Whether treatments differ at all, from their ranks in independent blocks.
struct FriedmanTest {
  int blocks = 0;      ///< N
  int treatments = 0;  ///< k
  /// Friedman's statistic (1937), about χ² distributed with k − 1 degrees of freedom; 0 where all
  /// ranks are tied.
  double chi_squared = 0;
  double chi_squared_p = 1;
  /// F = (N − 1) χ²/(N (k − 1) − χ²) of Iman & Davenport (1980), F distributed with k − 1 and
  /// (k − 1)(N − 1) degrees of freedom, which is less conservative. Infinite where all blocks agree
  /// perfectly; its p is then the chance of that, k!^(1 − N).
  double f = 0;
  double f_p = 1;
};

/// From values, with the correction for ties (Conover 1999, section 5.8): χ² = (k − 1) Σⱼ (Rⱼ −
/// N (k + 1)/2)²/(Σ ranks² − N k (k + 1)²/4), Rⱼ the rank sums. N ≥ 2, k ≥ 2, or the test is empty.
FriedmanTest TestFriedman(const Eigen::MatrixXd& values);
/// From mean ranks, without ties: χ² = 12 N/(k (k + 1)) (Σ rⱼ² − k (k + 1)²/4) (Demšar 2006,
/// section 3.2.2).
FriedmanTest TestMeanRanks(const Eigen::VectorXd& mean_ranks, int blocks);

/// Distribution function of the range of k independent standard normal variables (the studentised
/// range with infinite degrees of freedom), k ∫ φ(z) (Φ(z) − Φ(z − q))^(k−1) dz; absolute error
/// below 1e-10. k ≥ 2.
double NormalRangeCdf(double q, int groups);
/// Its inverse; 0 < p < 1.
double NormalRangeQuantile(double p, int groups);

/// Mean ranks of two treatments that lie this far apart differ at level `alpha`, all pairs compared
/// (Nemenyi 1963; Demšar 2006, section 3.2.2): q/√2 √(k (k + 1)/(6 N)), q the quantile 1 − alpha of
/// the range. k ≥ 2, N ≥ 1.
double NemenyiDifference(int treatments, int blocks, double alpha);

}  // namespace powdercal::comparison

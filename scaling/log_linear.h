#pragma once

#include <Eigen/Core>
#include <vector>

namespace powdercal {

/// Groups are products of powers, so that matching them is linear in logarithms: row j asks for
/// (coefficients x)_j = target_j, x being the logarithms of the factors that are sought.
struct LogLinearProblem {
  Eigen::MatrixXd coefficients;
  Eigen::VectorXd target;
  Eigen::VectorXd weight;     ///< > 0
  Eigen::VectorXd tolerance;  ///< > 0, |residual| that is accepted
};

struct LogLinearSolution {
  Eigen::VectorXd x;
  Eigen::VectorXd residual;   ///< coefficients x − target
  bool within = false;        ///< every residual is within its tolerance
  std::vector<int> conflict;  ///< where not: rows that cannot all be met, whatever x
};

/// Weighted least squares, of least norm where x is not determined: what no group asks for stays as
/// it is. Where that misses a tolerance, the x whose largest residual, in tolerances, is least
/// (Lawson's iteration: Rice & Usow 1968); if that misses one too, none can do better, and the rows
/// that contradict each other are named: those with a residual in ordinary least squares.
LogLinearSolution SolveLogLinear(const LogLinearProblem& problem);

}  // namespace powdercal

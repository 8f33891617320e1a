#include "scaling/log_linear.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace powdercal {
namespace {

// Of a residual that is zero but for rounding; logarithms are of order 1 to 30.
constexpr double kRounding = 1e-9;
constexpr int kIterations = 500;

Eigen::VectorXd Solve(const LogLinearProblem& problem, const Eigen::VectorXd& weight) {
  const Eigen::MatrixXd weighted = weight.asDiagonal() * problem.coefficients;
  return weighted.completeOrthogonalDecomposition().solve(weight.cwiseProduct(problem.target));
}

LogLinearSolution Evaluate(const LogLinearProblem& problem, const Eigen::VectorXd& x) {
  LogLinearSolution solution{.x = x, .residual = problem.coefficients * x - problem.target};
  solution.within = true;
  for (Eigen::Index j = 0; j < solution.residual.size(); ++j) {
    if (std::abs(solution.residual[j]) > problem.tolerance[j] + kRounding) solution.within = false;
  }
  return solution;
}

double LargestMiss(const LogLinearProblem& problem, const LogLinearSolution& solution) {
  return solution.residual.cwiseAbs().cwiseQuotient(problem.tolerance).maxCoeff();
}

// Weights grow with the residuals until the largest ones are equal.
LogLinearSolution LeastLargest(const LogLinearProblem& problem) {
  const Eigen::Index rows = problem.target.size();
  Eigen::VectorXd square = Eigen::VectorXd::Constant(rows, 1.0 / static_cast<double>(rows));
  LogLinearSolution best;
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::VectorXd weight = square.cwiseSqrt().cwiseQuotient(problem.tolerance);
    LogLinearSolution next = Evaluate(problem, Solve(problem, weight));
    const Eigen::VectorXd miss = next.residual.cwiseAbs().cwiseQuotient(problem.tolerance);
    if (best.x.size() == 0 || miss.maxCoeff() < LargestMiss(problem, best)) best = next;
    if (next.within) break;
    square = square.cwiseProduct(miss);
    square /= square.sum();
  }
  return best;
}

}  // namespace

LogLinearSolution SolveLogLinear(const LogLinearProblem& problem) {
  const Eigen::Index columns = problem.coefficients.cols();
  if (columns == 0 || problem.target.size() == 0) {  // nothing may change, or nothing is asked for
    LogLinearSolution solution = Evaluate(problem, Eigen::VectorXd::Zero(columns));
    for (Eigen::Index j = 0; j < problem.target.size(); ++j) {
      if (std::abs(solution.residual[j]) > problem.tolerance[j] + kRounding) {
        solution.conflict.push_back(static_cast<int>(j));
      }
    }
    return solution;
  }
  LogLinearSolution solution = Evaluate(problem, Solve(problem, problem.weight));
  if (solution.within) return solution;
  solution = LeastLargest(problem);
  if (solution.within) return solution;
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(problem.target.size());
  const Eigen::VectorXd residual = Evaluate(problem, Solve(problem, ones)).residual;
  for (Eigen::Index j = 0; j < residual.size(); ++j) {
    if (std::abs(residual[j]) > kRounding) solution.conflict.push_back(static_cast<int>(j));
  }
  return solution;
}

}  // namespace powdercal

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "optimizers/least_squares/differences.h"

namespace powdercal {

struct LocalSearchOptions {
  double tolerance = 1e-8;  ///< relative decrease of χ² below which the search has converged, > 0
  int max_iterations = 1000;         ///< of Levenberg–Marquardt
  std::vector<std::string> symbols;  ///< of the parameters, for the origins of candidates
};

struct LocalSearchEnd {
  enum class Reason {
    converged,  ///< no step makes χ² smaller by more than the tolerance
    matched,    ///< every residual is zero, to rounding
    stalled,    ///< steps that should have made χ² smaller did not, however short
    exhausted,  ///< max_iterations
    cancelled,  ///< `evaluate` said so; the rest is not defined
  };
  Reason reason = Reason::converged;
  Eigen::VectorXd point;
  Eigen::VectorXd residuals;
  DifferenceJacobian jacobian;  ///< of finite differences at `point`
  StepRule rule;                ///< as it is by now
  bool noise_found = false;     ///< differences disagreed although no noise was told of
  int failures = 0;             ///< trial points that failed or lacked an active response
};

/// Levenberg–Marquardt (Ceres) from one start, on residuals whose derivatives are finite
/// differences of evaluations.
///
/// Ceres asks for the Jacobian at each accepted point. It gets a stencil (Differences) where the
/// last step was badly predicted, else the last Jacobian with the rank-one update of Broyden
/// (1965), which costs no evaluation. Whatever comes of an updated Jacobian (a rejected step,
/// convergence) is tried again with a stencil. Columns of parameters at a bound that the gradient
/// pushes outwards are zero, so that the step is that of the others. A failed trial point is a
/// rejected step: the trust region shrinks.
///
/// Responses without known noise are differenced with short steps. Where the search seems to end,
/// a central stencil with longer steps confirms the Jacobian and removes its bias. If they
/// disagree, and a stencil of ten times the short steps does as well, there is noise (or a jump):
/// the steps are lengthened to suit it and the search goes on. Slopes that are too steep for the
/// spread of the responses are checked in this way at the start.
///
/// start: evaluated; `residuals` are those that it has.
LocalSearchEnd SearchLocally(const LocalSearchOptions& options, const Residuals& residuals,
                             const StepRule& rule, const EvaluateBatch& evaluate,
                             const Observation& start);

}  // namespace powdercal

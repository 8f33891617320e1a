#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <string>

#include "studies/results.h"
#include "surrogates/surrogate.h"

namespace powdercal {

/// One response as a Gaussian process over the unit box, fitted to the evaluations that succeeded.
/// For plots only: the optimizer has models of its own.
class ResponseSurface {
 public:
  /// Fits target number `target`. `why_not()` tells where that was impossible (too few evaluations,
  /// or a fit that fails).
  ResponseSurface(const StudyResults& results, std::size_t target);

  bool fitted() const { return why_not_.empty(); }
  const std::string& why_not() const { return why_not_; }
  int point_count() const { return point_count_; }

  /// SI. Requires fitted().
  Prediction Predict(const Eigen::VectorXd& unit_point) const;

 private:
  std::unique_ptr<Surrogate> surrogate_;
  std::string why_not_;
  int point_count_ = 0;
};

/// Means and standard deviations over nodes that divide the box evenly from end to end, for two
/// parameters, all others at `base`. Entry (i, j): first parameter at node i, second at node j.
struct SurfaceGrid {
  Eigen::MatrixXd mean;
  Eigen::MatrixXd sd;
};
SurfaceGrid EvaluateGrid(const ResponseSurface& surface, const Eigen::VectorXd& base, int first,
                         int second, int nodes);

}  // namespace powdercal

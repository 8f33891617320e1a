#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "surrogates/surrogate.h"

namespace powdercal {

/// Mean of the k nearest observations by Euclidean distance in the unit box, with weights 1/dᵖ
/// (Shepard 1968, doi:10.1145/800186.810616; p = 0: equal weights). On an observation p > 0 gives
/// its value, the mean of the values where there are several. k and p are those of the least error
/// by leave-one-out; of equal ones the smaller. Noise variances are checked and not used.
///
/// The variance is the spread of the neighbours about their mean, weighted likewise and free of
/// bias. Where a single one decides (k = 1, or on an observation) it is the mean squared error by
/// leave-one-out. Neighbours of equal values have none.
class NearestNeighbours final : public Surrogate {
 public:
  struct Options {
    int max_neighbours = 10;  ///< ≥ 1
    int max_power = 2;        ///< of the distance, ≥ 0
  };

  NearestNeighbours() : NearestNeighbours(Options{}) {}
  explicit NearestNeighbours(Options options);
  ~NearestNeighbours() override;

  const std::string& name() const override;
  void Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
           const Eigen::VectorXd& noise_variances) override;
  Prediction Predict(const Eigen::VectorXd& point) const override;
  std::string Describe() const override;

  int neighbours() const { return neighbours_; }
  int power() const { return power_; }

 private:
  class Tree;
  void Select(const Eigen::MatrixXd& points);

  Options options_;
  std::unique_ptr<const Tree> tree_;
  Eigen::VectorXd values_;
  int neighbours_ = 1;
  int power_ = 0;
  double leave_one_out_error_ = 0;  // mean square
};

}  // namespace powdercal

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "surrogates/surrogate.h"

namespace powdercal {

/// Random forest (Breiman 2001, doi:10.1023/A:1010933404324): mean of regression trees, each grown
/// on a bootstrap sample of the observations. A node is split where the squared error falls most,
/// in the middle between two observations, along one of the coordinates that were drawn for it. The
/// smallest leaf and the number of coordinates drawn are those of the least out-of-bag error; of
/// equal ones the smaller leaf and the more coordinates. Piecewise constant: beyond the data and
/// between two splits it is flat. Noise variances are checked and not used.
///
/// The variance is the spread of the trees' predictions (Hutter, Hoos & Leyton-Brown 2011,
/// doi:10.1007/978-3-642-25566-3_40, without that within leaves): what the bootstrap samples
/// disagree about, which knows of no distance to the data.
class RandomForest final : public Surrogate {
 public:
  struct Options {
    int trees = 500;  ///< ≥ 2
    int selection_trees =
        200;           ///< ≥ 2; for each out-of-bag error that hyperparameters are chosen by
    int max_leaf = 8;  ///< smallest leaves tried: 1, 2, 4, … up to this
    std::uint64_t seed = 1;
  };

  RandomForest() : RandomForest(Options{}) {}
  explicit RandomForest(Options options);

  const std::string& name() const override;
  void Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
           const Eigen::VectorXd& noise_variances) override;
  Prediction Predict(const Eigen::VectorXd& point) const override;
  std::string Describe() const override;

  int smallest_leaf() const { return growth_.smallest_leaf; }
  int coordinates_drawn() const { return growth_.coordinates_drawn; }

  struct Growth {
    int smallest_leaf = 1;      ///< observations, repeated ones counted as often as drawn
    int coordinates_drawn = 1;  ///< for each split; more where none of them allows one
  };
  struct Node {
    int coordinate = -1;  ///< −1: a leaf
    double threshold = 0;
    int below = 0;     ///< node of points at or below the threshold
    int above = 0;     ///< node of points above it
    double value = 0;  ///< of a leaf
  };
  using Tree = std::vector<Node>;  // the root first

 private:
  Options options_;
  Growth growth_;
  std::vector<Tree> trees_;
  Eigen::Index count_ = 0;
  Eigen::Index dimension_ = 0;
};

}  // namespace powdercal

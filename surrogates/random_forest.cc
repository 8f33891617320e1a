#include "surrogates/random_forest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "core/random.h"
#include "surrogates/fitting.h"

namespace powdercal {
namespace {

using Growth = RandomForest::Growth;
using Node = RandomForest::Node;
using Tree = RandomForest::Tree;

class TreeGrower {
 public:
  TreeGrower(const Eigen::MatrixXd& points, const Eigen::VectorXd& values, Growth growth)
      : points_(points), values_(values), growth_(growth) {}

  Tree Grow(std::vector<Eigen::Index> sample, RandomStream random) const {
    struct Range {
      int node;
      std::size_t begin;
      std::size_t end;
    };
    Tree tree(1);
    std::vector<Range> open = {{0, 0, sample.size()}};
    while (!open.empty()) {
      const Range range = open.back();
      open.pop_back();
      const std::span<Eigen::Index> rows(sample.data() + range.begin, range.end - range.begin);
      const Split split = FindSplit(rows, random);
      if (split.coordinate < 0) {
        tree[static_cast<std::size_t>(range.node)].value = Mean(rows);
        continue;
      }
      const auto middle = std::partition(rows.begin(), rows.end(), [&](Eigen::Index row) {
        return points_(row, split.coordinate) <= split.threshold;
      });
      const std::size_t border = range.begin + static_cast<std::size_t>(middle - rows.begin());
      const int below = static_cast<int>(tree.size());
      tree[static_cast<std::size_t>(range.node)] = {.coordinate = split.coordinate,
                                                    .threshold = split.threshold,
                                                    .below = below,
                                                    .above = below + 1};
      tree.resize(tree.size() + 2);
      open.push_back({below + 1, border, range.end});
      open.push_back({below, range.begin, border});
    }
    return tree;
  }

 private:
  struct Split {
    int coordinate = -1;
    double threshold = 0;
    double gain = 0;
  };

  double Mean(std::span<const Eigen::Index> rows) const {
    double sum = 0;
    for (const Eigen::Index row : rows) sum += values_[row];
    return sum / static_cast<double>(rows.size());
  }

  // The best split along the coordinates drawn; further ones are drawn while none allows a split.
  Split FindSplit(std::span<const Eigen::Index> rows, RandomStream& random) const {
    Split best;
    if (rows.size() < 2 * static_cast<std::size_t>(growth_.smallest_leaf)) return best;
    const bool constant = std::all_of(rows.begin(), rows.end(), [&](Eigen::Index row) {
      return values_[row] == values_[rows.front()];
    });
    if (constant) return best;
    std::vector<int> coordinates(static_cast<std::size_t>(points_.cols()));
    std::iota(coordinates.begin(), coordinates.end(), 0);
    random.Shuffle(std::span(coordinates));
    for (std::size_t drawn = 0; drawn < coordinates.size(); ++drawn) {
      if (static_cast<int>(drawn) >= growth_.coordinates_drawn && best.coordinate >= 0) break;
      TryCoordinate(rows, coordinates[drawn], &best);
    }
    return best;
  }

  // With values taken from their mean, the squared error falls by S²/n of either side.
  void TryCoordinate(std::span<const Eigen::Index> rows, int coordinate, Split* best) const {
    std::vector<Eigen::Index> sorted(rows.begin(), rows.end());
    std::sort(sorted.begin(), sorted.end(), [&](Eigen::Index a, Eigen::Index b) {
      const double left = points_(a, coordinate);
      const double right = points_(b, coordinate);
      return left != right ? left < right : a < b;
    });
    const double mean = Mean(sorted);
    const auto n = static_cast<double>(sorted.size());
    const auto smallest = static_cast<std::size_t>(growth_.smallest_leaf);
    double sum = 0;
    for (std::size_t i = 1; i < sorted.size(); ++i) {
      sum += values_[sorted[i - 1]] - mean;
      const double lower = points_(sorted[i - 1], coordinate);
      const double upper = points_(sorted[i], coordinate);
      if (lower == upper || i < smallest || sorted.size() - i < smallest) continue;
      const auto left = static_cast<double>(i);
      const double gain = sum * sum * (1 / left + 1 / (n - left));
      if (best->coordinate >= 0 && gain <= best->gain) continue;
      *best = {coordinate, std::min(std::midpoint(lower, upper), std::nextafter(upper, lower)),
               gain};
    }
  }

  const Eigen::MatrixXd& points_;
  const Eigen::VectorXd& values_;
  Growth growth_;
};

double PredictTree(const Tree& tree, const Eigen::VectorXd& point) {
  const Node* node = &tree.front();
  while (node->coordinate >= 0) {
    const int next = point[node->coordinate] <= node->threshold ? node->below : node->above;
    node = &tree[static_cast<std::size_t>(next)];
  }
  return node->value;
}

// How often each of n observations is in the sample of this tree.
std::vector<Eigen::Index> Bootstrap(Eigen::Index n, RandomStream random) {
  std::vector<Eigen::Index> sample(static_cast<std::size_t>(n));
  for (Eigen::Index& row : sample) {
    row = static_cast<Eigen::Index>(random.Below(static_cast<std::uint64_t>(n)));
  }
  return sample;
}

// Mean squared error of each observation's prediction by the trees that have not seen it; ∞ if
// every tree has seen every one.
double OutOfBagError(const Eigen::MatrixXd& points, const Eigen::VectorXd& values, Growth growth,
                     int trees, const RandomStream& random) {
  const Eigen::Index n = points.rows();
  const TreeGrower grower(points, values, growth);
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(n);
  for (int t = 0; t < trees; ++t) {
    const RandomStream own = random.Split(static_cast<std::uint64_t>(t));
    const std::vector<Eigen::Index> sample = Bootstrap(n, own.Split("sample"));
    std::vector<bool> seen(static_cast<std::size_t>(n), false);
    for (const Eigen::Index row : sample) seen[static_cast<std::size_t>(row)] = true;
    const Tree tree = grower.Grow(sample, own.Split("splits"));
    for (Eigen::Index i = 0; i < n; ++i) {
      if (seen[static_cast<std::size_t>(i)]) continue;
      sums[i] += PredictTree(tree, points.row(i).transpose());
      counts[i] += 1;
    }
  }
  double error = 0;
  double known = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (counts[i] == 0) continue;
    error += std::pow(sums[i] / counts[i] - values[i], 2);
    known += 1;
  }
  return known == 0 ? std::numeric_limits<double>::infinity() : error / known;
}

}  // namespace

RandomForest::RandomForest(Options options) : options_(options) {
  assert(options_.trees >= 2 && options_.selection_trees >= 2 && options_.max_leaf >= 1);
}

const std::string& RandomForest::name() const {
  static const std::string kName = "random_forest";
  return kName;
}

void RandomForest::Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
                       const Eigen::VectorXd& noise_variances) {
  CheckObservations(name(), points, values, noise_variances);
  count_ = points.rows();
  dimension_ = points.cols();
  const RandomStream random(options_.seed);
  const auto d = static_cast<int>(dimension_);
  growth_ = {.smallest_leaf = 1, .coordinates_drawn = d};
  double least = std::numeric_limits<double>::infinity();
  // From all coordinates to a third of them, Breiman's choice.
  const std::set<int, std::greater<>> draws = {d, (2 * d + 2) / 3, (d + 2) / 3};
  for (int leaf = 1; leaf <= options_.max_leaf && 2 * leaf <= count_; leaf *= 2) {
    for (const int drawn : draws) {
      const Growth growth{.smallest_leaf = leaf, .coordinates_drawn = drawn};
      const double error = OutOfBagError(points, values, growth, options_.selection_trees, random);
      if (!(error < least)) continue;
      least = error;
      growth_ = growth;
    }
  }
  trees_.clear();
  const TreeGrower grower(points, values, growth_);
  for (int t = 0; t < options_.trees; ++t) {
    const RandomStream own = random.Split(static_cast<std::uint64_t>(t));
    trees_.push_back(grower.Grow(Bootstrap(count_, own.Split("sample")), own.Split("splits")));
  }
}

Prediction RandomForest::Predict(const Eigen::VectorXd& point) const {
  assert(!trees_.empty() && point.size() == dimension_);
  Eigen::VectorXd predictions(static_cast<Eigen::Index>(trees_.size()));
  for (std::size_t t = 0; t < trees_.size(); ++t) {
    predictions[static_cast<Eigen::Index>(t)] = PredictTree(trees_[t], point);
  }
  const double mean = predictions.mean();
  const double variance =
      (predictions.array() - mean).square().sum() / static_cast<double>(predictions.size() - 1);
  return {.mean = mean, .variance = count_ > 1 ? variance : kUnknownVariance};
}

std::string RandomForest::Describe() const {
  if (trees_.empty()) return "random forest, not fitted";
  return fmt::format("random forest, {} points, {} trees, smallest leaf {}, {} of {} coordinates",
                     count_, trees_.size(), growth_.smallest_leaf, growth_.coordinates_drawn,
                     dimension_);
}

}  // namespace powdercal

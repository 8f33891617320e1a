#include "optimizers/metaheuristics/individual.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "optimizers/pareto.h"

namespace powdercal {
namespace {

using Indices = std::vector<std::size_t>;

// Of each member of a front: over all objectives, the gap between its two neighbours relative to
// the extent of the front; infinite at the ends.
std::vector<double> CrowdingDistances(std::span<const Individual> individuals,
                                      const Indices& front) {
  std::vector<double> distances(front.size(), 0);
  Indices order(front.size());
  for (Eigen::Index o = 0; o < individuals[front[0]].values.size(); ++o) {
    const auto value = [&](std::size_t i) { return individuals[front[i]].values[o]; };
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return value(a) < value(b); });
    const double extent = value(order.back()) - value(order.front());
    distances[order.front()] = std::numeric_limits<double>::infinity();
    distances[order.back()] = std::numeric_limits<double>::infinity();
    if (extent <= 0) continue;
    for (std::size_t i = 1; i + 1 < order.size(); ++i) {
      distances[order[i]] += (value(order[i + 1]) - value(order[i - 1])) / extent;
    }
  }
  return distances;
}

Indices ParetoRanking(std::span<const Individual> individuals) {
  Indices ranking;
  Indices left;
  for (std::size_t i = 0; i < individuals.size(); ++i) {
    if (individuals[i].Complete()) left.push_back(i);
  }
  while (!left.empty()) {
    Eigen::MatrixXd values(static_cast<Eigen::Index>(left.size()),
                           individuals[left[0]].values.size());
    for (std::size_t i = 0; i < left.size(); ++i) {
      values.row(static_cast<Eigen::Index>(i)) = individuals[left[i]].values.transpose();
    }
    Indices front = NonDominated(values);
    for (std::size_t& i : front) i = left[i];
    std::erase_if(left,
                  [&](std::size_t i) { return std::binary_search(front.begin(), front.end(), i); });
    const std::vector<double> distances = CrowdingDistances(individuals, front);
    Indices order(front.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return distances[a] > distances[b]; });
    for (const std::size_t i : order) ranking.push_back(front[i]);
  }
  for (std::size_t i = 0; i < individuals.size(); ++i) {
    if (!individuals[i].Complete()) ranking.push_back(i);
  }
  return ranking;
}

}  // namespace

bool Better(const Individual& a, const Individual& b) {
  if (a.Complete() != b.Complete()) return a.Complete();
  return a.Complete() && a.values[0] < b.values[0];
}

std::vector<std::size_t> Ranking(std::span<const Individual> individuals) {
  if (!individuals.empty() && individuals[0].values.size() > 1) return ParetoRanking(individuals);
  Indices ranking(individuals.size());
  std::iota(ranking.begin(), ranking.end(), 0);
  std::stable_sort(ranking.begin(), ranking.end(), [&](std::size_t a, std::size_t b) {
    return Better(individuals[a], individuals[b]);
  });
  return ranking;
}

std::vector<Individual> SelectBest(std::span<const Individual> individuals, std::size_t count) {
  std::vector<Individual> best;
  for (const std::size_t i : Ranking(individuals)) {
    if (best.size() == count) break;
    best.push_back(individuals[i]);
  }
  return best;
}

}  // namespace powdercal

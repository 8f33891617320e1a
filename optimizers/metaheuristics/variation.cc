#include "optimizers/metaheuristics/variation.h"

#include <algorithm>
#include <cmath>

namespace powdercal {
namespace {

constexpr double kEqual = 1e-14;  // parents' coordinates closer than this are the same

// Deb & Agrawal 1995, with the spread limited so that a child goes `room` beyond its parent at
// most. `gap` is the distance of the parents.
double SpreadFactor(double room, double gap, double index, double u) {
  const double beta = 1 + 2 * room / gap;
  const double alpha = 2 - std::pow(beta, -(index + 1));
  const double scaled = u * alpha;
  return scaled <= 1 ? std::pow(scaled, 1 / (index + 1))
                     : std::pow(1 / (2 - scaled), 1 / (index + 1));
}

double PolynomialMutation(double x, double index, double u) {
  const double power = 1 / (index + 1);
  if (u < 0.5) {
    const double inner = 2 * u + (1 - 2 * u) * std::pow(1 - x, index + 1);
    return std::clamp(x + std::pow(inner, power) - 1, 0.0, 1.0);
  }
  const double inner = 2 * (1 - u) + 2 * (u - 0.5) * std::pow(x, index + 1);
  return std::clamp(x + 1 - std::pow(inner, power), 0.0, 1.0);
}

}  // namespace

void VariationOptions::Serialize(Archive& archive) {
  const Range indices{.lower = 1, .upper = 100};
  archive.Number("crossover", crossover, kUnitInterval);
  archive.Number("crossover_index", crossover_index, indices);
  archive.Number("mutation", mutation, kUnitInterval);
  archive.Number("mutation_index", mutation_index, indices);
}

Variation::Variation(const VariationOptions& options, const SearchSpace& space)
    : options_(options), space_(space) {
  if (options_.mutation == 0) options_.mutation = 1.0 / space.dimension();
}

std::pair<Eigen::VectorXd, Eigen::VectorXd> Variation::Cross(const Eigen::VectorXd& a,
                                                             const Eigen::VectorXd& b,
                                                             RandomStream* random) const {
  std::pair<Eigen::VectorXd, Eigen::VectorXd> children(a, b);
  if (random->Uniform() >= options_.crossover) return children;
  for (Eigen::Index k = 0; k < a.size(); ++k) {
    if (random->Uniform() < 0.5) continue;
    if (space_.parameters[static_cast<std::size_t>(k)].levels() > 0) {
      std::swap(children.first[k], children.second[k]);
      continue;
    }
    const double low = std::min(a[k], b[k]);
    const double high = std::max(a[k], b[k]);
    const double gap = high - low;
    if (gap < kEqual) continue;
    const double u = random->Uniform();
    const double middle = 0.5 * (low + high);
    const double down = SpreadFactor(low, gap, options_.crossover_index, u);
    const double up = SpreadFactor(1 - high, gap, options_.crossover_index, u);
    children.first[k] = std::clamp(middle - 0.5 * down * gap, 0.0, 1.0);
    children.second[k] = std::clamp(middle + 0.5 * up * gap, 0.0, 1.0);
    if (random->Uniform() < 0.5) std::swap(children.first[k], children.second[k]);
  }
  return children;
}

double Variation::Mutated(Eigen::Index k, double x, RandomStream* random) const {
  const Parameter& parameter = space_.parameters[static_cast<std::size_t>(k)];
  const int levels = parameter.levels();
  if (levels == 0) return PolynomialMutation(x, options_.mutation_index, random->Uniform());
  if (levels == 1) return x;
  int level = std::min(static_cast<int>(x * levels), levels - 1);
  if (parameter.kind == Parameter::Kind::integer && random->Uniform() < 0.5) {
    const bool up = level == 0 || (level < levels - 1 && random->Uniform() < 0.5);
    level += up ? 1 : -1;
  } else {
    const int other = static_cast<int>(random->Below(static_cast<std::uint64_t>(levels - 1)));
    level = other < level ? other : other + 1;
  }
  return (level + 0.5) / levels;
}

void Variation::Mutate(Eigen::VectorXd* point, RandomStream* random) const {
  for (Eigen::Index k = 0; k < point->size(); ++k) {
    if (random->Uniform() < options_.mutation) (*point)[k] = Mutated(k, (*point)[k], random);
  }
}

void Variation::MutateOne(Eigen::VectorXd* point, RandomStream* random) const {
  const auto k =
      static_cast<Eigen::Index>(random->Below(static_cast<std::uint64_t>(point->size())));
  (*point)[k] = Mutated(k, (*point)[k], random);
}

}  // namespace powdercal

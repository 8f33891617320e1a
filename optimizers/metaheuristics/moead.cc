#include "optimizers/metaheuristics/moead.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "optimizers/metaheuristics/pagmo_methods.h"
#include "optimizers/pareto.h"

namespace powdercal {
namespace {

constexpr double kSmallestWeight = 1e-6;  // so that an objective without weight breaks ties
constexpr int kTriesForAParent = 20;
constexpr double kDifferenceFactor = 0.5;

// (H + m − 1 choose m − 1).
std::int64_t LatticeSize(int divisions, int objectives) {
  std::int64_t size = 1;
  for (int i = 1; i < objectives; ++i) size = size * (divisions + i) / i;
  return size;
}

// Divisions H of the lattice of that size; 0: there is none.
int LatticeDivisions(int count, int objectives) {
  int divisions = 1;
  while (LatticeSize(divisions, objectives) < count) ++divisions;
  return LatticeSize(divisions, objectives) == count ? divisions : 0;
}

void AddLattice(int left, int divisions, Eigen::Index next, Eigen::VectorXd* weights,
                std::vector<Eigen::VectorXd>* all) {
  if (next + 1 == weights->size()) {
    (*weights)[next] = static_cast<double>(left) / divisions;
    all->push_back(*weights);
    return;
  }
  for (int i = 0; i <= left; ++i) {
    (*weights)[next] = static_cast<double>(i) / divisions;
    AddLattice(left - i, divisions, next + 1, weights, all);
  }
}

// Uniform over the simplex for uniform u: exponential variates, normalised.
Eigen::VectorXd ToSimplex(const Eigen::VectorXd& u) {
  const Eigen::VectorXd e = -u.array().log();
  return e / e.sum();
}

class Moead final : public Strategy {
 public:
  Moead(const MoeadOptions& options, const SearchProblem& problem);

  void Begin(std::vector<Individual> population) override;
  std::vector<Eigen::VectorXd> Propose() override;
  void Learn(std::span<const Individual> generation) override;
  void Revise(const Individual& revised) override { ReviseMembers(members_, revised); }

 private:
  std::size_t Parent(const std::vector<std::size_t>& pool);
  void MoveByDifference(const Eigen::VectorXd& base, const Eigen::VectorXd& difference,
                        Eigen::VectorXd* child) const;
  void UpdateScale(std::span<const Individual> generation);
  double Tchebycheff(const Individual& individual, std::size_t weights) const;
  void Offer(const Individual& child, std::vector<std::size_t> pool);

  MoeadOptions options_;
  SearchSpace space_;
  Variation variation_;
  RandomStream random_;
  std::vector<Eigen::VectorXd> weights_;
  std::vector<std::vector<std::size_t>> neighbours_;  // of each weight vector, itself included
  std::vector<std::size_t> everyone_;
  std::vector<Individual> members_;  // one for each weight vector
  std::vector<bool> anywhere_;       // children of the generation that are not of neighbours
  Eigen::VectorXd ideal_;
  Eigen::VectorXd extent_;
};

Moead::Moead(const MoeadOptions& options, const SearchProblem& problem)
    : options_(options),
      space_(problem.space),
      variation_(options.variation, problem.space),
      random_(problem.random),
      weights_(SimplexWeights(problem.population, problem.objectives)),
      everyone_(weights_.size()) {
  std::iota(everyone_.begin(), everyone_.end(), 0);
  const std::size_t count = std::min<std::size_t>(
      options.neighbours > 0 ? options.neighbours : std::max(4, 3 * problem.population / 10),
      weights_.size());
  for (const Eigen::VectorXd& weights : weights_) {
    std::vector<std::size_t> order = everyone_;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return (weights_[a] - weights).squaredNorm() < (weights_[b] - weights).squaredNorm();
    });
    order.resize(count);
    neighbours_.push_back(std::move(order));
  }
  ideal_ = Eigen::VectorXd::Constant(problem.objectives, std::numeric_limits<double>::infinity());
}

// Every weight vector takes the best of those that are left.
void Moead::Begin(std::vector<Individual> population) {
  UpdateScale(population);
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    const auto best = std::min_element(population.begin(), population.end(),
                                       [&](const Individual& a, const Individual& b) {
                                         return Tchebycheff(a, i) < Tchebycheff(b, i);
                                       });
    members_.push_back(std::move(*best));
    population.erase(best);
  }
}

std::size_t Moead::Parent(const std::vector<std::size_t>& pool) {
  std::size_t parent = 0;
  for (int i = 0; i < kTriesForAParent; ++i) {
    parent = pool[random_.Below(pool.size())];
    if (members_[parent].Complete()) break;
  }
  return parent;
}

// Half-way to a bound that would be crossed.
void Moead::MoveByDifference(const Eigen::VectorXd& base, const Eigen::VectorXd& difference,
                             Eigen::VectorXd* child) const {
  for (Eigen::Index k = 0; k < base.size(); ++k) {
    if (space_.parameters[static_cast<std::size_t>(k)].levels() > 0) continue;
    const double moved = base[k] + kDifferenceFactor * difference[k];
    (*child)[k] = moved < 0 ? base[k] / 2 : moved > 1 ? (base[k] + 1) / 2 : moved;
  }
}

std::vector<Eigen::VectorXd> Moead::Propose() {
  std::vector<Eigen::VectorXd> children;
  anywhere_.clear();
  for (std::size_t i = 0; i < members_.size(); ++i) {
    anywhere_.push_back(random_.Uniform() >= options_.neighbour_probability);
    const std::vector<std::size_t>& pool = anywhere_.back() ? everyone_ : neighbours_[i];
    const std::size_t first = Parent(pool);
    std::size_t second = first;
    for (int k = 0; k < kTriesForAParent && second == first; ++k) second = Parent(pool);
    Eigen::VectorXd child =
        variation_.Cross(members_[first].point, members_[second].point, &random_).first;
    if (random_.Uniform() < options_.differential) {
      MoveByDifference(members_[i].point, members_[first].point - members_[second].point, &child);
    }
    variation_.Mutate(&child, &random_);
    children.push_back(std::move(child));
  }
  return children;
}

void Moead::UpdateScale(std::span<const Individual> generation) {
  Eigen::MatrixXd values(static_cast<Eigen::Index>(members_.size() + generation.size()),
                         ideal_.size());
  Eigen::Index row = 0;
  for (const Individual& member : members_) values.row(row++) = member.values.transpose();
  for (const Individual& child : generation) values.row(row++) = child.values.transpose();
  const std::vector<std::size_t> front = NonDominated(values);
  Eigen::VectorXd highest = -Eigen::VectorXd::Constant(ideal_.size(), 1e300);
  for (const std::size_t i : front) {
    const Eigen::VectorXd on_front = values.row(static_cast<Eigen::Index>(i)).transpose();
    ideal_ = ideal_.cwiseMin(on_front);
    highest = highest.cwiseMax(on_front);
  }
  extent_ = highest - ideal_;
  // Of one point there is no extent; any scale will do.
  for (double& extent : extent_) {
    if (!(extent > 0)) extent = 1;
  }
}

double Moead::Tchebycheff(const Individual& individual, std::size_t weights) const {
  if (!individual.Complete()) return std::numeric_limits<double>::infinity();
  return (weights_[weights].cwiseMax(kSmallestWeight).array() *
          (individual.values - ideal_).array() / extent_.array())
      .maxCoeff();
}

void Moead::Offer(const Individual& child, std::vector<std::size_t> pool) {
  random_.Shuffle(std::span(pool));
  int replaced = 0;
  for (const std::size_t i : pool) {
    if (!(Tchebycheff(child, i) < Tchebycheff(members_[i], i))) continue;
    members_[i] = child;
    if (++replaced == options_.replacements) break;
  }
}

void Moead::Learn(std::span<const Individual> generation) {
  UpdateScale(generation);
  for (std::size_t i = 0; i < generation.size(); ++i) {
    Offer(generation[i], anywhere_[i] ? everyone_ : neighbours_[i]);
  }
}

class MoeadMethod final : public Method {
 public:
  const std::string& name() const override {
    static const std::string name = "moead";
    return name;
  }
  std::string Describe() const override {
    return "decomposition of several objectives into weighted ones, searched together";
  }
  MethodTraits traits() const override {
    const bool own = options_.implementation == Implementation::own;
    return {.pareto = true,
            .categorical = own,
            .batches = own,
            .smallest_population = std::max(8, options_.neighbours + 1)};
  }
  // Even: no core idles. Lattices up to four objectives.
  int DefaultPopulation(int, int objectives) const override {
    const int usual = objectives == 2 ? 20 : objectives == 3 ? 28 : 14 * objectives;
    return std::max(usual, 2 * options_.neighbours);
  }
  void Serialize(Archive& archive) override {
    SerializeImplementation(archive, options_.implementation);
    archive.Integer("neighbours", options_.neighbours, {.lower = 0, .upper = 1000});
    if (options_.neighbours == 1) throw archive.ErrorAt("neighbours", "must be 0 or at least 2");
    archive.Number("neighbour_probability", options_.neighbour_probability, kUnitInterval);
    archive.Integer("replacements", options_.replacements, {.lower = 1, .upper = 1000});
    if (options_.implementation == Implementation::pagmo) return;
    archive.Number("differential", options_.differential, kUnitInterval);
    options_.variation.Serialize(archive);
  }
  std::unique_ptr<Strategy> MakeStrategy(const SearchProblem& problem) const override {
    return options_.implementation == Implementation::own ? MakeMoead(options_, problem)
                                                          : MakePagmoMoead(options_, problem);
  }

 private:
  MoeadOptions options_;
};

}  // namespace

std::vector<Eigen::VectorXd> SimplexWeights(int count, int objectives) {
  std::vector<Eigen::VectorXd> all;
  if (const int divisions = LatticeDivisions(count, objectives); divisions > 0) {
    Eigen::VectorXd weights(objectives);
    AddLattice(divisions, divisions, 0, &weights, &all);
    return all;
  }
  for (int o = 0; o < objectives; ++o) all.push_back(Eigen::VectorXd::Unit(objectives, o));
  const Eigen::MatrixXd sobol = SobolPoints(count - objectives, objectives, 1);
  for (Eigen::Index i = 0; i < sobol.rows(); ++i) {
    all.push_back(ToSimplex(sobol.row(i).transpose()));
  }
  return all;
}

bool IsLatticeSize(int count, int objectives) { return LatticeDivisions(count, objectives) > 0; }

std::unique_ptr<Strategy> MakeMoead(const MoeadOptions& options, const SearchProblem& problem) {
  return std::make_unique<Moead>(options, problem);
}

std::unique_ptr<Method> MakeMoeadMethod() { return std::make_unique<MoeadMethod>(); }

}  // namespace powdercal

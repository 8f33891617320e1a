#include "optimizers/metaheuristics/genetic.h"

#include <algorithm>

#include "optimizers/metaheuristics/pagmo_methods.h"

namespace powdercal {
namespace {

class Genetic final : public Strategy {
 public:
  Genetic(const GeneticOptions& options, const SearchProblem& problem)
      : tournament_(options.tournament),
        variation_(options.variation, problem.space),
        size_(static_cast<std::size_t>(problem.population)),
        random_(problem.random) {}

  void Begin(std::vector<Individual> population) override { members_ = std::move(population); }
  std::vector<Eigen::VectorXd> Propose() override;
  void Learn(std::span<const Individual> generation) override;
  void Revise(const Individual& revised) override {
    ReviseMembers(members_, revised);
    members_ = SelectBest(members_, size_);
  }

 private:
  const Eigen::VectorXd& Parent();
  void Add(Eigen::VectorXd child, std::vector<Eigen::VectorXd>* children);

  int tournament_;
  Variation variation_;
  std::size_t size_;
  RandomStream random_;
  std::vector<Individual> members_;  // best first
};

const Eigen::VectorXd& Genetic::Parent() {
  // Members are sorted: the lowest index wins.
  std::size_t winner = members_.size();
  for (int i = 0; i < tournament_; ++i) winner = std::min(winner, random_.Below(members_.size()));
  return members_[winner].point;
}

void Genetic::Add(Eigen::VectorXd child, std::vector<Eigen::VectorXd>* children) {
  const auto known = [&] {
    return std::any_of(members_.begin(), members_.end(),
                       [&](const Individual& member) { return member.point == child; }) ||
           std::find(children->begin(), children->end(), child) != children->end();
  };
  for (int i = 0; i < kTriesForANewPoint && known(); ++i) variation_.MutateOne(&child, &random_);
  children->push_back(std::move(child));
}

std::vector<Eigen::VectorXd> Genetic::Propose() {
  std::vector<Eigen::VectorXd> children;
  while (children.size() < size_) {
    const Eigen::VectorXd& first = Parent();
    auto [one, other] = variation_.Cross(first, Parent(), &random_);
    for (Eigen::VectorXd* child : {&one, &other}) {
      if (children.size() == size_) break;
      variation_.Mutate(child, &random_);
      Add(std::move(*child), &children);
    }
  }
  return children;
}

void Genetic::Learn(std::span<const Individual> generation) {
  members_.insert(members_.end(), generation.begin(), generation.end());
  members_ = SelectBest(members_, size_);
}

class GeneticMethod final : public Method {
 public:
  const std::string& name() const override {
    static const std::string name = "genetic";
    return name;
  }
  std::string Describe() const override {
    return "genetic algorithm with real, integer and categorical genes; one objective";
  }
  MethodTraits traits() const override {
    const bool own = options_.implementation == Implementation::own;
    return {.categorical = own,
            .batches = own,
            .smallest_population = std::max(4, options_.tournament + options_.tournament % 2),
            .population_multiple = own ? 1 : 2};
  }
  int DefaultPopulation(int, int) const override { return std::max(16, 2 * options_.tournament); }
  void Serialize(Archive& archive) override {
    SerializeImplementation(archive, options_.implementation);
    options_.variation.Serialize(archive);
    archive.Integer("tournament", options_.tournament, {.lower = 2, .upper = 100});
  }
  std::unique_ptr<Strategy> MakeStrategy(const SearchProblem& problem) const override {
    return options_.implementation == Implementation::own ? MakeGenetic(options_, problem)
                                                          : MakePagmoGenetic(options_, problem);
  }

 private:
  GeneticOptions options_;
};

}  // namespace

std::unique_ptr<Strategy> MakeGenetic(const GeneticOptions& options, const SearchProblem& problem) {
  return std::make_unique<Genetic>(options, problem);
}

std::unique_ptr<Method> MakeGeneticMethod() { return std::make_unique<GeneticMethod>(); }

}  // namespace powdercal

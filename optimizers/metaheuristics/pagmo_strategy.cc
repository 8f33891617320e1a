#include "optimizers/metaheuristics/pagmo_strategy.h"

#include <memory>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <utility>

#include "optimizers/blocking_solver.h"

namespace powdercal {
namespace {

constexpr double kFailureMargin = 1000;

// Leaves pagmo's algorithms when the solver is destroyed. Deliberately no std::exception, which they
// might catch.
struct Cancelled {};

// The unit box behind a channel; pagmo copies problems at will.
struct ChannelProblem {
  BlockingSolver::Channel* channel = nullptr;
  std::size_t dimension = 1;
  std::size_t objectives = 1;

  pagmo::vector_double fitness(const pagmo::vector_double& point) const {
    return batch_fitness(point);
  }
  pagmo::vector_double batch_fitness(const pagmo::vector_double& points) const {
    std::vector<BlockingSolver::Request> batch;
    const auto size = static_cast<Eigen::Index>(dimension);
    for (std::size_t begin = 0; begin < points.size(); begin += dimension) {
      batch.push_back({Eigen::Map<const Eigen::VectorXd>(points.data() + begin, size), ""});
    }
    const auto answers = channel->Evaluate(std::move(batch));
    if (!answers) throw Cancelled{};
    pagmo::vector_double values;
    for (const BlockingSolver::Answer& answer : *answers) {
      values.insert(values.end(), answer.values.begin(), answer.values.end());
    }
    return values;
  }
  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    return {pagmo::vector_double(dimension, 0), pagmo::vector_double(dimension, 1)};
  }
  pagmo::vector_double::size_type get_nobj() const { return objectives; }
};

// Turns outcomes into numbers for pagmo, missing ones included.
class Numbers {
 public:
  explicit Numbers(int objectives)
      : best_(Eigen::VectorXd::Constant(objectives, 1e300)), worst_(-best_) {}

  void See(std::span<const Individual> individuals) {
    for (const Individual& individual : individuals) {
      for (Eigen::Index o = 0; o < best_.size(); ++o) {
        const double value = individual.values[o];
        if (!std::isfinite(value)) continue;
        best_[o] = std::min(best_[o], value);
        worst_[o] = std::max(worst_[o], value);
      }
    }
  }
  Eigen::VectorXd Of(const Individual& individual) const {
    Eigen::VectorXd values = individual.values;
    for (Eigen::Index o = 0; o < values.size(); ++o) {
      if (std::isfinite(values[o])) continue;
      values[o] = worst_[o] + kFailureMargin * (worst_[o] - best_[o] + 1);
    }
    return values;
  }

 private:
  Eigen::VectorXd best_;
  Eigen::VectorXd worst_;
};

class PagmoStrategy final : public Strategy {
 public:
  PagmoStrategy(pagmo::algorithm algorithm, const SearchProblem& problem)
      : algorithm_(std::move(algorithm)),
        dimension_(problem.dimension()),
        objectives_(problem.objectives),
        seed_(PagmoSeed(problem)),
        numbers_(problem.objectives) {}

  void Begin(std::vector<Individual> population) override;
  std::vector<Eigen::VectorXd> Propose() override;
  void Learn(std::span<const Individual> generation) override;
  std::string Message() const override { return message_; }

 private:
  // In the solver's thread, which has the members to itself while it runs.
  void Run(BlockingSolver::Channel& channel, const std::vector<Individual>& individuals);

  pagmo::algorithm algorithm_;
  Eigen::Index dimension_;
  int objectives_;
  unsigned seed_;
  Numbers numbers_;
  std::string reason_;  // why the algorithm has ended
  std::string message_;
  std::vector<std::int64_t> tickets_;        // of the batch that was proposed
  std::unique_ptr<BlockingSolver> solver_;  // the last member: its thread uses the others
};

void PagmoStrategy::Begin(std::vector<Individual> individuals) {
  numbers_.See(individuals);
  solver_ = std::make_unique<BlockingSolver>(
      [this, individuals = std::move(individuals)](BlockingSolver::Channel& channel) {
        Run(channel, individuals);
      });
}

void PagmoStrategy::Run(BlockingSolver::Channel& channel,
                        const std::vector<Individual>& individuals) {
  try {
    pagmo::population population(
        pagmo::problem(ChannelProblem{&channel, static_cast<std::size_t>(dimension_),
                                      static_cast<std::size_t>(objectives_)}),
        0, seed_);
    for (const Individual& individual : individuals) {
      const Eigen::VectorXd values = numbers_.Of(individual);
      population.push_back({individual.point.begin(), individual.point.end()},
                           {values.begin(), values.end()});
    }
    // An algorithm may have ends of its own; then it goes on from where it was, unless it has
    // nothing to evaluate any more.
    for (auto before = population.get_problem().get_fevals();;) {
      population = algorithm_.evolve(population);
      const auto after = population.get_problem().get_fevals();
      if (after == before) break;
      before = after;
    }
    reason_ = algorithm_.get_name() + " has converged";
  } catch (const Cancelled&) {
  } catch (const std::exception& error) {
    reason_ = algorithm_.get_name() + " has stopped: " + error.what();
  }
}

std::vector<Eigen::VectorXd> PagmoStrategy::Propose() {
  std::vector<Eigen::VectorXd> points;
  tickets_.clear();
  while (auto ticket = solver_->Take()) {
    points.push_back(std::move(ticket->request.point));
    tickets_.push_back(ticket->number);
  }
  if (points.empty()) message_ = reason_;
  return points;
}

void PagmoStrategy::Learn(std::span<const Individual> generation) {
  numbers_.See(generation);
  for (std::size_t i = 0; i < generation.size(); ++i) {
    solver_->Give(tickets_[i], {.values = numbers_.Of(generation[i]), .variances = {}});
  }
}

}  // namespace

std::unique_ptr<Strategy> MakePagmoStrategy(pagmo::algorithm algorithm,
                                            const SearchProblem& problem) {
  return std::make_unique<PagmoStrategy>(std::move(algorithm), problem);
}

unsigned PagmoSeed(const SearchProblem& problem) {
  return static_cast<unsigned>(problem.random.Split("pagmo").seed());
}

}  // namespace powdercal

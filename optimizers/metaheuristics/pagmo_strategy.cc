#include "optimizers/metaheuristics/pagmo_strategy.h"

#include <memory>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <thread>
#include <utility>

#include "optimizers/metaheuristics/pagmo_channel.h"

namespace powdercal {
namespace {

constexpr double kFailureMargin = 1000;

// The unit box behind a channel; pagmo copies problems at will.
struct ChannelProblem {
  std::shared_ptr<PagmoChannel> channel;
  std::size_t dimension = 1;
  std::size_t objectives = 1;

  pagmo::vector_double fitness(const pagmo::vector_double& point) const {
    return channel->Evaluate(point);
  }
  pagmo::vector_double batch_fitness(const pagmo::vector_double& points) const {
    return channel->Evaluate(points);
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
  pagmo::vector_double Of(const Individual& individual) const {
    pagmo::vector_double values(individual.values.begin(), individual.values.end());
    for (std::size_t o = 0; o < values.size(); ++o) {
      if (std::isfinite(values[o])) continue;
      const auto i = static_cast<Eigen::Index>(o);
      values[o] = worst_[i] + kFailureMargin * (worst_[i] - best_[i] + 1);
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
  ~PagmoStrategy() override {
    channel_->Close();
    if (thread_.joinable()) thread_.join();
  }
  PagmoStrategy(const PagmoStrategy&) = delete;
  PagmoStrategy& operator=(const PagmoStrategy&) = delete;

  void Begin(std::vector<Individual> population) override;
  std::vector<Eigen::VectorXd> Propose() override;
  void Learn(std::span<const Individual> generation) override;
  std::string Message() const override { return message_; }

 private:
  void Run(pagmo::population population);

  pagmo::algorithm algorithm_;
  Eigen::Index dimension_;
  int objectives_;
  unsigned seed_;
  Numbers numbers_;
  std::shared_ptr<PagmoChannel> channel_ = std::make_shared<PagmoChannel>();
  std::thread thread_;
  std::string message_;
};

void PagmoStrategy::Begin(std::vector<Individual> individuals) {
  pagmo::population population(
      pagmo::problem(ChannelProblem{channel_, static_cast<std::size_t>(dimension_),
                                    static_cast<std::size_t>(objectives_)}),
      0, seed_);
  numbers_.See(individuals);
  for (const Individual& individual : individuals) {
    population.push_back({individual.point.begin(), individual.point.end()},
                         numbers_.Of(individual));
  }
  thread_ = std::thread(
      [this, population = std::move(population)]() mutable { Run(std::move(population)); });
}

void PagmoStrategy::Run(pagmo::population population) {
  std::string reason;
  try {
    // An algorithm may have ends of its own; then it goes on from where it was, unless it has
    // nothing to evaluate any more.
    for (auto before = population.get_problem().get_fevals();;) {
      population = algorithm_.evolve(population);
      const auto after = population.get_problem().get_fevals();
      if (after == before) break;
      before = after;
    }
    reason = algorithm_.get_name() + " has converged";
  } catch (const PagmoChannel::Closed&) {
  } catch (const std::exception& error) {
    reason = algorithm_.get_name() + " has stopped: " + error.what();
  }
  channel_->End(std::move(reason));
}

std::vector<Eigen::VectorXd> PagmoStrategy::Propose() {
  std::vector<Eigen::VectorXd> points;
  const auto batch = channel_->Receive();
  if (!batch) {
    message_ = channel_->reason();
    return points;
  }
  const auto values = static_cast<Eigen::Index>(batch->size());
  for (Eigen::Index begin = 0; begin < values; begin += dimension_) {
    points.emplace_back(Eigen::Map<const Eigen::VectorXd>(batch->data() + begin, dimension_));
  }
  return points;
}

void PagmoStrategy::Learn(std::span<const Individual> generation) {
  numbers_.See(generation);
  pagmo::vector_double values;
  for (const Individual& individual : generation) {
    const pagmo::vector_double of_point = numbers_.Of(individual);
    values.insert(values.end(), of_point.begin(), of_point.end());
  }
  channel_->Send(std::move(values));
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

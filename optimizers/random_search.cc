#include "optimizers/random_search.h"

#include "core/random.h"

namespace powdercal {
namespace {

class RandomSearch final : public Optimizer {
 public:
  RandomSearch(const SearchSpace& space, std::uint64_t seed)
      : space_(space), stream_(RandomStream(seed).Split("random")) {}

  std::vector<Candidate> Ask(int max_count) override {
    std::vector<Candidate> candidates;
    for (int i = 0; i < max_count; ++i) {
      // A stream for each candidate: how many are asked for at a time makes no difference.
      RandomStream random = stream_.Split(static_cast<std::uint64_t>(asked_));
      Candidate candidate{asked_++, Eigen::VectorXd(space_.dimension()), "random"};
      for (double& u : candidate.point) u = random.Uniform();
      candidate.point = space_.Snap(candidate.point);
      candidates.push_back(std::move(candidate));
    }
    return candidates;
  }
  void Tell(std::span<const Observation>) override {}
  Status status() const override { return {}; }
  Capabilities capabilities() const override {
    return {.asynchronous = true, .pareto = true, .discrete = true};
  }
  std::string ExplainUnsupported(const SearchSpace&, const Objectives&) const override {
    return "";
  }

 private:
  SearchSpace space_;
  RandomStream stream_;
  std::int64_t asked_ = 0;
};

class RandomSearchFactory final : public OptimizerFactory {
 public:
  const std::string& name() const override {
    static const std::string name = "random";
    return name;
  }
  std::string Describe() const override {
    return "independent uniform points, without end (a baseline)";
  }
  void Serialize(Archive&, const SearchSpace&) override {}
  std::unique_ptr<Optimizer> Make(const SearchSpace& space, const Objectives&,
                                  std::uint64_t seed) const override {
    return std::make_unique<RandomSearch>(space, seed);
  }
};

}  // namespace

std::unique_ptr<OptimizerFactory> MakeRandomSearchFactory() {
  return std::make_unique<RandomSearchFactory>();
}

}  // namespace powdercal

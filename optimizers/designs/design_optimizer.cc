#include "optimizers/designs/design_optimizer.h"

#include <fmt/format.h>

#include "optimizers/designs/design.h"

namespace powdercal {
namespace {

std::string DescribeDesign(const std::string& name) {
  if (name == "corners_and_centre") return "the 2^d corners and the centre of the box";
  if (name == "grid") return "a full grid of `levels` values of each parameter";
  if (name == "latin_hypercube") return "a maximin Latin hypercube of `points` points";
  if (name == "orthogonal_array") {
    return "`levels`² points, each pair of levels of two parameters once (strength 2)";
  }
  if (name == "list") return "the user's own list of `points`";
  return "the first `points` points of a shifted Sobol' sequence";
}

class DesignOptimizer final : public Optimizer {
 public:
  DesignOptimizer(std::string name, DesignOptions options, const SearchSpace& space,
                  std::uint64_t seed)
      : name_(std::move(name)), options_(std::move(options)) {
    if (options_.ExplainUnsupported(space).empty()) points_ = MakeDesign(options_, space, seed);
  }

  std::vector<Candidate> Ask(int max_count) override {
    std::vector<Candidate> candidates;
    while (static_cast<int>(candidates.size()) < max_count && asked_ < points_.size()) {
      const DesignPoint& point = points_[asked_];
      candidates.push_back({static_cast<std::int64_t>(asked_), point.point,
                            fmt::format("{}: {}", name_, point.label)});
      ++asked_;
    }
    return candidates;
  }
  void Tell(std::span<const Observation>) override {}
  Status status() const override {
    if (asked_ < points_.size()) return {};
    return {
        Status::Phase::finished,
        fmt::format("all {} points of the design '{}' have been asked for", points_.size(), name_)};
  }
  Capabilities capabilities() const override {
    return {.asynchronous = true, .pareto = true, .discrete = true};
  }
  std::string ExplainUnsupported(const SearchSpace& space, const Objectives&) const override {
    return options_.ExplainUnsupported(space);
  }

 private:
  std::string name_;
  DesignOptions options_;
  std::vector<DesignPoint> points_;
  std::size_t asked_ = 0;
};

class DesignFactory final : public OptimizerFactory {
 public:
  explicit DesignFactory(const std::string& name) : description_(DescribeDesign(name)) {
    options_.name = name;
  }

  const std::string& name() const override { return options_.name; }
  std::string Describe() const override { return description_; }
  void Serialize(Archive& archive, const SearchSpace& space) override {
    options_.Serialize(archive, space);
  }
  std::unique_ptr<Optimizer> Make(const SearchSpace& space, const Objectives&,
                                  std::uint64_t seed) const override {
    return std::make_unique<DesignOptimizer>(options_.name, options_, space, seed);
  }

 private:
  std::string description_;
  DesignOptions options_;
};

}  // namespace

std::unique_ptr<OptimizerFactory> MakeDesignFactory(const std::string& name) {
  return std::make_unique<DesignFactory>(name);
}

}  // namespace powdercal

#include "optimizers/metaheuristics/differential_evolution.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "optimizers/metaheuristics/pagmo_methods.h"
#include "optimizers/metaheuristics/variation.h"

namespace powdercal {
namespace {

constexpr std::size_t kMemory = 6;  // H of Tanabe & Fukunaga

struct Setting {
  double f = 0.5;
  double cr = 0.5;
};

struct Success {
  Setting setting;
  double gain = 0;
};

// Means of the successful settings, weighted by gain: Lehmer's of F, arithmetic of CR (Tanabe &
// Fukunaga 2013, equations 13 to 16).
Setting WeightedMeans(const std::vector<Success>& successes) {
  double weights = 0, f = 0, f_squared = 0, cr = 0;
  for (const Success& success : successes) {
    weights += success.gain;
    f += success.gain * success.setting.f;
    f_squared += success.gain * success.setting.f * success.setting.f;
    cr += success.gain * success.setting.cr;
  }
  return {f_squared / f, cr / weights};
}

class DifferentialEvolution final : public Strategy {
 public:
  DifferentialEvolution(const DifferentialEvolutionOptions& options, const SearchProblem& problem)
      : options_(options), random_(problem.random), memory_(kMemory) {}

  void Begin(std::vector<Individual> population) override { members_ = std::move(population); }
  std::vector<Eigen::VectorXd> Propose() override;
  void Learn(std::span<const Individual> generation) override;
  void Revise(const Individual& revised) override { ReviseMembers(members_, revised); }

 private:
  Setting DrawSetting();
  Eigen::VectorXd Trial(std::size_t target, const Eigen::VectorXd& best, const Setting& setting);
  void Keep(Eigen::VectorXd point);

  DifferentialEvolutionOptions options_;
  RandomStream random_;
  std::vector<Setting> memory_;
  std::size_t next_memory_ = 0;
  std::vector<Individual> members_;  // their points not snapped
  std::vector<Eigen::VectorXd> archive_;
  std::vector<Eigen::VectorXd> trials_;
  std::vector<Setting> settings_;  // of the trials
};

// F: Cauchy about the remembered one, (0, 1]; CR: normal, [0, 1].
Setting DifferentialEvolution::DrawSetting() {
  const Setting& centre = memory_[random_.Below(kMemory)];
  Setting setting;
  setting.cr = std::clamp(centre.cr + 0.1 * random_.Normal(), 0.0, 1.0);
  do {
    setting.f = centre.f + 0.1 * std::tan(std::numbers::pi * (random_.Uniform() - 0.5));
  } while (setting.f <= 0);
  setting.f = std::min(setting.f, 1.0);
  return setting;
}

Eigen::VectorXd DifferentialEvolution::Trial(std::size_t target, const Eigen::VectorXd& best,
                                             const Setting& setting) {
  const std::size_t count = members_.size();
  std::size_t first = target;
  while (first == target) first = random_.Below(count);
  std::size_t second = target;
  while (second == target || second == first) second = random_.Below(count + archive_.size());
  const Eigen::VectorXd& base = members_[target].point;
  const Eigen::VectorXd& other = second < count ? members_[second].point : archive_[second - count];
  const Eigen::VectorXd mutant =
      base + setting.f * (best - base) + setting.f * (members_[first].point - other);
  Eigen::VectorXd trial = base;
  const auto sure =
      static_cast<Eigen::Index>(random_.Below(static_cast<std::uint64_t>(trial.size())));
  for (Eigen::Index k = 0; k < trial.size(); ++k) {
    if (random_.Uniform() >= setting.cr && k != sure) continue;
    trial[k] = mutant[k] < 0 ? base[k] / 2 : mutant[k] > 1 ? (base[k] + 1) / 2 : mutant[k];
  }
  return trial;
}

std::vector<Eigen::VectorXd> DifferentialEvolution::Propose() {
  trials_.clear();
  settings_.clear();
  const std::vector<std::size_t> ranking = Ranking(members_);
  const auto succeeded = static_cast<std::size_t>(
      std::count_if(members_.begin(), members_.end(),
                    [](const Individual& member) { return member.Complete(); }));
  const double share = options_.best_share * static_cast<double>(members_.size());
  std::size_t best_count = std::min<std::size_t>(std::max(2LL, std::llround(share)), succeeded);
  best_count = std::max<std::size_t>(best_count, 1);
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const Setting setting = DrawSetting();
    const Eigen::VectorXd& best = members_[ranking[random_.Below(best_count)]].point;
    // Coordinates of a Sobol' sequence form a grid, on which differences cancel exactly.
    Eigen::VectorXd trial = members_[i].point;
    for (int k = 0; k < kTriesForANewPoint && trial == members_[i].point; ++k) {
      trial = Trial(i, best, setting);
    }
    trials_.push_back(std::move(trial));
    settings_.push_back(setting);
  }
  return trials_;
}

// Holds as many as there are members; a random one gives way.
void DifferentialEvolution::Keep(Eigen::VectorXd point) {
  if (archive_.size() < members_.size()) {
    archive_.push_back(std::move(point));
  } else {
    archive_[random_.Below(archive_.size())] = std::move(point);
  }
}

void DifferentialEvolution::Learn(std::span<const Individual> generation) {
  std::vector<Success> successes;
  for (std::size_t i = 0; i < generation.size(); ++i) {
    Individual& member = members_[i];
    if (!generation[i].Complete() || Better(member, generation[i])) continue;
    if (Better(generation[i], member)) {
      // How much was gained on a failed member cannot be said.
      if (member.Complete()) {
        successes.push_back({settings_[i], member.values[0] - generation[i].values[0]});
      }
      Keep(member.point);
    }
    member = generation[i];
    member.point = trials_[i];
  }
  if (successes.empty()) return;
  memory_[next_memory_] = WeightedMeans(successes);
  next_memory_ = (next_memory_ + 1) % kMemory;
}

class DifferentialEvolutionMethod final : public Method {
 public:
  const std::string& name() const override {
    static const std::string name = "differential_evolution";
    return name;
  }
  std::string Describe() const override {
    return "differential evolution that adapts its settings; one objective";
  }
  MethodTraits traits() const override {
    const bool own = options_.implementation == Implementation::own;
    return {.batches = own, .smallest_population = own ? 4 : 7};
  }
  int DefaultPopulation(int, int) const override { return 16; }
  void Serialize(Archive& archive) override {
    SerializeImplementation(archive, options_.implementation);
    if (options_.implementation == Implementation::pagmo) return;
    archive.Number("best_share", options_.best_share, {.lower = 0, .upper = 1, .lower_open = true});
  }
  std::unique_ptr<Strategy> MakeStrategy(const SearchProblem& problem) const override {
    return options_.implementation == Implementation::own
               ? MakeDifferentialEvolution(options_, problem)
               : MakePagmoDifferentialEvolution(problem);
  }

 private:
  DifferentialEvolutionOptions options_;
};

}  // namespace

std::unique_ptr<Strategy> MakeDifferentialEvolution(const DifferentialEvolutionOptions& options,
                                                    const SearchProblem& problem) {
  return std::make_unique<DifferentialEvolution>(options, problem);
}

std::unique_ptr<Method> MakeDifferentialEvolutionMethod() {
  return std::make_unique<DifferentialEvolutionMethod>();
}

}  // namespace powdercal

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "optimizers/bayesian/expected_improvement.h"
#include "optimizers/bayesian/sampled_acquisition.h"
#include "optimizers/pareto.h"

namespace powdercal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// ln E[max(0, level − objective)] with derivatives by the term's own responses.
double LogImprovementBelow(const ObjectiveTerm& term, double level, const Eigen::ArrayXd& means,
                           const Eigen::ArrayXd& variances, Eigen::ArrayXd* by_mean,
                           Eigen::ArrayXd* by_variance) {
  const auto count = static_cast<Eigen::Index>(term.processes.size());
  Eigen::ArrayXd mean(count);
  Eigen::ArrayXd variance(count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const auto process = static_cast<Eigen::Index>(term.processes[static_cast<std::size_t>(j)]);
    mean[j] = means[process] - term.targets[j];
    variance[j] = variances[process];
  }
  if (!term.linear) {
    return CompositeLogExpectedImprovement(std::max(level, kSmallestObjective), mean, variance,
                                           term.weights, by_mean, by_variance);
  }
  const double w = term.weights[0];
  const LogImprovement improvement =
      LogExpectedImprovement(level, w * mean[0], w * w * variance[0]);
  if (by_mean != nullptr) *by_mean = Eigen::ArrayXd::Constant(1, w * improvement.by_mean);
  if (by_variance != nullptr) {
    *by_variance = Eigen::ArrayXd::Constant(1, w * w * improvement.by_variance);
  }
  return improvement.value;
}

// Adds `factor` times the term's own derivatives to those by all responses.
void Scatter(const ObjectiveTerm& term, double factor, const Eigen::ArrayXd& own,
             Eigen::ArrayXd* all) {
  for (std::size_t j = 0; j < term.processes.size(); ++j) {
    (*all)[static_cast<Eigen::Index>(term.processes[j])] +=
        factor * own[static_cast<Eigen::Index>(j)];
  }
}

class ImprovementUtility final : public SampleUtility {
 public:
  ImprovementUtility(ObjectiveTerm term, Eigen::Index samples)
      : term_(std::move(term)), bests_(samples) {}

  void SetSample(Eigen::Index k, const Eigen::MatrixXd& objectives) override {
    bests_[k] = objectives.col(0).minCoeff();
  }
  double LogGain(Eigen::Index k, const Eigen::ArrayXd& means, const Eigen::ArrayXd& variances,
                 Eigen::ArrayXd* by_mean, Eigen::ArrayXd* by_variance) const override {
    Eigen::ArrayXd own_mean;
    Eigen::ArrayXd own_variance;
    const bool sloped = by_mean != nullptr;
    const double value =
        LogImprovementBelow(term_, bests_[k], means, variances, sloped ? &own_mean : nullptr,
                            sloped ? &own_variance : nullptr);
    if (sloped) {
      *by_mean = Eigen::ArrayXd::Zero(means.size());
      *by_variance = Eigen::ArrayXd::Zero(means.size());
      Scatter(term_, 1, own_mean, by_mean);
      Scatter(term_, 1, own_variance, by_variance);
    }
    return value;
  }

 private:
  ObjectiveTerm term_;
  Eigen::ArrayXd bests_;
};

class HypervolumeUtility final : public SampleUtility {
 public:
  HypervolumeUtility(std::vector<ObjectiveTerm> terms, Eigen::VectorXd reference,
                     Eigen::Index samples)
      : terms_(std::move(terms)),
        reference_(std::move(reference)),
        fronts_(static_cast<std::size_t>(samples)) {}

  void SetSample(Eigen::Index k, const Eigen::MatrixXd& objectives) override {
    const Boxes boxes = NonDominatedBoxes(objectives, reference_);
    Front& front = fronts_[static_cast<std::size_t>(k)];
    front.lower.resize(boxes.lower.rows(), boxes.lower.cols());
    front.upper.resize(boxes.lower.rows(), boxes.lower.cols());
    front.levels.resize(terms_.size());
    for (Eigen::Index o = 0; o < boxes.lower.cols(); ++o) {
      std::vector<double>& levels = front.levels[static_cast<std::size_t>(o)];
      levels.assign(boxes.upper.col(o).begin(), boxes.upper.col(o).end());
      for (const double value : boxes.lower.col(o)) {
        if (std::isfinite(value)) levels.push_back(value);
      }
      std::sort(levels.begin(), levels.end());
      levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
      const auto index = [&](double value) {
        if (!std::isfinite(value)) return -1;
        return static_cast<int>(std::lower_bound(levels.begin(), levels.end(), value) -
                                levels.begin());
      };
      for (Eigen::Index b = 0; b < boxes.lower.rows(); ++b) {
        front.lower(b, o) = index(boxes.lower(b, o));
        front.upper(b, o) = index(boxes.upper(b, o));
      }
    }
  }

  double LogGain(Eigen::Index k, const Eigen::ArrayXd& means, const Eigen::ArrayXd& variances,
                 Eigen::ArrayXd* by_mean, Eigen::ArrayXd* by_variance) const override {
    const Front& front = fronts_[static_cast<std::size_t>(k)];
    const bool sloped = by_mean != nullptr;
    std::vector<std::vector<Below>> below(terms_.size());
    for (std::size_t o = 0; o < terms_.size(); ++o) {
      for (const double level : front.levels[o]) {
        Below& entry = below[o].emplace_back();
        entry.value = std::exp(LogImprovementBelow(terms_[o], level, means, variances,
                                                   sloped ? &entry.by_mean : nullptr,
                                                   sloped ? &entry.by_variance : nullptr));
      }
    }
    // Gain = Σ_b Π_o (E_o(upper) − E_o(lower)), E_o the improvement below a level. `weights`: its
    // derivative by each E_o.
    double gain = 0;
    std::vector<std::vector<double>> weights(terms_.size());
    for (std::size_t o = 0; o < terms_.size(); ++o) weights[o].assign(below[o].size(), 0);
    std::vector<double> sides(terms_.size());
    for (Eigen::Index b = 0; b < front.lower.rows(); ++b) {
      double product = 1;
      for (std::size_t o = 0; o < terms_.size(); ++o) {
        const auto column = static_cast<Eigen::Index>(o);
        const int low = front.lower(b, column);
        sides[o] = below[o][static_cast<std::size_t>(front.upper(b, column))].value -
                   (low < 0 ? 0 : below[o][static_cast<std::size_t>(low)].value);
        product *= sides[o];
      }
      gain += product;
      for (std::size_t o = 0; o < terms_.size() && sloped; ++o) {
        double others = 1;
        for (std::size_t p = 0; p < terms_.size(); ++p) {
          if (p != o) others *= sides[p];
        }
        const auto column = static_cast<Eigen::Index>(o);
        weights[o][static_cast<std::size_t>(front.upper(b, column))] += others;
        const int low = front.lower(b, column);
        if (low >= 0) weights[o][static_cast<std::size_t>(low)] -= others;
      }
    }
    if (!(gain > 0)) return -kInfinity;
    if (sloped) {
      *by_mean = Eigen::ArrayXd::Zero(means.size());
      *by_variance = Eigen::ArrayXd::Zero(means.size());
      for (std::size_t o = 0; o < terms_.size(); ++o) {
        for (std::size_t i = 0; i < below[o].size(); ++i) {
          const double factor = weights[o][i] * below[o][i].value / gain;
          Scatter(terms_[o], factor, below[o][i].by_mean, by_mean);
          Scatter(terms_[o], factor, below[o][i].by_variance, by_variance);
        }
      }
    }
    return std::log(gain);
  }

 private:
  struct Front {
    std::vector<std::vector<double>> levels;  // of each objective, ascending
    Eigen::MatrixXi lower;                    // boxes × objectives: index of the level, −1: none
    Eigen::MatrixXi upper;
  };
  struct Below {
    double value = 0;
    Eigen::ArrayXd by_mean;  // of its logarithm
    Eigen::ArrayXd by_variance;
  };

  std::vector<ObjectiveTerm> terms_;
  Eigen::VectorXd reference_;
  std::vector<Front> fronts_;
};

class ChebyshevUtility final : public SampleUtility {
 public:
  ChebyshevUtility(std::vector<ObjectiveTerm> terms, Eigen::ArrayXd shares,
                   const Eigen::MatrixXd& normals)
      : terms_(std::move(terms)),
        shares_(std::move(shares)),
        normals_(normals),
        samples_(static_cast<std::size_t>(normals.cols())) {}

  void SetSample(Eigen::Index k, const Eigen::MatrixXd& objectives) override {
    Sample& sample = samples_[static_cast<std::size_t>(k)];
    sample.ideal = objectives.colwise().minCoeff().transpose();
    sample.range = Eigen::ArrayXd::Ones(objectives.cols());
    const std::vector<std::size_t> front = NonDominated(objectives);
    for (Eigen::Index o = 0; o < objectives.cols(); ++o) {
      double highest = sample.ideal[o];
      for (const std::size_t i : front) {
        highest = std::max(highest, objectives(static_cast<Eigen::Index>(i), o));
      }
      if (highest > sample.ideal[o]) sample.range[o] = highest - sample.ideal[o];
    }
    sample.best = kInfinity;
    for (Eigen::Index i = 0; i < objectives.rows(); ++i) {
      sample.best =
          std::min(sample.best, Norm(sample, objectives.row(i).transpose().array(), nullptr));
    }
  }

  double LogGain(Eigen::Index k, const Eigen::ArrayXd& means, const Eigen::ArrayXd& variances,
                 Eigen::ArrayXd* by_mean, Eigen::ArrayXd* by_variance) const override {
    constexpr double kSmoothing = 1e-2;  // of the norm, whose scale is 1
    const Sample& sample = samples_[static_cast<std::size_t>(k)];
    const Eigen::ArrayXd normals = normals_.col(k).array();
    const Eigen::ArrayXd responses = means + variances.sqrt() * normals;
    Eigen::ArrayXd values(static_cast<Eigen::Index>(terms_.size()));
    for (std::size_t o = 0; o < terms_.size(); ++o) {
      values[static_cast<Eigen::Index>(o)] = terms_[o].ValueOf(responses);
    }
    Eigen::ArrayXd by_objective;
    const bool sloped = by_mean != nullptr;
    const double gain =
        (sample.best - Norm(sample, values, sloped ? &by_objective : nullptr)) / kSmoothing;
    // ln softplus, which is `gain` far below 0.
    const double soft = gain > 30 ? gain : std::log1p(std::exp(gain));
    const double value = gain < -30 ? gain : std::log(soft);
    if (sloped) {
      const double by_gain = gain < -30 ? 1 : 1 / ((1 + std::exp(-gain)) * soft);
      *by_mean = Eigen::ArrayXd::Zero(means.size());
      for (std::size_t o = 0; o < terms_.size(); ++o) {
        const ObjectiveTerm& term = terms_[o];
        Eigen::ArrayXd own = term.weights;
        for (Eigen::Index j = 0; j < own.size() && !term.linear; ++j) {
          const auto process =
              static_cast<Eigen::Index>(term.processes[static_cast<std::size_t>(j)]);
          own[j] *= 2 * (responses[process] - term.targets[j]);
        }
        Scatter(term, -by_gain * by_objective[static_cast<Eigen::Index>(o)] / kSmoothing, own,
                by_mean);
      }
      *by_variance = *by_mean * normals / (2 * variances.sqrt());
    }
    return value;
  }

 private:
  struct Sample {
    Eigen::ArrayXd ideal;
    Eigen::ArrayXd range;
    double best = 0;
  };

  double Norm(const Sample& sample, const Eigen::ArrayXd& objectives,
              Eigen::ArrayXd* gradient) const {
    constexpr double kAugmentation = 0.05;
    const Eigen::ArrayXd scaled = shares_ * (objectives - sample.ideal) / sample.range;
    Eigen::Index largest = 0;
    const double value = scaled.maxCoeff(&largest) + kAugmentation * scaled.sum();
    if (gradient != nullptr) {
      *gradient = kAugmentation * shares_ / sample.range;
      (*gradient)[largest] += shares_[largest] / sample.range[largest];
    }
    return value;
  }

  std::vector<ObjectiveTerm> terms_;
  Eigen::ArrayXd shares_;
  Eigen::MatrixXd normals_;
  std::vector<Sample> samples_;
};

}  // namespace

std::unique_ptr<SampleUtility> MakeImprovementUtility(ObjectiveTerm term, Eigen::Index samples) {
  return std::make_unique<ImprovementUtility>(std::move(term), samples);
}

std::unique_ptr<SampleUtility> MakeHypervolumeUtility(std::vector<ObjectiveTerm> terms,
                                                      const Eigen::VectorXd& reference,
                                                      Eigen::Index samples) {
  return std::make_unique<HypervolumeUtility>(std::move(terms), reference, samples);
}

std::unique_ptr<SampleUtility> MakeChebyshevUtility(std::vector<ObjectiveTerm> terms,
                                                    const Eigen::ArrayXd& shares,
                                                    const Eigen::MatrixXd& normals) {
  return std::make_unique<ChebyshevUtility>(std::move(terms), shares, normals);
}

}  // namespace powdercal

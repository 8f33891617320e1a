#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "optimizers/bayesian/acquisition.h"
#include "optimizers/feasibility.h"
#include "surrogates/sampled_process.h"

namespace powdercal {

/// How one objective is made of the processes: Σ_j weights_j (f_j − targets_j)², or, linear,
/// weights_0 (f_0 − targets_0).
struct ObjectiveTerm {
  bool linear = false;
  std::vector<std::size_t> processes;  ///< at least one; linear: exactly one
  Eigen::ArrayXd targets;
  Eigen::ArrayXd weights;

  double ValueOf(const Eigen::ArrayXd& responses) const;
};

/// What a sample of the responses at the evaluated points is worth, and what a further point adds
/// to it.
class SampleUtility {
 public:
  virtual ~SampleUtility() = default;

  /// Sets up sample k from its objectives at the evaluated and pending points (points ×
  /// objectives).
  virtual void SetSample(Eigen::Index k, const Eigen::MatrixXd& objectives) = 0;
  /// ln of the expected gain in sample k by a point with these means and variances of all responses
  /// (independent, normal); −∞ where it underflows. Derivatives of the logarithm unless null.
  virtual double LogGain(Eigen::Index k, const Eigen::ArrayXd& means,
                         const Eigen::ArrayXd& variances, Eigen::ArrayXd* by_mean,
                         Eigen::ArrayXd* by_variance) const = 0;
};

/// Expected improvement on the best of a sample: qLogNEI (Letham et al. 2019; Ament et al. 2023).
std::unique_ptr<SampleUtility> MakeImprovementUtility(ObjectiveTerm term, Eigen::Index samples);
/// Expected gain of hypervolume below `reference` (in units of the objectives), over the front of a
/// sample: qLogNEHVI (Daulton, Balandat & Bakshy 2021). Exact: the region that is not dominated is
/// cut into boxes, in each of which the gain is a product of one-dimensional expected improvements.
std::unique_ptr<SampleUtility> MakeHypervolumeUtility(std::vector<ObjectiveTerm> terms,
                                                      const Eigen::VectorXd& reference,
                                                      Eigen::Index samples);
/// Expected decrease of the augmented Chebyshev norm max_o λ_o u_o + 0.05 Σ λ_o u_o of objectives
/// u_o = (c_o − ideal_o)/range_o: qLogNParEGO (Knowles 2006; Daulton et al. 2020). One outcome of
/// the new point is drawn in each sample, and the gain smoothed so that it never vanishes. normals:
/// responses × samples.
std::unique_ptr<SampleUtility> MakeChebyshevUtility(std::vector<ObjectiveTerm> terms,
                                                    const Eigen::ArrayXd& shares,
                                                    const Eigen::MatrixXd& normals);

/// ln [p(x) · (1/K) Σ_k gain_k(x)] over K samples of what the processes say of the points that were
/// evaluated, with noise, and of those that are under way: nothing evaluated is taken for known
/// beyond its noise, and a further point is worth what it adds to the pending ones.
class SampledAcquisition final : public Acquisition {
 public:
  struct Data {
    std::vector<GaussianProcess> processes;  ///< fitted
    /// For each process, points without an observation of it: pending, failed. m_j × d
    std::vector<Eigen::MatrixXd> unobserved;
    Eigen::MatrixXd counted;  ///< n × d: evaluated and pending points, which have objectives
    std::vector<ObjectiveTerm> terms;
    Feasibility feasibility;
  };

  /// seed: of the samples. Throws std::runtime_error where a covariance cannot be factorised.
  SampledAcquisition(Data data, std::unique_ptr<SampleUtility> utility, Eigen::Index samples,
                     std::uint64_t seed);

  double Evaluate(const Eigen::VectorXd& point, Eigen::VectorXd* gradient) const override;
  Eigen::VectorXd EvaluateMany(const Eigen::MatrixXd& points) const override;
  double LogFeasibility(const Eigen::VectorXd& point) const override {
    return feasibility_.LogProbability(point, nullptr);
  }
  /// With the lowest mean over the samples of the first objective.
  const Eigen::VectorXd& best_point() const override { return best_point_; }

 private:
  Feasibility feasibility_;
  std::vector<SampledProcess> processes_;
  std::unique_ptr<SampleUtility> utility_;
  Eigen::Index samples_;
  Eigen::VectorXd best_point_;
};

}  // namespace powdercal

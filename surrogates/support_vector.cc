#include "surrogates/support_vector.h"

#include <dlib/svm/kernel.h>
#include <dlib/svm/svr_trainer.h>
#include <fmt/format.h>

#include <cassert>

#include "surrogates/fitting.h"

namespace powdercal {
namespace {

using Sample = dlib::matrix<double, 0, 1>;
using RadialKernel = dlib::radial_basis_kernel<Sample>;

constexpr double kSolverTolerance = 1e-4;  // of the optimality conditions

Sample ToSample(const Eigen::VectorXd& point) {
  Sample sample(point.size());
  for (Eigen::Index k = 0; k < point.size(); ++k) sample(k) = point[k];
  return sample;
}

}  // namespace

struct SupportVector::Machine {
  dlib::decision_function<RadialKernel> function;

  static Machine Train(const Eigen::MatrixXd& points, const Eigen::VectorXd& values, double gamma,
                       double cost, double tube) {
    std::vector<Sample> samples;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      samples.push_back(ToSample(points.row(i).transpose()));
    }
    const std::vector<double> targets(values.begin(), values.end());
    dlib::svr_trainer<RadialKernel> trainer;
    trainer.set_kernel(RadialKernel(gamma));
    trainer.set_c(cost);
    trainer.set_epsilon_insensitivity(tube);
    trainer.set_epsilon(kSolverTolerance);
    Machine machine{trainer.train(samples, targets)};
    // Every constant is optimal that has all values in its tube; the trainer takes an extreme one.
    if (machine.function.basis_vectors.size() == 0) {
      machine.function.b = -0.5 * (values.minCoeff() + values.maxCoeff());
    }
    return machine;
  }
};

SupportVector::SupportVector(Options options) : options_(std::move(options)) {
  assert(!options_.gammas.empty() && !options_.costs.empty() && !options_.tubes.empty());
  assert(options_.folds >= 2);
}
SupportVector::~SupportVector() = default;

const std::string& SupportVector::name() const {
  static const std::string kName = "support_vector";
  return kName;
}

void SupportVector::Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
                        const Eigen::VectorXd& noise_variances) {
  CheckObservations(name(), points, values, noise_variances);
  count_ = points.rows();
  const Standardisation standard = Standardise(values);
  offset_ = standard.offset;
  scale_ = standard.scale;
  const Eigen::VectorXd scaled = standard.Apply(values);
  gamma_ = options_.gammas.front();
  cost_ = options_.costs.front();
  tube_ = options_.tubes.front();
  double least = kUnknownVariance;
  const std::vector<int> folds = SelectionFolds(count_, options_.folds);
  for (const double gamma : count_ > 1 ? options_.gammas : std::vector<double>{}) {
    for (const double cost : options_.costs) {
      for (const double tube : options_.tubes) {
        const CandidateFits fit = [&](const Eigen::MatrixXd& some, const Eigen::VectorXd& theirs,
                                      const Eigen::MatrixXd& targets) -> Eigen::MatrixXd {
          const Machine machine = Machine::Train(some, theirs, gamma, cost, tube);
          Eigen::MatrixXd predictions(targets.rows(), 1);
          for (Eigen::Index i = 0; i < targets.rows(); ++i) {
            predictions(i, 0) = machine.function(ToSample(targets.row(i).transpose()));
          }
          return predictions;
        };
        const double error = CrossValidatedErrors(folds, points, scaled, fit)[0];
        if (!(error < least)) continue;
        least = error;
        gamma_ = gamma;
        cost_ = cost;
        tube_ = tube;
      }
    }
  }
  variance_ = least * scale_ * scale_;
  machine_ = std::make_unique<const Machine>(Machine::Train(points, scaled, gamma_, cost_, tube_));
}

Prediction SupportVector::Predict(const Eigen::VectorXd& point) const {
  assert(machine_);
  return {.mean = offset_ + scale_ * machine_->function(ToSample(point)), .variance = variance_};
}

std::string SupportVector::Describe() const {
  if (!machine_) return "support vector regression, not fitted";
  return fmt::format(
      "support vector regression, RBF, {} points, {} support vectors, gamma {:g}, C {:g}, epsilon "
      "{:.3g}",
      count_, machine_->function.basis_vectors.size(), gamma_, cost_, tube_ * scale_);
}

}  // namespace powdercal

#include "surrogates/surrogate.h"

#include <array>
#include <stdexcept>
#include <vector>

#include "core/errors.h"
#include "surrogates/gaussian_process.h"

namespace powdercal {
namespace {

const std::array<std::string, 1> kNames = {"gaussian_process"};

}  // namespace

std::span<const std::string> SurrogateNames() { return kNames; }

std::unique_ptr<Surrogate> MakeSurrogate(const std::string& name) {
  if (name == "gaussian_process") return std::make_unique<GaussianProcess>();
  throw UnknownName("surrogate", name, kNames);
}

double LeaveOneOutR2(const SurrogateMaker& make, const Eigen::MatrixXd& points,
                     const Eigen::VectorXd& values) {
  const Eigen::Index n = points.rows();
  if (n < 3 || values.size() != n) {
    throw std::invalid_argument("LeaveOneOutR2: needs at least 3 points with one value each");
  }
  double residual = 0;
  for (Eigen::Index left_out = 0; left_out < n; ++left_out) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (i != left_out) kept.push_back(i);
    }
    const std::unique_ptr<Surrogate> surrogate = make();
    surrogate->Fit(points(kept, Eigen::all), values(kept), {});
    const double error =
        surrogate->Predict(points.row(left_out).transpose()).mean - values[left_out];
    residual += error * error;
  }
  const double total = (values.array() - values.mean()).square().sum();
  if (total == 0) throw std::invalid_argument("LeaveOneOutR2: all values are equal");
  return 1 - residual / total;
}

double LeaveOneOutR2(const std::string& surrogate, const Eigen::MatrixXd& points,
                     const Eigen::VectorXd& values) {
  return LeaveOneOutR2([&] { return MakeSurrogate(surrogate); }, points, values);
}

}  // namespace powdercal

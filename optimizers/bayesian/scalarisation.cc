#include "optimizers/bayesian/scalarisation.h"

#include <algorithm>

#include "optimizers/pareto.h"

namespace powdercal {
namespace {

constexpr double kSharedByAll = 0.01;

// Uniform over the simplex: exponential variates over their sum.
Eigen::ArrayXd SimplexPoint(Eigen::Index count, RandomStream& random) {
  Eigen::ArrayXd point(count);
  for (double& share : point) share = -PortableLog(1 - random.Uniform());
  const double sum = point.sum();
  return sum > 0 ? Eigen::ArrayXd(point / sum)
                 : Eigen::ArrayXd::Constant(count, 1.0 / static_cast<double>(count));
}

Eigen::ArrayXd FrontRanges(const Eigen::MatrixXd& chi2) {
  Eigen::ArrayXd ranges = Eigen::ArrayXd::Ones(chi2.cols());
  const std::vector<std::size_t> front = NonDominated(chi2);
  for (Eigen::Index o = 0; o < chi2.cols() && !front.empty(); ++o) {
    double low = chi2(static_cast<Eigen::Index>(front[0]), o);
    double high = low;
    for (const std::size_t i : front) {
      low = std::min(low, chi2(static_cast<Eigen::Index>(i), o));
      high = std::max(high, chi2(static_cast<Eigen::Index>(i), o));
    }
    ranges[o] = std::max(1.0, high - low);
  }
  return ranges;
}

}  // namespace

Scalarisation MakeScalarisation(const Eigen::MatrixXd& chi2, std::int64_t proposal,
                                RandomStream random) {
  const Eigen::Index count = chi2.cols();
  if (count == 1) return {Eigen::ArrayXd::Ones(1), Eigen::ArrayXd::Ones(1)};
  const Eigen::Index turn = proposal % (3 * count);
  Scalarisation result;
  if (turn < count) {
    result.shares = Eigen::ArrayXd::Zero(count);
    result.shares[turn] = 1;
  } else {
    result.shares = SimplexPoint(count, random);
  }
  result.shares = (1 - kSharedByAll) * result.shares + kSharedByAll / static_cast<double>(count);
  result.weights = result.shares / FrontRanges(chi2);
  result.weights /= result.weights.maxCoeff();
  return result;
}

}  // namespace powdercal

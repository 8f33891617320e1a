#include "optimizers/least_squares/identifiability.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/errors.h"

namespace powdercal {
namespace {

constexpr double kFlat = 0.1;  // √ of the change of χ² across the box
constexpr double kAtBound = 1e-9;
constexpr double kNamed = 0.1;  // least part of a direction that is worth its name

std::string DescribeDirection(const Eigen::VectorXd& direction,
                              const std::vector<std::string>& symbols) {
  std::vector<std::string> parts;
  for (Eigen::Index k = 0; k < direction.size(); ++k) {
    if (std::abs(direction[k]) < kNamed) continue;
    parts.push_back(fmt::format("{}:{:+.2f}", symbols[static_cast<std::size_t>(k)], direction[k]));
  }
  return fmt::format("flat valley: direction ({}) leaves chi² unchanged", JoinNames(parts));
}

}  // namespace

Identifiability Identify(const Eigen::VectorXd& point, const Eigen::MatrixXd& jacobian,
                         const Eigen::ArrayXd& noise) {
  Identifiability result;
  const double root = std::sqrt(static_cast<double>(jacobian.rows()));
  std::vector<Eigen::Index> alive;
  for (Eigen::Index k = 0; k < point.size(); ++k) {
    if (point[k] <= kAtBound) result.lower.push_back(k);
    if (point[k] >= 1 - kAtBound) result.upper.push_back(k);
    if (jacobian.col(k).norm() < std::max(kFlat, noise[k] * root)) {
      result.dead.push_back(k);
    } else {
      alive.push_back(k);
    }
  }
  if (alive.empty()) return result;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(jacobian(Eigen::all, alive), Eigen::ComputeFullV);
  const auto count = static_cast<Eigen::Index>(alive.size());
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(point.size());
    direction(alive) = svd.matrixV().col(i);
    const double limit = std::max(kFlat, root * (direction.array() * noise).matrix().norm());
    // Fewer responses than parameters: the rest of V has the singular value 0.
    if (i < svd.singularValues().size() && svd.singularValues()[i] >= limit) continue;
    Eigen::Index largest = 0;
    direction.cwiseAbs().maxCoeff(&largest);
    if (direction[largest] < 0) direction = -direction;
    result.flat.push_back(std::move(direction));
  }
  return result;
}

std::string Describe(const Identifiability& identifiability,
                     const std::vector<std::string>& symbols) {
  const auto symbol = [&](Eigen::Index k) { return symbols[static_cast<std::size_t>(k)]; };
  std::vector<std::string> findings;
  for (const Eigen::Index k : identifiability.dead) {
    findings.push_back(fmt::format("dead parameter: no response changes with {}", symbol(k)));
  }
  for (const Eigen::VectorXd& direction : identifiability.flat) {
    findings.push_back(DescribeDirection(direction, symbols));
  }
  for (const Eigen::Index k : identifiability.lower) {
    findings.push_back(fmt::format("{} is at its lower bound", symbol(k)));
  }
  for (const Eigen::Index k : identifiability.upper) {
    findings.push_back(fmt::format("{} is at its upper bound", symbol(k)));
  }
  std::string text;
  for (const std::string& finding : findings) text += (text.empty() ? "" : "; ") + finding;
  return text;
}

}  // namespace powdercal

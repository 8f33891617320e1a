#include "optimizers/pareto.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace powdercal {
namespace {

// Rows of the front strictly below the reference, sorted by the last objective.
Eigen::MatrixXd FrontBelow(const Eigen::MatrixXd& objectives, const Eigen::VectorXd& reference) {
  std::vector<Eigen::Index> rows;
  for (const std::size_t i : NonDominated(objectives)) {
    const auto row = static_cast<Eigen::Index>(i);
    if ((objectives.row(row).transpose().array() < reference.array()).all()) rows.push_back(row);
  }
  const Eigen::Index last = objectives.cols() - 1;
  std::stable_sort(rows.begin(), rows.end(), [&](Eigen::Index a, Eigen::Index b) {
    return objectives(a, last) < objectives(b, last);
  });
  return objectives(rows, Eigen::all);
}

// Calls visit(rows of the sorted front that reach the slice, without their last objective; lower
// and upper end of the slice) for each slice along the last objective, that below the front first.
template <typename Visit>
void ForEachSlice(const Eigen::MatrixXd& front, double end, const Visit& visit) {
  const Eigen::Index last = front.cols() - 1;
  double begin = -std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i <= front.rows(); ++i) {
    const double next = i < front.rows() ? front(i, last) : end;
    if (next > begin) visit(Eigen::MatrixXd(front.topLeftCorner(i, last)), begin, next);
    begin = next;
  }
}

void Append(const Boxes& slice, double lower, double upper, Boxes* boxes) {
  const Eigen::Index old = boxes->lower.rows();
  const Eigen::Index added = slice.lower.rows();
  const Eigen::Index columns = slice.lower.cols() + 1;
  boxes->lower.conservativeResize(old + added, columns);
  boxes->upper.conservativeResize(old + added, columns);
  boxes->lower.bottomRows(added) << slice.lower, Eigen::VectorXd::Constant(added, lower);
  boxes->upper.bottomRows(added) << slice.upper, Eigen::VectorXd::Constant(added, upper);
}

}  // namespace

std::vector<std::size_t> NonDominated(const Eigen::MatrixXd& objectives) {
  std::vector<std::size_t> front;
  for (Eigen::Index i = 0; i < objectives.rows(); ++i) {
    const auto row = objectives.row(i).array();
    bool kept = row.isFinite().all();
    for (Eigen::Index j = 0; j < objectives.rows() && kept; ++j) {
      const auto other = objectives.row(j).array();
      kept = !(other.isFinite().all() && (other <= row).all() && (other < row).any());
    }
    if (kept) front.push_back(static_cast<std::size_t>(i));
  }
  return front;
}

double Hypervolume(const Eigen::MatrixXd& objectives, const Eigen::VectorXd& reference) {
  const Eigen::MatrixXd front = FrontBelow(objectives, reference);
  if (front.rows() == 0) return 0;
  const Eigen::Index rest = front.cols() - 1;
  if (rest == 0) return reference[0] - front.col(0).minCoeff();
  double volume = 0;
  ForEachSlice(front, reference[rest],
               [&](const Eigen::MatrixXd& reaching, double lower, double upper) {
                 if (reaching.rows() == 0) return;
                 volume += (upper - lower) * Hypervolume(reaching, reference.head(rest));
               });
  return volume;
}

Boxes NonDominatedBoxes(const Eigen::MatrixXd& objectives, const Eigen::VectorXd& reference) {
  const Eigen::MatrixXd front = FrontBelow(objectives, reference);
  const Eigen::Index rest = objectives.cols() - 1;
  Boxes boxes{Eigen::MatrixXd(0, objectives.cols()), Eigen::MatrixXd(0, objectives.cols())};
  if (rest == 0) {
    boxes.lower = Eigen::MatrixXd::Constant(1, 1, -std::numeric_limits<double>::infinity());
    boxes.upper =
        Eigen::MatrixXd::Constant(1, 1, front.rows() > 0 ? front.col(0).minCoeff() : reference[0]);
    return boxes;
  }
  ForEachSlice(front, reference[rest],
               [&](const Eigen::MatrixXd& reaching, double lower, double upper) {
                 Append(NonDominatedBoxes(reaching, reference.head(rest)), lower, upper, &boxes);
               });
  return boxes;
}

}  // namespace powdercal

#include "optimizers/pareto.h"

namespace powdercal {

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

}  // namespace powdercal

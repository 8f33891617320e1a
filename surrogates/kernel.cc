#include "surrogates/kernel.h"

#include <cmath>

namespace powdercal {

void Correlation(Kernel kernel, const Eigen::Ref<const Eigen::ArrayXd>& squared_distances,
                 Eigen::ArrayXd* correlation, Eigen::ArrayXd* slope) {
  if (kernel == Kernel::rbf) {
    *correlation = (-0.5 * squared_distances).exp();
    if (slope != nullptr) *slope = *correlation;
    return;
  }
  const Eigen::ArrayXd scaled = std::sqrt(5.0) * squared_distances.sqrt();
  const Eigen::ArrayXd decay = (-scaled).exp();
  *correlation = (1 + scaled + (5.0 / 3.0) * squared_distances) * decay;
  if (slope != nullptr) *slope = (5.0 / 3.0) * (1 + scaled) * decay;
}

}  // namespace powdercal

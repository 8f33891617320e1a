#include "surrogates/surrogate.h"

#include <array>

#include "core/errors.h"
#include "surrogates/gaussian_process.h"
#include "surrogates/gradient_boosting.h"
#include "surrogates/nearest_neighbours.h"
#include "surrogates/random_forest.h"
#include "surrogates/ridge.h"
#include "surrogates/support_vector.h"

namespace powdercal {
namespace {

const std::array<std::string, 6> kNames = {
    "gaussian_process", "gradient_boosting", "nearest_neighbours", "random_forest", "ridge",
    "support_vector"};

}  // namespace

std::span<const std::string> SurrogateNames() { return kNames; }

std::unique_ptr<Surrogate> MakeSurrogate(const std::string& name) {
  if (name == "gaussian_process") return std::make_unique<GaussianProcess>();
  if (name == "gradient_boosting") return std::make_unique<GradientBoosting>();
  if (name == "nearest_neighbours") return std::make_unique<NearestNeighbours>();
  if (name == "random_forest") return std::make_unique<RandomForest>();
  if (name == "ridge") return std::make_unique<Ridge>();
  if (name == "support_vector") return std::make_unique<SupportVector>();
  throw UnknownName("surrogate", name, kNames);
}

}  // namespace powdercal

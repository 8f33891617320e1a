#include "surrogates/gradient_boosting.h"

#include <fmt/format.h>
#include <xgboost/c_api.h>

#include <cassert>
#include <limits>
#include <mutex>
#include <stdexcept>

#include "surrogates/fitting.h"

namespace powdercal {
namespace {

using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

void Check(int status) {
  if (status != 0) {
    throw std::runtime_error(fmt::format("gradient_boosting: XGBoost: {}", XGBGetLastError()));
  }
}

struct FreeData {
  void operator()(DMatrixHandle handle) const { XGDMatrixFree(handle); }
};
struct FreeBooster {
  void operator()(BoosterHandle handle) const { XGBoosterFree(handle); }
};
using Data = std::unique_ptr<void, FreeData>;

Data MakeData(const Eigen::MatrixXd& points) {
  const FloatRows rows = points.cast<float>();
  DMatrixHandle handle = nullptr;
  Check(XGDMatrixCreateFromMat_omp(rows.data(), static_cast<bst_ulong>(rows.rows()),
                                   static_cast<bst_ulong>(rows.cols()),
                                   std::numeric_limits<float>::quiet_NaN(), &handle, 1));
  return Data(handle);
}

}  // namespace

class GradientBoosting::Booster {
 public:
  Booster(const Options& options, int depth, int rounds, const Eigen::MatrixXd& points,
          const Eigen::VectorXd& values)
      : dimension_(points.cols()) {
    const Data data = MakeData(points);
    const Eigen::VectorXf labels = values.cast<float>();
    Check(XGDMatrixSetFloatInfo(data.get(), "label", labels.data(),
                                static_cast<bst_ulong>(labels.size())));
    const DMatrixHandle train = data.get();
    BoosterHandle created = nullptr;
    Check(XGBoosterCreate(&train, 1, &created));
    handle_.reset(created);
    const std::pair<const char*, std::string> settings[] = {
        {"verbosity", "0"},
        {"nthread", "1"},
        {"tree_method", "exact"},
        {"objective", "reg:squarederror"},
        {"base_score", fmt::format("{}", values.mean())},
        {"max_depth", std::to_string(depth)},
        {"eta", fmt::format("{}", options.learning_rate)},
        {"lambda", fmt::format("{}", options.leaf_penalty)}};
    for (const auto& [key, value] : settings) {
      Check(XGBoosterSetParam(handle_.get(), key, value.c_str()));
    }
    for (int round = 0; round < rounds; ++round) {
      Check(XGBoosterUpdateOneIter(handle_.get(), round, train));
    }
  }
  // By the first `rounds` trees; 0: by all.
  Eigen::VectorXd Predict(const Eigen::MatrixXd& points, int rounds = 0) const {
    const Data data = MakeData(points);
    const std::string settings =
        fmt::format(R"({{"type": 0, "training": false, "iteration_begin": 0, "iteration_end": {}, )"
                    R"("strict_shape": false}})",
                    rounds);
    const bst_ulong* shape = nullptr;
    bst_ulong dimensions = 0;
    const float* result = nullptr;
    const std::lock_guard lock(mutex_);  // XGBoost caches predictions
    Check(XGBoosterPredictFromDMatrix(handle_.get(), data.get(), settings.c_str(), &shape,
                                      &dimensions, &result));
    return Eigen::Map<const Eigen::VectorXf>(result, points.rows()).cast<double>();
  }
  Eigen::Index dimension() const { return dimension_; }

 private:
  std::unique_ptr<void, FreeBooster> handle_;
  Eigen::Index dimension_;
  mutable std::mutex mutex_;
};

GradientBoosting::GradientBoosting(Options options) : options_(std::move(options)) {
  assert(!options_.depths.empty() && !options_.rounds.empty() && options_.folds >= 2);
}
GradientBoosting::~GradientBoosting() = default;

const std::string& GradientBoosting::name() const {
  static const std::string kName = "gradient_boosting";
  return kName;
}

void GradientBoosting::Fit(const Eigen::MatrixXd& points, const Eigen::VectorXd& values,
                           const Eigen::VectorXd& noise_variances) {
  CheckObservations(name(), points, values, noise_variances);
  count_ = points.rows();
  const Standardisation standard = Standardise(values);
  offset_ = standard.offset;
  scale_ = standard.scale;
  const Eigen::VectorXd scaled = standard.Apply(values);
  depth_ = options_.depths.front();
  rounds_ = options_.rounds.front();
  double least = kUnknownVariance;
  const std::vector<int> folds = SelectionFolds(count_, options_.folds);
  for (const int depth : count_ > 1 ? options_.depths : std::vector<int>{}) {
    const CandidateFits fits = [&](const Eigen::MatrixXd& some, const Eigen::VectorXd& theirs,
                                   const Eigen::MatrixXd& targets) -> Eigen::MatrixXd {
      const Booster booster(options_, depth, options_.rounds.back(), some, theirs);
      Eigen::MatrixXd predictions(targets.rows(),
                                  static_cast<Eigen::Index>(options_.rounds.size()));
      for (std::size_t r = 0; r < options_.rounds.size(); ++r) {
        predictions.col(static_cast<Eigen::Index>(r)) =
            booster.Predict(targets, options_.rounds[r]);
      }
      return predictions;
    };
    const Eigen::VectorXd errors = CrossValidatedErrors(folds, points, scaled, fits);
    for (std::size_t r = 0; r < options_.rounds.size(); ++r) {
      const double error = errors[static_cast<Eigen::Index>(r)];
      if (!(error < least)) continue;
      least = error;
      depth_ = depth;
      rounds_ = options_.rounds[r];
    }
  }
  variance_ = least * scale_ * scale_;
  booster_ = std::make_unique<const Booster>(options_, depth_, rounds_, points, scaled);
}

Prediction GradientBoosting::Predict(const Eigen::VectorXd& point) const {
  assert(booster_ && booster_->dimension() == point.size());
  return {.mean = offset_ + scale_ * booster_->Predict(point.transpose())[0],
          .variance = variance_};
}

std::string GradientBoosting::Describe() const {
  if (!booster_) return "gradient boosting, not fitted";
  return fmt::format("gradient boosting, {} points, {} trees of depth {}, learning rate {:g}",
                     count_, rounds_, depth_, options_.learning_rate);
}

}  // namespace powdercal

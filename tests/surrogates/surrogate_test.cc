#include "surrogates/surrogate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/errors.h"
#include "surrogates/gaussian_process.h"
#include "tests/surrogates/table3_data.h"

namespace powdercal {
namespace {

TEST(SurrogateTest, EveryNameMakesASurrogateOfThatName) {
  EXPECT_TRUE(std::is_sorted(SurrogateNames().begin(), SurrogateNames().end()));
  for (const std::string& name : SurrogateNames()) EXPECT_EQ(MakeSurrogate(name)->name(), name);
}

TEST(SurrogateTest, AnUnknownNameIsAnErrorWithTheNearestName) {
  try {
    MakeSurrogate("gausian_process");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.details().suggestion, "gaussian_process");
  }
}

TEST(SurrogateTest, LeaveOneOutR2OnTable3) {
  const Table3 table = ReadTable3();
  EXPECT_GE(LeaveOneOutR2("gaussian_process", table.points, table.void_ratios), 0.90);
  GaussianProcess::Options options;
  options.model.kernel = Kernel::rbf;
  EXPECT_GE(LeaveOneOutR2([&] { return std::make_unique<GaussianProcess>(options); }, table.points,
                          table.void_ratios),
            0.90);
}

// Predicts the mean of what it was fitted to.
class MeanSurrogate final : public Surrogate {
 public:
  const std::string& name() const override { return name_; }
  void Fit(const Eigen::MatrixXd&, const Eigen::VectorXd& values, const Eigen::VectorXd&) override {
    mean_ = values.mean();
  }
  Prediction Predict(const Eigen::VectorXd&) const override { return {mean_, 1}; }
  std::string Describe() const override { return name_; }

 private:
  std::string name_ = "mean";
  double mean_ = 0;
};

TEST(SurrogateTest, LeaveOneOutR2ByHand) {
  // Of 1, 2, 6 the others' means are 4, 3.5, 1.5: residuals 9 + 2.25 + 20.25 of 14.
  const double r2 = LeaveOneOutR2([] { return std::make_unique<MeanSurrogate>(); },
                                  Eigen::Vector3d(0, 0.5, 1), Eigen::Vector3d(1, 2, 6));
  EXPECT_NEAR(r2, 1 - 31.5 / 14, 1e-12);
}

TEST(SurrogateTest, LeaveOneOutR2RefusesWhatHasNoAnswer) {
  EXPECT_THROW(LeaveOneOutR2("gaussian_process", Eigen::MatrixXd(2, 1), Eigen::Vector2d(0, 1)),
               std::invalid_argument);
  EXPECT_THROW(
      LeaveOneOutR2("gaussian_process", Eigen::Vector3d(0, 0.5, 1), Eigen::Vector3d(1, 1, 1)),
      std::invalid_argument);
}

}  // namespace
}  // namespace powdercal

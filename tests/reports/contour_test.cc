#include "reports/contour.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace powdercal {
namespace {

TEST(ContourTest, PlaneGivesAStraightLine) {
  Eigen::MatrixXd field(5, 4);
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 4; ++j) field(i, j) = 2 * i + j;
  }
  const std::vector<ContourSegment> segments = Contour(field, 4.5);
  ASSERT_FALSE(segments.empty());
  double length = 0;
  for (const ContourSegment& s : segments) {
    EXPECT_NEAR(2 * s.x1 + s.y1, 4.5, 1e-12);
    EXPECT_NEAR(2 * s.x2 + s.y2, 4.5, 1e-12);
    length += std::hypot(s.x2 - s.x1, s.y2 - s.y1);
  }
  // From (2.25, 0) to (0.75, 3).
  EXPECT_NEAR(length, std::hypot(1.5, 3.0), 1e-12);
}

TEST(ContourTest, LevelOutsideTheFieldGivesNothing) {
  EXPECT_TRUE(Contour(Eigen::MatrixXd::Constant(3, 3, 1.0), 2).empty());
  EXPECT_TRUE(Contour(Eigen::MatrixXd::Constant(3, 3, 1.0), 0.5).empty());
}

TEST(ContourTest, SaddleIsResolvedByItsMean) {
  Eigen::MatrixXd field(2, 2);
  field << 0, 3, 3, 0;
  // The mean, 1.5, is above 1: the two low corners are cut off one by one.
  for (const ContourSegment& s : Contour(field, 1)) {
    const double middle = (s.x1 + s.x2 + s.y1 + s.y2) / 2;
    EXPECT_TRUE(middle < 0.5 || middle > 1.5) << middle;
  }
  EXPECT_EQ(Contour(field, 1).size(), 2u);
}

TEST(ContourTest, CellsWithoutAValueAreLeftOut) {
  Eigen::MatrixXd field(2, 2);
  field << 0, 1, 1, std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(Contour(field, 0.5).empty());
}

}  // namespace
}  // namespace powdercal

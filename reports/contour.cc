#include "reports/contour.h"

#include <array>
#include <cmath>

namespace powdercal {
namespace {

struct Point {
  double x, y;
};

// Corners and edges of a cell, both anticlockwise from the lower left; edge e joins e and e + 1.
constexpr std::array<Point, 4> kCorners = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

Point Crossing(const std::array<double, 4>& values, int edge, double level) {
  const int next = (edge + 1) % 4;
  const double t = (level - values[edge]) / (values[next] - values[edge]);
  return {kCorners[edge].x + t * (kCorners[next].x - kCorners[edge].x),
          kCorners[edge].y + t * (kCorners[next].y - kCorners[edge].y)};
}

}  // namespace

std::vector<ContourSegment> Contour(const Eigen::MatrixXd& field, double level) {
  std::vector<ContourSegment> segments;
  for (Eigen::Index i = 0; i + 1 < field.rows(); ++i) {
    for (Eigen::Index j = 0; j + 1 < field.cols(); ++j) {
      const std::array<double, 4> values = {field(i, j), field(i + 1, j), field(i + 1, j + 1),
                                            field(i, j + 1)};
      const double mean = (values[0] + values[1] + values[2] + values[3]) / 4;
      if (!std::isfinite(mean)) continue;
      std::array<int, 4> crossed{};
      int count = 0;
      for (int edge = 0; edge < 4; ++edge) {
        if ((values[edge] >= level) != (values[(edge + 1) % 4] >= level)) crossed[count++] = edge;
      }
      const auto add = [&](int first, int second) {
        const Point a = Crossing(values, first, level);
        const Point b = Crossing(values, second, level);
        const double x = static_cast<double>(i);
        const double y = static_cast<double>(j);
        segments.push_back({x + a.x, y + a.y, x + b.x, y + b.y});
      };
      if (count == 2) {
        add(crossed[0], crossed[1]);
      } else if (count == 4) {
        // The line cuts off the two corners that differ from the middle.
        const bool lower_left_alone = (values[0] >= level) != (mean >= level);
        add(0, lower_left_alone ? 3 : 1);
        add(2, lower_left_alone ? 1 : 3);
      }
    }
  }
  return segments;
}

}  // namespace powdercal

#include "experiments/regions.h"

#include <algorithm>
#include <numbers>

namespace powdercal {
namespace {

using std::numbers::pi;

// The following are volumes of the unit ball's octant x, y, z ≥ 0, with 0 ≤ a, b, c ≤ 1.

// Beyond x = a: a quarter of a cap.
double OctantBeyond(double a) { return pi / 12 * (1 - a) * (1 - a) * (2 + a); }

// Beyond both x = a and y = b.
double OctantBeyondEdge(double a, double b) {
  const double squared = 1 - a * a - b * b;
  if (squared <= 0) return 0;
  const double z = std::sqrt(squared);  // half the length of the edge within the ball
  return (std::atan2(z, a * b) + a * b * z) / 3 - a * (3 - a * a) / 6 * std::atan2(z, b) -
         b * (3 - b * b) / 6 * std::atan2(z, a);
}

// Common to the ball and the box [0, a] × [0, b] × [0, c].
double OctantBox(double a, double b, double c) {
  if (a * a + b * b + c * c <= 1) return a * b * c;
  return pi / 6 - OctantBeyond(a) - OctantBeyond(b) - OctantBeyond(c) + OctantBeyondEdge(a, b) +
         OctantBeyondEdge(b, c) + OctantBeyondEdge(a, c);
}

}  // namespace

bool PlateWindow::IsValid() const {
  // A window as wide as the period may have been computed from other numbers.
  return x0 < x1 && y0 < y1 && (period_y == 0 || y1 - y0 <= period_y * (1 + 1e-9));
}

double BoxRegion::Volume() const {
  return (upper[0] - lower[0]) * (upper[1] - lower[1]) * (upper[2] - lower[2]);
}

bool BoxRegion::Contains(const Vector3& point) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(point[axis] >= lower[axis] && point[axis] < upper[axis])) return false;
  }
  return true;
}

double SphereBoxVolume(const Vector3& centre, double radius, const BoxRegion& box) {
  const double ball = 4 * pi / 3 * radius * radius * radius;
  std::array<std::array<double, 2>, 3> bounds;  // of the box, in radii from the centre
  bool inside = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double lower = std::max((box.lower[axis] - centre[axis]) / radius, -1.0);
    const double upper = std::min((box.upper[axis] - centre[axis]) / radius, 1.0);
    if (lower >= upper) return 0;
    inside = inside && lower == -1 && upper == 1;
    bounds[axis] = {lower, upper};
  }
  if (inside) return ball;
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double sign = 1;
    Vector3 extent;
    for (int axis = 0; axis < 3; ++axis) {
      const int end = (corner >> axis) & 1;
      const double bound = bounds[axis][end];
      sign *= (end == 1) == (bound >= 0) ? 1 : -1;
      extent[axis] = std::abs(bound);
    }
    sum += sign * OctantBox(extent[0], extent[1], extent[2]);
  }
  return std::clamp(sum * radius * radius * radius, 0.0, ball);
}

std::size_t CountThatFit(double length, double size) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::floor(length / size + 1e-9)));
}

}  // namespace powdercal

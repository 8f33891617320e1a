#include "core/portable_math.h"

#include <cmath>
#include <limits>

namespace powdercal {

double PortableExp(double x) {
  if (std::isnan(x)) return x;
  if (x > 709.8) return std::numeric_limits<double>::infinity();
  if (x < -745.2) return 0;
  // x = k ln 2 + r with |r| <= ln 2 / 2; ln 2 in two parts, the first with trailing zeros, so that
  // its product with k is exact.
  constexpr double kLn2High = 0x1.62e42fee00000p-1;
  constexpr double kLn2Low = 0x1.a39ef35793c76p-33;
  constexpr double kInverseLn2 = 0x1.71547652b82fep+0;
  const double k = std::floor(x * kInverseLn2 + 0.5);
  const double r = (x - k * kLn2High) - k * kLn2Low;
  double sum = 0;  // (e^r - 1 - r)/r² by its Taylor series; the first term left out is below 1e-18
  double factorial = 87178291200.0;  // 14!
  for (int term = 14; term >= 2; --term) {
    sum = sum * r + 1 / factorial;
    factorial /= term;
  }
  return std::ldexp(1 + (r + r * r * sum), static_cast<int>(k));
}

double PortableNormalDensity(double z) {
  constexpr double kInverseRootTwoPi = 0.39894228040143267794;
  return kInverseRootTwoPi * PortableExp(-0.5 * z * z);
}

double PortableNormalCdf(double z) {
  if (std::isnan(z)) return z;
  const double magnitude = std::abs(z);
  if (magnitude < 2) {
    // Phi(z) = 1/2 + phi(z) (z + z³/3 + z⁵/(3·5) + …): Abramowitz & Stegun 26.2.11.
    double term = z;
    double sum = z;
    for (int k = 3; k <= 61; k += 2) {
      term *= z * z / k;
      sum += term;
    }
    return 0.5 + PortableNormalDensity(z) * sum;
  }
  // Q(z) = phi(z) / (z + 1/(z + 2/(z + 3/(z + …)))): Abramowitz & Stegun 26.2.14, from the inside
  // out.
  const int terms = 30 + static_cast<int>(400 / (magnitude * magnitude));
  double fraction = magnitude;
  for (int k = terms; k >= 1; --k) fraction = magnitude + k / fraction;
  const double tail = PortableNormalDensity(magnitude) / fraction;
  return z < 0 ? tail : 1 - tail;
}

}  // namespace powdercal

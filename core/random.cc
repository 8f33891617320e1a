#include "core/random.h"

#include <bit>
#include <cassert>
#include <cmath>

namespace powdercal {
namespace {

std::uint64_t SplitMix(std::uint64_t* state) {
  std::uint64_t z = (*state += 0x9e3779b97f4a7c15ULL);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

std::uint64_t Mix(std::uint64_t a, std::uint64_t b) {
  std::uint64_t state = a;
  state = SplitMix(&state) ^ b;
  return SplitMix(&state);
}

// Horner's rule, highest power first.
template <std::size_t N>
double Polynomial(const std::array<double, N>& coefficients, double x) {
  double sum = 0;
  for (const double c : coefficients) sum = sum * x + c;
  return sum;
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed) : seed_(seed) {
  std::uint64_t state = seed;
  for (std::uint64_t& word : state_) word = SplitMix(&state);
}

RandomStream RandomStream::Split(std::string_view label) const {
  std::uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a
  for (const char c : label) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  }
  return RandomStream(Mix(seed_ ^ 0x6c61626c65ULL, hash));
}

RandomStream RandomStream::Split(std::uint64_t index) const {
  return RandomStream(Mix(seed_ ^ 0x696e646578ULL, index));
}

std::uint64_t RandomStream::Bits() {
  const std::uint64_t result = std::rotl(state_[1] * 5, 7) * 9;
  const std::uint64_t shifted = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= shifted;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double RandomStream::Uniform() { return static_cast<double>(Bits() >> 11) * 0x1.0p-53; }

double RandomStream::Uniform(double lower, double upper) {
  const double value = lower + (upper - lower) * Uniform();
  return value < upper ? value : lower;  // rounding may reach the open end
}

std::uint64_t RandomStream::Below(std::uint64_t count) {
  assert(count >= 1);
  const std::uint64_t limit = max() - max() % count;  // a multiple of count
  std::uint64_t bits = Bits();
  while (bits >= limit) bits = Bits();
  return bits % count;
}

double RandomStream::Normal() {
  double p = Uniform();
  while (p == 0) p = Uniform();
  return NormalQuantile(p);
}

double PortableLog(double x) {
  assert(x > 0 && std::isfinite(x));
  int exponent = 0;
  double mantissa = std::frexp(x, &exponent);  // exact
  constexpr double kHalfRoot = 0.70710678118654752440;
  if (mantissa < kHalfRoot) {
    mantissa *= 2;
    --exponent;
  }
  // log m = 2 artanh s with s = (m − 1)/(m + 1), |s| < 0.1716: 12 terms reach 1e-19.
  const double s = (mantissa - 1) / (mantissa + 1);
  const double s2 = s * s;
  double sum = 0;
  for (int term = 23; term >= 3; term -= 2) sum = (sum + 1.0 / term) * s2;
  // ln 2 in two parts: the first has trailing zeros, so its product with the exponent is exact.
  constexpr double kLn2High = 0x1.62e42fee00000p-1;
  constexpr double kLn2Low = 0x1.a39ef35793c76p-33;
  const double k = exponent;
  return k * kLn2High + (2 * s + (2 * s * sum + k * kLn2Low));
}

double NormalQuantile(double p) {
  assert(p > 0 && p < 1);
  const double q = p - 0.5;
  if (std::abs(q) <= 0.425) {
    constexpr std::array<double, 8> kNumerator = {
        2.5090809287301226727e+3, 3.3430575583588128105e+4, 6.7265770927008700853e+4,
        4.5921953931549871457e+4, 1.3731693765509461125e+4, 1.9715909503065514427e+3,
        1.3314166789178437745e+2, 3.3871328727963666080e+0};
    constexpr std::array<double, 8> kDenominator = {
        5.2264952788528545610e+3, 2.8729085735721942674e+4,
        3.9307895800092710610e+4, 2.1213794301586595867e+4,
        5.3941960214247511077e+3, 6.8718700749205790830e+2,
        4.2313330701600911252e+1, 1.0};
    const double r = 0.180625 - q * q;
    return q * Polynomial(kNumerator, r) / Polynomial(kDenominator, r);
  }
  const double tail = q < 0 ? p : 1 - p;
  double r = std::sqrt(-PortableLog(tail));
  double magnitude = 0;
  if (r <= 5) {
    constexpr std::array<double, 8> kNumerator = {
        7.74545014278341407640e-4, 2.27238449892691845833e-2, 2.41780725177450611770e-1,
        1.27045825245236838258e+0, 3.64784832476320460504e+0, 5.76949722146069140550e+0,
        4.63033784615654529590e+0, 1.42343711074968357734e+0};
    constexpr std::array<double, 8> kDenominator = {
        1.05075007164441684324e-9, 5.47593808499534494600e-4,
        1.51986665636164571966e-2, 1.48103976427480074590e-1,
        6.89767334985100004550e-1, 1.67638483018380384940e+0,
        2.05319162663775882187e+0, 1.0};
    r -= 1.6;
    magnitude = Polynomial(kNumerator, r) / Polynomial(kDenominator, r);
  } else {
    constexpr std::array<double, 8> kNumerator = {
        2.01033439929228813265e-7, 2.71155556874348757815e-5, 1.24266094738807843860e-3,
        2.65321895265761230930e-2, 2.96560571828504891230e-1, 1.78482653991729133580e+0,
        5.46378491116411436990e+0, 6.65790464350110377720e+0};
    constexpr std::array<double, 8> kDenominator = {
        2.04426310338993978564e-15, 1.42151175831644588870e-7,
        1.84631831751005468180e-5,  7.86869131145613259100e-4,
        1.48753612908506148525e-2,  1.36929880922735805310e-1,
        5.99832206555887937690e-1,  1.0};
    r -= 5;
    magnitude = Polynomial(kNumerator, r) / Polynomial(kDenominator, r);
  }
  return q < 0 ? -magnitude : magnitude;
}

}  // namespace powdercal
